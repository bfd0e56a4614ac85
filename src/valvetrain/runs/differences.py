"""Differences of two saved runs: of inputs by key path, of results by quantity and run."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from valvetrain.errors import InputError
from valvetrain.parameters.loading import parse_toml, read_text
from valvetrain.runs.saved_runs import DEFINITIONS, FORCE, SavedRun, check_inputs, is_number
from valvetrain.solution.definition import definition_of, is_defined, label_cut_off
from valvetrain.solution.force_peak import FORCE_BANDWIDTH, band_text

#: Entries of an answer that describe the request, or repeat other numbers.
NO_RESULT = (
    "command", "command_line", "case", "title", "digest", "checksum", "changed", "created_at", "choices", "versions", "files", "folder",
    "page", "units", "cite", "kept_from_before", "known_before", "quantities", "quantities_by_label", "springs_at_rest", "comparisons",
    "findings", "source_findings", "definitions",
)  # fmt: skip
#: Entries of an answer, at any level, that are of the computation and not of the valvetrain.
NUMERICS = ("runs_count", "resolution", "statistics", "options", "uncertainties")
#: Levels of an answer that are compared, more than twice those of any that is written.
MAX_DEPTH = 24
#: Fields that identify the items of a list.
IDENTIFYING = (
    "measurement", "key", "quantity", "name", "channel", "label", "model", "spring_set", "source", "event", "kind",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class ResultDifference:
    """A ``quantity`` (SI, ``unit``) of a ``run`` (label and speed; empty for none) that differs;
    None: missing. ``bar`` (SI): sum of the error bars that the runs stored of it.
    """

    quantity: str
    run: str
    unit: str
    a: float | None
    b: float | None
    bar: float = 0.0

    @property
    def difference(self) -> float | None:
        """Value of B less value of A."""
        return None if self.a is None or self.b is None else self.b - self.a

    @property
    def relative(self) -> float | None:
        """Difference over the size of A's value; None where that is zero or missing."""
        return None if self.difference is None or not self.a else self.difference / abs(self.a)


@dataclass(frozen=True)
class RunDifferences:
    """Two saved runs, the ``inputs`` (key path, value of each) and the ``results`` that differ."""

    a: SavedRun
    b: SavedRun
    inputs: tuple[tuple[str, Any, Any], ...]
    results: tuple[ResultDifference, ...]


def differences(one: SavedRun, other: SavedRun) -> RunDifferences:
    """What differs between two saved runs.

    Raises :class:`InputError` as :func:`input_differences` and :func:`result_differences` do.
    """
    return RunDifferences(one, other, input_differences(one, other), result_differences(one, other))


def input_differences(one: SavedRun, other: SavedRun) -> tuple[tuple[str, Any, Any], ...]:
    """(key path, value of ``one``, value of ``other``) of all inputs that differ: case, options,
    versions; None where a key is missing.

    Raises :class:`InputError` where the inputs of a run have changed on disk.
    """
    for run in (one, other):
        check_inputs(run)
    first, second = _inputs_of(one), _inputs_of(other)
    keys = dict.fromkeys((*first, *second))
    return tuple(
        (key, first.get(key), second.get(key)) for key in keys if first.get(key) != second.get(key)
    )


def result_differences(one: SavedRun, other: SavedRun) -> tuple[ResultDifference, ...]:
    """Every physical number that differs between the runs: those that both have first, by falling relative
    difference.

    Raises :class:`InputError` where the engine speeds of the runs are different, or where both have peak spring
    forces, but below different cut-offs.
    """
    of_a, of_b = (_speeds_of(run) for run in (one, other))
    if of_a and of_b and of_a != of_b:
        texts = [
            ", ".join(some[:4]) + (" and more" if len(some) > 4 else "") for some in (of_a, of_b)
        ]
        raise InputError(
            f"run A is of {texts[0]} rpm and run B of {texts[1]} rpm; compare runs at the same engine speeds"
        )
    own, label = (
        {row.get("label", "") for row in run.answer.get("runs", ())} for run in (one, other)
    )
    if len(own) == len(label) == 1:  # of one variant each, whatever it is called
        text = json.dumps(other.answer).replace(json.dumps(*label), json.dumps(*own))
        other = replace(other, answer=json.loads(text))
    first, second = dict(answer_numbers(one.answer)), dict(answer_numbers(other.answer))
    forces = [any(name.endswith(FORCE) for name, _ in numbers) for numbers in (first, second)]
    cut_offs = [cut_off_of(run) for run in (one, other)]
    if all(forces) and cut_offs[0] != cut_offs[1]:
        texts = ["that of every instant" if at is None else band_text(at) for at in cut_offs]
        raise InputError(
            f"the peak spring force is {texts[0]} in one run and {texts[1]} in the other, so they are two quantities; "
            "repeat one of them, with the [operation] force_bandwidth of the other"
        )
    label_cut_off(cut_offs[0 if forces[0] else 1] or FORCE_BANDWIDTH)
    rows = []
    for key in dict.fromkeys((*first, *second)):
        (a, unit), (b, other_unit) = first.get(key, (None, "")), second.get(key, (None, ""))
        if a != b:
            bar = _bar_of(one, *key) + _bar_of(other, *key)
            rows.append(ResultDifference(*key, unit or other_unit, a, b, bar))
    return tuple(sorted(rows, key=lambda row: (row.difference is None, -abs(row.relative or 0.0))))


def _bar_of(run: SavedRun, quantity: str, name: str) -> float:
    """The error bar (SI) that a run stored of a quantity; 0 for none."""
    for row in run.answer.get("uncertainties", ()):
        if isinstance(row, Mapping) and row.get("quantity") == quantity:
            speed = (row.get("engine_speed") or {}).get("value")
            place = " at ".join(filter(None, (row.get("label"), speed and f"{speed:g} rpm")))
            bar: Any = (row.get("numerical_uncertainty") or {}).get("value")
            if name.endswith(place) and is_number(bar):
                return float(bar)
    return 0.0


def cut_off_of(run: SavedRun) -> float | None:
    """Cut-off (Hz) of the peak spring force of a saved run; None where it is that of every instant."""
    try:
        return float(run.answer[DEFINITIONS][FORCE]["below"]["value"])
    except (KeyError, TypeError, ValueError):
        return None


def _speeds_of(run: SavedRun) -> tuple[str, ...]:
    """Crank speeds (rpm) of a run, of a run-up its first and last with their unit; none where it has none."""
    ends = [run.choices.get(f"{name}_engine_speed") for name in ("first", "last")]
    if all(ends):
        return tuple(map(str, ends))
    return tuple(f"{speed:g}" for speed in sorted({round(one, 3) for one in run.engine_speeds}))


def _inputs_of(run: SavedRun) -> dict[str, Any]:
    try:
        values = dict(_leaves(parse_toml(read_text(run.case_file), "case")))
    except (InputError, RecursionError):
        values = {}
    about = {
        "case": run.case,
        "command": run.answer.get("command"),
        "choices": run.answer.get("choices"),
    }
    return dict(_leaves(about | {"versions": run.answer.get("versions")})) | values


def _leaves(item: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    if isinstance(item, Mapping) and "value" in item and path:
        yield path, item["value"]  # status and source of a value change no number
    elif isinstance(item, Mapping):
        for key, value in item.items():
            if key not in ("status", "source"):
                yield from _leaves(value, f"{path}.{key}" if path else str(key))
    elif isinstance(item, list) and any(isinstance(value, (Mapping, list)) for value in item):
        for index, value in enumerate(item):
            yield from _leaves(value, f"{path}.{index}")
    else:
        yield path, item


def answer_numbers(
    answer: Mapping[str, Any],
) -> Iterator[tuple[tuple[str, str], tuple[float, str]]]:
    """(quantity, run) -> value and unit, of every named number of a ``run.json``."""
    for label, values in {
        "": answer.get("quantities", {}),
        **answer.get("quantities_by_label", {}),
    }.items():
        yield from _quantities(values, label)
    for run in answer.get("runs", ()):
        if isinstance(run, Mapping) and "quantities" in run:
            speed = (run.get("engine_speed") or {}).get("value")
            label = run.get("label") or run.get("model") or ""
            yield from _quantities(
                run.get("quantities", {}), label if speed is None else f"{label} at {speed:g} rpm"
            )
    others = {key: value for key, value in answer.items() if key not in NO_RESULT}
    runs = [
        run
        for run in answer.get("runs", ())
        if not (isinstance(run, Mapping) and "quantities" in run)
    ]
    yield from _others(others | {"runs": runs}, ())


def _others(
    item: Any, path: tuple[str, ...]
) -> Iterator[tuple[tuple[str, str], tuple[float, str]]]:
    """(last part of the path, those before it) -> value and unit, of every number that is not a
    quantity of a run.
    """
    if len(path) > MAX_DEPTH:
        return
    if isinstance(item, Mapping):
        if path and is_number(item.get("value")) and isinstance(item.get("unit"), str):
            yield (path[-1], ", ".join(path[:-1])), (float(item["value"]), item["unit"])
            item = {key: value for key, value in item.items() if key not in ("value", "unit")}
        for key, value in item.items():
            if key not in NUMERICS:
                yield from _others(value, (*path, str(key)))
    elif isinstance(item, list):
        for name, value in zip(_names_of(item), item, strict=True):
            yield from _others(value, (*path, name))
    elif is_number(item) and path:
        yield (path[-1], ", ".join(path[:-1])), (float(item), "")


def _names_of(items: list[Any]) -> list[str]:
    """Identifiers of the items of a list: their names, with the engine speed where these repeat,
    else numbers from 1.
    """
    names = [
        " ".join(item[key] for key in IDENTIFYING if isinstance(item.get(key), str))
        if isinstance(item, Mapping)
        else ""
        for item in items
    ]
    speeds = [item.get("engine_speed") if isinstance(item, Mapping) else None for item in items]
    numbers = [speed.get("value") if isinstance(speed, Mapping) else None for speed in speeds]
    with_speed = [
        f"{name} {number:g} rpm".strip() if is_number(number) else name
        for name, number in zip(names, numbers, strict=True)
    ]
    for some in (names, with_speed):
        if len(set(some)) == len(some) and all(some):
            return some
    return [f"{name} {number}".strip() for number, name in enumerate(names, start=1)]


def _quantities(
    values: Mapping[str, Any], run: str
) -> Iterator[tuple[tuple[str, str], tuple[float, str]]]:
    for name, item in values.items():
        if is_defined(name) and not definition_of(name).physical:
            continue
        if isinstance(item, Mapping) and isinstance(item.get("value"), (int, float)):
            yield (name, run), (float(item["value"]), str(item.get("unit", "")))
