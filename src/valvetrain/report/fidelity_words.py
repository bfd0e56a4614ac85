"""Models beside a reference as rows of a table and sentences, the same in the terminal and on the
page.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from valvetrain.report.words import in_unit, rpm
from valvetrain.solution.definition import definition_of, label_of
from valvetrain.solution.fidelity import RPM, FidelityMap, Reach


@dataclass(frozen=True, slots=True)
class ReachRow:
    """One quantity: its words, a cell per model, and the cheapest model that is good enough at
    every speed.
    """

    quantity: str
    words: str
    cells: tuple[str, ...]
    cheapest: str


def reach_rows(found: FidelityMap) -> list[ReachRow]:
    """A row per quantity: engine speeds (rpm) up to which each model is good enough."""
    rows = []
    for name in found.quantities:
        words = label_of(name)
        cells = tuple(found.reach(name, model).words for model in found.models)
        rows.append(ReachRow(name, words[:1].upper() + words[1:], cells, found.cheapest(name)))
    return rows


def share(value: float) -> str:
    """A share in per cent with two digits that count; empty where there is none."""
    return (
        ""
        if not math.isfinite(value)
        else f"{100 * value:.2g} %"
        if abs(value) < 0.995
        else f"{100 * value:.0f} %"
    )


def reason_for(found: FidelityMap, quantity: str) -> str:
    """Why the cheapest model is recommended for a quantity, or what keeps each cheaper one from it."""
    chosen = found.cheapest(quantity)
    costs = dict(found.costs)
    if chosen == found.reference:
        best = min(
            (found.reach(quantity, model) for model in found.models), key=_miss, default=None
        )
        if best is None or not math.isfinite(best.largest):
            return "no other model tells it"
        if math.isinf(best.largest_doubt):
            return f"{best.model} comes nearest, but a finer run that should tell the error gave no result"
        if best.largest_doubt > best.largest:
            return f"{best.model} comes nearest, but its error bar, {share(best.largest_doubt)}, is larger than the difference"
        return f"the nearest, {best.model}, is {_apart(best)} off at worst"
    reach, ratio = found.reach(quantity, chosen), costs[found.reference] / costs[chosen]
    return (
        f"at worst {_apart(reach)} off, in 1/{ratio:.0f} of the time"
        if ratio >= 2
        else f"at worst {_apart(reach)} off"
    )


def _apart(reach: Reach) -> str:
    return share(reach.largest) + (
        f" ± {share(reach.largest_doubt)}" if reach.largest_doubt > 0 else ""
    )


def _miss(reach: Reach) -> float:
    return reach.largest if math.isfinite(reach.largest) else math.inf


def fidelity_notes(found: FidelityMap) -> tuple[str, ...]:
    """What must be known of the verdicts."""
    speeds = [row.engine_speed / RPM for row in found]
    undivided = [model for model in (*found.models, found.reference) if model not in found.divided]
    sizes = "; ".join(f"{label_of(name)} {_scale(found, name)}" for name in found.quantities)
    notes = [
        f"Good enough: within {share(found.tolerance)} of the largest value of {found.reference} over {min(speeds):.6g} to "
        f"{max(speeds):.6g} rpm ({sizes}), the numerical error of both included; open: the error bars leave it undecided; "
        "not told: the model does not know it.",
        "The bars are the change that 1.5 times as many elements, masses or modes make, with the safety factor of two grids."
        + (
            f" Without such a division, and so without a bar of their own: {', '.join(undivided)}."
            if undivided
            else ""
        ),
        f"The verdicts are about {found.reference}, not about a measurement: what it leaves out, all leave out.",
    ]
    untold = {
        name: sorted(
            {
                rpm(row.engine_speed)
                for row in found
                if row.quantity == name and not math.isfinite(row.reference)
            }
        )
        for name in found.quantities
    }
    if any(untold.values()):
        places = "; ".join(
            f"{label_of(name)} at {', '.join(f'{one:.6g}' for one in some)} rpm"
            for name, some in untold.items()
            if some
        )
        notes.append(f"{found.reference} gave no value, so nothing is said there of: {places}.")
    unknown = [row for row in found if math.isinf(row.doubt)]
    if unknown:
        notes.append(
            f"{len(unknown)} of {len(found)} error bars are unknown, since the run that should tell them gave no result."
        )
    return tuple(notes)


def _scale(found: FidelityMap, name: str) -> str:
    unit = definition_of(name).shown_unit
    size = next(row.scale for row in found if row.quantity == name)
    return f"{in_unit(size, unit):.4g} {unit}".strip()


def speed_axis(found: FidelityMap) -> list[float]:
    """Engine speeds (rpm) in order."""
    return [rpm(speed) for speed in sorted({row.engine_speed for row in found})]
