"""Headline quantities of a study in the order of their topics, for terminal, JSON and page."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from valvetrain.quantities.limits import MARK, PassedLimit, passed_limits
from valvetrain.report.control import range_in_use
from valvetrain.report.run_summary import critical_rows, searched
from valvetrain.report.text import (
    clash_pair,
    number,
    peak_angle,
    quantity_label,
    rpm_text,
    speed_text,
)
from valvetrain.solution.definition import definition_of, names_for, shown, topics
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Event
from valvetrain.solution.study import Study
from valvetrain.units.reader import reader_factor, reader_unit

#: What is nothing but rounding, in any shown unit.
_ROUNDING = 1e-9
#: Quantities that are said of each spring of a nested pair, not of both.
OF_EACH = ("surge_frequency", "coil_bind_clearance")
#: What is lost, left out where it is negative: a valve that flies loses no lift, its flight has a row.
LOSSES = ("lift_loss_displacement",)
#: Clashes that are named one by one, per run.
NAMED_CLASHES = 5


@dataclass(frozen=True, slots=True)
class HeadlineColumn:
    """A run or, in a sweep, all runs of a label (``engine_speed`` None)."""

    label: str
    engine_speed: float | None = None

    @property
    def heading(self) -> str:
        """Label and engine speed."""
        return (
            self.label
            if self.engine_speed is None
            else f"{self.label}, {speed_text(self.engine_speed)}"
        )


@dataclass(frozen=True, slots=True)
class HeadlineRow:
    """One quantity over the columns: ``values`` in ``unit`` (None where not given).

    ``engine_speeds`` (rad/s): where a sweep has the worst value of each column, None where that
    does not apply. ``cells``: what is shown where a number alone is not enough (a bracket,
    "none up to 9000"), empty elsewhere. ``passed``: whether a value passes its limit. ``beyond``:
    the extremes of a sweep beyond its speeds in use (red line, else control) where they are worse.
    """

    topic: str
    name: str
    label: str
    unit: str
    values: tuple[float | None, ...]
    engine_speeds: tuple[float | None, ...]
    cells: tuple[str, ...] = ()
    passed: tuple[bool, ...] = ()
    beyond: HeadlineRow | None = None

    def mark(self, place: int) -> str:
        """The mark behind the value of a column that passes a limit, empty elsewhere."""
        return MARK if self.passed and self.passed[place] else ""


def headline_columns(study: Study) -> tuple[HeadlineColumn, ...]:
    """Runs by label and engine speed; in a sweep labels alone; without runs the labels of the
    static results.
    """
    if not study.solutions:
        return tuple(HeadlineColumn(label) for label in study.still)
    if study.over_speed:
        return tuple(HeadlineColumn(label) for label in study.labels)
    return tuple(
        HeadlineColumn(label, run.engine_speed)
        for label in study.labels
        for run in study.runs(label)
    )


def headline_rows(study: Study) -> tuple[HeadlineRow, ...]:
    """Headline quantities by topic; a sweep gives the worst value of each label and its engine
    speed.
    """
    columns = headline_columns(study)
    critical = (
        [row for row in critical_rows(study, [one.label for one in columns]) if row.main]
        if searched(study)
        else []
    )
    cells = {row.name: row.cells for row in critical}
    rows = []
    used = [_in_use(study, column, _runs(study, column)) for column in columns]
    limits = [{one.quantity for one in _passed(runs)} for runs in used]
    for topic, names in topics().items():
        for name in names:
            found = [
                _value(study, column, name, runs)
                for column, runs in zip(columns, used, strict=True)
            ]
            if name in OF_EACH:
                found = [
                    (None, None)
                    if _value(study, column, f"outer_{name}", runs)[0] is not None
                    else one
                    for column, runs, one in zip(columns, used, found, strict=True)
                ]
            if name in cells or any(value is not None for value, _ in found):
                values, speeds = zip(*found, strict=True)
                unit, own = definition_of(name).unit_word, cells.get(name, ())
                passed = tuple(name in some for some in limits)
                label = quantity_label(name)
                row = HeadlineRow(topic, name, label, unit, values, speeds, own, passed)
                rows.append(replace(row, beyond=_beyond(study, columns, row)))
    return tuple(rows)


def _in_use(study: Study, column: HeadlineColumn, runs: list[Solution]) -> list[Solution]:
    """Of a sweep the runs up to the red line, or while control is maintained; all of them where none is."""
    if column.engine_speed is not None or not study.solutions:
        return runs
    limit, _ = range_in_use(study)
    return [run for run in runs if run.engine_speed <= limit] or runs


def _beyond(
    study: Study, columns: Sequence[HeadlineColumn], row: HeadlineRow
) -> HeadlineRow | None:
    """The row of the extremes beyond the speeds in use; None where no column has a worse one there."""
    found, passed = [], []
    for column, value, speed in zip(columns, row.values, row.engine_speeds, strict=True):
        runs = _runs(study, column)
        worse = _value(study, column, row.name, runs) if speed is not None else (None, None)
        found.append((None, None) if worse[0] == value else worse)
        names = {one.quantity for one in _passed(runs)}
        passed.append(found[-1][0] is not None and row.name in names)
    if all(value is None for value, _ in found):
        return None
    values, speeds = zip(*found, strict=True)
    label = f"beyond {range_in_use(study)[1]}"
    return replace(row, label=label, values=values, engine_speeds=speeds, passed=tuple(passed))


def _runs(study: Study, column: HeadlineColumn) -> list[Solution]:
    """The runs of a column; over engine speed those between the swept speeds too."""
    if column.engine_speed is None:
        between = [run for run in study.between if run.label == column.label]
        return sorted((*study.runs(column.label), *between), key=lambda run: run.engine_speed)
    return [run for run in study.runs(column.label) if run.engine_speed == column.engine_speed]


def _passed(runs: Sequence[Solution]) -> list[PassedLimit]:
    return [one for run in runs for one in passed_limits(run.quantities).values()]


def limit_sentences(study: Study, reasons: bool = True) -> tuple[str, ...]:
    """What the marks say: per quantity and label the worst value that passes its limit, with the
    ``reasons`` of the limits.
    """
    found = []
    for label in study.labels:
        worst: dict[str, tuple[PassedLimit, Solution]] = {}
        every = _runs(study, HeadlineColumn(label)) if study.over_speed else study.runs(label)
        for run in every:
            for name, one in passed_limits(run.quantities).items():
                if name not in worst or abs(one.value - one.limit) > abs(
                    worst[name][0].value - worst[name][0].limit
                ):
                    worst[name] = one, run
        for one, run in worst.values():
            reason = f": {one.reason}." if reasons else ""
            found.append(f"{label}, {rpm_text(run.engine_speed)} rpm: {one.comparison}{reason}")
    return tuple(found)


def clashes_of(run: Solution) -> tuple[Event, ...]:
    """All coil clashes of a run by decreasing energy, then impulse."""
    mine = (event for event in run.events if event.kind == "clash")
    return tuple(
        sorted(
            mine,
            key=lambda event: (-_detail(event, "energy"), -_detail(event, "impulse"), event.time),
        )
    )


def largest_clash_rows(
    study: Study, columns: Sequence[HeadlineColumn]
) -> list[tuple[str, str, tuple[str, ...]]]:
    """(label, unit, cells) of coils, angle of the peak force and impulse of the largest clash of every
    run; empty without clashes.
    """
    runs = [
        None
        if one.engine_speed is None or not study.solutions
        else study.solution(one.label, one.engine_speed)
        for one in columns
    ]
    events = [None if run is None else next(iter(clashes_of(run)), None) for run in runs]
    if not any(events):
        return []
    angles = [None if one is None else peak_angle(one) for one in events]
    rows = [
        (
            "largest by energy: coils",
            "",
            tuple("–" if one is None else clash_pair(one) for one in events),
        ),
        ("its peak at cam angle", "deg", _cells(angles)),
    ]
    lifts = [_lift_at(run, one) for run, one in zip(runs, events, strict=True)]
    if any(one != "–" for one in lifts):
        rows.append(("valve lift there", reader_unit("mm"), tuple(lifts)))
    sizes = [None if one is None else clash_size(one, "impulse") for one in events]
    if any(size is not None for size in sizes):
        unit, factor = reader_unit("mN s"), reader_factor("mN s")
        rows.append(
            ("impulse", unit, _cells([None if one is None else one * factor for one in sizes]))
        )
    return rows


def _lift_at(run: Solution | None, event: Event | None) -> str:
    """``0.24 closing``: valve lift in the reader's unit at the peak of a clash, and where the valve goes; a dash
    of a run that has no lift."""
    if run is None or event is None or not run.has("valve_lift"):
        return "–"
    angle = math.radians(peak_angle(event))
    here, later = np.interp([angle, angle + 0.01], run.cam_angle, run.channel("valve_lift"), period=math.tau)  # fmt: skip
    way = "" if here == later else " closing" if here > later else " opening"
    return number(1e3 * float(here) * reader_factor("mm"), 3) + way


def _cells(values: Sequence[float | None]) -> tuple[str, ...]:
    return tuple(map(number, values))


def clash_size(event: Event, name: str) -> float | None:
    """Impulse (mN s) or energy (mJ) of a clash; None where the model has none."""
    return _detail(event, name) * 1e3 if name in event.details else None


def _detail(event: Event, name: str) -> float:
    value = event.details.get(name, 0.0)
    return float(value) if isinstance(value, (int, float)) else 0.0


def _value(
    study: Study, column: HeadlineColumn, name: str, runs: Sequence[Solution]
) -> tuple[float | None, float | None]:
    """A quantity of a column over its ``runs`` in its shown unit and, in a sweep, the engine speed of its
    worst value.
    """
    known = [
        (run.quantities[name], run.engine_speed)
        for run in runs
        if math.isfinite(run.quantities.get(name, math.nan))
        and not (name in LOSSES and run.quantities[name] < 0)
    ]
    if known:
        least = definition_of(name).sense == "larger is better" or "minimum" in name
        value, speed = (min if least else max)(known, key=lambda pair: pair[0])
        several = column.engine_speed is None and len({one for one, _ in known}) > 1
        seen = float(shown(name, value)[0])
        seen = 0.0 if abs(seen) < _ROUNDING else seen
        return (
            (None, None)
            if several and name in names_for("one speed")
            else (seen, speed if several else None)
        )
    models = (run.model for run in runs)
    for label in dict.fromkeys((column.label, *models, "")):
        value = study.still.get(label, {}).get(name, math.nan)
        if math.isfinite(value):
            return float(shown(name, value)[0]), None
    return None, None
