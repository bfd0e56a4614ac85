"""What the numbers of a run are judged by: the springs as installed, their states of rest, the
cam's own motion.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.quantities.kinematics import RigidTable
from valvetrain.solution.static import SpringAtRest
from valvetrain.solution.study import LiftEvent

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Frame:
    """What :func:`~valvetrain.quantities.evaluate.evaluate` needs beside the run; everything may be
    left out, and what needs it with it.

    ``springs``: outer first. ``rest``: springs at rest. ``surge_frequencies`` (Hz): first axial
    natural frequency of each spring.
    ``lift_event``: main lift event. ``valve_lift``: lift (m) over cam angle (rad) as the cam asks
    for it. ``source``: word of the
    published study whose own quantities are wanted. ``rigid``: rigid motion of a train at the run's
    speed. ``points``: coil numbers of the
    study's points on the wire, where they are others than its own.
    """

    springs: tuple[InstalledSpring, ...] = ()
    rest: tuple[SpringAtRest, ...] = ()
    surge_frequencies: tuple[float, ...] = ()
    lift_event: LiftEvent | None = None
    valve_lift: Callable[[Array], Array] | None = None
    source: str = ""
    rigid: RigidTable | None = None
    points: tuple[tuple[str, float], ...] = ()

    @property
    def surge_frequency(self) -> float | None:
        """Lowest surge frequency (Hz) of the springs; None where none is known."""
        return min(self.surge_frequencies, default=None)

    def static_force(self, valve_lift: Array, model: str = "") -> Array | None:
        """Force (N) of all springs at rest at lifts (m), by ``model`` where it has a curve, else by
        the first that has one.

        None where a spring has no curve or a lift lies beyond it.
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
