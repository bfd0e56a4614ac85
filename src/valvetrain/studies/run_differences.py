"""What differs between two kept runs: in their inputs by key path, in their results by quantity and run. Nothing is printed here."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from valvetrain.studies.run_store import KeptRun, check_inputs


@dataclass(frozen=True, slots=True)
class ResultDifference:
    """A ``quantity`` (SI, ``unit``) of a ``run`` (label and speed; empty for what belongs to none) that is not the same; None: missing."""

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


def input_differences(one: KeptRun, other: KeptRun) -> tuple[tuple[str, Any, Any], ...]:
    """(key path, value of ``one``, value of ``other``) of all inputs that differ: case, choices, versions; None where a key is missing.

    Raises :class:`InputError` where the inputs on disk are not those that a run was made from.
    """
    for run in (one, other):
        check_inputs(run)
    first, second = _inputs_of(one), _inputs_of(other)
    keys = dict.fromkeys((*first, *second))
    return tuple((key, first.get(key), second.get(key)) for key in keys if first.get(key) != second.get(key))


def result_differences(one: KeptRun, other: KeptRun) -> tuple[ResultDifference, ...]:
    """Every number of either run that is not the same in the other: those that both have first, the largest relative one before."""
    first, second = dict(_numbers(one.answer)), dict(_numbers(other.answer))
    rows = []
    for key in dict.fromkeys((*first, *second)):
        (a, unit), (b, other_unit) = first.get(key, (None, "")), second.get(key, (None, ""))
        if a != b:
            rows.append(ResultDifference(*key, unit or other_unit, a, b))
    return tuple(sorted(rows, key=lambda row: (row.difference is None, -abs(row.relative or 0.0))))


def _inputs_of(run: KeptRun) -> dict[str, Any]:
    try:
        values = dict(_leaves(tomllib.loads(run.case_file.read_text("utf-8"))))
    except (OSError, ValueError, RecursionError):
        values = {}
    about = {"case": run.case, "command": run.answer.get("command"), "choices": run.answer.get("choices")}
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
    for label, values in {"": answer.get("quantities", {}), **answer.get("quantities_by_label", {})}.items():
        yield from _quantities(values, label)
    for run in answer.get("runs", ()):
        speed = (run.get("engine_speed") or {}).get("value")
        label = run.get("label") or run.get("model") or ""
        yield from _quantities(run.get("quantities", {}), label if speed is None else f"{label} at {speed:g} rpm")


def _quantities(values: Mapping[str, Any], run: str) -> Iterator[tuple[tuple[str, str], tuple[float, str]]]:
    for name, item in values.items():
        if isinstance(item, Mapping) and isinstance(item.get("value"), (int, float)):
            yield (name, run), (float(item["value"]), str(item.get("unit", "")))
