"""Results of a film of a spring."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from valvetrain.arrays import Array, Flags
from valvetrain.film.cycles import CamPhase, CoilPeak
from valvetrain.film.space_time import SpaceTime
from valvetrain.film.surge import SurgeFit
from valvetrain.measured.cycles import MeasuredCycles
from valvetrain.solution.display import Reported


@dataclass(frozen=True, eq=False)
class CoilMotion(Reported):
    """Results of a film of a spring. Coils are counted from the seat; displacements are positive
    towards it, from rest in the dwell.

    Parameters
    ----------
    seen : the space-time picture behind it
    places, spread : highlights (frames, coils) px from the start of the line, camera drift taken
        off, and standard deviations
    merged : (frames, coils), where neighbouring highlights ran into each other
    displacement : (frames, coils) m
    phase : cam angle of every frame; None for a free decay
    cycles : per coil its displacement over the cam angle, one row a turn; empty for a free decay
    peaks : per coil its largest displacement a turn with scatter
    dwell : cam angles (rad) of the closed valve
    surge : fitted decay; None where the dwell is too short
    metres_per_pixel, scale_spread : scale and its standard deviation
    drift : (frames,) px that was taken off
    notes : what was found or done, a sentence each

    >>> [name for name in CoilMotion.__dataclass_fields__ if name in ("displacement", "cycles", "peaks")]
    ['displacement', 'cycles', 'peaks']
    """

    seen: SpaceTime
    places: Array
    spread: Array
    merged: Flags
    displacement: Array
    phase: CamPhase | None
    cycles: tuple[MeasuredCycles, ...]
    peaks: tuple[CoilPeak, ...]
    dwell: tuple[float, float] | None
    surge: SurgeFit | None
    metres_per_pixel: float
    scale_spread: float
    drift: Array
    notes: tuple[str, ...]

    @property
    def time(self) -> Array:
        """Time (s) of every frame."""
        return self.seen.time

    @property
    def coils(self) -> int:
        """Number of tracked coils."""
        return int(self.places.shape[1])

    def __repr__(self) -> str:
        frames = len(self.places)
        speed = (
            "free decay"
            if self.phase is None
            else f"{30 * self.phase.cam_speed / np.pi:.1f} rpm of the cam"
        )
        return f"CoilMotion of {self.seen.name}: {self.coils} coils in {frames} frames, {speed}"
