"""The tables of the case file say what the parts do."""

from __future__ import annotations

from dataclasses import MISSING, fields

import pytest

from valvetrain import registry
from valvetrain.parameters.loading import parse_case


@pytest.mark.parametrize("word", registry.names("contacts"))
def test_defaults_of_contact_tables_are_those_of_the_laws(word):
    spec = registry.find("contacts", word)
    for item in fields(spec.law):
        told = spec.table.model_fields.get(item.name)
        if (
            told is not None
            and told.default is not None
            and item.init
            and item.default is not MISSING
        ):
            assert told.default == item.default, item.name


def test_what_a_file_leaves_out_is_what_the_page_says():
    text = '[spring]\nwire_diameter = "4 mm"\nmean_diameter = "24 mm"\npitch = "7.5 mm"\ntotal_coils = 6\nmaterial = "OTEVA 90 SC"\n'
    case = parse_case(text)
    (spring,) = case.springs
    assert (
        spring.precompression,
        spring.seats,
        spring.contact.stiffness,
        spring.contact.damping_time,
    ) == (0.0, "planes", 2e10, 1e-6)
    assert (
        spring.damping.mass_damping,
        spring.damping.stiffness_damping,
        dict(spring.options),
    ) == (0.0, 0.0, {})
    assert (spring.wire.lower_end.kind, spring.wire.lower_end.inactive_coils, spring.wire.hand) == (
        "closed-ground",
        0.75,
        "right",
    )
    assert case.operation.cycles is None and case.operation.output_step == pytest.approx(
        0.5 * 3.141592653589793 / 180
    )
