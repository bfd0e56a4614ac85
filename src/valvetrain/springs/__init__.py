"""Spring models of every fidelity behind one contract (`contract.SpringModel`)."""
