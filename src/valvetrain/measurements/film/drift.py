"""Slow shift of the camera, seen at a coil that stands still."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
#: A coil stands still that moves less than this share of the largest motion; harmonics of the cam that are told from a drift.
STILL, HARMONICS = 0.15, 8
#: Highest power of time in a drift, and the smallest one (px) that is spoken of.
MOST_POWERS, SPOKEN_OF = 5, 0.05


def camera_drift(places: Array, time: Array, cam_angle: Array | None) -> tuple[Array, int | None]:
    """Drift (frames,) px by the stillest coil, and which it is (None, with zeros, where none stands still).

    Powers of time, fitted together with harmonics of the cam so that a coil that moves a little with the cam tells no drift.
    """
    size = np.array([_motion(one, time) for one in places.T])
    still = int(np.argmin(size))
    if len(size) < 2 or not size[still] < STILL * size.max():
        return np.zeros(len(time)), None
    one, good = places[:, still], np.isfinite(places[:, still])
    turns = 0.0 if cam_angle is None else float(cam_angle[-1] - cam_angle[0]) / (2 * np.pi)
    powers = int(np.clip(1 + turns, 1, MOST_POWERS)) if cam_angle is not None else 3
    scaled = 2 * (time - time[0]) / (time[-1] - time[0]) - 1
    slow = np.polynomial.legendre.legvander(scaled, powers)[:, 1:]
    waves = [np.ones((len(time), 1))]
    if cam_angle is not None and turns >= 1.0:
        phase = cam_angle[:, None] * np.arange(1, HARMONICS + 1)
        waves += [np.cos(phase), np.sin(phase)]
    basis = np.concatenate([slow, *waves], axis=1)
    shares = np.linalg.lstsq(basis[good], one[good], rcond=None)[0]
    return np.asarray(slow @ shares[:powers]), still


def _motion(place: Array, time: Array) -> float:
    """Size of a motion (standard deviation) beside a slow trend."""
    good = np.isfinite(place)
    if good.sum() < 8:
        return np.inf
    trend = np.polyval(np.polyfit(time[good] - time[0], place[good], 3), time[good] - time[0])
    return float(np.std(place[good] - trend))
