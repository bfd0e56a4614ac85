"""Small films with a known truth, drawn by scripts/sample_film.py, which shares nothing with the reading of films."""

from __future__ import annotations

import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "scripts"))
import sample_film as drawn

from valvetrain.measurements.film.motion import coil_motion
from valvetrain.measurements.film.setup import FilmSetup

RATE, PER_MM = 2000.0, 6.0
SCENE = drawn.Scene(columns=10, frame_rate=RATE, pixels_per_mm=PER_MM)
SCALE = {"frame_rate": RATE, "scale_points": ((4, 0), (4, 120)), "scale_length": 20e-3}
#: Natural frequency (Hz) and damping ratio of the closed forms, speed of the cam (rad/s), angles of first frame and mark (rad).
SURGE, DAMPING, CAM_SPEED, FIRST_ANGLE, MARK_ANGLE = 412.0, 0.015, 170.0, 0.7, 1.1
SHARE = np.array([0.0, 0.2, 0.4, 0.6, 0.8, 1.0])
REST = 2.0 + 32.0 * SHARE
LIFT, OPEN = 9.0, 2.2  # mm, rad


def lift(cam_angle):
    """Lift (m) of a closed form: fourth power of a sine over the open part, none before and after."""
    angle = np.mod(cam_angle, 2 * np.pi)
    return 1e-3 * LIFT * np.where(angle < OPEN, np.sin(np.pi * np.minimum(angle, OPEN) / OPEN) ** 4, 0.0)


def turning(time):
    """Heights (mm): each section follows its share of the lift; as the valve closes a surge begins that decays freely."""
    angle = CAM_SPEED * time + FIRST_ANGLE
    since = np.mod(angle - OPEN, 2 * np.pi) / CAM_SPEED
    rate = 2 * np.pi * SURGE
    swing = 0.7 * np.exp(-DAMPING * rate * since) * np.sin(rate * np.sqrt(1 - DAMPING**2) * since)
    return REST - 1e3 * lift(angle)[:, None] * SHARE + swing[:, None] * np.sin(np.pi * SHARE)


def cam_marks(frames):
    return drawn.mark_of(frames, RATE, CAM_SPEED, FIRST_ANGLE, MARK_ANGLE)


@cache
def turning_film(frames=300, seed=1):
    """The film with a camera that drifts, and its true rows (frames, coils), seat first."""
    return drawn.draw(replace(SCENE, camera_drift=1.2, seed=seed), turning, frames, cam_marks(frames))


@cache
def turning_motion():
    film, _ = turning_film()
    return coil_motion(film, FilmSetup(marker=(4, 4), marker_radius=2, marker_angle=MARK_ANGLE, line=((6, 10), (6, 239)), **SCALE))


def closing(coils, wire, pitch, surge):
    """Heights (mm) of coils that close one after the other until all touch, twenty turns a second, and surge at 420 Hz."""
    share, room = np.arange(coils) / (coils - 1), (pitch - wire) * (coils - 1)

    def heights(time):
        angle = np.mod(2 * np.pi * 20 * time + 2.0, 2 * np.pi)
        opened = np.where(np.abs(angle - np.pi) < 0.8, np.cos((angle - np.pi) / 1.6 * np.pi) ** 2, 0.0)
        found = 2.0 + pitch * np.arange(coils) - room * opened[:, None] * share
        found = found + surge * np.sin(2 * np.pi * 420 * time)[:, None] * np.sin(np.pi * share)
        for one in range(1, coils):
            found[:, one] = np.maximum(found[:, one], found[:, one - 1] + wire)
        return found

    return heights


def errors(found, truth):
    """Errors (px) of places in their order along the line beside true rows (frames, coils) from the seat, apart from where on the wire
    the glare lies."""
    off = found - truth[:, ::-1]
    return off - np.nanmedian(off, axis=0)
