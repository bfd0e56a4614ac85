"""Trains of the package that a moving surface strikes, and their orbits by Newton's method on the package's cycle map."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from validation.impacts import Array, Bouncer, Surface, TwoMasses
from valvetrain.contact.dissipative import Flores, damping_number
from valvetrain.errors import InputError
from valvetrain.integrate.multipliers import DISTURBANCE, multipliers
from valvetrain.integrate.train_record import TrainOptions
from valvetrain.integrate.train_run import runner
from valvetrain.integrate.train_steady import scaled_cycle
from valvetrain.mechanism.contour import lift_table
from valvetrain.mechanism.gap_kinds import CAM_LIFT, LINEAR
from valvetrain.mechanism.parts import AssembledMechanism, Coordinate, ElasticLink, Interaction
from valvetrain.system.train_system import TrainSystem


def train(bouncer: Bouncer) -> TrainSystem:
    """A struck mass as a train of the package; the restitution of its contact does not depend on the speed."""
    number = damping_number(bouncer.restitution)
    law = Flores(bouncer.stiffness, 1.6 / (1.6 + number))
    link = ElasticLink(bouncer.rate, 2 * bouncer.damping * math.sqrt(bouncer.rate * bouncer.mass))
    spring = Interaction("spring", LINEAR, ("valve",), (bouncer.raised, 1.0), link)
    return struck((Coordinate("valve", bouncer.mass),), (spring,), law, bouncer.surface)


def two_masses(known: TwoMasses) -> TrainSystem:
    """The two masses of 1 kg as a train of the package."""
    number, rate = damping_number(known.restitution), known.natural**2
    law = Flores(1e14, 1.6 / (1.6 + number))
    link = ElasticLink(rate, 2 * known.damping * known.natural)
    springs = (
        Interaction("spring", LINEAR, ("valve",), (0.0, 1.0), link),
        Interaction("link", LINEAR, ("valve", "mass"), (0.0, 1.0, -1.0), link),
    )
    return struck((Coordinate("valve", 1.0), Coordinate("mass", 1.0)), springs, law, known)


def struck(
    bodies: tuple[Coordinate, ...], springs: tuple[Interaction, ...], law: Flores, surface: Surface
) -> TrainSystem:
    """A train whose first body a surface strikes."""
    strikes = Interaction(
        "cam", CAM_LIFT, ("valve",), (0.0, 1.0, 0.0, 0.0, 0.0, 1.0), law, "cam lift"
    )
    tables = {"cam lift": lift_table(surface)}
    return TrainSystem(
        AssembledMechanism("follower", bodies, (strikes, *springs), tables, "valve", "valve")
    )


@dataclass(frozen=True)
class Orbit:
    """An orbit of the package: its state at angle zero (height over the surface's zero, velocity), the slopes of the turn's
    map there, and the multipliers that the package finds.
    """

    state: Array
    slopes: Array
    multipliers: NDArray[np.complex128]


def orbit(system: TrainSystem, cam_speed: float, start: Array, size: float) -> Orbit:
    """The package's orbit near a state at angle zero, by Newton's method on its cycle map.

    ``size`` (m): of the motion; the slopes for the search are taken over a hundredth of it, as those for multipliers.
    Raises InputError where none is found.
    """
    ready = runner(
        system, cam_speed, TrainOptions(samples=1440, step_fraction=0.1, impact_steps=64)
    )
    cycle, _, weights = scaled_cycle(ready, ready.initial_state())
    scale = float(weights[0]) * size
    state, every = start * weights, np.eye(len(start))
    for _ in range(20):
        left = (cycle(state) - state) / scale
        if not np.all(np.isfinite(left)) or np.max(np.abs(left)) > 10:
            break
        steps = 0.01 * scale * every
        slopes = np.array(
            [(cycle(state + step) - cycle(state - step)) / (0.02 * scale) for step in steps]
        ).T
        if np.max(np.abs(left)) < 2e-5:
            found = multipliers(cycle, state, every, disturbance=DISTURBANCE * scale)
            return Orbit(state / weights, slopes, found)
        state = state - np.linalg.solve(slopes - every, left * scale)
    raise InputError(f"no orbit near the known one at {cam_speed * 30 / math.pi:g} rpm")
