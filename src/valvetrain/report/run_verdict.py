"""Verdicts of a study and of a single run: what did not complete, limits passed, then coil bind,
contact, bounce or clash, and the figure that matters most.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterator, Sequence

from valvetrain.quantities.limits import PassedLimit, passed_limits
from valvetrain.report.clauses import (
    ENDED,
    Clause,
    Runs,
    Worst,
    counted,
    ended_clauses,
    figure,
    joined,
    quantity_text,
    sentence,
    told,
)
from valvetrain.report.text import percent, speed_text
from valvetrain.runs.stored_error_bars import fresh_uncertainty
from valvetrain.solution.comparison import Comparison
from valvetrain.solution.definition import NESTED, label_of
from valvetrain.solution.later import is_computed
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study
from valvetrain.system.contract import TRAIN

#: Lift above the rigid lift from which a valve is said to float (m), as critical speeds take it.
FLOAT_LIFT = 5e-5


def study_verdict(study: Study) -> str:
    """The sentence of a study: of its sweep, its map of models, its runs or its springs at rest."""
    if len(study.fidelity):
        from valvetrain.report.model_verdict import fidelity_verdict

        return fidelity_verdict(study.fidelity)
    published = published_clause(study.comparisons)
    if not study.solutions:
        return sentence([*rest_failures(study), *rest_clauses(study), published])
    if study.over_speed:
        from valvetrain.report.sweep_verdict import sweep_clauses

        return sentence([*rest_failures(study), *sweep_clauses(study), published])
    judged = judged_runs(study)
    return sentence(
        [
            *ended_clauses(study.solutions),
            *rest_failures(study),
            *told(list(run_clauses(judged)), judged),
            _spread(study),
            published,
        ]
    )


def solution_verdict(run: Solution) -> str:
    """The sentence of one run."""
    judged = Runs((run,) if _judged(run) else ())
    return sentence([*ended_clauses((run,)), *told(list(run_clauses(judged)), judged)])


def judged_runs(study: Study) -> Runs:
    """The runs of a study whose numbers count, with the error bars that are known."""
    bars = fresh_uncertainty(study) if is_computed(study, "error_bars") else ()
    return Runs(tuple(run for run in study.solutions if _judged(run)), study.still, bars)


def _judged(run: Solution) -> bool:
    return run.status.code in ("completed", "not-converged")


def run_clauses(runs: Runs) -> Iterator[Clause]:
    """What a user asks first, limits passed before all else; nothing without runs."""
    if not runs.solutions:
        return
    yield from limit_clauses(runs)
    if (bind := bind_clause(runs)) is not None:
        yield bind
    if any(run.provenance.system == TRAIN for run in runs.solutions):
        yield from _contact_clauses(runs)
    yield from _clash_clauses(runs)
    yield from _force_clauses(runs)


def worst_run(runs: Runs) -> Solution | None:
    """The run that most clauses are about, of equal ones the fastest; None without runs."""
    named = [id(one.run) for one in run_clauses(runs) if one.run is not None]
    return max(
        runs.solutions, key=lambda run: (named.count(id(run)), run.engine_speed), default=None
    )


def limit_clauses(runs: Runs) -> Iterator[Clause]:
    """Limits passed, coil bind left out: the worst run of each."""
    worst: dict[str, tuple[PassedLimit, Solution]] = {}
    for run in runs.solutions:
        for name, one in passed_limits(run.quantities).items():
            if name not in worst or one.value > worst[name][0].value:
                worst[name] = one, run
    for name, (one, run) in worst.items():
        if name.endswith("coil_bind_clearance"):
            continue
        text = runs.text(Worst(name, one.value, run))
        bound = quantity_text(name, one.limit)
        yield Clause(f"{label_of(name)} {text}, above its limit of {bound}", run)


def bind_clause(runs: Runs) -> Clause | None:
    """Room to coil bind of the spring that has the least."""
    found = [
        (one, spring)
        for spring in ("", *NESTED)
        if (one := runs.worst(f"{spring}_coil_bind_clearance".strip("_"), least=True)) is not None
    ]
    if not found:
        return None
    one, spring = min(found, key=lambda pair: pair[0].value)
    whose = f"{spring} spring " if spring else ""
    if one.value >= 0:
        return Clause(f"{whose}clear of coil bind by {runs.text(one)}", one.run)
    short = runs.text(Worst(one.name, -one.value, one.run))
    return Clause(f"{whose}solid {short} before the largest lift", one.run)


def _contact_clauses(runs: Runs) -> Iterator[Clause]:
    """Loft, float, bounce and clearance to the piston."""
    loft, lost = runs.worst("loft_gap", False), runs.worst("loss_of_contact_duration", False)
    if lost is not None and lost.value > 0:
        time = runs.text(lost)
        gap = f"loft of {runs.text(loft)}, " if loft is not None and loft.value > 0 else ""
        yield Clause(
            f"{gap}{time} without contact" if gap else f"contact lost for {time}", lost.run
        )
    elif lost is not None:
        yield Clause("no loft")
    over = runs.worst("float_excess_lift", False)
    if over is not None and over.value > FLOAT_LIFT:
        yield Clause(f"floats {runs.text(over)} above the rigid lift", over.run)
    bounces, height = runs.worst("bounce_count", False), runs.worst("bounce_height", False)
    if bounces is not None:
        count = round(bounces.value)
        size = f" of {runs.text(height)}" if height is not None and height.value > 0 else ""
        high = f" up{size.replace(' of', ' to')}" if count > 1 and size else size
        run = bounces.run if height is None or not count else height.run or bounces.run
        yield Clause(f"{counted(count, 'bounce')}{high if count else ''}", run if count else None)
    piston = runs.worst("minimum_piston_clearance_gap", True)
    if piston is not None:
        yield Clause(
            f"clear of the piston by {runs.text(piston)}"
            if piston.value > 0
            else "the valve meets the piston",
            piston.run,
        )


def _clash_clauses(runs: Runs) -> Iterator[Clause]:
    clashes = runs.worst("clash_count", False)
    alone = all(run.provenance.system != TRAIN for run in runs.solutions)
    if clashes is not None and (clashes.value or alone):
        count = round(clashes.value)
        plural = "coil clashes"
        yield Clause(counted(count, "coil clash", plural), clashes.run if count else None)


def _force_clauses(runs: Runs) -> Iterator[Clause]:
    """The least force at the cam, or of the spring, and the largest of a spring alone."""
    lofting = runs.worst("loss_of_contact_duration", False)
    cam = runs.worst("minimum_cam_contact_force", True, lofting.run if lofting else None)
    if cam is not None:
        yield Clause(f"minimum cam force {runs.text(cam)}", cam.run)
        return
    peak, least = runs.worst("peak_spring_force", False), runs.worst("minimum_spring_force", True)
    if peak is not None:
        yield Clause(f"peak spring force {runs.text(peak)}", peak.run)
    if least is not None:
        yield Clause(f"minimum {runs.text(least)}", least.run)


def _spread(study: Study) -> str:
    """How far models of one spring set are apart in the peak force, where there are several."""
    worst: tuple[float, float, float, float] | None = None
    for speed in study.engine_speeds:
        for name in {run.spring_set for run in study.solutions}:
            peaks = {
                run.model: run.quantities["peak_spring_force"]
                for run in study.solutions
                if run.label.rpartition(", ")[2] == run.model
                and run.engine_speed == speed
                and run.spring_set == name
                and _judged(run)
                and math.isfinite(run.quantities.get("peak_spring_force", math.nan))
            }
            if len(peaks) > 1:
                low, high = min(peaks.values()), max(peaks.values())
                found = ((high - low) / max(abs(high), 1e-12), low, high, speed)
                worst = found if worst is None or found > worst else worst
    if worst is None:
        return ""
    apart, _, _, speed = worst
    where = f" at {speed_text(speed)}" if len(study.engine_speeds) > 1 else ""
    return f"models differ by {_share(apart)} in peak force{where}"


def rest_failures(study: Study) -> list[str]:
    """Springs whose static curve or modes did not complete."""
    return [
        f"{one.spring} {ENDED.get(part.status.code, part.status.code)} by {one.model}, {name}"
        for one in study.rest
        for name, part in (("at rest", one.curve), ("in its modes", one.modes))
        if part is not None and not part.status.completed
    ]


def rest_clauses(study: Study) -> list[str]:
    """Preload, rate and first axial mode of the first spring at rest, and how far others are."""
    if not study.rest:
        return []
    first = study.rest[0]
    parts, curve = [], first.curve
    if curve is not None and curve.compression[0] <= first.precompression <= curve.compression[-1]:
        force, rate = curve.force_at(first.precompression), curve.stiffness_at(first.precompression)
        if first.precompression > 0:
            parts.append(f"preload {figure(float(force))} N")
        parts.append(f"rate {figure(float(rate) * 1e-3)} N/mm")
    modes = [] if first.modes is None else [float(one) for one in first.modes.axial_frequencies]
    if modes:
        parts.append(f"first axial mode {figure(modes[0])} Hz")
    if not parts:
        return []
    others = [
        float(one.modes.axial_frequencies[0]) / modes[0] - 1
        for one in study.rest[1:]
        if modes and one.spring == first.spring and one.modes is not None
        if len(one.modes.axial_frequencies)
    ]
    whose = f"{first.spring}: " if len({one.spring for one in study.rest}) > 1 else ""
    text = f"{whose}{joined(parts)} by {first.model}"
    if others:
        text += f", other models within {_share(max(map(abs, others)))} in that mode"
    return [text]


def _share(value: float) -> str:
    """A positive share in per cent."""
    return "less than 0.1 %" if 0 <= value < 5e-4 else percent(value).lstrip("+")


def published_clause(rows: Sequence[Comparison]) -> str:
    """How the published values of a case compare, in one clause; empty without any."""
    known = [
        (abs(row.relative_difference), row)
        for row in rows
        if row.relative_difference is not None and row.unit != "deg" and not row.doubt
    ]
    if not known:
        return ""
    count = f"{len(known)} published values" if len(known) > 1 else "the published value"
    middle = _share(statistics.median(share for share, _ in known))
    share, row = max(known, key=lambda pair: pair[0])
    if len(known) == 1:
        return f"{count} of {label_of(row.quantity)} differs by {middle}"
    where = "" if row.engine_speed is None else f" at {speed_text(row.engine_speed)}"
    most = f"most {_share(share)} in {label_of(row.quantity)}{where}"
    return f"{count} differ by {middle} in the median, {most}"
