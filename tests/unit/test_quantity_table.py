"""The one table of quantities: every row says what it must, every name means one thing, every
number of a study is in it.
"""

from __future__ import annotations

import re

import pytest

from valvetrain.errors import InputError
from valvetrain.parameters.loading import library_names, load_case
from valvetrain.registry import BUILT_IN
from valvetrain.solution import definition
from valvetrain.solution.definition import (
    definition_of,
    is_defined,
    label_of,
    pattern_of,
    row,
    shown,
    tables,
)
from valvetrain.units import DIMENSIONS, dimension_powers

ROWS = [one for rows in tables().values() for one in rows]


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
        fixed = [len(re.sub(r"\{\w+\}", "", row.name)) for row in others]
        assert fixed.count(max(fixed)) == 1 and others[fixed.index(max(fixed))] is one
        assert (
            definition_of(name).shown_unit == one.shown_unit
            and "{" not in definition_of(name).label + definition_of(name).definition
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
    from valvetrain.runs.api import simulate

    case = load_case(name)
    done = simulate(case, engine_speeds=case.operation.engine_speeds[:1], models=(model,))
    names = {key for solution in done.solutions for key in solution.quantities} | {
        key for one in done.still.values() for key in one
    }
    assert len(names) > 15 and not [one for one in names if not is_defined(one)]


@pytest.mark.parametrize("name", ["gu2021-beehive-blind", "job-t"])
def test_every_number_of_a_definition_is_defined(name):
    from valvetrain.quantities.statics import design_quantities

    names = [key for spring in load_case(name).springs for key in design_quantities(spring)]
    assert names and not [one for one in names if not is_defined(one)]
