"""Up to which engine speed a train is controlled, and what is lost from where: the loss that stays,
and the short ranges of lost contact below it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from valvetrain.quantities.loss_cause import leading_loss
from valvetrain.quantities.train_events import counted_losses
from valvetrain.report.clauses import Runs, joined
from valvetrain.report.run_clauses import cause_phrase, cause_text
from valvetrain.report.run_summary import searched
from valvetrain.report.text import rpm
from valvetrain.solution.critical import (
    FLOAT_LIFT,
    PULLED,
    CriticalSpeed,
    SpeedBracket,
    places_text,
)
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study

#: Kind of critical speed -> what happens there first, and what happens from there.
LOST = {
    "contact-loss": ("contact is lost", "loses contact"),
    "float": ("the valve floats", "floats"),
    "bounce": ("the valve bounces", "bounces"),
}
#: Share of a critical speed that its range is named from.
WIDE = 0.05


@dataclass(frozen=True)
class Loss:
    """One kind of lost control: its critical speed, and the ranges of engine speed (rad/s) that hold it,
    from 0 where it is lost from the first speed searched on.
    """

    row: CriticalSpeed
    ranges: tuple[SpeedBracket, ...]

    @property
    def begin(self) -> float:
        """Engine speed (rad/s) from which control is lost."""
        return self.ranges[0].lower_engine_speed


@dataclass(frozen=True)
class Control:
    """What a search found of a label: ``losses`` by their begin, and ``islands``, short ranges of lost contact
    below all of them in which the valve neither floats nor bounces; ``contact`` is the row of those.
    """

    losses: tuple[Loss, ...]
    islands: tuple[SpeedBracket, ...] = ()
    contact: CriticalSpeed | None = None

    @property
    def limit(self) -> float:
        """Engine speed (rad/s) up to which the train is controlled but for the islands; infinite for
        never lost.
        """
        return min((one.begin for one in self.losses), default=math.inf)

    def begin(self, kind: str) -> float:
        """Engine speed (rad/s) from which control is lost in one way, islands left out; infinite for
        never.
        """
        return min((one.begin for one in self.losses if one.row.kind == kind), default=math.inf)


def control_of(study: Study, label: str) -> Control:
    """The control of a label by the critical speeds of a study."""
    losses = [
        Loss(one, one.ranges) for one in study.critical_speeds if one.label == label and one.found
    ]
    contact = next((one for one in losses if one.row.kind == "contact-loss"), None)
    others = [one for one in losses if one is not contact]
    other = min((one.begin for one in others), default=math.inf)
    islands = () if contact is None else contact.row.short_ranges(other)
    if contact is not None and islands:
        left = contact.ranges[len(islands) :]
        losses = [*others, *([Loss(contact.row, left)] if left else [])]
    ordered = tuple(sorted(losses, key=lambda one: one.begin))
    return Control(ordered, islands, None if contact is None else contact.row)


def controlled_to(study: Study, label: str) -> float:
    """Engine speed (rad/s) from which a label loses contact, floats or bounces, short ranges of lost contact
    left out: infinite for never, 0 where it does from the first speed on.
    """
    return control_of(study, label).limit


def range_in_use(study: Study) -> tuple[float, str]:
    """Engine speed (rad/s) up to which extremes over engine speed count first, and what ends there: the red line
    where the case states one, else control; of several labels that of the first to lose it, so that they compare.
    """
    if (line := study.record.red_line) is not None:
        return line, "the red line"
    limit = min((controlled_to(study, label) for label in study.labels), default=math.inf)
    return limit, "control" if len(study.labels) < 2 else f"{rpm(limit):.0f} rpm"


def control_clauses(study: Study, label: str, runs: Runs) -> list[str]:
    """Up to where everything stays in contact, and what happens from where."""
    every = [one for one in study.critical_speeds if one.label == label]
    if not searched(study) or not every:
        return [_control_of_runs(runs, study.record.red_line)]
    control = control_of(study, label)
    first, last = every[0].first_engine_speed, every[0].last_engine_speed
    apart, apart_cause = _apart(control, runs)
    reached = last if not control.losses else max(control.limit, first)
    margin = red_line_margin(reached, study.record.red_line)
    pulled = [span_text(one) for one in every[0].pulled]
    silent = (
        [f"{PULLED} at {joined(pulled)} rpm, where nothing is known of control"] if pulled else []
    )
    if not control.losses:
        reach = f"controlled up to {rpm(last):.6g} rpm, the highest speed searched{margin}"
        return [f"{reach}{apart}{_least_force(runs)}", *silent]
    lost = control.losses[0]
    row, whole = lost.row, not control.islands or lost.row is not control.contact
    line, span = study.record.red_line, row.span
    if (
        line is not None
        and whole
        and span is not None
        and span.lower_engine_speed < line < lost.begin
    ):
        margin += ", which its range reaches below"
    what = LOST[row.kind][0]
    if row.kind == "contact-loss" and row.places:
        what += f" at the {places_text(*row.places)}"
    begun = (
        f"not controlled: {what} already at {rpm(first):.6g} rpm, the lowest speed searched{margin}"
        if lost.begin <= 0
        else f"controlled to {rpm(lost.begin):.0f} rpm{_over(row)}{margin}, where {what}"
    )
    cause = _cause(row, runs) if whole else _cause_from(lost, runs)
    begun += f" because {cause}" if cause and cause != apart_cause else ""
    begun += _until(lost)
    others = [_loses(one, runs, cause) for one in control.losses[1:]]
    unit = " rpm" if others and not others[-1].endswith(")") else ""
    also = list(filter(None, (_first_angle(lost, runs),)))
    both = row.both_motions if whole else None
    if both is not None:
        low, high = (f"{rpm(one):.0f}" for one in both)
        branches = f"from {low} to {high} rpm both motions exist: rising speed keeps control, falling speed does not regain it"
        also.insert(0, branches)
    return [f"{begun}{apart}", *([f"{joined(others)}{unit}"] if others else []), *also, *silent]


def _first_angle(lost: Loss, runs: Runs) -> str:
    """``contact opens at 242 cam deg``: where at the critical speed itself, else ``(run at 7000 rpm)`` in the
    first run from there on that shows it; empty of another loss.
    """
    if lost.row.kind != "contact-loss":
        return ""
    if math.isfinite(lost.row.cam_angle) and lost.begin == lost.row.engine_speed:
        return f"contact opens at {math.degrees(lost.row.cam_angle):.0f} cam deg"
    for run in runs.solutions:
        events = [one for one in counted_losses(run.events) if one.where in lost.row.places]
        if run.engine_speed >= lost.begin and events:
            angle = math.degrees(events[0].cam_angle) % 360
            return f"contact opens at {angle:.0f} cam deg (run at {_speed(run)})"
    return ""


def _apart(control: Control, runs: Runs) -> tuple[str, str]:
    """``, apart from 5218 to 5258 rpm, where contact is lost at the cam because ...`` and that cause."""
    row = control.contact
    if row is None or not control.islands:
        return "", ""
    spans = [span_text(one) for one in control.islands]
    place = f" at the {places_text(*row.places)}" if row.places else ""
    cause = _cause(row, runs)
    why = f" because {cause}" if cause else ""
    return f", apart from {joined(spans)} rpm, where contact is lost{place}{why}", cause


def red_line_margin(engine_speed: float, red_line: float | None) -> str:
    """How far ``engine_speed`` (rad/s) is beyond a red line or below it; empty without one.

    >>> from math import pi
    >>> red_line_margin(6598 * pi / 30, 6200 * pi / 30)
    ', 398 rpm above the red line of 6200'
    """
    if red_line is None:
        return ""
    beyond = round(rpm(engine_speed) - rpm(red_line))
    if beyond == 0:
        return f", the red line of {rpm(red_line):.6g}"
    return f", {abs(beyond)} rpm {'above' if beyond > 0 else 'below'} the red line of {rpm(red_line):.6g}"


def span_text(one: SpeedBracket) -> str:
    """``5218 to 5258``; one speed where both are the same in whole rpm."""
    low, high = (f"{rpm(value):.0f}" for value in (one.lower_engine_speed, one.upper_engine_speed))
    return low if low == high else f"{low} to {high}"


def _over(row: CriticalSpeed) -> str:
    """The range of a critical speed where it is wide, rounded outwards, empty elsewhere."""
    span = row.span
    wide = WIDE * row.deciding_speed
    if span is None or not span.upper_engine_speed - span.lower_engine_speed > wide:
        return ""
    return f" ({row.range_text})"


def _loses(one: Loss, runs: Runs, first: str) -> str:
    """``floats from 7302``, ``floats from 7302 to 7419 and again from 7800``, ``floats at 7302``, with its cause
    where that is not the ``first``.
    """
    verb, begin = LOST[one.row.kind][1], f"{rpm(one.begin):.0f}"
    cause = _cause(one.row, runs, size=False)
    why = f" rpm ({cause})" if cause and not first.startswith(cause) else ""
    end, again = _end(one), _again(one)
    if one.begin <= 0:
        until = f" and up to {end}" if end else ""
        return f"{verb} below {rpm(one.row.first_engine_speed):.6g}{until}{again}{why}"
    where = f"at {begin}" if end == begin else f"from {begin}{f' to {end}' if end else ''}"
    return f"{verb} {where}{again}{why}"


def _until(one: Loss) -> str:
    """``, until 7419 and again from 7800 rpm`` behind a loss that ends within the speeds searched."""
    end, again = _end(one), _again(one)
    if not end:
        return ""
    alone = end == f"{rpm(one.begin):.0f}"
    until = "at this speed alone" if alone else f"until {end}"
    return f", {until}{again}{'' if alone and not again else ' rpm'}"


def _end(one: Loss) -> str:
    """The engine speed at which control returns; empty where it does not within those searched."""
    end = one.ranges[0].upper_engine_speed
    return f"{rpm(end):.0f}" if end < one.row.last_engine_speed else ""


def _again(one: Loss) -> str:
    """`` and again from 7800`` where control is lost once more, empty elsewhere."""
    again = one.ranges[1:]
    if not again:
        return ""
    ranges = f" in {len(again)} ranges" if len(again) > 1 else ""
    return f" and again{ranges} from {rpm(again[0].lower_engine_speed):.0f}"


def _least_force(runs: Runs) -> str:
    """``, minimum cam force 35 N at 6000 rpm``: a force of zero for a moment opens no contact yet."""
    force = runs.worst("minimum_cam_contact_force", True)
    if force is None:
        return ""
    where = "" if force.run is None else f" at {_speed(force.run)}"
    return f", minimum cam force {runs.text(force)}{where}"


def _cause(row: CriticalSpeed, runs: Runs, size: bool = True) -> str:
    """Why control is lost: at the critical speed itself where that was looked at, else in the first run
    from there on that shows it; empty where none shows a cause.
    """
    if row.cause:
        known = (row.spring_force_loss, row.surge_order) if size else (0.0, 0)
        return cause_phrase(row.cause, *known)
    return _cause_from(Loss(row, row.ranges), runs, size)


def _cause_from(lost: Loss, runs: Runs, size: bool = True) -> str:
    """Why control is lost in the first run from the begin of a loss on that shows it."""
    row = lost.row
    for run in runs.solutions:
        if run.engine_speed >= lost.begin and (
            cause := _cause_in(run, row.kind, row.limit, row.places, size)
        ):
            return cause
    return ""


def _cause_in(
    run: Solution, kind: str, limit: float, places: Sequence[str] = (), size: bool = True
) -> str:
    """Why a run loses control in one way, in its largest event above a ``limit`` (m), at one of the
    ``places`` where it has one there.
    """
    events = (
        counted_losses(run.events)  # of a force of zero alone the gap is none
        if kind == "contact-loss"
        else [one for one in run.events if one.kind == kind and one.size > limit]
    )
    events = [one for one in events if one.where in places] or events
    if not events:
        return ""
    leading = leading_loss(events) if kind == "contact-loss" else None
    at = f" at {_speed(run)}"
    text = cause_text(
        run, leading or max(events, key=lambda one: one.size), size, at if size else ""
    )
    return text if not size or not text or at in text else f"{text}{at}"


def _control_of_runs(runs: Runs, red_line: float | None) -> str:
    """The same of a sweep without search: from the runs themselves."""
    speeds, first = [run.engine_speed for run in runs.solutions], first_losses(runs)
    if not first:
        reach = f"in contact from {rpm(min(speeds)):.0f} to {rpm(max(speeds)):.0f} rpm"
        reach += red_line_margin(max(speeds), red_line)
        return f"{reach}{_least_force(runs)}"
    texts = [
        f"{LOST[kind][0]} already at {_speed(run)}, the lowest speed run"
        if run.engine_speed <= min(speeds)
        else f"{LOST[kind][0]} first at {_speed(run)}"
        for kind, run in first.items()
    ]
    kind, run = next(iter(first.items()))
    texts[0] += red_line_margin(run.engine_speed, red_line)
    cause = _cause_in(run, kind, FLOAT_LIFT if kind == "float" else 0.0)
    return joined([f"{texts[0]} because {cause}" if cause else texts[0], *texts[1:]])


def first_losses(runs: Runs) -> dict[str, Solution]:
    """Kind of critical speed -> the first run of a sweep without search that shows it, the slowest first."""
    first: dict[str, Solution] = {}
    for run in sorted(runs.solutions, key=lambda one: one.engine_speed):
        values = run.quantities
        for kind, value, limit in (
            ("contact-loss", values.get("loss_of_contact_duration", 0.0), 0.0),
            ("float", values.get("float_excess_lift", 0.0), FLOAT_LIFT),
        ):
            if value > limit:
                first.setdefault(kind, run)
    return first


def _speed(run: Solution) -> str:
    return f"{rpm(run.engine_speed):.0f} rpm"
