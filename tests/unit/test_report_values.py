"""Values of a case as a page shows them: numbers with units, no names of classes."""

from __future__ import annotations

from valvetrain.parameters.loading import load_case


def test_values_carry_the_unit_of_their_file() -> None:
    shown = {one.path: one.text for one in load_case("vaz-ohc").record().values}
    assert shown["operation.cam_speeds"] == "2068 rpm"
    assert shown["train.cam"] == "base radius 18 mm, width 15 mm"
    assert shown["train.contacts.seat"] == "linear, contact stiffness 100 kN/mm, damping 1500 N s/m"
    assert (
        shown["train.contacts.cam"]
        == "hunt-crossley, contact stiffness 200 kN/mm, exponent 1, damping 2 s/m"
    )
