"""Sentences on what was found in a film and done to it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from valvetrain.measurements.film.cycles import TURN
from valvetrain.measurements.film.drift import SPOKEN_OF
from valvetrain.measurements.film.surge import SurgeFit

Array = NDArray[np.float64]


def drift_words(drift: Array, still: int | None) -> tuple[str, ...]:
    """How far the camera moved, and by which coil (from 0) that was told."""
    if still is None:
        return ("no coil stands still, so a shift of the camera cannot be separated from the spring's motion and stays in it",)
    reach = float(np.ptp(drift))
    if reach < SPOKEN_OF:
        return ()
    return (f"the camera drifted by {reach:.2g} px over the film, as coil {still + 1} shows that stands still; this was taken off",)


def turn_words(cam_angle: Array) -> tuple[str, ...]:
    """What few turns leave open."""
    shown = float(cam_angle[-1] - cam_angle[0]) / TURN
    if shown >= 2.0:
        return ()
    words = f"the film shows {shown:.2f} turns of the cam, so peaks have no scatter"
    return (words + (", and a peak outside them is not seen" if shown < 1.0 else ""),)


def surge_words(surge: SurgeFit, frame_rate: float, exposure: float | None) -> tuple[str, ...]:
    """What frame rate and exposure do to the lines."""
    half, notes = 0.5 * frame_rate, []
    high = [one for one in surge.lines if one.natural_frequency > 0.8 * half]
    for one in high:
        notes.append(
            f"the line at {one.natural_frequency:.4g} Hz lies near half the frame rate ({half:g} Hz) and may be one of "
            f"{frame_rate - one.natural_frequency:.4g} Hz mirrored there; film faster to tell"
        )
    if exposure is not None:
        lost = [(one.natural_frequency, 1 - float(np.sinc(one.natural_frequency * exposure))) for one in surge.lines]
        notes += [f"motion blur lowers the swing at {line:.4g} Hz by {100 * share:.2g} %" for line, share in lost if share > 0.005]
    return tuple(notes)
