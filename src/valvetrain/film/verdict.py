"""The verdict on a film: the coil that moves most, and how far a model is from every coil."""

from __future__ import annotations

import numpy as np

from valvetrain.film.model import FilmedModel
from valvetrain.film.result import CoilMotion
from valvetrain.report.text import number

#: Share of the largest peak from which a coil counts as moving.
MOVING = 0.05


def film_verdict(motion: CoilMotion, model: FilmedModel | None = None) -> str:
    """How near the model is, where there is one; else what the film shows."""
    if model is not None:
        return filmed_model_verdict(model)
    if motion.phase is None:
        return f"Free decay of {_coils(motion.coils)}{_surge(motion)}."
    peaks = np.array([one.mean for one in motion.peaks])
    top = int(np.nanargmax(peaks))
    where = f"coil {top + 1} of {motion.coils} moves most, {number(1e3 * float(peaks[top]), 4)} mm"
    rpm = 30 * motion.phase.cam_speed / np.pi
    return f"At {number(rpm, 4)} rpm of the cam, {where}{_surge(motion)}."


def _coils(count: int) -> str:
    return f"{count} coil{'s' * (count != 1)}"


def _surge(motion: CoilMotion) -> str:
    """The lowest line of the surge with its damping; empty where there is none."""
    if motion.surge is None or not motion.surge.lines:
        return ""
    line = motion.surge.lines[0]
    return f"; surge at {number(line.natural_frequency, 4)} Hz, damping ratio {number(line.damping_ratio, 2)}"


def filmed_model_verdict(model: FilmedModel) -> str:
    """How far the model is from the moving coils, in per cent of the largest peak of each."""
    moving = np.flatnonzero(model.peaks > MOVING * float(np.max(model.peaks, initial=0.0)))
    if not len(moving):
        return f"No coil moves in {model.case} by {model.model}."
    shares = model.apart[moving] / model.peaks[moving]
    worst = int(np.nanargmax(shares))
    off = f"{100 * float(shares[worst]):.2g} % of its peak"
    which = f"coil {int(moving[worst]) + 1} is the furthest off, {number(1e3 * float(model.apart[moving[worst]]), 2)} mm"
    if len(moving) == 1:
        return f"{model.case} by {model.model} moves one coil; it is within {off} of the film."
    return f"{model.case} by {model.model} is within {100 * float(shares[worst]):.2g} % of every moving coil; {which} (root mean square)."
