"""Clauses on coil clashes: how often coils strike, where the hardest impact acts, and which coils only
come to rest on each other as the spring closes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from valvetrain.report.clauses import Clause, Runs, Worst, counted, joined
from valvetrain.report.text import clash_pair, peak_angle
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Cause, Event
from valvetrain.system.contract import TRAIN

#: Models that resolve the wire, the finest first; others follow as they are.
FINEST = ("solid", "finite-element", "wave-rod", "reduced-rod")
AS_IT_CLOSES = " as the spring closes"


def strikes(run: Solution) -> list[Event]:
    """Clashes of a run but contacts that close with the spring: those press without an impact."""
    return [
        one
        for one in run.events
        if one.kind == "clash" and one.details.get("cause") != Cause.COILS_REST
    ]


def resting(run: Solution) -> list[Event]:
    """Contacts of coils that close as the spring does."""
    return [
        one
        for one in run.events
        if one.kind == "clash" and one.details.get("cause") == Cause.COILS_REST
    ]


def strike_count(runs: Runs, run: Solution) -> float:
    """How often coils strike in a run; NaN where its model has no coil pairs."""
    return runs.value(run, "clash_count") - len(resting(run))


def clash_clauses(runs: Runs, brief: bool) -> list[Clause]:
    """Strikes, their energy and the hardest by its force at the angle of its peak, of the run with most
    energy by the finest model; ``brief`` leaves the hardest out.
    """
    known = [run for run in runs.solutions if math.isfinite(strike_count(runs, run))]
    alone = all(run.provenance.system != TRAIN for run in runs.solutions)
    if not known:
        return []
    found = any(strike_count(runs, run) > 0 for run in known)
    run = max(_of_finest(known), key=lambda one: _severity(runs, one))
    closed = resting_text(run)
    if not (found or alone):
        return [Clause(closed, run if len(runs.solutions) > 1 else None)] if closed else []
    count = round(strike_count(runs, run))
    text = counted(count, "coil clash", "coil clashes")
    energy = runs.worst("clash_energy", False, only=run)
    if count and not closed and energy is not None and energy.value > 0:
        text += f" ({runs.text(energy)} in all)"
    hardest = max(strikes(run), key=lambda one: one.size, default=None)
    if hardest and not brief:
        text += f", {_hardest_text(runs, run, hardest)}"
    if count:
        closed = closed.replace(AS_IT_CLOSES, " at lift")
    parts = [text, closed] if closed and not brief else [text]
    about = run if (count or closed) and len(runs.solutions) > 1 else None
    return [Clause(part, about, lost=count > 0 and part == text) for part in parts]


def resting_text(run: Solution) -> str:
    """``coils 1–2 and 6–7 rest on each other as the spring closes``; empty where none does."""
    pairs = sorted({clash_pair(one) for one in resting(run)})
    if not pairs:
        return ""
    return f"coils {joined(pairs)} rest on each other{AS_IT_CLOSES}"


def _hardest_text(runs: Runs, run: Solution, hardest: Event) -> str:
    found = Worst("surge_clash_peak_force", hardest.size, run)
    size = runs.text(found)
    why = " under surge" if hardest.details.get("cause") == Cause.COILS_STRIKE else ""
    pair = clash_pair(hardest)
    return f"hardest {size} between coils {pair}{why} at {peak_angle(hardest):.0f} cam deg"


def _severity(runs: Runs, run: Solution) -> tuple[bool, float, float]:
    energy = runs.value(run, "clash_energy")
    count = strike_count(runs, run)
    return count > 0, energy if math.isfinite(energy) else -math.inf, count


def _of_finest(known: Sequence[Solution]) -> list[Solution]:
    """Of each spring set and speed the runs by its finest model."""

    def place(run: Solution) -> int:
        return FINEST.index(run.model) if run.model in FINEST else len(FINEST)

    best: dict[tuple[str, float], int] = {}
    for run in known:
        key = run.spring_set, run.engine_speed
        best[key] = min(best.get(key, len(FINEST)), place(run))
    return [run for run in known if place(run) == best[run.spring_set, run.engine_speed]]
