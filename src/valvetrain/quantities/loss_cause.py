"""Why a train loses control at an engine speed at which it just does: the cause of the largest event,
or of the moment at which a contact is about to open.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from valvetrain.quantities.train_events import (
    LOSSES,
    SMALLEST_GAP,
    TURN,
    RigidCycle,
    cause_in,
)
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Cause, Detail, Event

#: Gap (m) from which a loss of contact is a flight, whose cause and angles are said.
FLIGHT = 10 * SMALLEST_GAP


def leading_loss(losses: Sequence[Event]) -> Event | None:
    """The loss of contact whose cause is that of all: the largest, but of a gap that is no flight and comes of
    vibration the largest one of another cause, where there is one; None without any.
    """
    ordered = sorted(losses, key=lambda one: -one.size)
    ranks = ((one, _evidence(one)[0]) for one in ordered)
    telling = (one for one, rank in ranks if rank > 0 or (rank == 0 and one.size > FLIGHT))
    return next(telling, ordered[0] if ordered else None)


def loss_cause(
    solution: Solution,
    rigid: RigidCycle,
    kind: str,
    places: Sequence[str],
    window: tuple[float, float],
) -> Mapping[str, Detail]:
    """The cause (``cause``, of surge ``spring_force_loss`` in N) in a run with channels and events.

    A float has its own cause or that of the loss of contact in which it begins, whichever is not the
    remainder (vibration). A loss of contact at one of the
    ``places`` (``cam``, ``valve_tip``) that has no gap yet has that of the moment at which the force there
    is least in the ``window`` (begin, end in cam rad) of the open valve. Empty where none is known.
    """
    if kind == "float":
        largest, around = float_and_losses(solution)
        # vibration is what is left where neither inertia nor surge shows, so either of both goes before it
        return {} if largest is None else max((largest, *around), key=_evidence).details
    if kind != "contact-loss":
        return {}
    begin, end = window
    here = [
        one
        for one in solution.events
        if one.kind in LOSSES
        and one.where in places
        and ((one.cam_angle - begin) % TURN <= end - begin or _holds(one, begin, solution))
    ]
    if (leading := leading_loss(here)) is not None:
        return leading.details
    sample = least_force_sample(solution, places, window)
    return {} if sample is None else cause_in(solution, rigid, np.array([sample]))


def float_and_losses(solution: Solution) -> tuple[Event | None, list[Event]]:
    """The largest float of a run, None without any, and the losses of contact that are open as it begins."""
    floats = [one for one in solution.events if one.kind == "float"]
    largest = max(floats, key=lambda one: one.size, default=None)
    if largest is None:
        return None, []
    losses = (one for one in solution.events if one.kind in LOSSES)
    return largest, [one for one in losses if _holds(one, largest.cam_angle, solution)]


def least_force_sample(
    solution: Solution, places: Sequence[str], window: tuple[float, float]
) -> int | None:
    """The sample of the least contact force of the ``places`` in a ``window`` (begin, end in
    cam rad); None of a run without their channels.
    """
    begin, end = window
    names = [f"{place}_contact_force" for place in places]
    forces = [solution.channel(name) for name in names if solution.has(name)]
    inside = np.flatnonzero((solution.cam_angle - begin) % TURN <= end - begin)
    if not forces or not len(inside):
        return None
    return int(inside[np.argmin(np.min(np.stack(forces), axis=0)[inside])])


def _holds(loss: Event, cam_angle: float, solution: Solution) -> bool:
    """Whether a contact that is lost in an event of a run is open at a cam angle (rad)."""
    return (cam_angle - loss.cam_angle) % TURN <= loss.duration * solution.engine_speed / 2


def _evidence(event: Event) -> tuple[int, float]:
    """Rank of the cause of an event, of surge with the force (N) that it takes."""
    known = (Cause.VIBRATION, Cause.SURGE, Cause.INERTIA)
    cause, loss = event.details.get("cause"), event.details.get("spring_force_loss", 0.0)
    return (known.index(cause) if cause in known else -1), float(loss)
