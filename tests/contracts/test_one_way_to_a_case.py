"""A study, a search, ``set`` and a file with a value in it name one case, at speeds far beyond road engines too.

Every template and library case, every value that can be varied, at 3000 and 20 000 rpm: a drawn sample of
60 by default, all of them by ``make validate-all``.
"""

from __future__ import annotations

import copy
import itertools
import os
import random
import tomllib
import warnings
from dataclasses import replace
from functools import lru_cache

import pytest

import valvetrain as vt
from valvetrain.explore.case_paths import MOVING, nominal, unit_in_case, vary
from valvetrain.explore.distributions import Values
from valvetrain.explore.space import Varied
from valvetrain.parameters.loading import library_names, parse_case
from valvetrain.parameters.overrides import split_notes
from valvetrain.parameters.templates import KINDS, TITLES, template_text
from valvetrain.parameters.toml_text import toml_text
from valvetrain.quantities.request import LIGHT
from valvetrain.solution.definition import definition_of

SPEEDS = ("3000 rpm", "20000 rpm")
CASES = [*KINDS, *(f"{kind}, cards" for kind in TITLES), *library_names()]
#: Factors on a value, and steps of a whole number, of which the first that makes a case is taken.
FACTORS, STEPS = (1.03, 0.97, 1.5), (1, -1, 0.03)
SAMPLE, RUNS, SEED = 60, 6, 49
pytestmark = pytest.mark.filterwarnings("ignore::valvetrain.errors.UnusualValueWarning")


@lru_cache(maxsize=64)
def tree_of(name: str, speed: str) -> dict:
    """The tables of a case, without notes and published values, with one engine speed."""
    kind, _, cards = name.partition(",")
    text = template_text(kind, cards=bool(cards)) if kind in KINDS else vt.load_case(name).text
    tree = split_notes(tomllib.loads(text))[0]
    tree.pop("published", None)
    tree.get("operation", {}).pop("cam_speeds", None)
    tree.setdefault("operation", {})["engine_speeds"] = speed
    return tree


@lru_cache(maxsize=64)
def case_of(name: str, speed: str) -> vt.Case:
    return vt.Case(toml_text(tree_of(name, speed)))


def leaves(item: object, path: tuple[str, ...] = ()):
    """Key paths of everything that holds a number."""
    if isinstance(item, dict):
        for key, value in item.items():
            yield from leaves(value, (*path, key))
    elif isinstance(item, list):
        for place, value in enumerate(item):
            yield from leaves(value, (*path, str(place)))
    elif isinstance(item, str) and "," in item:
        for place, _ in enumerate(item.split(",")):
            yield (*path, str(place))
    elif isinstance(item, (str, int, float)) and not isinstance(item, bool):
        yield path


@lru_cache(maxsize=1)
def every_value() -> list[tuple[str, str, str]]:
    """(case, key, speed) of all that can be varied."""
    found = []
    for name, speed in itertools.product(CASES, SPEEDS):
        for path in leaves(tree_of(name, speed)):
            key = ".".join(path)
            if path[0] not in MOVING:
                continue
            try:
                nominal(case_of(name, speed).parameters, Varied(key))
            except vt.InputError:
                continue  # a word, or a name
            found.append((name, key, speed))
    return found


def moved(case: vt.Case, key: str) -> tuple[Varied, float]:
    """A value that the case can have in place of its own, in the unit of the case."""
    varied = Varied(key, unit_in_case(case.parameters, key))
    value = nominal(case.parameters, varied)
    whole = not varied.unit and float(value).is_integer()
    others = (
        [value + step for step in STEPS]
        if whole
        else [value * factor or 1e-3 for factor in FACTORS]
    )
    for other in others:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                vary(case.parameters, dict([of_unit(varied, other)]))
            except vt.InputError:
                continue
        return of_unit(varied, other)
    return of_unit(varied, others[0])


def written(varied: Varied, value: float) -> object:
    """The value as a file holds it."""
    if varied.unit:
        return f"{value!r} {varied.si_unit}"
    return int(value) if float(value).is_integer() else value


def of_unit(varied: Varied, value: float) -> tuple[Varied, float]:
    """The quantity as it is given with its unit, which is believed."""
    return replace(varied, distribution=Values((written(varied, value),))), value


def in_file(tree: dict, key: str, text: object) -> str:
    """The case file with a value written at a key, by hand."""
    tree, (*heads, last) = copy.deepcopy(tree), key.split(".")
    holder = tree
    for head in heads:
        holder_of, place = holder, int(head) if isinstance(holder, list) else head
        holder = holder[place]
    if isinstance(holder, str):  # a row such as "0, 1.5 mm"
        unit = holder.rpartition(",")[2].strip().lstrip("+-0123456789.eE").strip()
        row = [
            one.strip() if one.strip().endswith(unit) else f"{one} {unit}"
            for one in holder.split(",")
        ]
        row = row if unit else [float(one) for one in row]
        row[int(last)] = text
        holder_of[place] = row
    else:
        holder[int(last) if isinstance(holder, list) else last] = text
    return toml_text(tree)


def outcome(build):
    """What a case is, or that it is refused."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            found = build()
        except vt.InputError:
            return "refused"
    return (
        found.springs, found.rubbing, found.lift_law, found.operation, found.train, found.study, dict(found.points),
    )  # fmt: skip


def differs(name: str, key: str, speed: str) -> str:
    """Whose case differs from that of the file with the value in it; empty where none does."""
    case = case_of(name, speed)
    varied, value = moved(case, key)
    text = written(varied, value)
    by_hand = outcome(lambda: parse_case(in_file(tree_of(name, speed), key, text), case.name))
    if by_hand == outcome(lambda: case.parameters):
        return "" if by_hand == "refused" else "nothing: the value is the case's own"
    ways = {
        "study": lambda: vary(case.parameters, {varied: value}),
        "set": lambda: case.set({key: text}).parameters,
        "--set": lambda: parse_case(case.text, case.name, changes={key: text}),
    }
    return ", ".join(way for way, build in ways.items() if outcome(build) != by_hand)


@lru_cache(maxsize=1)
def drawn() -> list[tuple[str, str, str]]:
    return random.Random(SEED).sample(every_value(), SAMPLE)


@pytest.mark.parametrize("place", range(SAMPLE))
def test_a_value_gives_the_case_of_the_file_that_holds_it(place):
    name, key, speed = drawn()[place]
    assert not differs(name, key, speed), (name, key, speed)


def numbers(name: str, key: str, speed: str) -> tuple[dict, dict]:
    """What a study gives at a value, and a run of the case with it, without mass of the springs; both end with
    the code of their status.
    """
    if key.startswith("operation.engine_speeds"):  # a study varies engine_speed instead
        return {}, {}
    case = case_of(name, speed)
    varied, value = moved(case, key)
    kind = "spring" if case.parameters.train is None else "train"
    light = [one for one in sorted(LIGHT) if kind in definition_of(one).systems]
    try:
        changed = case.set({key: written(varied, value)})
        run = changed.run(models="massless", outputs=light if kind == "spring" else ())
    except vt.InputError:
        return {}, {}
    names = [one for one in run.quantities if kind in definition_of(one).systems]
    table = case.study(
        {key: [written(varied, value)]},
        names or ["peak_spring_force"],  # of a run that ended without numbers
        sampling="grid",
        models="massless",
        workers=1,
    )
    values = {one: float(table.to_xarray()[one].values.item()) for one in names}
    expected = {one: run.quantities[one] for one in names}
    return values | {"": table.statuses[0].code}, expected | {"": run.status.code}


@pytest.mark.parametrize("place", range(RUNS))
def test_a_study_gives_the_numbers_of_a_run_of_that_case(place):
    values, expected = numbers(*drawn()[place])
    assert values == expected, drawn()[place]


def test_what_follows_from_a_value_follows_beyond_15_000_rpm():
    """The rate of a card from its open load, and the lifts of a cam card from its duration."""
    text = template_text("direct", cards=True).replace("3000, 5500 rpm", "15500 rpm")
    case = vt.Case(text.replace('"45 g"', '"11 g"').replace('"95 g"', '"21 g"'))
    force, loads = "minimum_cam_contact_force", [600.0, 700.0]
    key = "train.springs.card.0.open_load"
    table = case.study(
        {key: loads}, ["card_rate", force], sampling="grid", models="massless", workers=1
    )
    found = table.to_xarray()
    assert found["card_rate"].values.ravel() == pytest.approx(
        [(one - 240.0) / 9e-3 for one in loads]
    )
    runs = [case.set({key: one}).run(models="massless") for one in loads]
    assert found[force].values.ravel().tolist() == [run.quantities[force] for run in runs]
    assert found[force].values.ravel()[1] > found[force].values.ravel()[0] + 20.0
    key, same, other = "lift_law.duration", "248 deg", "252 deg"
    lifts = case.study(
        {key: [same, other]},
        "peak_cam_contact_force",
        sampling="grid",
        models="massless",
        workers=1,
    )
    low, high = lifts.to_xarray()["peak_cam_contact_force"].values.ravel()
    own = case.run(models="massless").quantities["peak_cam_contact_force"]
    assert low == pytest.approx(own, rel=1e-9) and high != low


def rows_of(name: str) -> list[tuple[str, str, str]]:
    return [row for row in every_value() if row[0] == name]


@pytest.mark.long
@pytest.mark.parametrize("name", CASES)
def test_every_value_gives_the_case_of_the_file_that_holds_it(name):
    rows = rows_of(name)
    assert rows and not {row: way for row in rows if (way := differs(*row))}
    print(f"{name}: {len(rows)} values")


@pytest.mark.long
@pytest.mark.skipif("VALVETRAIN_ALL" not in os.environ, reason="half an hour: make validate-all")
@pytest.mark.parametrize("name", CASES)
def test_every_study_gives_the_numbers_of_a_run_of_that_case(name):
    compared = {row: numbers(*row) for row in rows_of(name)}
    assert not [row for row, (values, expected) in compared.items() if values != expected]
    print(
        f"{name}: {sum(map(bool, (pair[1] for pair in compared.values())))} of {len(compared)} ran"
    )
