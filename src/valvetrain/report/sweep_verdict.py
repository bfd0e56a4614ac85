"""Verdicts over engine speed: up to where a train is controlled, what is lost then, and where surge
is worst.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from valvetrain.quantities.limits import passed_limits
from valvetrain.report.clauses import (
    ENDED,
    Runs,
    Worst,
    counted,
    ended_clauses,
    joined,
    quantity_text,
)
from valvetrain.report.control import (
    control_clauses,
    controlled_to,
    first_losses,
    range_in_use,
)
from valvetrain.report.fact_texts import on_assumed_ramp
from valvetrain.report.run_clauses import (
    ENDS_PULL,
    PULLS,
    SEATING,
    SOLID,
    bind_clause,
    ends_that_pull,
    is_judged,
    passes_resolved,
)
from valvetrain.report.run_summary import searched
from valvetrain.report.text import rpm
from valvetrain.solution.definition import label_of
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study
from valvetrain.solution.uncertainty import NOT_RESOLVED
from valvetrain.system.contract import TRAIN

#: Share of the peak spring force up to which a surge is none, but what a massless spring leaves.
NO_SURGE = 1e-4
#: Engine speeds that are named one by one.
MAX_NAMED = 3


class Surge(NamedTuple):
    """The largest surge amplitude (N) over the speeds of a label, its run and cam order (0: unknown)."""

    amplitude: float
    run: Solution
    order: int


def sweep_clauses(study: Study) -> tuple[list[str], list[str]]:
    """Parts of the verdict over engine speed, of the worst label: those of its first sentence, up to where
    a train is controlled, and the others.
    """
    counts = [run for run in study.solutions if run.status.code in ("completed", "not-converged")]
    stopped = [one for one in ended_clauses(study.solutions) if ENDED["not-converged"] not in one]
    left = [study.interruption] if study.interruption else []
    if not counts:
        return [*stopped, *left], []
    label = worst_label(study)
    runs = runs_over_speed(study, label)
    if not runs.solutions:
        return [*stopped, *left], []
    train = any(run.provenance.system == TRAIN for run in runs.solutions)
    first = control_clauses(study, label, runs) if train else _spring_forces(runs)
    first += _ended_between(study, label)
    bind, more = bind_clause(runs), list[str]()
    if bind is not None and SOLID in bind.text:
        first.insert(0, bind.text)
    elif (
        bind is not None
        and not (train and "clear of coil bind by" in bind.text)
        and not _bound(study, label)
    ):
        more.append(bind.text)
    if pulling := ends_that_pull(runs):
        where = speeds_text(pulling, runs.solutions)
        if train and first and pulling[0].engine_speed <= controlled_to(study, label):
            first[0] = f"doubtful where ends of the spring would lift ({where}): {first[0]}"
        more.append(f"{where} {ENDS_PULL.format(pulling[0].model)}")
    limits = limits_over_speed(runs)
    more += [text for name, text in limits.items() if name != SEATING]
    more += _surge(study, label, runs)
    ramp = on_assumed_ramp(study.facts)
    more += [f"{text}{ramp}" for name, text in limits.items() if name == SEATING]
    more += unsettled(study.runs(label))
    if not first:
        first, more = more[:1], more[1:]
    if len(study.labels) > 1 and first:
        first[0] = f"{label if study.interruption else f'worst ({label})'}: {first[0]}"
    if first and _beyond_control(study):
        return [*left, *first], [*stopped, *more]
    return [*stopped, *left, *first], more


def _bound(study: Study, label: str) -> bool:
    """Whether a run of a label reached coil bind, so that there is no clearance left."""
    return any(run.status.code == "coil-bind" for run in study.runs(label))


def _beyond_control(study: Study) -> bool:
    """Whether every run that ended is faster than its label is controlled, so that it is no answer for engines in
    use.
    """
    ended = [
        run for run in study.solutions if run.status.code not in ("completed", "not-converged")
    ]
    return all(run.engine_speed > controlled_to(study, run.label) for run in ended)


def runs_over_speed(study: Study, label: str) -> Runs:
    """The runs of a label whose numbers count, those between the swept speeds among them."""
    both = (*study.runs(label), *(run for run in study.between if run.label == label))
    judged = sorted(filter(is_judged, both), key=lambda run: run.engine_speed)
    bars = study.error_bars
    return Runs(tuple(judged), study.still, bars)


def _ended_between(study: Study, label: str) -> list[str]:
    """``the run at 8542 rpm reached coil bind`` of those between the swept speeds that did not complete."""
    ended: dict[str, list[Solution]] = {}
    for run in study.between:
        if run.label == label and not is_judged(run):
            ended.setdefault(run.status.code, []).append(run)
    return [
        f"the run{'s' if len(some) > 1 else ''} {speeds_text(some, some)} {ENDED.get(code, code)}"
        for code, some in ended.items()
    ]


def _surge(study: Study, label: str, runs: Runs) -> list[str]:
    """The worst surge of the speeds in use, then a larger one beyond them."""
    surge = worst_surge(runs.solutions)
    if surge is None:
        return []
    text, (limit, end) = (
        f"worst surge amplitude {_surge_at(runs, surge)}",
        range_in_use(study),
    )
    if NOT_RESOLVED in text:
        return [text]
    if surge.run.engine_speed > limit:
        used = surge_in_use(study, runs)
        if used is None or used.run is surge.run:
            return [f"{text}, beyond {end}"]
        first = f"worst surge amplitude {_surge_at(runs, used)}"
        return [f"{first}, beyond {end} {_surge_at(runs, surge)}"]
    if surge.run in (runs.solutions[0], runs.solutions[-1]) and runs.speeds > 1:
        text += ", at the end of the range"
    return [text]


def surge_in_use(study: Study, runs: Runs) -> Surge | None:
    """The worst surge up to the red line, or while control is maintained; of all speeds where none is below."""
    limit, _ = range_in_use(study)
    used = [run for run in runs.solutions if run.engine_speed <= limit]
    return worst_surge(used) or worst_surge(runs.solutions)


def _surge_at(runs: Runs, surge: Surge) -> str:
    """``124 N at 6444 rpm (order 9)``."""
    size = runs.text(Worst("surge_amplitude_force", surge.amplitude, surge.run))
    order = f" (order {surge.order})" if surge.order else ""
    return f"{size} at {_speed(surge.run)}{order}"


def worst_label(study: Study) -> str:
    """The label that loses control first; of springs alone that whose coils clash hardest; else that
    with the largest surge.
    """

    def key(label: str) -> tuple[float, float, float]:
        every = runs_over_speed(study, label)
        runs = every.solutions
        surge = worst_surge(runs)
        train = any(run.provenance.system == TRAIN for run in runs)
        clash = (
            0.0
            if train
            else max((run.quantities.get("clash_energy", 0.0) for run in runs), default=0.0)
        )
        # what a stopped search has not computed ranks nothing
        lost = (run.engine_speed for run in first_losses(every).values())
        limit = controlled_to(study, label) if searched(study) else min(lost, default=math.inf)
        control = 0.0 if study.interruption else limit
        return control, -clash, -(surge.amplitude if surge else 0.0)

    return min(study.labels, key=key)


def limits_over_speed(runs: Runs) -> dict[str, str]:
    """Limits passed: from which engine speed run, or where alone."""
    passed: dict[str, list[Solution]] = {}
    for run in runs.solutions:
        for name, one in passed_limits(run.quantities).items():
            if not name.endswith("coil_bind_clearance") and passes_resolved(runs, run, one):
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
        ("peak_spring_force", label_of("peak_spring_force"), False),
        ("minimum_spring_force", "minimum", True),
    ):
        found = runs.worst(name, least)
        if found is not None:
            where = "" if found.run is None else f" at {_speed(found.run)}"
            pulls = PULLS if least and found.value < 0 else ""
            texts.append(f"{word} {runs.text(Worst(name, found.value, found.run))}{where}{pulls}")
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
