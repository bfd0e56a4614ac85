"""What differs between two kept runs: in their inputs by key path, in their results by quantity and
run. Nothing is printed here.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from valvetrain.runs.saved_runs import SavedRun, check_inputs

#: What an answer tells of how it was asked and made, and what only says its other numbers again.
NO_RESULT = (
    "command", "command_line", "case", "title", "digest", "checksum", "changed", "created_at", "choices", "versions", "files", "folder",
    "page", "units", "cite", "kept_from_before", "known_before", "quantities", "quantities_by_label", "springs_at_rest", "comparisons",
    "findings",
)  # fmt: skip
#: Levels of an answer that are looked into; none that is written has half of them.
DEEPEST = 24
#: Fields that tell the items of a list apart.
TOLD_APART = (
    "measurement",
    "key",
    "quantity",
    "name",
    "channel",
    "label",
    "model",
    "spring_set",
    "source",
    "event",
    "kind",
)


@dataclass(frozen=True, slots=True)
class ResultDifference:
    """A ``quantity`` (SI, ``unit``) of a ``run`` (label and speed; empty for what belongs to none)
    that is not the same; None: missing.
    """

    quantity: str
    run: str
    unit: str
    a: float | None
    b: float | None

    @property
    def difference(self) -> float | None:
        """Value of B less value of A."""
        return None if self.a is None or self.b is None else self.b - self.a

    @property
    def relative(self) -> float | None:
        """Difference over the size of A's value; None where that is zero or missing."""
        return None if self.difference is None or not self.a else self.difference / abs(self.a)


def input_differences(one: SavedRun, other: SavedRun) -> tuple[tuple[str, Any, Any], ...]:
    """(key path, value of ``one``, value of ``other``) of all inputs that differ: case, choices,
    versions; None where a key is missing.

    Raises :class:`InputError` where the inputs on disk are not those that a run was made from.
    """
    for run in (one, other):
        check_inputs(run)
    first, second = _inputs_of(one), _inputs_of(other)
    keys = dict.fromkeys((*first, *second))
    return tuple(
        (key, first.get(key), second.get(key)) for key in keys if first.get(key) != second.get(key)
    )


def result_differences(one: SavedRun, other: SavedRun) -> tuple[ResultDifference, ...]:
    """Every number of either run that is not the same in the other: those that both have first, the
    largest relative one before.
    """
    first, second = dict(_numbers(one.answer)), dict(_numbers(other.answer))
    rows = []
    for key in dict.fromkeys((*first, *second)):
        (a, unit), (b, other_unit) = first.get(key, (None, "")), second.get(key, (None, ""))
        if a != b:
            rows.append(ResultDifference(*key, unit or other_unit, a, b))
    return tuple(sorted(rows, key=lambda row: (row.difference is None, -abs(row.relative or 0.0))))


def _inputs_of(run: SavedRun) -> dict[str, Any]:
    try:
        values = dict(_leaves(tomllib.loads(run.case_file.read_text("utf-8"))))
    except (OSError, ValueError, RecursionError):
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
        for place, value in enumerate(item):
            yield from _leaves(value, f"{path}.{place}")
    else:
        yield path, item


def _numbers(answer: Mapping[str, Any]) -> Iterator[tuple[tuple[str, str], tuple[float, str]]]:
    """(quantity, run in words) -> value and unit, of every named number of a ``run.json``."""
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
    """(last word of the path, those before it) -> value and unit, of every number of an answer that
    is no quantity of a run.
    """
    if len(path) > DEEPEST:
        return
    if isinstance(item, Mapping):
        if path and _is_number(item.get("value")) and isinstance(item.get("unit"), str):
            yield (path[-1], ", ".join(path[:-1])), (float(item["value"]), item["unit"])
            item = {key: value for key, value in item.items() if key not in ("value", "unit")}
        for key, value in item.items():
            yield from _others(value, (*path, str(key)))
    elif isinstance(item, list):
        for name, value in zip(_names_of(item), item, strict=True):
            yield from _others(value, (*path, name))
    elif _is_number(item) and path:
        yield (path[-1], ", ".join(path[:-1])), (float(item), "")


def _names_of(items: list[Any]) -> list[str]:
    """What tells the items of a list apart: their names, where these do not the engine speed too,
    else their places from 1.
    """
    names = [
        " ".join(item[key] for key in TOLD_APART if isinstance(item.get(key), str))
        if isinstance(item, Mapping)
        else ""
        for item in items
    ]
    speeds = [item.get("engine_speed") if isinstance(item, Mapping) else None for item in items]
    told = [
        f"{speed['value']:g} rpm"
        if isinstance(speed, Mapping) and _is_number(speed.get("value"))
        else ""
        for speed in speeds
    ]
    for some in (
        names,
        [f"{name} {speed}".strip() for name, speed in zip(names, told, strict=True)],
    ):
        if len(set(some)) == len(some) and all(some):
            return some
    return [f"{name} {place}".strip() for place, name in enumerate(names, start=1)]


def _is_number(item: Any) -> bool:
    return isinstance(item, (int, float)) and not isinstance(item, bool)


def _quantities(
    values: Mapping[str, Any], run: str
) -> Iterator[tuple[tuple[str, str], tuple[float, str]]]:
    for name, item in values.items():
        if isinstance(item, Mapping) and isinstance(item.get("value"), (int, float)):
            yield (name, run), (float(item["value"]), str(item.get("unit", "")))
