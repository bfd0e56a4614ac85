"""A spline through a table of lifts, resting on an exactly zero base circle."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from valvetrain.arrays import Array
from valvetrain.cam.contract import TURN, LiftSpec
from valvetrain.cam.event import bounded_pieces, event_of_table, has_jumps, lobe_of_file
from valvetrain.cam.pieces import (
    OfPieces,
    PeriodicPieces,
    pieces_of_spline,
    quintic_pieces,
    with_base_circle,
)
from valvetrain.errors import InputError
from valvetrain.parameters.lift_law import LiftModel, check_angles
from valvetrain.parameters.schema_types import (
    Angle,
    Angles,
    Length,
    Lengths,
    Line,
    guarded,
    problem,
    quantities,
)


@dataclass(frozen=True, kw_only=True)
class Spline(OfPieces):
    """Spline of ``degree`` 5 or 7 through ``lifts`` (m) at ``cam_angles`` (rad), zero outside them.

    The first (degree - 1) / 2 derivatives vanish at both ends, so the law leaves and meets the base
    circle with that continuity; inside it has degree - 1 continuous derivatives. ``smoothing`` (m):
    root-mean-square distance from the table that is allowed to calm the jerk; 0 interpolates. Where
    the acceleration of the table jumps (arcs, tangents), a spline through it would swing; the law
    is then that of `valvetrain.cam.event`, of straight acceleration between the stations and a
    continuity of 2.
    """

    cam_angles: tuple[float, ...]
    lifts: tuple[float, ...]
    degree: int = 5
    smoothing: float = 0.0

    def __post_init__(self) -> None:
        angles = np.asarray(self.cam_angles, dtype=float)
        if self.degree not in (5, 7):
            raise InputError(
                f"a lift spline has degree 5 or 7, not {self.degree}; choose one of them"
            )
        if len(angles) != len(self.lifts) or len(angles) < 4:
            raise InputError(
                "a lift spline needs four stations or more, each with one lift; complete the table"
            )
        if np.any(np.diff(angles) <= 0) or angles[-1] - angles[0] > TURN * (1 + 1e-12):
            raise InputError(
                "the stations of a lift spline must rise in angle within one cam revolution; sort them"
            )
        if self.lifts[0] != 0 or self.lifts[-1] != 0:
            raise InputError(
                "a lift spline must begin and end on the base circle; add stations of zero lift"
            )

    @property
    def continuity(self) -> int:
        return 2 if self._jumps else (self.degree - 1) // 2

    @property
    def joints(self) -> tuple[float, ...]:
        return self._pieces.joints if self._jumps else tuple(self.cam_angles)

    @cached_property
    def _jumps(self) -> bool:
        """Whether the acceleration jumps and the base circle has space for one more station on
        either side.
        """
        first, last = (self.cam_angles[place + 1] - self.cam_angles[place] for place in (0, -2))
        room = self.cam_angles[-1] - self.cam_angles[0] + first + last <= TURN
        return (
            self.smoothing == 0
            and room
            and has_jumps(
                np.asarray(self.cam_angles, dtype=float), np.asarray(self.lifts, dtype=float)
            )
        )

    @cached_property
    def _pieces(self) -> PeriodicPieces:
        from scipy.interpolate import make_interp_spline

        angles, lifts = (
            np.asarray(self.cam_angles, dtype=float),
            np.asarray(self.lifts, dtype=float),
        )
        if self._jumps:
            return with_base_circle(*bounded_pieces(angles, lifts), self.continuity)
        if self.smoothing > 0:
            spline = smoothed_spline(angles, lifts, self.degree, self.smoothing)
        else:
            rest = [(order, 0.0) for order in range(1, self.continuity + 1)]
            spline = make_interp_spline(angles, lifts, k=self.degree, bc_type=(rest, rest))
        return pieces_of_spline(spline, self.continuity)


class SplineModel(LiftModel):
    """A spline through a table of lifts; ``mirror_angle`` completes half a table."""

    law: ClassVar[str] = "spline"
    cam_angles: Angles | None = None
    lifts: Lengths | None = None
    file: str | None = None
    angle_unit: Literal["deg", "rad"] | None = None
    angle_of: Literal["cam", "crank"] | None = None
    lift_unit: str | None = None
    columns: str = Field(
        default="", description="what each column of the file is, where it has more than two"
    )
    lobe: Line = Field(
        default="", description="which lobe of the file, where it holds more than one"
    )
    mirror_angle: Angle | None = Field(
        default=None, description="about which half a table is mirrored; without it it is whole"
    )
    degree: Literal[5, 7] = Field(default=5, description="of the spline")
    smoothing: Length = Field(
        default=0.0, description="root-mean-square distance from the table that is allowed"
    )

    def values(self, folder: Path) -> dict[str, Any]:
        """Keyword arguments of the law's class; refuses tables that contradict themselves."""
        angles, lifts = self._table(folder)
        if len(angles) != len(lifts):
            raise problem(
                f"lifts has {len(lifts)} entries but cam_angles {len(angles)}; give one lift per angle",
                ("lifts",),
            )
        check_angles(angles, ("cam_angles",))
        if self.mirror_angle is not None:
            angles, lifts = _mirrored(angles, lifts, self.mirror_angle)
            check_angles(angles, ("mirror_angle",))
        if self.smoothing < 0:
            raise problem(
                "smoothing is the allowed root-mean-square deviation from the table, zero or more",
                ("smoothing",),
            )
        noise = max(self.smoothing, 1e-9)
        if min(lifts) < -10 * noise:
            raise problem(
                "lifts must not be negative (beyond ten times the smoothing); correct the table",
                ("lifts",),
            )
        angles, lifts = guarded(event_of_table, angles, lifts, noise, path=("lifts",))
        check_angles(angles, ("cam_angles",))
        return {
            "cam_angles": angles,
            "lifts": lifts,
            "degree": self.degree,
            "smoothing": self.smoothing,
        }

    def _table(self, folder: Path) -> tuple[tuple[float, ...], tuple[float, ...]]:
        inline = self.cam_angles is not None or self.lifts is not None
        if inline == (self.file is not None):
            raise problem(
                "a lift table is given either by cam_angles and lifts or by file; give one of them"
            )
        if self.file is None:
            if self.cam_angles is None or self.lifts is None:
                raise problem("cam_angles and lifts belong together; add the missing one")
            return self.cam_angles, self.lifts
        for name in ("angle_unit", "angle_of", "lift_unit"):
            if getattr(self, name) is None:
                raise problem(
                    f"{name} is missing: a lift file does not say it itself; add {name}", ()
                )
        lobe = lobe_of_file(self, folder, self.lift_of)
        return tuple(map(float, lobe.cam_angles)), tuple(map(float, lobe.lifts))


def _mirrored(
    angles: tuple[float, ...], lifts: tuple[float, ...], about: float
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    if abs(angles[-1] - about) > 1e-6:
        last, mirror = math.degrees(angles[-1]), math.degrees(about)
        raise problem(
            f"half a table must end at mirror_angle; it ends at {last:g} deg, not {mirror:g} deg",
            ("mirror_angle",),
        )
    return (*angles[:-1], *(2 * about - angle for angle in angles[::-1])), (
        *lifts[:-1],
        *lifts[::-1],
    )


SPLINE_SPEC = LiftSpec(Spline, SplineModel)


@dataclass(frozen=True, kw_only=True)
class Stations(OfPieces):
    """Piecewise quintic through stations (cam rad): lifts (m), velocities (m/rad) and accelerations
    (m/rad2), all zero at both ends.
    """

    continuity: ClassVar[int] = 2

    cam_angles: tuple[float, ...]
    lifts: tuple[float, ...]
    velocities: tuple[float, ...]
    accelerations: tuple[float, ...]

    def __post_init__(self) -> None:
        states = np.array([self.lifts, self.velocities, self.accelerations])
        if np.any(states[:, [0, -1]] != 0):
            raise InputError(
                "the first and last station must rest on the base circle (lift, velocity, acceleration zero); add them"
            )
        angles = np.asarray(self.cam_angles)
        if np.any(np.diff(angles) <= 0) or angles[-1] - angles[0] > TURN * (1 + 1e-12):
            raise InputError("the stations must rise in angle within one cam revolution; sort them")

    @cached_property
    def _pieces(self) -> PeriodicPieces:
        angles = np.asarray(self.cam_angles)
        states = np.stack([self.lifts, self.velocities, self.accelerations], axis=1)
        return with_base_circle(
            angles, quintic_pieces(angles, states[:-1], states[1:]), self.continuity
        )

    @property
    def joints(self) -> tuple[float, ...]:
        return tuple(self.cam_angles)


CamVelocities = Annotated[tuple[float, ...], quantities("cam velocity")]
CamAccelerations = Annotated[tuple[float, ...], quantities("cam acceleration")]


class StationsModel(LiftModel):
    """Quintic pieces between stations at which lift, velocity and acceleration (per cam angle) are
    all given.
    """

    cam_angles: Angles
    lifts: Lengths
    velocities: CamVelocities
    accelerations: CamAccelerations

    def values(self, folder: Path) -> dict[str, Any]:
        """Keyword arguments of the law's class; refuses stations of unequal number or out of order."""
        own = super().values(folder)
        for name in ("lifts", "velocities", "accelerations"):
            if len(own[name]) != len(self.cam_angles):
                raise problem(
                    f"{name} has {len(own[name])} entries but cam_angles {len(self.cam_angles)}; give one each",
                    (name,),
                )
        check_angles(self.cam_angles, ("cam_angles",))
        return own


STATIONS_SPEC = LiftSpec(Stations, StationsModel)


#: Knots at first, and at last; where stations are closer they share them, and only a deviation
#: that cannot be met so needs more.
FIRST_KNOTS, MAX_KNOTS = 400, 1600


def smoothed_spline(cam_angles: Array, lifts: Array, degree: int, deviation: float) -> Any:
    """B-spline (scipy) of least squared jerk at a root-mean-square distance ``deviation`` (m) from
    the table.

    Its lift and first (degree - 1) / 2 derivatives are zero at both ends. Penalised regression; the
    weight of the jerk is found by bisection. Raises :class:`InputError` when no curve between the
    table and a straight base circle is that far away, or none of :data:`MAX_KNOTS` knots that near.
    """
    most, nearest = FIRST_KNOTS, 0.0
    while most <= MAX_KNOTS:
        found, nearest = _with_knots(cam_angles, lifts, degree, deviation, most)
        if found is not None:
            return found
        most *= 2
    raise InputError(
        f"smoothing of {deviation * 1e3:g} mm is less than the {len(lifts)} stations scatter: {nearest * 1e3:.2g} mm about the nearest "
        "curve; give the noise of the table, or fewer stations"
    )


def _with_knots(
    cam_angles: Array, lifts: Array, degree: int, deviation: float, most: int
) -> tuple[Any, float]:
    """The spline with at most this many knots, and 0; None and how near these come where that is not
    enough and there are more stations.
    """
    from scipy.interpolate import BSpline

    stations = len(cam_angles)
    angles = (
        cam_angles
        if stations <= most
        else cam_angles[np.round(np.linspace(0, stations - 1, most)).astype(int)]
    )
    knots = np.concatenate([np.full(degree, angles[0]), angles, np.full(degree, angles[-1])])
    held = (degree + 1) // 2
    count = len(knots) - degree - 1
    free = slice(held, count - held)
    design = BSpline.design_matrix(cam_angles, knots, degree).toarray()[:, free]
    nodes, weights = np.polynomial.legendre.leggauss(4)
    points = (angles[:-1, None] + np.diff(angles)[:, None] * (nodes + 1) / 2).ravel()
    scale = np.sqrt((np.diff(angles)[:, None] * weights / 2).ravel())
    jerk = BSpline(knots, np.eye(count), degree).derivative(3)(points)[:, free] * scale[:, None]
    normal, penalty, right = design.T @ design, jerk.T @ jerk, design.T @ lifts
    unit = np.trace(normal) / np.trace(penalty)

    def fit(weight: float) -> tuple[Array, float]:
        inner = np.linalg.lstsq(normal + weight * unit * penalty, right, rcond=None)[0]
        return inner, float(np.sqrt(np.mean((design @ inner - lifts) ** 2)))

    low, high = 1e-16, 1e8
    if fit(high)[1] < deviation:
        raise InputError(
            f"smoothing of {deviation * 1e3:g} mm would flatten the lift; give the noise of the table, such as 0.002 mm"
        )
    if len(angles) < stations and (nearest := fit(low)[1]) > deviation:
        return None, nearest
    for _ in range(60):
        weight = np.sqrt(low * high)
        low, high = (weight, high) if fit(weight)[1] < deviation else (low, weight)
    coefficients = np.zeros(count)
    coefficients[free] = fit(low)[0]
    return BSpline(knots, coefficients, degree), 0.0
