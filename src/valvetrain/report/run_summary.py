"""Rows for terminal and page: critical speeds of a sweep, differences
of two saved runs.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from valvetrain.mechanism.rigid import OPEN_SHARE
from valvetrain.report.text import amount, in_unit, number, percent, quantity_label, rpm
from valvetrain.runs.differences import ResultDifference
from valvetrain.solution.critical import KINDS, CriticalSpeed
from valvetrain.solution.definition import is_defined, label_of, shown, topics
from valvetrain.solution.result import Solution
from valvetrain.solution.study import SWEEPS, Study
from valvetrain.system.contract import TRAIN

NOT_COMPUTED = "not computed"
#: How the ranges of critical speeds came about and what the words for an onset mean.
RANGES_NOTE = (
    "Each speed is found inside its bracket to 0.01 rpm and again with another spring model, with half the time step, with 1.5 times the "
    "masses, elements or modes of the springs (the mesh), and with the damping of the springs times 0.6 and 1.5, which is known to no better "
    "than a factor of two: the range holds all of these speeds and names what its ends come from. Just touching zero: the force reaches zero "
    "so flatly that a tenth of it more or less moves the speed by more than 7.5 %. Motion does not repeat: it differs from revolution to "
    "revolution, the range reaches from where it keeps control to where it loses it every time. A run in which the ends of the spring would "
    "pull gives no critical speed."
)
#: What the rows below a critical speed mean.
CRITICAL_LEGEND = (
    "until: control returns there; rising / falling speed: where control is lost when the motion is carried on from "
    "speed to speed upwards, and where it returns downwards (between the two both motions exist); again: further ranges of speed without control; "
    "single revolutions: short ranges before, in which some revolutions of a motion that does not repeat lose control."
)
#: Ranges of further stretches that are named; of more only how many.
MAX_AGAIN = 2
#: Engine speeds that are named where the motion did not settle.
MAX_UNSETTLED = 4


@dataclass(frozen=True, slots=True)
class CriticalRow:
    """One row: quantity, label, and a cell per label of the study (speeds in rpm)."""

    name: str
    label: str
    cells: tuple[str, ...]
    main: bool = False


def searched(study: Study) -> bool:
    """Whether the study is a sweep of a train, which reports critical speeds."""
    return study.command in SWEEPS and any(
        run.provenance.system == TRAIN for run in study.solutions
    )


def critical_rows(study: Study, labels: Sequence[str]) -> list[CriticalRow]:
    """A row per kind of critical speed; below it the speed at which control returns, hysteresis,
    further ranges, and short ones before in which single revolutions lose control.
    """
    rows = []
    for kind, name in KINDS.items():
        found = [study.critical_speeds.of(kind, label) for label in labels]
        main = tuple(NOT_COMPUTED if one is None else one.text for one in found)
        rows.append(CriticalRow(name, quantity_label(name), main, True))
        for text, cell in (
            ("until", _until),
            ("rising / falling speed", _hysteresis),
            ("again", _again),
            ("single revolutions", _passed),
        ):
            cells = tuple("" if one is None else cell(one) for one in found)
            if any(cells):
                rows.append(CriticalRow(name, text, cells))
    return rows


def control_legend(study: Study) -> str:
    """From what on a train has lost control, of the search of a sweep; empty without one."""
    limits = {row.kind: amount(in_unit(row.limit, "mm"), "mm") for row in study.critical_speeds}
    if not limits:
        return ""
    return (
        f"Controlled: no contact of the drive opens while the valve is open by more than {OPEN_SHARE:.0%} of its lift".replace(
            "%", " %"
        )
        + f"; float: more than {limits['float']} above the rigid lift; bounce: higher than {limits['bounce']}."
    )


def critical_notes(study: Study) -> tuple[str, ...]:
    """How the critical speeds were searched."""
    if not len(study.critical_speeds):
        return ()
    one = study.critical_speeds.rows[0]
    return (
        control_legend(study),
        f"Searched from {rpm(one.first_engine_speed):.6g} to {rpm(one.last_engine_speed):.6g} rpm, every speed from rest, and about each "
        f"change with the motion of the neighbouring speed carried on, rising and falling; brackets of {rpm(one.resolution):.3g} rpm or "
        f"less. A very narrow speed range may be missed.",
        *((RANGES_NOTE,) if any(row.onset for row in study.critical_speeds) else ()),
        *dict.fromkeys(
            f"The range of {row.label} holds no run with {one.cause} {one.change}: {one.refusal}."
            for row in study.critical_speeds
            for one in row.members
            if one.refusal
        ),
    )


def _until(one: CriticalSpeed) -> str:
    if not one.found:
        return ""
    return (
        f"{rpm(one.last_engine_speed):.6g} or more" if one.ends is None else str(one.ends.from_rest)
    )


def _hysteresis(one: CriticalSpeed) -> str:
    """The brackets of rising and falling speed where they are apart by more than the resolution,
    empty elsewhere, and where there are none: a motion that does not repeat has no branch to follow.
    """
    if one.begins is None:
        return ""
    ways = (one.begins.rising, one.begins.falling)
    if not any(ways):
        return ""
    same = all(way is not None and way.apart(one.begins.from_rest) <= 0 for way in ways)
    return "" if same else " / ".join("none" if way is None else str(way) for way in ways)


def _again(one: CriticalSpeed) -> str:
    if len(one.again) > MAX_AGAIN:
        first, last = rpm(one.again[0].lower_engine_speed), rpm(one.again[-1].upper_engine_speed)
        return f"{len(one.again)} times, {first:.0f}–{last:.0f}"
    return ", ".join(map(str, one.again))


def _passed(one: CriticalSpeed) -> str:
    return ", ".join(map(str, one.passed[:MAX_AGAIN]))


def unsettled_text(runs: Sequence[Solution]) -> str:
    """How many runs of a label did not settle, and at which engine speeds (rpm): ``2: 7400, 8000``;
    empty where all did.
    """
    speeds = [rpm(run.engine_speed) for run in runs if run.status.code == "not-converged"]
    if not speeds:
        return ""
    named = ", ".join(f"{one:.6g}" for one in speeds[:MAX_UNSETTLED])
    more = f" and {len(speeds) - MAX_UNSETTLED} up to {speeds[-1]:.6g}"
    return f"{len(speeds)}: {named}{more if len(speeds) > MAX_UNSETTLED else ''}"


def share(value: float) -> str:
    """A ratio in per cent with two significant digits; empty for none."""
    return (
        ""
        if not math.isfinite(value)
        else f"{100 * value:.2g} %"
        if abs(value) < 0.995
        else f"{100 * value:.0f} %"
    )


INPUT_HEADS = ("inputs", "A", "B")
RESULT_HEADS = ("results", "run", "A", "B", "", "difference")


def input_rows(inputs: Sequence[tuple[str, Any, Any]]) -> list[tuple[str, ...]]:
    """Rows of the inputs that differ: key path, value in A, value in B.

    >>> input_rows([("spring.total_coils", 6, None)])
    [('spring.total_coils', '6', '–')]
    """
    return [(key, _word(first), _word(second)) for key, first, second in inputs]


def result_rows(results: Sequence[ResultDifference]) -> list[tuple[str, ...]]:
    """Rows of the numbers that both runs have and that differ: headline quantities first, then the
    largest difference.

    >>> result_rows([ResultDifference("peak_spring_force", "massless", "N", 800.0, 840.0)])
    [('peak spring force below 10 kHz', 'massless', '800', '840', 'N', '+5.0 %')]
    """
    first = [name for names in topics().values() for name in names]
    place = {name: index for index, name in enumerate(first)}
    both = sorted(
        (row for row in results if row.difference is not None),
        key=lambda row: place.get(row.quantity, len(first)),
    )
    rows: list[tuple[str, ...]] = []
    for row in both:
        change = "" if row.relative is None else percent(row.relative)
        if is_defined(row.quantity):
            a, b = (
                number(float(shown(row.quantity, value)[0]))
                for value in (row.a or 0.0, row.b or 0.0)
            )
            rows.append(
                (label_of(row.quantity), row.run, a, b, shown(row.quantity, 1.0)[1], change)
            )
        else:
            label = row.quantity.replace("_", " ")
            rows.append(
                (
                    label,
                    row.run.replace("_", " "),
                    number(row.a or 0.0),
                    number(row.b or 0.0),
                    row.unit,
                    change,
                )
            )
    return rows


def _word(value: Any) -> str:
    text = (
        "–"
        if value is None
        else ", ".join(map(str, value))
        if isinstance(value, list)
        else str(value)
    )
    return text if len(text) <= 60 else text[:57] + "..."
