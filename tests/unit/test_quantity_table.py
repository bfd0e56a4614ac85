"""The one table of quantities: every row says what it must, every name means one thing, every
number of a study is in it.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from quantity_pages import quantities_page

from valvetrain.errors import InputError
from valvetrain.parameters.loading import library_names, load_case
from valvetrain.parameters.schema_case import dimension_of_quantity
from valvetrain.registry import BUILT_IN
from valvetrain.report.text import quantity_label
from valvetrain.solution import definition
from valvetrain.solution.definition import (
    definition_of,
    fixed_part,
    is_defined,
    label_of,
    near_names,
    no_quantity,
    not_given,
    pattern_of,
    row,
    shown,
    tables,
)
from valvetrain.solution.quantity import unit_of
from valvetrain.units import DIMENSIONS, dimension_powers

ROWS = [one for rows in tables().values() for one in rows]
PAGE = Path(__file__).resolve().parents[2] / "docs" / "quantities.md"


def example(template: str) -> str:
    """A name of a template: numbers for single letters, a word for places and springs."""
    return re.sub(r"\{(\w+)\}", lambda place: "3" if len(place[1]) == 1 else "cam", template)


@pytest.fixture
def other_table(monkeypatch):
    """A function that registers one more table for the test."""
    import sys
    from types import ModuleType

    def forget() -> None:
        for cached in (
            definition.tables,
            definition._definition,
            definition._for_reader,
            definition._index,
        ):
            cached.cache_clear()

    def add(*rows):
        module = ModuleType("table_of_a_package")
        module.ROWS = rows
        monkeypatch.setitem(sys.modules, module.__name__, module)
        monkeypatch.setitem(BUILT_IN["quantities"], "mine", f"{module.__name__}:ROWS")
        _clear_registry()
        forget()

    yield add
    monkeypatch.undo()
    _clear_registry()
    forget()


def _clear_registry() -> None:
    from valvetrain import registry

    registry.places.cache_clear()
    registry._load.cache_clear()


@pytest.mark.parametrize("one", ROWS, ids=lambda one: one.name)
def test_a_row_says_all_it_must(one):
    assert dimension_powers(f"1 {one.shown_unit}") == dimension_powers(
        f"1 {DIMENSIONS[one.dimension].si_unit}"
    )
    assert (
        one.label
        and one.definition.endswith(".")
        and one.systems in (("spring",), ("train",), ("spring", "train"))
    )
    assert one.label == one.label.strip() and "_" not in re.sub(r"\{\w+\}", "", one.label)
    assert set(re.findall(r"\{\w+\}", one.label + one.definition)) <= set(
        re.findall(r"\{\w+\}", one.name)
    )


@pytest.mark.parametrize("one", ROWS, ids=lambda one: one.name)
def test_a_name_means_exactly_one_row(one):
    name = example(one.name)
    others = [row for row in ROWS if "{" in row.name and pattern_of(row.name).fullmatch(name)]
    if "{" not in one.name:
        assert definition_of(name) is one
    else:
        best = max(len(fixed_part(row.name)) for row in others)
        assert [row for row in others if len(fixed_part(row.name)) == best] == [one]
        assert (
            definition_of(name).shown_unit == one.shown_unit
            and "{" not in definition_of(name).label + definition_of(name).definition
        )


def test_the_committed_page_is_the_generated_one():
    assert PAGE.read_text(encoding="utf-8") == quantities_page(), (
        "run python scripts/write_pages.py quantities"
    )


def test_labels_of_templates_are_filled():
    assert label_of("mode_12_frequency") == "mode 12 frequency"
    assert label_of("peak_valve_tip_contact_force") == "peak valve tip contact force"
    assert (
        label_of("peak_open_valve_tip_contact_force") == "peak valve tip contact force while open"
    )
    assert (
        label_of("outer_mean_peak_section_displacement") == "mean peak motion of the coils (outer)"
    )
    assert label_of("outer_coil_bind_clearance") == "clearance to coil bind, outer spring"
    assert quantity_label("peak_spring_force") == "Peak spring force below 10 kHz"


def test_values_are_shown_in_the_fields_units():
    value, unit = shown("valve_open_duration", 0.0125)
    assert (value, unit) == (pytest.approx(12.5), "ms")
    assert shown("peak_lever_speed", np.pi) == (pytest.approx(180.0), "deg/s")
    assert shown("clash_count", 4.0) == (4.0, "")
    values, unit = shown("peak_shear_stress", np.array([1e6, 2e8]))
    assert unit == "MPa" and values == pytest.approx([1.0, 200.0])


def test_units_of_json_are_si():
    units = {
        "mode_1_frequency": "Hz",
        "clash_count": "1",
        "peak_valve_acceleration": "m/s2",
        "main_clash_impulse": "N s",
        "card_rate": "N/m",
    }
    assert {name: unit_of(name) for name in units} == units
    assert unit_of("peak_lever_bending_moment") == "N m"


def test_a_name_that_no_table_has_speaks_by_its_last_word():
    assert not is_defined("rocker_shaft_cam_angle")
    assert (unit_of("rocker_shaft_cam_angle"), label_of("rocker_shaft_cam_angle")) == (
        "rad",
        "rocker shaft, cam angle",
    )
    assert unit_of("rocker_shaft_velocity_range") == "m/s"
    assert dimension_of_quantity("rocker_shaft_velocity_range") == "velocity"
    assert (unit_of("rocker_shaft_colour"), dimension_of_quantity("rocker_shaft_colour")) == (
        "1",
        None,
    )


def test_a_package_adds_a_table(other_table):
    assert not is_defined("leak_down_duration")
    other_table(
        row(
            "leak_down_duration",
            "leak-down time",
            "Time the lifter takes to leak down.",
            systems=("train",),
            shown_unit="s",
        )
    )
    assert label_of("leak_down_duration") == "leak-down time" and shown(
        "leak_down_duration", 2.0
    ) == (2.0, "s")


def test_a_name_of_two_tables_is_refused(other_table):
    other_table(row("preload", "preload", "Another one.", systems=("train",)))
    with pytest.raises(InputError, match="'preload' is in the tables 'general' and 'mine'"):
        definition_of("preload")


@pytest.mark.parametrize("name", library_names())
def test_every_published_quantity_of_the_library_is_defined(name):
    assert not [
        value.quantity for value in load_case(name).published if not is_defined(value.quantity)
    ]


@pytest.mark.parametrize(
    ("name", "model"),
    [("job-t", "modal-varied"), ("vaz-ohc", "multi-mass"), ("tdi-pushrod", "modal-varied")],
)
def test_every_number_of_a_study_is_defined(name, model):
    from valvetrain.runs.run import run_study

    case = load_case(name)
    done = run_study(case, engine_speeds=case.operation.engine_speeds[:1], spring_models=(model,))
    names = {key for solution in done.solutions for key in solution.quantities} | {
        key for one in done.still.values() for key in one
    }
    assert len(names) > 15 and not [one for one in names if not is_defined(one)]


@pytest.mark.parametrize("name", ["gu2021-beehive-blind", "job-t"])
def test_every_number_of_a_definition_is_defined(name):
    from valvetrain.quantities.statics import design_quantities

    names = [key for spring in load_case(name).springs for key in design_quantities(spring)]
    assert names and not [one for one in names if not is_defined(one)]


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        ("float_speed", "did you mean float_engine_speed?"),  # all its words
        ("seat_velocity", "did you mean seating_velocity?"),  # letters
        (
            "mode_1",
            "did you mean mode_{n}_frequency, moving_retainer_mode_{n}_frequency or",
        ),  # a number of a template
        ("coil_bind_clearence", "did you mean coil_bind_clearance?"),
        ("valve_tip", "docs/quantities.md lists their names"),
        ("", "docs/quantities.md lists their names"),
    ],
)
def test_a_name_that_no_table_has_is_answered_with_the_nearest(asked, told):
    assert not is_defined(asked) and no_quantity(asked).startswith(
        f"'{asked}' is no quantity; {told}"
    )


def test_a_quantity_that_no_run_gave_is_told_with_those_near_it_but_not_itself():
    near = near_names("peak_shear_stress")
    assert "peak_shear_stress" not in near and len(near) == 3
    assert not_given("peak_shear_stress").startswith(
        f"no run gave the peak shear stress (peak_shear_stress); similar: {near[0]}, "
    )
    assert near_names("xyzzy") == () and not_given("mode_7_frequency").startswith(
        "no run gave the mode 7 frequency (mode_7_frequency)"
    )
