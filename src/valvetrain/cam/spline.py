"""A spline through a table of lifts, resting on an exactly zero base circle."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from valvetrain.cam.contract import TURN, Array, LiftSpec
from valvetrain.cam.jumps import bounded_pieces, has_jumps
from valvetrain.cam.lift_event import event_of_table
from valvetrain.cam.pieces import PeriodicPieces, pieces_of_spline, with_base_circle
from valvetrain.errors import InputError
from valvetrain.measurements.lift_answers import LiftAnswers
from valvetrain.measurements.lift_reading import read_lift
from valvetrain.measurements.measured_lift import MeasuredLift
from valvetrain.parameters.bounded_file import named_file
from valvetrain.parameters.schema_lift import LiftModel, check_angles
from valvetrain.parameters.schema_types import Angle, Angles, Length, Lengths, guarded, problem


@dataclass(frozen=True, kw_only=True)
class Spline:
    """Spline of ``degree`` 5 or 7 through ``lifts`` (m) at ``cam_angles`` (rad), zero outside them.

    The first (degree - 1) / 2 derivatives vanish at both ends, so the law leaves and meets the base circle with that continuity;
    inside it has degree - 1 continuous derivatives. ``smoothing`` (m): root-mean-square distance from the table that is allowed to
    calm the jerk; 0 interpolates. Where the acceleration of the table jumps (arcs, tangents), a spline through it would swing; the law
    is then that of `valvetrain.cam.jumps`, of straight acceleration between the stations and a continuity of 2.
    """

    cam_angles: tuple[float, ...]
    lifts: tuple[float, ...]
    degree: int = 5
    smoothing: float = 0.0

    def __post_init__(self) -> None:
        angles = np.asarray(self.cam_angles, dtype=float)
        if self.degree not in (5, 7):
            raise InputError(f"a lift spline has degree 5 or 7, not {self.degree}; choose one of them")
        if len(angles) != len(self.lifts) or len(angles) < 4:
            raise InputError("a lift spline needs four stations or more, each with one lift; complete the table")
        if np.any(np.diff(angles) <= 0) or angles[-1] - angles[0] > TURN * (1 + 1e-12):
            raise InputError("the stations of a lift spline must rise in angle within one cam revolution; sort them")
        if self.lifts[0] != 0 or self.lifts[-1] != 0:
            raise InputError("a lift spline must begin and end on the base circle; add stations of zero lift")

    @property
    def continuity(self) -> int:
        return 2 if self._jumps else (self.degree - 1) // 2

    @property
    def joints(self) -> tuple[float, ...]:
        return self._pieces.joints if self._jumps else tuple(self.cam_angles)

    @cached_property
    def _jumps(self) -> bool:
        """Whether the acceleration jumps and the base circle has room for one more station on either side."""
        first, last = (self.cam_angles[place + 1] - self.cam_angles[place] for place in (0, -2))
        room = self.cam_angles[-1] - self.cam_angles[0] + first + last <= TURN
        return self.smoothing == 0 and room and has_jumps(np.asarray(self.cam_angles, dtype=float), np.asarray(self.lifts, dtype=float))

    @cached_property
    def _pieces(self) -> PeriodicPieces:
        from scipy.interpolate import make_interp_spline

        angles, lifts = np.asarray(self.cam_angles, dtype=float), np.asarray(self.lifts, dtype=float)
        if self._jumps:
            return with_base_circle(*bounded_pieces(angles, lifts), self.continuity)
        if self.smoothing > 0:
            from valvetrain.cam.smoothing import smoothed_spline

            spline = smoothed_spline(angles, lifts, self.degree, self.smoothing)
        else:
            rest = [(order, 0.0) for order in range(1, self.continuity + 1)]
            spline = make_interp_spline(angles, lifts, k=self.degree, bc_type=(rest, rest))
        return pieces_of_spline(spline, self.continuity)

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        return self._pieces.lift(cam_angle, derivative)

    def polynomial_pieces(self) -> PeriodicPieces:
        """The exact flat form."""
        return self._pieces


class SplineModel(LiftModel):
    """A spline through a table of lifts; ``mirror_angle`` completes half a table."""

    law: ClassVar[str] = "spline"
    cam_angles: Angles | None = None
    lifts: Lengths | None = None
    file: str | None = None
    angle_unit: Literal["deg", "rad"] | None = None
    angle_of: Literal["cam", "crank"] | None = None
    lift_unit: str | None = None
    columns: str = Field(default="", description="what each column of the file is, where it has more than two")
    mirror_angle: Angle | None = Field(default=None, description="about which half a table is mirrored; without it it is whole")
    degree: Literal[5, 7] = Field(default=5, description="of the spline")
    smoothing: Length = Field(default=0.0, description="root-mean-square distance from the table that is allowed")

    def values(self, folder: Path) -> dict[str, Any]:
        """Keyword arguments of the law's class; refuses tables that contradict themselves."""
        angles, lifts = self._table(folder)
        if len(angles) != len(lifts):
            raise problem(f"lifts has {len(lifts)} entries but cam_angles {len(angles)}; give one lift per angle", ("lifts",))
        check_angles(angles, ("cam_angles",))
        if self.mirror_angle is not None:
            angles, lifts = _mirrored(angles, lifts, self.mirror_angle)
            check_angles(angles, ("mirror_angle",))
        if self.smoothing < 0:
            raise problem("smoothing is the allowed root-mean-square deviation from the table, zero or more", ("smoothing",))
        noise = max(self.smoothing, 1e-9)
        if min(lifts) < -10 * noise:
            raise problem("lifts must not be negative (beyond ten times the smoothing); correct the table", ("lifts",))
        angles, lifts = guarded(event_of_table, angles, lifts, noise, path=("lifts",))
        check_angles(angles, ("cam_angles",))
        return {"cam_angles": angles, "lifts": lifts, "degree": self.degree, "smoothing": self.smoothing}

    def _table(self, folder: Path) -> tuple[tuple[float, ...], tuple[float, ...]]:
        inline = self.cam_angles is not None or self.lifts is not None
        if inline == (self.file is not None):
            raise problem("a lift table is given either by cam_angles and lifts or by file; give one of them")
        if self.file is None:
            if self.cam_angles is None or self.lifts is None:
                raise problem("cam_angles and lifts belong together; add the missing one")
            return self.cam_angles, self.lifts
        for name in ("angle_unit", "angle_of", "lift_unit"):
            if getattr(self, name) is None:
                raise problem(f"{name} is missing: a lift file does not say it itself; add {name}", ())
        answers = guarded(
            lambda: LiftAnswers(
                angle_of=self.angle_of or "", lift_of=self.lift_of, angle_unit=self.angle_unit or "", lift_unit=self.lift_unit or "",
                columns=tuple(word.strip() for word in self.columns.split(",") if word.strip()),
            )
        )  # fmt: skip
        lobes: tuple[MeasuredLift, ...] = guarded(
            read_lift, guarded(named_file, folder, self.file, path=("file",)), answers, path=("file",)
        )
        if len(lobes) > 1:
            words = " and ".join(lobe.name for lobe in lobes)
            raise problem(f"{self.file[:80]} holds {words}; name the others 'ignore' in columns", ("columns",))
        return tuple(map(float, lobes[0].cam_angles)), tuple(map(float, lobes[0].lifts))


def _mirrored(angles: tuple[float, ...], lifts: tuple[float, ...], about: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
    if abs(angles[-1] - about) > 1e-6:
        last, mirror = math.degrees(angles[-1]), math.degrees(about)
        raise problem(f"half a table must end at mirror_angle; it ends at {last:g} deg, not {mirror:g} deg", ("mirror_angle",))
    return (*angles[:-1], *(2 * about - angle for angle in angles[::-1])), (*lifts[:-1], *lifts[::-1])


SPEC = LiftSpec(Spline, SplineModel)
