"""Rows of the first table of a study, declared one by one: what each shows of a run, and its mark and remark."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from valvetrain.findings.engine import Findings, Mark, above, below
from valvetrain.findings.facts import Facts
from valvetrain.findings.rules_sweep import (
    ALIKE,
    AMPLITUDE,
    SPEED,
    STRESS,
    SURGE,
    gain_text,
    gains,
    largest_stress,
    most_surge,
    pair,
    reached,
)
from valvetrain.findings.rules_train import FLOAT, NEAR_PISTON, hardest
from valvetrain.findings.words import (
    Amount,
    Words,
    about,
    fields_of,
    speed_text,
)
from valvetrain.parameters.material import FATIGUE_RANGES
from valvetrain.registry import BUILT_IN
from valvetrain.solution.critical import NEAR_BIND
from valvetrain.solution.definition import tables
from valvetrain.solution.result import Solution
from valvetrain.views.at_rest import rest_headings, rest_lines
from valvetrain.views.table import Line

#: Marks by falling gravity.
GRAVITY: tuple[Mark, ...] = ("bad", "warn", "ok", "")
#: Rows that say nothing of a difference between two springs.
NO_DIFFERENCE = ("most at", "valve open", "lost to flex")
#: Runs that are columns of the first table, at most, and of a search over engine speed.
COLUMNS, SEARCHED = 4, 3


class Limit(NamedTuple):
    """A ``quantity`` that is to be at most ``limit`` (SI, or the name of another quantity of the run), or at least that, and
    what stands behind a row that keeps it: a template with ``value`` and ``limit``.
    """

    quantity: str
    limit: float | str
    least: bool = False
    text: str = "limit {limit}"

    def kept(self, facts: Facts, run: Solution, words: Words) -> str:
        """The text, of one run, where every run keeps the limit; empty where one does not, or number or limit are unknown."""
        bound = facts.value(run, self.limit) if isinstance(self.limit, str) else self.limit
        amount, passed = facts.amount(run, self.quantity), below if self.least else above
        if (
            amount is None
            or not math.isfinite(bound)
            or any(passed(self.quantity, self.limit)(facts))
        ):
            return ""
        return words.fill(self.text, {"value": amount, "limit": Amount(self.quantity, bound)})


@dataclass(frozen=True)
class Row:
    """A row of the first table.

    Parameters
    ----------
    label : what it shows
    texts : templates over the names of quantities of a run; the first that can be filled is taken
    note : a few words behind it, where no finding has any
    of : what has the row, ``train``, ``spring`` or both (empty)
    limit : what it is checked against; a row without one has no tick of its own
    units : the system of the reader that it is for, ``si``, ``imperial`` or both (empty)
    """

    label: str
    texts: tuple[str, ...]
    note: str = ""
    of: str = ""
    limit: Limit | None = None
    units: str = ""

    @property
    def reads(self) -> tuple[str, ...]:
        """Quantities that its templates name."""
        return tuple(name for text in self.texts for name in fields_of(text))


SEAT = "{minimum_spring_force..peak_spring_force}"
#: A quantity that a row says as a place on the cam.
PLACE = "peak_cam_contact_force_cam_angle"
ROWS = (
    Row("on the cam", ("{minimum_cam_contact_force..peak_cam_contact_force}",), "least while open, most of all", "train"),
    Row("most at", ("{peak_cam_contact_force_cam_angle}",), "cam deg of the most", "train"),
    Row("off the cam", ("[{loft_gap}][, {loft_duration}]",), of="train"),
    Row("above its path", ("[{float_excess_lift}]",), of="train", limit=Limit("float_excess_lift", FLOAT)),
    Row("on the retainer", ("{minimum_retainer_force..peak_retainer_force}",), "what cam and valve feel", "spring"),
    Row("on the seat", (SEAT,), "below 10 kHz", "spring"),
    Row("coil on coil", ("{surge_clash_peak_force}",), "hardest blow", "spring"),
    Row("coil on coil", ("{surge_clash_peak_force}[, {clash_count} blows]", "{clash_count} blows"), "hardest blow", "train"),
    Row("landing", ("{seating_velocity}",), of="train", limit=Limit("seating_velocity", "permitted_seating_velocity")),
    Row("bounce", ("[{bounce_height:2}]",), of="train", limit=Limit("bounce_height", "permitted_bounce_height")),
    Row("to the piston", ("{minimum_piston_clearance_gap} left",), of="train", limit=Limit("minimum_piston_clearance_gap", NEAR_PISTON, least=True)),
    Row("spring", (SEAT,), of="train"),
    Row("needed, rigid", ("{needed_closed_spring_force..needed_open_spring_force}",), "at your rate, plus 20 %", "train"),
    Row("you have", ("{preload..open_spring_force}",), "seat to full lift, at rest", "train"),
    Row("surge, 0 to peak", ("{surge_amplitude_force}",)),
    Row("coil bind", ("{coil_bind_clearance} left",), "at full lift", limit=Limit("coil_bind_clearance", NEAR_BIND, least=True)),
    Row("by wire and turns", ("{wound_least_clearance..wound_most_clearance} left",), "to coil bind at full lift",
        limit=Limit("wound_least_clearance", NEAR_BIND, least=True)),
    Row("wire, shear", ("{minimum_shear_stress..peak_shear_stress}", "{outer_minimum_shear_stress..outer_peak_shear_stress} outer",
        "{closed_nominal_shear_stress..open_nominal_shear_stress} at rest"),
        limit=Limit("open_uncorrected_shear_stress", "permitted_shear_stress", text="uncorrected {value} of {limit} permitted")),
    Row("inner wire, shear", ("{inner_minimum_shear_stress..inner_peak_shear_stress}",)),
    Row("lost to flex", ("[{lift_loss_displacement:2}][, {valve_1_mm_lost_crank_angle_range:2}]",), of="train", units="si"),
    Row("lost to flex", ("[{lift_loss_displacement:2}][, {valve_50_thou_lost_crank_angle_range:2}]",), of="train", units="imperial"),
    Row("cam power", ("{mean_cam_power}",), "per valve", "train"),
)  # fmt: skip
#: Rows of one or two runs alone: what hardly changes over engine speed.
DETAILS = (
    Row("valve open", ("{valve_1_mm_open_crank_angle_range}",), "above 1 mm of valve lift", "train", units="si"),
    Row("valve open", ("{valve_50_thou_open_crank_angle_range}",), "above 0.050 in of valve lift", "train", units="imperial"),
    Row("first mode", ("{surge_frequency}",), "of the wire at rest", "spring"),
    Row("time step", ("{time_step_duration}",), "stable, starts from static equilibrium"),
)  # fmt: skip


def columns(facts: Facts, findings: Findings) -> list[Solution]:
    """The runs of the first table: at the speeds of the gravest findings, where control is first lost, at the highest and
    the lowest speed in use, and at some between; over engine speed of the variant that loses control first, but of two
    springs of both.
    """
    asked, runs = {id(run) for run in facts.study.solutions}, list(facts.runs)
    if facts.run_up and runs:
        flies = (run.label for run in runs if facts.value(run, "loft_gap") > 0)
        label = next(flies, runs[-1].label)
        runs = [run for run in runs if run.label == label]
    elif facts.study.command == "sweep":
        runs = [run for run in runs if run.label == facts.first_label] or runs
    labels = {run.label for run in runs}
    there = [one.fields.get("there") for one in findings.by("D10")]
    if both := [run for run in runs if speed_text(run.engine_speed) in there]:
        return both
    numbers = [one for one in findings if one.value is not None]
    named = [one for one in numbers if one.label in labels]
    worst = [one.engine_speed or 0.0 for one in named if one.level != "notes"]
    noted = [one.engine_speed or 0.0 for one in named]
    counted = Counter(
        run.engine_speed for run in runs if id(run) in asked or run.engine_speed in noted
    )
    speeds = sorted(speed for speed, count in counted.items() if count >= len(labels))
    if not speeds:
        return runs[:COLUMNS]
    most = SEARCHED if facts.searched else COLUMNS
    count = 1 if pair(facts) else max(most // len(labels), 1)
    even = [speeds[int(place)] for place in np.linspace(0, len(speeds) - 1, count).round()]
    lost = [one.value for one in numbers if one.quantity == SPEED and one.level != "notes"]
    begin = [speed for one in lost for speed in speeds if speed >= (one or 0.0)][:1]
    chosen = list[float]()
    for speed in dict.fromkeys((*worst, *begin, speeds[-1], speeds[0], *noted, *even)):
        alike = speed not in worst and any(abs(speed - one) < ALIKE * one for one in chosen)
        if speed in speeds and not alike and len(chosen) < count:
            chosen.append(speed)
    return [run for run in runs if run.engine_speed in chosen][:COLUMNS]


def headings(facts: Facts, findings: Findings) -> list[str]:
    """What tells the columns apart: the label, the engine speed, or both; of springs at rest the model."""
    if not facts.study.solutions:
        return rest_headings(facts)
    runs = columns(facts, findings)
    speeds, labels = len({run.engine_speed for run in runs}), len({run.label for run in runs})
    sets = len({run.spring_set for run in runs}) == labels
    names = ((run.spring_set if sets else run.label) * (labels > 1) for run in runs)
    several = speeds > 1 or bool(pair(facts))
    texts = (speed_text(run.engine_speed) * several for run in runs)
    return [", ".join(filter(None, both)) for both in zip(names, texts, strict=True)]


def first_rows(facts: Facts, findings: Findings, words: Words) -> list[Line]:
    """Six to ten rows; the mark is that of the gravest finding about a row, ``ok`` where its limit was checked and kept.

    Parameters
    ----------
    facts, findings : of the study
    words : units and language
    """
    if not facts.study.solutions:
        return rest_lines(facts, findings, words)
    lines, brief, told, runs = (
        list[Line](),
        replace(words, brief=True),
        set[str](),
        columns(facts, findings),
    )
    if pair(facts):
        lines += pair_lines(facts, runs, words)
    speeds = {run.engine_speed for run in runs}
    of, units = ("", "train" if facts.train else "spring"), ("", words.units)
    for row in (*ROWS, *(DETAILS if len(runs) < SEARCHED else ()), *_added_rows()):
        if row.of not in of or row.units not in units:
            continue
        if row.label in NO_DIFFERENCE and pair(facts):
            continue
        cells = _cells(row, facts, runs, brief)
        if not any(cells):
            continue
        about = findings.about(row.reads)
        mark: Mark = min((one.mark for one in about), key=GRAVITY.index, default="")
        telling = next((one for one in about if one.remark and one.code not in told), None)
        told.add(telling.code if telling else "")
        remark = telling.remark if telling else row.note
        if telling and telling.engine_speed is not None and telling.engine_speed not in speeds:
            remark += f" at {speed_text(telling.engine_speed)}" * (" rpm" not in remark)
        limit = "" if mark or row.limit is None else row.limit.kept(facts, runs[-1], brief)
        if limit:
            mark, remark = "ok", ", ".join(filter(None, (remark, limit)))
        if mark == "ok" and not limit:
            amounts = (facts.amount(run, name) for run in runs for name in row.reads)
            mark = "" if any(one and not one.resolved for one in amounts) else mark
        lines.append(Line(row.label, cells, mark, remark))
    return lines


def pair_lines(facts: Facts, runs: list[Solution], words: Words) -> list[Line]:
    """Of two springs in one engine: to which speed each keeps control and by how much longer the better one does, and its
    largest surge, stress and stress amplitude.
    """
    sets, more = [run.spring_set for run in runs], gains(facts)
    ends = tuple(reached(facts.control(run.label).limit) for run in runs)
    between, surge = "of the speeds searched", most_surge(facts)
    if len(more) > 1:
        between = f"{gain_text(more)} apart by model and damping"
    most = tuple(
        f"{words.amount(Amount(SURGE, surge[name][0]))} at {about(surge[name][1])} rpm" if name in surge else "" for name in sets
    )  # fmt: skip
    peak, amplitude = (
        tuple(words.amount(found[name]) if name in found else "" for name in sets)
        for found in (largest_stress(facts, STRESS), largest_stress(facts, AMPLITUDE))
    )
    endless = " or ".join(
        f"{words.amount(Amount(AMPLITUDE, (high - low) / 2))} {word}"
        for word, (low, high) in FATIGUE_RANGES.items()
    )
    lines = (
        Line("in control", ends, "", between),
        Line("most surge", most, "", "0 to peak, of the speeds in use"),
        Line("most shear", peak, "", "in motion, of the speeds in use"),
        Line("shear amplitude", amplitude, "", f"half its range in motion, endless to {endless}"),
    )  # fmt: skip
    return [one for one in lines if any(one.cells)]


def _added_rows() -> Iterator[Row]:
    """Quantities of installed packages that are shown of a run among many."""
    for table, rows in tables().items():
        for one in () if table in BUILT_IN["quantities"] else rows:
            if "brief" in one.uses:
                of = one.systems[0] if len(one.systems) == 1 else ""
                yield Row(one.label, (f"{{{one.name}}}",), of=of)


def _cells(row: Row, facts: Facts, runs: list[Solution], words: Words) -> tuple[str, ...]:
    """A row of all runs by the template that most of them can fill, so that all cells say the same; empty where numbers
    are missing.
    """
    names = {
        id(run): {
            name: one
            for name in row.reads
            if (one := hardest(facts, run) if name == PLACE else facts.amount(run, name))
        }
        for run in runs
    }
    rows = [tuple(words.cell(text, names[id(run)]) for run in runs) for text in row.texts]
    return max(rows, key=lambda cells: sum(map(bool, cells)))
