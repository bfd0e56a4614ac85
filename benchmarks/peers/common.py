"""The standard jobs in numpy alone, for programs that know nothing of this package (SI units)."""

from __future__ import annotations

import json
import resource
import sys
import time

import numpy as np

YOUNGS, SHEAR, DENSITY, SHEAR_FACTOR = 206e9, 79.6e9, 7850.0, 0.8859
WIRE, RADIUS, TURNS = 4e-3, 12e-3, 6.0
AREA, SECOND_MOMENT = np.pi * WIRE**2 / 4, np.pi * WIRE**4 / 64
#: kappa G A, kappa G A, E A; E I, E I, G J with J = 2 I.
STRETCH = np.array([SHEAR_FACTOR * SHEAR * AREA, SHEAR_FACTOR * SHEAR * AREA, YOUNGS * AREA])
BEND = np.array([YOUNGS * SECOND_MOMENT, YOUNGS * SECOND_MOMENT, 2 * SHEAR * SECOND_MOMENT])
#: Rotary inertia per length about the section axes and the wire axis.
SPIN_INERTIA = DENSITY * SECOND_MOMENT * np.array([1.0, 1.0, 2.0])
MASS_PER_LENGTH = DENSITY * AREA
DAMPING = {"stiffness": (0.0, 8.48826e-6), "mass": (120.637, 0.0)}
PRECOMPRESSION, LIFT, CAM_SPEED = 7e-3, 10e-3, 4000 * 2 * np.pi / 60
DURATION = 2 * 2 * np.pi / CAM_SPEED
PER_TURN = 720
CONTACT_STIFFNESS = 2e10


def displacement(time_now: float) -> float:
    """Retainer displacement (m) at a time (s)."""
    degrees = np.degrees(CAM_SPEED * time_now) % 360.0
    lift = (
        LIFT * np.sin(np.pi * (degrees - 127.0) / 106.0) ** 4 if 127.0 <= degrees <= 233.0 else 0.0
    )
    return PRECOMPRESSION + float(lift)


def velocity(time_now: float) -> float:
    """Retainer velocity (m/s, closing)."""
    degrees = np.degrees(CAM_SPEED * time_now) % 360.0
    if not 127.0 <= degrees <= 233.0:
        return 0.0
    phase = np.pi * (degrees - 127.0) / 106.0
    return float(
        4 * LIFT * np.sin(phase) ** 3 * np.cos(phase) * np.pi / np.radians(106.0) * CAM_SPEED
    )


def height(turn, job: str):
    """Height of the wire axis (m) over the coil number, and its slope (m per turn)."""
    turn = np.asarray(turn, dtype=float)
    if job == "T":
        return 7.5e-3 * turn, np.full_like(turn, 7.5e-3)
    low, high, start, end = 4.4e-3, 8.533e-3, 1.25, 1.75
    inside = np.clip(turn - start, 0.0, end - start)
    slope = low + (high - low) * inside / (end - start)
    rise = (
        low * turn
        + (high - low) * inside**2 / (2 * (end - start))
        + (high - low) * np.maximum(turn - end, 0.0)
    )
    return rise, slope


def wire(turn, job: str):
    """Position (n, 3), directors (n, 3, 3; columns: outward, binormal, tangent) and arc length per
    turn (n,) at coil numbers.
    """
    turn = np.atleast_1d(np.asarray(turn, dtype=float))
    z, slope = height(turn, job)
    angle = 2 * np.pi * turn
    position = np.stack([RADIUS * np.cos(angle), RADIUS * np.sin(angle), z], axis=1)
    tangent = np.stack(
        [-2 * np.pi * RADIUS * np.sin(angle), 2 * np.pi * RADIUS * np.cos(angle), slope], axis=1
    )
    speed = np.linalg.norm(tangent, axis=1)
    tangent /= speed[:, None]
    outward = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1)
    return position, np.stack([outward, np.cross(tangent, outward), tangent], axis=2), speed


def answer(started: tuple[float, float], trace, **more) -> None:
    """Print the result as one JSON line: times of the job, peak memory of the process, trace at
    every half cam degree.
    """
    wall, cpu = time.perf_counter() - started[0], time.process_time() - started[1]
    print(
        "RESULT "
        + json.dumps(
            {
                "wall": wall,
                "cpu": cpu,
                "memory_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
                "trace": [float(value) for value in trace],
                **more,
            }
        )
    )


def start() -> tuple[float, float]:
    """Clocks at the start of a job."""
    return time.perf_counter(), time.process_time()


def options() -> dict:
    """The job's options, a JSON object in the first argument."""
    return json.loads(sys.argv[1])
