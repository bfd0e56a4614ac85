"""A law behind measured stations: noise removed with its uncertainty quantified, base circle exactly
zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

from pydantic import Field

from valvetrain.cam.contract import LiftSpec
from valvetrain.cam.event import lobe_of_file
from valvetrain.cam.pieces import OfPieces, PeriodicPieces, pieces_of_spline
from valvetrain.errors import InputError
from valvetrain.measured.lift_file import MeasuredLift
from valvetrain.measured.lift_smoothing import DEGREE, SmoothedLift, smooth_lift
from valvetrain.parameters.lift_law import LiftLawParameters, LiftModel, check_angles
from valvetrain.parameters.schema_types import (
    Angle,
    Angles,
    Length,
    Lengths,
    Line,
    guarded,
    problem,
)

#: Highest number of a draw.
MAX_DRAWS = 10_000


@dataclass(frozen=True, kw_only=True)
class Measured(OfPieces):
    """The law behind ``lifts`` (m) at ``cam_angles`` (rad), as `valvetrain.measured.lift_smoothing`
    finds it.

    ``noise`` (m): standard deviation of a station, 0 to find it. ``band`` (m): how far the law may
    leave a station, 0 for no bound. ``draw``: 0 for the mean; another number for one of the laws
    that the stations allow, the same for the same number.
    """

    cam_angles: tuple[float, ...]
    lifts: tuple[float, ...]
    noise: float = 0.0
    band: float = 0.0
    draw: int = 0

    def __post_init__(self) -> None:
        if len(self.cam_angles) != len(self.lifts):
            raise InputError(
                f"lifts has {len(self.lifts)} entries but cam_angles {len(self.cam_angles)}; give one lift per angle"
            )
        if not 0 <= self.draw <= MAX_DRAWS:
            raise InputError(
                f"draw is a whole number from 0 (the mean) to {MAX_DRAWS}; it is {self.draw}",
                "draw",
            )

    @property
    def continuity(self) -> int:
        return 2

    @cached_property
    def smoothed(self) -> SmoothedLift:
        """The law with its uncertainty."""
        return smooth_lift(self.cam_angles, self.lifts, self.noise or None, self.band or None)

    @cached_property
    def _pieces(self) -> PeriodicPieces:
        from scipy.interpolate import BSpline

        lift = self.smoothed
        coefficients = lift.draws(self.draw)[-1] if self.draw else lift.coefficients
        return pieces_of_spline(BSpline(lift.knots, coefficients, DEGREE), self.continuity)


class MeasuredModel(LiftModel):
    """Measured lifts, from a file of any known form or inline; the law behind their noise."""

    cam_angles: Angles | None = None
    lifts: Lengths | None = None
    file: str | None = None
    lobe: Line = Field(
        default="", description="which lobe of the file, where it holds more than one"
    )
    angle_of: Literal["", "cam", "crank"] = Field(
        default="", description="whose angles the file holds, where it does not say"
    )
    angle_unit: Literal["", "deg", "rad"] = Field(
        default="", description="unit of the angles of the file, where it does not say"
    )
    lift_unit: str = Field(
        default="", description="unit of the lifts of the file, where it does not say"
    )
    zero: Literal["", "file", "nose"] = Field(
        default="", description="zero of the angle: that of the file, or the nose"
    )
    direction: Literal["", "forward", "reversed"] = Field(
        default="", description="whether the table was taken against the rotation"
    )
    columns: str = Field(
        default="", description="what each column of the file is, where it does not say"
    )
    follower: Line = Field(
        default="", description="of a file with a contour: what it lifts, such as roller 10 mm"
    )
    mend: bool = Field(
        default=False, description="takes out stations that stand out of a smooth lift"
    )
    peak_lift: Length | None = Field(
        default=None, description="largest lift of a file of fractions"
    )
    duration: Angle | None = Field(
        default=None,
        description="length of the event of a file of fractions, in the angle of angle_of",
    )
    opening: Angle | None = Field(
        default=None,
        description="beginning of the event of a file of fractions, in the angle of angle_of",
    )
    noise: Length = Field(default=0.0, description="standard deviation of a station; 0 finds it")
    band: Length = Field(
        default=0.0, description="how far the law may leave a station; 0 for no bound"
    )
    draw: int = Field(
        default=0,
        ge=0,
        le=MAX_DRAWS,
        description="0: the mean; another: one of the laws that the stations allow",
    )

    def parameters(self, folder: Path) -> LiftLawParameters:
        if self.file is None:
            return LiftLawParameters("measured", self._inline(), self.lift_of, self.zero_of_angle)
        lobe = self._read(folder)
        zero = self.zero_of_angle or lobe.zero
        return LiftLawParameters(
            "measured",
            self._values(tuple(lobe.cam_angles), tuple(lobe.lifts)),
            lobe.lift_of,  # type: ignore[arg-type]
            zero,
        )

    def _inline(self) -> dict[str, Any]:
        if self.cam_angles is None or self.lifts is None:
            raise problem(
                "measured lifts are given by file, or by cam_angles and lifts together; add what is missing"
            )
        return self._values(self.cam_angles, self.lifts)

    def _values(self, cam_angles: tuple[float, ...], lifts: tuple[float, ...]) -> dict[str, Any]:
        if len(cam_angles) != len(lifts):
            raise problem(
                f"lifts has {len(lifts)} entries but cam_angles {len(cam_angles)}; give one lift per angle",
                ("lifts",),
            )
        check_angles(cam_angles, ("cam_angles",))
        values: dict[str, Any] = {
            "cam_angles": tuple(float(angle) for angle in cam_angles), "lifts": tuple(float(lift) for lift in lifts), "noise": self.noise,
            "band": self.band, "draw": self.draw,
        }  # fmt: skip
        guarded(lambda: Measured(**values).smoothed)
        return values

    def _read(self, folder: Path) -> MeasuredLift:
        if self.cam_angles is not None or self.lifts is not None:
            raise problem(
                "measured lifts are given by file or by cam_angles and lifts, not by both; leave one out",
                ("file",),
            )
        return lobe_of_file(
            self, folder, self.lift_of if "lift_of" in self.model_fields_set else ""
        )


SPEC = LiftSpec(Measured, MeasuredModel)
