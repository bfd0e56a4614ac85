"""Springs under a prescribed retainer motion: a train whose every other part is rigid and in
contact.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.arrays import Array
from valvetrain.cam.contract import LiftLaw
from valvetrain.errors import InputError
from valvetrain.springs.contract import SpringModel
from valvetrain.system.contract import PRESCRIBED


def names_of(springs: Sequence[object]) -> tuple[str, ...]:
    """Names of the springs in a slot."""
    return ("outer", "inner") if len(springs) > 1 else ("spring",)


@dataclass(frozen=True)
class PrescribedSpring:
    """One spring, or a nested pair, under prescribed motion: the retainer follows ``valve_lift``
    from the installed position.
    """

    kind: ClassVar[str] = PRESCRIBED

    springs: tuple[SpringModel, ...]
    valve_lift: LiftLaw
    name: str = ""

    def __post_init__(self) -> None:
        if not 1 <= len(self.springs) <= 2:
            raise InputError(
                f"a valve carries one or two springs (outer, inner); {len(self.springs)} are given"
            )

    @property
    def spring_names(self) -> tuple[str, ...]:
        return names_of(self.springs)

    def members(self) -> tuple[PrescribedSpring, ...]:
        """Each spring alone: under prescribed motion the springs of a pair do not feel each other."""
        return tuple(
            PrescribedSpring((spring,), self.valve_lift, self.name) for spring in self.springs
        )

    def displacement(self, time: ArrayLike, cam_speed: float, derivative: int = 0) -> Array:
        """Retainer displacement (m) from the installed position over time (s), or its
        ``derivative`` (m/s, m/s2).
        """
        return (
            np.asarray(self.valve_lift.lift(cam_speed * np.asarray(time), derivative))
            * cam_speed**derivative
        )
