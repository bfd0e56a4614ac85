"""Modal model with varied stiffness, equations 1 to 5 of Gu, Hou, Keating and Ye (2021), solved exactly in Fourier space.

Over one cam cycle every harmonic exp(i j theta) of the lift y gives the same harmonic of mode n:
G_n = (2 / (n pi)) j**2 Y / (w**2 - j**2 + 2 i z w j), w = natural over cam frequency (equation 2 without approximation).

Signs. With G driven by -2/(n pi) y'' (equation 2) the wave equation gives k x0 + k y + pi k sum (-1)**(n+1) n G_n at the fixed end and
k x0 + k y - pi k sum n G_n at the moving one. Equation 5 as printed adds + n G_n for every mode: right at the fixed end for odd
modes, wrong for even ones. Both are returned. Stiffness k(x) is the secant of the static curve, so slow motion follows it exactly.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.errors import InputError
from valvetrain.springs.contract import Array

SAMPLES = 4096


@dataclass(frozen=True)
class ModalSolution:
    """One cam cycle: ``cam_angle`` (s,) rad, ``valve_lift`` (s,) m, ``modal_coordinates`` (modes, s) m, forces (s,) N.

    ``seat_force``: fixed end, signs of the wave equation. ``seat_force_as_printed``: equation 5 letter by letter.
    """

    cam_angle: Array
    valve_lift: Array
    modal_coordinates: Array
    seat_force: Array
    seat_force_as_printed: Array
    retainer_force: Array


@dataclass(frozen=True)
class ModalVaried:
    """``natural_frequencies`` (Hz, one per mode), ``damping_ratio``, static curve ``compressions`` (m from free) -> ``forces`` (N).

    ``precompression`` (m) is the installed compression x0. Raises :class:`InputError` for a curve or frequencies that cannot be.
    """

    natural_frequencies: tuple[float, ...]
    damping_ratio: float
    compressions: tuple[float, ...]
    forces: tuple[float, ...]
    precompression: float
    name: str = "modal-varied"

    def __post_init__(self) -> None:
        if not self.natural_frequencies or min(self.natural_frequencies) <= 0 or np.any(np.diff(self.natural_frequencies) <= 0):
            raise InputError(f"spring '{self.name}' needs positive, rising natural frequencies, one per mode")
        if not 0 <= self.damping_ratio < 1:
            raise InputError(f"damping_ratio of spring '{self.name}' is {self.damping_ratio}; it must lie between 0 and 1")
        if len(self.compressions) != len(self.forces) or len(self.forces) < 2 or np.any(np.diff(self.compressions) <= 0):
            raise InputError(f"static curve of spring '{self.name}' needs two or more points of rising compression")
        if not self.precompression > 0:
            raise InputError(f"precompression of spring '{self.name}' is {self.precompression} m; the model needs a preloaded spring")

    def secant_stiffness(self, compression: ArrayLike) -> Array:
        """k(x) = F(x) / x (N/m) on the static curve; compression in m from the free state.

        Raises :class:`InputError` beyond the curve.
        """
        x = np.asarray(compression, dtype=float)
        if np.any(x > self.compressions[-1] * (1 + 1e-9)) or np.any(x < self.compressions[0]) or np.any(x <= 0):
            raise InputError(
                f"static curve of spring '{self.name}' spans {1e3 * self.compressions[0]:g} to {1e3 * self.compressions[-1]:g} mm, "
                f"but the motion needs {1e3 * float(np.min(x)):.3f} to {1e3 * float(np.max(x)):.3f} mm; extend the curve"
            )
        found: Array = np.interp(x, self.compressions, self.forces) / x
        return found

    def solve(self, valve_lift: Callable[[Array], ArrayLike] | ArrayLike, cam_speed: float, samples: int = SAMPLES) -> ModalSolution:
        """Steady periodic response over one cam turn.

        ``valve_lift`` (m): function of the cam angle (rad), sampled at ``samples`` angles, or samples over one turn (end point left out);
        ``cam_speed`` in rad/s.
        """
        if not cam_speed > 0:
            raise InputError(f"cam_speed is {cam_speed} rad/s; give a positive speed")
        moved, cam_angle = _sampled(valve_lift, samples)
        modal = self.modal_coordinates(moved, cam_speed)
        number = np.arange(1, len(self.natural_frequencies) + 1)
        stiffness = self.secant_stiffness(self.precompression + moved)
        static = stiffness * (self.precompression + moved)
        alternating = np.pi * stiffness * (((-1.0) ** (number + 1) * number) @ modal)
        printed = np.pi * stiffness * (number @ modal)
        return ModalSolution(cam_angle, moved, modal, static + alternating, static + printed, static - printed)

    def modal_coordinates(self, valve_lift: Array, cam_speed: float) -> Array:
        """G_n (m) at the samples of one cam turn, shape (modes, samples), harmonic by harmonic."""
        harmonic = np.arange(len(valve_lift) // 2 + 1)
        spectrum = np.fft.rfft(valve_lift)
        number = np.arange(1, len(self.natural_frequencies) + 1)[:, None]
        ratio = 2 * np.pi * np.asarray(self.natural_frequencies)[:, None] / cam_speed
        transfer = 2 / (np.pi * number) * harmonic**2 / (ratio**2 - harmonic**2 + 2j * self.damping_ratio * ratio * harmonic)
        return np.fft.irfft(transfer * spectrum, n=len(valve_lift), axis=1)


def _sampled(valve_lift: Callable[[Array], ArrayLike] | ArrayLike, samples: int) -> tuple[Array, Array]:
    if callable(valve_lift):
        cam_angle = 2 * np.pi * np.arange(samples) / samples
        return np.asarray(valve_lift(cam_angle), dtype=float), cam_angle
    given = np.asarray(valve_lift, dtype=float)
    if given.ndim != 1 or len(given) < 16 or not np.all(np.isfinite(given)):
        raise InputError("lift samples must be a row of at least 16 finite numbers over one cam turn")
    return given, 2 * np.pi * np.arange(len(given)) / len(given)
