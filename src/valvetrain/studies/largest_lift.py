"""Largest lift of the valve in a problem, for whoever must know how far its springs are compressed."""

from __future__ import annotations

import numpy as np

from valvetrain.system.problem import Problem


def largest_lift(problem: Problem) -> float:
    """Largest valve lift (m): of the rigid train, or of the law that drives the spring."""
    lifts = [
        float(member.gear.mechanism.kinematics.maximum_lift)
        for member in problem.members
        if member.gear is not None
    ]
    return max(
        lifts, default=float(np.max(problem.valve_lift.lift(np.linspace(0.0, 2 * np.pi, 721))))
    )
