"""The law of contact between coils: one contract and one home for every spring model."""
