"""The reported cam cycle of a run: the last whole one, from the case's zero of the cam angle."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from valvetrain.arrays import Array, Flags
from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.quantities.kinematics import RigidTable
from valvetrain.solution.cycle_view import angle_within, last_revolution
from valvetrain.solution.result import Solution
from valvetrain.solution.static import SpringAtRest
from valvetrain.solution.study import LiftEvent


@dataclass(frozen=True, eq=False)
class Cycle:
    """One cam revolution of a run: ``samples`` of the last whole one, or of the unfinished one when
    none is whole.

    ``cam_angle`` (sample,) rad from 0 to 2 pi, ascending; ``time`` (sample,) s; ``whole`` says
    whether the turn is complete.
    """

    solution: Solution
    samples: slice
    cam_angle: Array
    time: Array
    whole: bool

    def channel(self, name: str) -> Array:
        """Values of a channel over the cycle; :class:`InputError` when the run has none of that
        name.
        """
        return self.solution.channel(name)[self.samples]

    def at_coil(self, name: str, coil: float, reach: float = 0.15) -> Array | None:
        """A channel along the wire or over the coil pairs, interpolated to coil number ``coil``.

        None when the run lacks the channel or has no point within ``reach`` turns.
        """
        if not self.solution.has(name):
            return None
        places = self.solution.arrays.along(name)
        if places is None or places.size == 0 or np.min(np.abs(places - coil)) > reach:
            return None
        values, order = self.channel(name), np.argsort(places)
        places = places[order]
        right = (
            int(np.clip(np.searchsorted(places, coil), 1, len(places) - 1))
            if len(places) > 1
            else 0
        )
        if right == 0:
            return values[:, order[0]]
        share = float(
            np.clip((coil - places[right - 1]) / (places[right] - places[right - 1]), 0.0, 1.0)
        )
        if share in (0.0, 1.0):  # a neighbour that is not finite must not spoil an exact hit
            return values[:, order[right - 1 + int(share)]]
        return (1 - share) * values[:, order[right - 1]] + share * values[:, order[right]]

    def window(self, first: float, last: float) -> Flags:
        """Mask of the samples with ``first <= cam_angle < last`` (rad)."""
        return (self.cam_angle >= first - 1e-9) & (self.cam_angle < last - 1e-9)

    def covers(self, first: float, last: float) -> bool:
        """True when the samples reach over ``first`` to ``last`` (rad) but for one step at either
        end.
        """
        if len(self.cam_angle) < 2:
            return False
        step = 1.5 * float(np.median(np.diff(self.cam_angle)))
        return bool(self.cam_angle[0] <= first + step and self.cam_angle[-1] >= last - step)


def is_closed(solution: Solution) -> bool:
    """Whether the samples are one closed period: true for trains, false under prescribed motion."""
    return solution.provenance.system == "train"


def reported_cycle(solution: Solution) -> Cycle:
    """The last whole cam revolution of a run; :class:`InputError` for a run without two samples."""
    angle = solution.cam_angle
    if len(angle) < 2:
        raise InputError("the run holds fewer than two samples, so it has no cycle; see its status")
    part = last_revolution(angle)
    within = angle_within(angle[part.samples], part.number)
    return Cycle(solution, part.samples, within, solution.time[part.samples], part.whole)


@dataclass(frozen=True, eq=False)
class Frame:
    """Inputs of :func:`~valvetrain.quantities.evaluate.evaluate` other than the run; each is
    optional, and quantities that need a missing one are left out.

    ``springs``: outer first. ``rest``: springs at rest. ``surge_frequencies`` (Hz): first axial
    natural frequency of each spring. ``lift_event``: main lift event. ``valve_lift``: lift (m) over
    cam angle (rad) as the cam prescribes it. ``source``: name of the published study whose own
    quantities are requested. ``rigid``: rigid motion of a train at the run's speed. ``points``: coil
    numbers of the study's points on the wire, where they are others than its own.
    ``permitted_seating_velocity`` (m/s) where the case sets that limit. ``top_dead_centre``: cam angle (rad) of gas exchange,
    of a timed cam.
    """

    springs: tuple[InstalledSpring, ...] = ()
    rest: tuple[SpringAtRest, ...] = ()
    surge_frequencies: tuple[float, ...] = ()
    lift_event: LiftEvent | None = None
    valve_lift: Callable[[Array], Array] | None = None
    source: str = ""
    rigid: RigidTable | None = None
    points: tuple[tuple[str, float], ...] = ()
    permitted_seating_velocity: float | None = None
    top_dead_centre: float | None = None

    @property
    def surge_frequency(self) -> float | None:
        """Lowest surge frequency (Hz) of the springs; None where none is known."""
        return min(self.surge_frequencies, default=None)

    def static_force(self, valve_lift: Array, model: str = "") -> Array | None:
        """Force (N) of all springs at rest at lifts (m), by ``model`` where it has a curve, else by
        the first that has one.

        None where a spring has no curve or a lift is beyond it.
        """
        total = np.zeros_like(valve_lift)
        for spring in self.springs:
            mine = [
                one
                for one in self.rest
                if one.spring == spring.name
                and one.curve is not None
                and len(one.curve.compression) > 1
            ]
            chosen = next((one for one in mine if one.model == model), mine[0] if mine else None)
            if chosen is None or chosen.curve is None:
                return None
            compression, curve = spring.precompression + valve_lift, chosen.curve
            if np.max(compression) > curve.compression[-1] * (1 + 1e-6) + 1e-9:
                return None
            total = total + np.interp(compression, curve.compression, curve.force)
        return total if self.springs else None
