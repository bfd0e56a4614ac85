"""The case of an engine from what a person has of it: spring card, cam card, weighed masses and red line."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import reduce
from math import cos, sin, sqrt
from operator import getitem
from typing import Any

from valvetrain.errors import InputError
from valvetrain.parameters.loading import parse_case, parse_toml
from valvetrain.parameters.overrides import split_notes
from valvetrain.parameters.templates import CARDS, QUESTIONS, SPRING, Question, flag, template_text
from valvetrain.parameters.toml_text import find_line, inline
from valvetrain.parameters.train import TrainParameters
from valvetrain.parameters.train_names import TITLES
from valvetrain.units import parse_quantities, parse_quantity
from valvetrain.units.text import PLAIN_NUMBER

#: Tables of a template that no card gives.
_NO_CARD = ("train.cam", "train.lever", f"{SPRING}.damping")
#: Answers of which one takes the place of others, or goes with them: those of another part would contradict it.
_SPRING_CARD = tuple(QUESTIONS)[:9]
_NEEDED = ("seat_load", "height")
#: Of a bending lever: 3 % of critical for 50 g on 40 kN/mm.
_LEVER_DAMPING = "100 N s/m"
#: Unit of a number without one, where people use no other.
_CUSTOMARY = {"ANGLE": "deg", "SPEED": "rpm"}


def questions_of(kind: str) -> Iterator[tuple[str, Question, str]]:
    """Name, question and default of everything that is asked of a ``kind`` of train; an empty default leaves a value out."""
    tree = split_notes(parse_toml(template_text(kind, kind in CARDS), kind))[0]
    for name, one in QUESTIONS.items():
        if kind in one.kinds:
            yield name, one, str(_at(tree, one.path) or one.default)


def card_case_text(kind: str, answers: Mapping[str, str], title: str = "") -> str:
    """The commented case of a ``kind`` of train with the ``answers`` by name; values that were not answered have the status
    "assumed".

    Raises :class:`InputError` for an answer that cannot be, that contradicts another, or that needs another.
    """
    given = {
        name: _with_unit(name, str(value).strip())
        for name, value in answers.items()
        if str(value).strip()
    }
    asked = {name: (one, default) for name, one, default in questions_of(kind)}
    for name in given:
        if name not in asked:
            raise InputError(
                f"{TITLES[kind]} has no {name.replace('_', ' ')}; leave it out", flag(name)
            )
    _complete(given)
    text = template_text(kind, kind in CARDS)
    for name in _left_out(given):
        text = with_value(text, QUESTIONS[name].path, None)
    lobe = ("lift_law", "lobe_lift")
    if lift := _held(text, lobe):
        text = with_value(text, lobe, None if "lift" in given else _assumed(lift))
    for name, (one, _) in asked.items():
        if name not in given:
            if value := _held(text, one.path):
                text = with_value(text, one.path, _assumed(value))
            continue
        value, parts = given[name], given[name].split("+")
        if len(parts) > 1:
            kilograms = sum(parse_quantity(part, "mass", flag(name)) for part in parts)
            value = f"{kilograms * 1e3:.6g} g"
        text = with_value(text, one.path, value, given[name] if len(parts) > 1 else "")
    if not given.keys() & {"spring_mass", "wire"} and given.keys() & set(_SPRING_CARD):
        mass = _held(text, QUESTIONS["spring_mass"].path) or QUESTIONS["spring_mass"].default
        text = with_value(text, QUESTIONS["spring_mass"].path, _assumed(mass))
    for table in _NO_CARD:
        path = Question(table, "", "").path
        values = _at(parse_toml(text, "case"), path) or {}
        answered = [QUESTIONS[name].path[-1] for name in given if QUESTIONS[name].path[:-1] == path]
        if values and not answered:
            text = with_value(text, (*path, "status"), "assumed")
        for key in [
            one
            for one in values
            if answered and one not in answered and isinstance(values[one], str)
        ]:
            text = with_value(text, (*path, key), _assumed(values[key]))
    if "red_line" in given:
        (top,) = parse_quantities(given["red_line"], "angular speed", flag("red_line"))
        speeds = f"{top * 15 / 3.141592653589793:.0f}, {top * 30 / 3.141592653589793:.0f} rpm"
        text = with_value(text, ("operation", "engine_speeds"), speeds)
    if title:
        text = with_value(text, ("title",), title)
    train = _checked(text)
    lever, rod = train.lever, train.pushrod
    if "pushrod_length" in given and lever and lever.drive_angle and rod and rod.length:
        across, up = (
            lever.drive_arm * cos(lever.drive_angle),
            lever.drive_arm * sin(lever.drive_angle),
        )
        aside = lever.pivot[0] + across - rod.lower_end[0]
        height = rod.lower_end[1] + sqrt(max(rod.length**2 - aside**2, 0.0)) - up
        pivot = f"{lever.pivot[0] * 1e3:.6g}, {height * 1e3:.6g} mm"
        text = with_value(text, ("train", "lever", "pivot"), pivot)
    if lever and "rocker_stiffness" in given:
        text = with_value(text, ("train", "lever", "damping"), _assumed(_LEVER_DAMPING))
    if lever and "rocker_mass" in given and "rocker_inertia" not in given:
        back = 0.0 if kind == "finger" else lever.drive_arm  # a finger turns about its end
        square = (back**2 - back * lever.valve_arm + lever.valve_arm**2) / 3
        inertia = _assumed(f"{lever.mass * square * 1e6:.3g} kg mm^2")
        text = with_value(text, QUESTIONS["rocker_inertia"].path, inertia)
    return text


def _with_unit(name: str, value: str) -> str:
    """The answer with the unit that its number can only mean: degrees, rpm, and any for no lash."""
    unit = _CUSTOMARY.get(QUESTIONS[name].follows) if name in QUESTIONS else None
    if name == "lash" and re.fullmatch(r"0+(\.0*)?", value):
        unit = "mm"
    return f"{value} {unit}" if unit and re.fullmatch(PLAIN_NUMBER, value) else value


def _complete(given: Mapping[str, str]) -> None:
    """Refuse a part of a spring card, whose rest would be that of another spring."""
    if not given.keys() & set(_SPRING_CARD):
        return
    loads = [] if "rate" in given else ["open_load", "open_height"]
    for name in (*_NEEDED, *loads):
        if name not in given:
            rest = "" if name in _NEEDED else f", or {flag('rate')} in place of both open ones"
            raise InputError(
                f"the spring card lacks it: {QUESTIONS[name].meaning}; add it{rest}", flag(name)
            )
    if ("wire" in given) != ("outer_diameter" in given):
        has, lacks = ("wire", "outer_diameter")[:: 1 if "wire" in given else -1]
        raise InputError(f"the moving mass of the spring takes wire and outer diameter; add it, or leave {flag(has)} out", flag(lacks))  # fmt: skip


def _left_out(given: Mapping[str, str]) -> Iterator[str]:
    """Values of the template that belong to another spring or cam than the one ``given``."""
    if given.keys() & set(_SPRING_CARD):
        yield from (name for name in ("open_load", "open_height", "coil_bind") if name not in given)
        if "wire" in given:
            yield "spring_mass"
        else:
            yield from ("wire", "outer_diameter")
    if given.keys() & {"lift", "duration"} and "advertised" not in given:
        yield from ("advertised", "advertised_lift")


def _checked(text: str) -> TrainParameters:
    """The train of the case; an error is told at the option of the answer."""
    try:
        train = parse_case(text, where="the case").train
    except InputError as error:
        key = next((n for n, one in QUESTIONS.items() if one.key in error.where), "")
        raise InputError(error.reason, flag(key) if key else error.where) from None
    assert train is not None
    return train


def _at(tree: Any, path: tuple[str | int, ...]) -> Any:
    try:
        return reduce(getitem, path, tree)
    except (LookupError, TypeError):
        return None


def _held(text: str, path: tuple[str | int, ...]) -> str:
    return str(_at(split_notes(parse_toml(text, "case"))[0], path) or "")


def _assumed(value: str) -> dict[str, str]:
    return {"value": value, "status": "assumed"}


def with_value(text: str, path: tuple[str | int, ...], value: Any, comment: str = "") -> str:
    """The text of a template with the value at ``path`` on its line, and a comment where it has one; None removes the line."""
    lines, there = text.splitlines(True), _at(parse_toml(text, "case"), path) is not None
    line = find_line(text, path)
    if value is None:
        return "".join([*lines[: line - 1], *lines[line:]]) if there and line else text
    made = f"{path[-1]} = {inline(value)}{f' # {comment}' if comment else ''}"
    if there and line:  # a comment on the number that was there stays with an assumed one alone
        old = re.search(r"\s#[^\"]*$", lines[line - 1]) if isinstance(value, dict) else None
        lines[line - 1] = made + (old.group() if old else "\n")
    else:
        lines.insert(line or 0, f"{made}\n")
    return "".join(lines)
