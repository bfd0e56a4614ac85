"""Small films with a known truth, drawn by scripts/sample_film.py, which shares nothing with the
reading of films.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "scripts"))
import sample_film as drawn

from valvetrain.film.motion import coil_motion
from valvetrain.film.setup import FilmSetup

RATE, PER_MM = 2000.0, 6.0
SCENE = drawn.Scene(columns=10, frame_rate=RATE, pixels_per_mm=PER_MM)
SCALE = {"frame_rate": RATE, "scale": ((4, 0), (4, 120), 20e-3)}
SURGE, DAMPING, CAM_SPEED, FIRST_ANGLE, MARK_ANGLE = (
    drawn.SURGE,
    drawn.DAMPING,
    drawn.CAM_SPEED,
    drawn.FIRST_ANGLE,
    drawn.MARK_ANGLE,
)
SHARE, REST, OPEN, lift, turning, closing = (
    drawn.SHARE,
    drawn.REST,
    drawn.OPEN,
    drawn.lift,
    drawn.turning,
    drawn.closing,
)


def cam_marks(frames):
    return drawn.mark_of(frames, RATE, CAM_SPEED, FIRST_ANGLE, MARK_ANGLE)


@cache
def turning_film(frames=300, seed=1):
    """The film with a camera that drifts, and its true rows (frames, coils), seat first."""
    return drawn.draw(
        replace(SCENE, camera_drift=1.2, seed=seed), turning, frames, cam_marks(frames)
    )


@cache
def turning_motion():
    film, _ = turning_film()
    return coil_motion(
        film,
        FilmSetup(
            marker=(4, 4),
            marker_radius=2,
            marker_angle=MARK_ANGLE,
            line=((6, 10), (6, 239)),
            **SCALE,
        ),
    )


def errors(found, truth):
    """Errors (px) of places in their order along the line beside true rows (frames, coils) from the
    seat, apart from where on the wire
    the glare lies."""
    off = found - truth[:, ::-1]
    return off - np.nanmedian(off, axis=0)
