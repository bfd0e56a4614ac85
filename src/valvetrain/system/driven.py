"""Springs that no step of a train can carry, moved by the motion of the same train with other models
of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import BPoly

from valvetrain.arrays import Array
from valvetrain.mechanism.parts import AssembledMechanism
from valvetrain.springs.contract import SpringModel
from valvetrain.system.contract import TRAIN
from valvetrain.system.prescribed import names_of
from valvetrain.system.train_system import TrainSystem

TURN = 2 * np.pi


@dataclass(frozen=True, eq=False)
class DrivenSprings:
    """``springs`` that follow the retainer of ``train``, which runs with models ``driver`` of them.

    One way: the train does not feel how the springs differ from those that it ran with.
    """

    kind: ClassVar[str] = TRAIN

    train: TrainSystem
    springs: tuple[SpringModel, ...]
    driver: str

    @property
    def name(self) -> str:
        return self.train.name

    @property
    def spring_names(self) -> tuple[str, ...]:
        return names_of(self.springs)

    @property
    def mechanism(self) -> AssembledMechanism:
        """That of the train."""
        return self.train.mechanism


@dataclass(frozen=True, eq=False)
class RecordedMotion:
    """A lift law through the samples of one turn of a train: quintic pieces from sample to sample.

    ``displacement`` (n,) m and its first two derivatives, m/rad and m/rad2, at even cam angles from 0.
    The last piece leads back to the first sample.

    >>> angle = np.arange(64) * TURN / 64
    >>> law = RecordedMotion(np.sin(angle), np.cos(angle), -np.sin(angle))
    >>> bool(abs(law.lift(0.3) - np.sin(0.3)) < 1e-9)
    True
    """

    displacement: Array
    slope: Array
    curvature: Array
    continuity: int = 2

    @property
    def joints(self) -> tuple[float, ...]:
        return tuple(float(one) for one in self._angle[:-1])

    @property
    def _angle(self) -> Array:
        return np.linspace(0.0, TURN, len(self.displacement) + 1)

    def __post_init__(self) -> None:
        rows = np.stack([self.displacement, self.slope, self.curvature], axis=1)
        pieces = BPoly.from_derivatives(self._angle, np.concatenate([rows, rows[:1]]))
        laws = (pieces, *(pieces.derivative(order) for order in (1, 2, 3)))
        object.__setattr__(self, "_laws", laws)

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        """See :class:`valvetrain.cam.contract.LiftLaw`."""
        laws: tuple[BPoly, ...] = self.__dict__["_laws"]
        return np.asarray(laws[derivative](np.mod(np.asarray(cam_angle, dtype=float), TURN)))
