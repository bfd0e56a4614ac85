"""Verdicts over engine speed: up to where a train is controlled, what is lost then, and where surge
is worst.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from valvetrain.quantities.limits import passed_limits
from valvetrain.quantities.train_events import PLACES
from valvetrain.report.clauses import (
    ENDED,
    Runs,
    Worst,
    counted,
    ended_clauses,
    joined,
    quantity_text,
)
from valvetrain.report.run_clauses import (
    ENDS_PULL,
    SEATING,
    bind_clause,
    cause_phrase,
    cause_text,
    ends_that_pull,
    is_judged,
)
from valvetrain.report.run_summary import searched
from valvetrain.report.text import rpm
from valvetrain.solution.critical import FLOAT_LIFT, CriticalSpeed
from valvetrain.solution.definition import label_of
from valvetrain.solution.later import is_computed
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study
from valvetrain.system.contract import TRAIN

#: Kind of critical speed -> what happens there first, and what happens from there.
LOST = {
    "contact-loss": ("contact is lost", "loses contact from"),
    "float": ("the valve floats", "floats from"),
    "bounce": ("the valve bounces", "bounces from"),
}
#: Share of a critical speed that its range over damping and division is named from.
WIDE = 0.05
#: Share of the peak spring force up to which a surge is none, but what a massless spring leaves.
NO_SURGE = 1e-4
#: What is said of a surge below its error bar.
UNRESOLVED = ", not resolved"
#: Engine speeds that are named one by one.
MAX_NAMED = 3


class Surge(NamedTuple):
    """The largest surge amplitude (N) over the speeds of a label, its run and cam order (0: unknown)."""

    amplitude: float
    run: Solution
    order: int


def sweep_clauses(study: Study) -> list[str]:
    """Parts of the verdict over engine speed, of the worst label."""
    counts = [run for run in study.solutions if run.status.code in ("completed", "not-converged")]
    stopped = [one for one in ended_clauses(study.solutions) if ENDED["not-converged"] not in one]
    stopped += [study.interruption] if study.interruption else []
    if not counts:
        return stopped
    label = worst_label(study)
    runs = runs_over_speed(study, label)
    if not runs.solutions:
        return stopped
    several = len(study.labels) > 1
    train = any(run.provenance.system == TRAIN for run in runs.solutions)
    parts = [*_control(study, label, runs)] if train else []
    bind = bind_clause(runs)
    if bind is not None and (not train or "clear of coil bind by" not in bind.text):
        parts.insert(0 if "solid" in bind.text else len(parts), bind.text)
    if pulling := ends_that_pull(runs):
        parts.append(f"from {_speed(pulling[0])} {ENDS_PULL.format(pulling[0].model)}")
    limits = limits_over_speed(runs)
    parts += [text for name, text in limits.items() if name != SEATING]
    if not train:
        parts += _spring_forces(runs)
    parts += _surge(study, label, runs)
    parts += [text for name, text in limits.items() if name == SEATING]
    parts += unsettled(study.runs(label))
    if several:
        parts[0] = f"{label if study.interruption else f'worst ({label})'}: {parts[0]}"
    return [*stopped, *parts]


def runs_over_speed(study: Study, label: str) -> Runs:
    """The runs of a label whose numbers count, those between the swept speeds among them."""
    both = (*study.runs(label), *(run for run in study.between if run.label == label))
    judged = sorted(filter(is_judged, both), key=lambda run: run.engine_speed)
    bars = study.error_bars.rows if is_computed(study, "error_bars") else ()
    return Runs(tuple(judged), study.still, bars)


def _surge(study: Study, label: str, runs: Runs) -> list[str]:
    """The worst surge; one beyond control also with the worst below that."""
    surge = worst_surge(runs.solutions)
    if surge is None:
        return []
    text, limit = f"worst surge amplitude {_surge_at(runs, surge)}", controlled_to(study, label)
    if text.endswith(UNRESOLVED):
        return [text]
    if surge.run.engine_speed > limit:
        text += ", beyond control"
        below = [run for run in runs.solutions if run.engine_speed < limit]
        if (other := worst_surge(below)) is not None:
            return [f"{text}, below that {_surge_at(runs, other)}"]
    elif surge.run in (runs.solutions[0], runs.solutions[-1]) and runs.speeds > 1:
        text += ", at the end of the range"
    return [text]


def _surge_at(runs: Runs, surge: Surge) -> str:
    """``124 N at 6444 rpm (order 9)``."""
    size, known = surge_text(runs, surge)
    order = f" (order {surge.order})" if surge.order else ""
    return f"{size} at {_speed(surge.run)}{order}{'' if known else UNRESOLVED}"


def surge_text(runs: Runs, surge: Surge) -> tuple[str, bool]:
    """A surge amplitude with its error bar, and whether it is above that."""
    found = Worst("surge_amplitude_force", surge.amplitude, surge.run)
    return runs.text(found), runs.bar(found) <= surge.amplitude


def controlled_to(study: Study, label: str) -> float:
    """Lowest engine speed (rad/s) at which a label loses contact, floats or bounces: infinite for
    never, 0 where it does from the first speed on.
    """
    found = [one for one in study.critical_speeds if one.label == label and one.found]
    return min(map(_lost_from, found), default=math.inf)


def worst_label(study: Study) -> str:
    """The label that loses control first; of springs alone that whose coils clash hardest; else that
    with the largest surge.
    """

    def key(label: str) -> tuple[float, float, float]:
        runs = runs_over_speed(study, label).solutions
        surge = worst_surge(runs)
        train = any(run.provenance.system == TRAIN for run in runs)
        clash = (
            0.0
            if train
            else max((run.quantities.get("clash_energy", 0.0) for run in runs), default=0.0)
        )
        # what a stopped search has not computed ranks nothing
        control = 0.0 if study.interruption else controlled_to(study, label)
        return control, -clash, -(surge.amplitude if surge else 0.0)

    return min(study.labels, key=key)


def _control(study: Study, label: str, runs: Runs) -> list[str]:
    """Up to where everything stays in contact, and what happens from where."""
    if not searched(study) or not any(one.label == label for one in study.critical_speeds):
        return [_control_of_runs(runs, study.record.red_line)]
    rows = sorted(
        (one for one in study.critical_speeds if one.label == label and one.found),
        key=lambda one: one.engine_speed,
    )
    searched_rows = [one for one in study.critical_speeds if one.label == label]
    first, last = searched_rows[0].first_engine_speed, searched_rows[0].last_engine_speed
    limit = controlled_to(study, label)
    reach = last if not rows else max(limit, first)
    margin = red_line_margin(reach, study.record.red_line)
    if not rows:
        begun = f"controlled up to {rpm(last):.6g} rpm, the highest speed searched{margin}"
        return [f"{begun}{_least_force(runs)}"]
    first_lost = LOST[rows[0].kind][0]
    if rows[0].kind == "contact-loss" and rows[0].place:
        first_lost += f" at the {rows[0].place}"
    begun = (
        f"not controlled: {first_lost} already at {rpm(first):.6g} rpm, the lowest speed searched{margin}"
        if limit <= 0
        else f"controlled to {rpm(limit):.0f} rpm{margin}, where {first_lost}{_range(rows[0])}"
    )
    cause = _cause(rows[0], runs)
    begun += f" because {cause}" if cause else ""
    if later := _returns(rows[0]).removeprefix(" to "):
        begun += f", until {later} rpm"
    others = [_loses(one, runs, cause) for one in rows[1:]]
    unit = " rpm" if others and not others[-1].endswith(")") else ""
    return [begun, *([f"{joined(others)}{unit}"] if others else [])]


def red_line_margin(engine_speed: float, red_line: float | None) -> str:
    """How far ``engine_speed`` (rad/s) lies beyond a red line or below it; empty without one.

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


def _least_force(runs: Runs) -> str:
    """``, minimum cam force 35 N at 6000 rpm``: a force of zero for a moment opens no contact yet."""
    force = runs.worst("minimum_cam_contact_force", True)
    if force is None:
        return ""
    where = "" if force.run is None else f" at {_speed(force.run)}"
    return f", minimum cam force {runs.text(force)}{where}"


def _cause(one: CriticalSpeed, runs: Runs, size: bool = True) -> str:
    """Why control is lost: at the critical speed itself where that was looked at, else in the first run
    from there on that shows it; empty where none tells.
    """
    if one.cause:
        known = (one.spring_force_loss, one.surge_order) if size else (0.0, 0)
        return cause_phrase(one.cause, *known)
    for run in runs.solutions:
        if run.engine_speed >= _lost_from(one) and (
            cause := _cause_in(run, one.kind, one.limit, one.place, size)
        ):
            return cause
    return ""


def _cause_in(run: Solution, kind: str, limit: float, place: str = "", size: bool = True) -> str:
    """Why a run loses control in one way, in its largest event above a ``limit`` (m), at the ``place``
    where it has one there.
    """
    kinds = tuple(PLACES.values()) if kind == "contact-loss" else (kind,)
    events = [one for one in run.events if one.kind in kinds and one.size > limit]
    events = [one for one in events if one.where in place.split(", ")] or events
    if not events:
        return ""
    where = f" at {_speed(run)}" if size else ""
    return cause_text(run, max(events, key=lambda one: one.size), size, where)


def _lost_from(one: CriticalSpeed) -> float:
    """Engine speed (rad/s) from which control is lost: 0 for the first speed searched."""
    return (
        0.0
        if one.begins is None and not math.isfinite(one.nominal_engine_speed)
        else one.engine_speed
    )


def _loses(one: CriticalSpeed, runs: Runs, first: str) -> str:
    """``floats from 7302``, with its cause where that is not the ``first``."""
    verb = LOST[one.kind][1]
    cause = _cause(one, runs, size=False)
    speed, later = one.engine_speed, _returns(one)
    why = f" rpm ({cause})" if cause and not first.startswith(cause) else ""
    if one.begins is None and not math.isfinite(one.nominal_engine_speed):
        return f"{verb} below {rpm(one.first_engine_speed):.6g}{later}{why}"
    return f"{verb} {rpm(speed):.0f}{later}{why}"


def _returns(one: CriticalSpeed) -> str:
    """`` to 7419 and again from 7800`` of a loss that ends within the speeds searched; empty of others."""
    if not one.found or one.ends is None:
        return ""
    text = f" to {rpm(one.ends.from_rest.lower_engine_speed):.0f}"
    if one.again:
        ranges = f" in {len(one.again)} ranges" if len(one.again) > 1 else ""
        text += f" and again{ranges} from {rpm(one.again[0].lower_engine_speed):.0f}"
    return text


def _range(one: CriticalSpeed) -> str:
    """The range of a critical speed where it is wide, empty elsewhere."""
    span = one.printed
    wide = WIDE * one.engine_speed
    if span is None or not span.upper_engine_speed - span.lower_engine_speed > wide:
        return ""
    low, high = span.lower_engine_speed, span.upper_engine_speed
    start = "below " + f"{rpm(one.first_engine_speed):.6g}" if low <= 0 else f"{rpm(low):.0f}"
    end = "never" if math.isinf(high) else f"{rpm(high):.0f}"
    return f" ({start} to {end} with other damping or division)"


def _control_of_runs(runs: Runs, red_line: float | None) -> str:
    """The same of a run-up or of a sweep without search: from the runs themselves."""
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
    """Kind of critical speed -> the first run of a sweep without search, or turn of a run-up, that
    shows it, the slowest first.
    """
    first: dict[str, Solution] = {}
    for run in sorted(runs.solutions, key=lambda one: one.engine_speed):
        lost = run.quantities.get("loss_of_contact_duration", run.quantities.get("loft_gap", 0.0))
        for kind, value, limit in (
            ("contact-loss", lost, 0.0),
            ("float", run.quantities.get("float_excess_lift", 0.0), FLOAT_LIFT),
        ):
            if value > limit:
                first.setdefault(kind, run)
    return first


def limits_over_speed(runs: Runs) -> dict[str, str]:
    """Quantity that passes a limit -> from which engine speed run, or where alone."""
    passed: dict[str, list[Solution]] = {}
    for run in runs.solutions:
        for name in passed_limits(run.quantities):
            if not name.endswith("coil_bind_clearance"):
                passed.setdefault(name, []).append(run)
    texts = {}
    for name, some in passed.items():
        limit = passed_limits(some[0].quantities)[name]
        bound = f"{label_of(name)} {limit.phrase.format(quantity_text(name, limit.limit))}"
        above = [run for run in runs.solutions if run.engine_speed >= some[0].engine_speed]
        texts[name] = (
            f"{bound} at every speed"
            if len(some) == len(runs.solutions)
            else f"{bound} from {_speed(some[0])}"
            if len(some) == len(above) > 1
            else f"{bound} {speeds_text(some, runs.solutions)}"
        )
    return texts


def _spring_forces(runs: Runs) -> list[str]:
    """Largest and least force of a spring alone, and where its coils clash."""
    clashing = [run for run in runs.solutions if run.quantities.get("clash_count", 0) > 0]
    texts = []
    if any("clash_count" in run.quantities for run in runs.solutions):
        texts.append(
            f"coils clash {speeds_text(clashing, runs.solutions)}" if clashing else "no coil clash"
        )
    for name, word, least in (
        ("peak_spring_force", "peak spring force", False),
        ("minimum_spring_force", "minimum", True),
    ):
        found = runs.worst(name, least)
        if found is not None:
            where = "" if found.run is None else f" at {_speed(found.run)}"
            texts.append(f"{word} {runs.text(Worst(name, found.value, found.run))}{where}")
    return [", ".join(texts)] if texts else []


def worst_surge(runs: Sequence[Solution]) -> Surge | None:
    """Where the surge amplitude is largest, and the cam order that makes it; None without a surge."""
    known = [
        run for run in runs if math.isfinite(run.quantities.get("surge_amplitude_force", math.nan))
    ]
    if not known:
        return None
    run = max(known, key=lambda one: one.quantities["surge_amplitude_force"])
    peak = run.quantities.get("peak_spring_force", 0.0)
    if run.quantities["surge_amplitude_force"] <= NO_SURGE * peak:
        return None
    order = run.quantities.get("surge_amplitude_cam_order", 0.0)
    return Surge(run.quantities["surge_amplitude_force"], run, round(order))


def unsettled(runs: Sequence[Solution]) -> list[str]:
    """How many of the speeds of a label do not settle, and which; nothing where all do."""
    some = [run for run in runs if run.status.code == "not-converged"]
    if not some:
        return []
    count = "one" if len(some) == 1 else f"{len(some)}"
    where = speeds_text(some, runs)
    return [f"{count} of {counted(len(runs), 'speed')} did not settle, {where}"]


def speeds_text(some: Sequence[Solution], every: Sequence[Solution]) -> str:
    """``at 7000 and 7200 rpm``; of more than a few the range, ``from`` where it has no gap."""
    speeds = [f"{rpm(run.engine_speed):.0f}" for run in some]
    if len(speeds) <= MAX_NAMED:
        return f"at {joined(speeds)} rpm"
    low, high = some[0].engine_speed, some[-1].engine_speed
    whole = len(speeds) == sum(low <= run.engine_speed <= high for run in every)
    return (
        f"from {speeds[0]} to {speeds[-1]} rpm"
        if whole
        else f"between {speeds[0]} and {speeds[-1]} rpm"
    )


def _speed(run: Solution) -> str:
    return f"{rpm(run.engine_speed):.0f} rpm"
