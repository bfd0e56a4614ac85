"""Numbers of a run's coil clashes; the clashes themselves where its integrator kept no record of
the contacts.
"""

from __future__ import annotations

import numpy as np

from valvetrain.integrate.clash import RECORDED, ClashRule, PairSeries, find_clashes
from valvetrain.quantities.cycle import is_closed
from valvetrain.solution.event import Event
from valvetrain.solution.result import Solution


def clash_events(solution: Solution, rule: ClashRule = ClashRule()) -> tuple[Event, ...]:
    """Events of kind ``clash`` by start time: those that the integrator found on its own steps,
    else those that the samples show.

    Empty for a model without coil pairs. From the samples, the energy of a pressed pair is half of
    force times overlap.
    """
    if _recorded(solution):
        return tuple(event for event in solution.events if event.kind == "clash")
    found: list[Event] = []
    for spring in solution.springs:
        pairs = _pairs_of(solution, spring)
        if pairs is not None:
            found += find_clashes(
                pairs, spring if len(solution.springs) > 1 else "", is_closed(solution), rule
            )
    return tuple(sorted(found, key=lambda event: event.time))


def _recorded(solution: Solution) -> bool:
    """Whether the integrator looked for clashes itself, in any spring of the run."""
    return any(name.endswith(RECORDED) for name in solution.statistics)


def _pairs_of(solution: Solution, spring: str) -> PairSeries | None:
    name = solution.channel_of(spring, "coil_contact_force")
    if not solution.has(name, solution.channel_of(spring, "coil_gap")) or len(solution.time) < 2:
        return None
    places = solution.arrays.along(name)
    if places is None or not len(places):
        return None
    order = np.argsort(places)
    force = np.nan_to_num(solution.channel(name)[:, order])
    gap = np.nan_to_num(
        solution.channel(solution.channel_of(spring, "coil_gap"))[:, order], nan=0.0, posinf=0.0
    )
    energy = 0.5 * force * np.maximum(-gap, 0.0)
    return PairSeries(
        solution.time, solution.cam_angle, np.arange(len(order)), places[order], force.T, energy.T
    )


def clash_numbers(solution: Solution, events: tuple[Event, ...]) -> dict[str, float]:
    """Count, largest force (N) and impulse (N s), and energy (J; of all and the largest) of the
    clashes of one cycle.

    Empty where the model has no coil pairs; ``events`` are those of the cycle.
    """
    if not _recorded(solution) and all(
        _pairs_of(solution, spring) is None for spring in solution.springs
    ):
        return {}
    clashes = [event for event in events if event.kind == "clash"]
    energies = [float(event.details["energy"]) for event in clashes]
    return {
        "clash_count": float(len(clashes)),
        "peak_clash_force": max((event.size for event in clashes), default=0.0),
        "clash_energy": float(sum(energies)),
        "largest_clash_energy": max(energies, default=0.0),
        "largest_clash_impulse": max(
            (float(event.details["impulse"]) for event in clashes), default=0.0
        ),
    }
