"""Runs with a known answer, made of plain formulas: the oracle of the analysis and report tests."""

from __future__ import annotations

import numpy as np

from valvetrain.solution.channels import spring_channels
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.result import Solution

ENGINE_SPEED = 5600 * 2 * np.pi / 60


def bump(angle_deg, centre, width):
    """A smooth bump of height 1 and full width ``width`` (deg), zero outside."""
    inside = np.abs(angle_deg - centre) < width / 2
    return np.where(inside, np.cos(np.pi * (angle_deg - centre) / width) ** 2, 0.0)


def run(values, *, per_turn=720, turns=2, engine_speed=ENGINE_SPEED, model="finite-element", **places) -> Solution:
    """A run whose channels are functions of the wrapped cam angle in degrees (or arrays), over ``turns`` cam turns."""
    angle = np.arange(per_turn * turns) * 2 * np.pi / per_turn
    degrees = np.round(np.degrees(angle), 9) % 360  # a step at 46.5 must start at the sample there
    computed = {name: value(degrees) if callable(value) else value for name, value in values.items()}
    channels = spring_channels(angle / (engine_speed / 2), angle, computed, **places)
    return Solution(channels, provenance=Provenance("synthetic", model, engine_speed))
