"""Runs with a known answer, made of plain formulas: the oracle of the analysis and report tests."""

from __future__ import annotations

import numpy as np

from valvetrain.quantities.cycle import reported_cycle
from valvetrain.solution.channels import spring_channels
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.result import Solution
from valvetrain.solution.study import LiftEvent
from valvetrain.sources.contract import GU2021
from valvetrain.sources.reader import Reader

ENGINE_SPEED = 5600 * 2 * np.pi / 60
#: The lift event of the beehive study.
EVENT = LiftEvent(np.radians(127.0), np.radians(233.0))


def bump(angle_deg, centre, width):
    """A smooth bump of height 1 and full width ``width`` (deg), zero outside."""
    inside = np.abs(angle_deg - centre) < width / 2
    return np.where(inside, np.cos(np.pi * (angle_deg - centre) / width) ** 2, 0.0)


def beehive_reader(made: Solution, event=EVENT, surge_frequency=None) -> Reader:
    """A run as the beehive study reads it, all of its readings taken."""
    reader = GU2021.reader(reported_cycle(made), event, surge_frequency)
    reader.read(GU2021.readings)
    return reader


def run(
    values,
    *,
    per_turn=720,
    turns=2,
    engine_speed=ENGINE_SPEED,
    model="finite-element",
    system="",
    extra=None,
    **places,
) -> Solution:
    """A run whose channels are functions of the wrapped cam angle in degrees (or arrays), over
    ``turns`` cam turns.
    """
    angle = np.arange(per_turn * turns) * 2 * np.pi / per_turn
    degrees = np.round(np.degrees(angle), 9) % 360  # a step at 46.5 must start at the sample there
    computed = {
        name: value(degrees) if callable(value) else value for name, value in values.items()
    }
    channels = spring_channels(angle / (engine_speed / 2), angle, computed, extra=extra, **places)
    return Solution(
        channels, provenance=Provenance("synthetic", model, engine_speed, system=system)
    )


def clashing_run(samples: int = 720, engine_speed: float = ENGINE_SPEED) -> Solution:
    """Two turns of a spring with a bump of 400 N over 3 degrees at 250, four substeps a sample in
    its force.
    """
    angle = np.arange(2 * samples) * 2 * np.pi / samples
    degrees, pairs = np.degrees(angle) % 360, np.arange(1.0, 7.25, 0.5)
    fine = np.degrees(angle[:, None] + np.arange(4) * np.pi / 2 / samples) % 360
    spike = 300 + 500 * bump(fine, 180, 106) + 400 * bump(fine, 250, 3)
    values = {
        "valve_lift": 9e-3 * bump(degrees, 180, 106), "seat_force": spike[:, 0], "seat_force_fine": spike,
        "coil_gap": 1e-3 - 1.1e-3 * bump(degrees, 250, 3)[:, None] * (pairs < 2.6),
        "coil_contact_force": 200 * bump(degrees, 250, 3)[:, None] * (pairs < 2.6),
    }  # fmt: skip
    extra = {"seat_force_fine": (("subsample",), "N", "seat force between the samples")}
    return run(values, per_turn=samples, engine_speed=engine_speed, extra=extra, upper_coil=pairs)
