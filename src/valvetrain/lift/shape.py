"""The cam behind a lift: the contour that gives it to a follower, its curvature, and what the follower needs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.lift.figures import LiftFigure, LobeResult, figure_of, overshoot
from valvetrain.measured.contours import TURN, Follower, contour_of_lift, curvature_of_contour
from valvetrain.measured.lift_smoothing import BAND
from valvetrain.solution.atomic import write_text
from valvetrain.views.files import csv_of

#: Points of a contour, draws behind a standard deviation, and largest roller (m) that is looked for.
POINTS, DRAWS, LARGEST = 1440, 40, 1.0
#: Headings of a contour as a file.
HEADINGS = (
    "cam angle [deg]", "polar angle [deg]", "radius [mm]", "x [mm]", "y [mm]", "radius of curvature [mm]", "pressure angle [deg]"
)  # fmt: skip


def with_contour(lobe: LobeResult, base_radius: float | None, follower: Follower) -> LobeResult:
    """The lobe with the contour that gives ``follower`` its lift on a base circle of ``base_radius`` (m), and its figures; as it
    is without a base circle. A lift that was made of a contour keeps that one.

    Raises :class:`InputError` for the lift of a valve, which is not that of the follower, and a follower that does not
    reach the base circle.
    """
    given = lobe.measured.contour
    if given is not None:
        base_radius = float(given[1].min())
    if base_radius is None:
        return lobe
    if lobe.measured.lift_of != "tappet":
        raise InputError(
            "a contour lifts the tappet, and this is the lift of the valve; give the tappet's, with --lift-of tappet where both are one",
            "--base-radius",
        )
    law = lobe.smoothed
    angles = law.event[0] + TURN * np.arange(POINTS) / POINTS
    every = np.vstack([law.coefficients, law.draws(DRAWS, 0)])
    lifts = np.array([[law.evaluated(row, angles, order) for row in every] for order in range(3)])
    drawn = contour_of_lift(lifts, angles, base_radius, follower)
    contour = contour_of_lift(lifts[:, 0], angles, base_radius, follower)
    found = [LiftFigure("base_radius", "radius of the base circle", base_radius, 0.0, "mm")]
    if given is None:
        beyond = overshoot(law, -1)[1] / BAND
        found += _curvature(drawn.curvature_radii, angles, beyond)
        found += _largest_roller(lifts[:, 0], angles, base_radius)
    else:
        radii, spread = curvature_of_contour(*given)
        turn = given[0][0] + TURN * np.arange(len(radii)) / len(radii)
        found += _curvature(radii[None], turn, spread)
        hollow = np.any((radii < 0) & (not follower.radius or -radii < follower.radius))
        contour = replace(contour, curvature_radii=radii, undercut=bool(hollow))
    if follower.radius:
        steep = np.abs(drawn.pressure_angles)
        place = angles[np.argmax(steep, axis=1)]
        found.append(
            figure_of(
                "largest_pressure_angle", "largest pressure angle", steep.max(axis=1), "degree"
            )
        )
        found.append(
            figure_of("pressure_angle_place", "where the pressure angle is largest", place, "deg")
        )
    else:
        width = 2 * np.abs(lifts[1]).max(axis=1)
        found.append(figure_of("flat_width", "least width of the flat face", width, "mm"))
    return replace(lobe, figures=(*lobe.figures, *found), contour=contour)


def _curvature(radii: Array, angles: Array, spread: Array | float) -> list[LiftFigure]:
    """Least radius of curvature with its place, and that of a hollow where the flank has one, of ``radii`` (laws, stations), the
    mean law first; ``spread`` (m): standard deviations besides that of the laws. None of a contour too rough for curvature.
    """
    if np.any(np.isnan(radii)):
        return []
    found, beyond = [], np.broadcast_to(spread, angles.shape)
    for name, words, sign in (
        ("least_radius", "least radius of curvature", 1),
        ("hollow_radius", "radius of the hollow flank, to grind and for rollers", -1),
    ):
        sizes = np.where(sign * radii > 0, sign * radii, np.inf)
        values, place = sizes.min(axis=1), int(np.argmin(sizes[0]))
        if np.all(values < LARGEST):
            off = float(np.hypot(np.std(values[1:]) if len(values) > 1 else 0.0, beyond[place]))
            found.append(LiftFigure(name, words, float(values[0]), off, "mm"))
            found.append(
                LiftFigure(
                    f"place_of_{name}", f"where the {words} is", float(angles[place]), 0.0, "deg"
                )
            )
    return found


def _largest_roller(lifts: Array, angles: Array, base_radius: float) -> list[LiftFigure]:
    """The largest roller on a line through the cam's centre that this base circle lifts without undercutting; none where
    every roller may be used.
    """
    low, high = 0.0, LARGEST
    if not contour_of_lift(lifts, angles, base_radius, Follower(high)).undercut:
        return []
    for _ in range(40):
        middle = (low + high) / 2
        undercut = contour_of_lift(lifts, angles, base_radius, Follower(middle)).undercut
        low, high = (low, middle) if undercut else (middle, high)
    return [LiftFigure("largest_roller", "largest roller radius without undercut", low, 0.0, "mm")]


def write_contours(lobes: Sequence[LobeResult], folder: Path) -> list[Path]:
    """The contours that were made for ``lobes`` as files of columns."""
    files = []
    for lobe in lobes:
        if (one := lobe.contour) is not None and lobe.measured.contour is None:
            angles = np.degrees(lobe.smoothed.event[0] + TURN * np.arange(POINTS) / POINTS)
            x, y = one.radii * [np.cos(one.polar_angles), np.sin(one.polar_angles)]
            lengths = 1e3 * np.array([one.radii, x, y, one.curvature_radii])
            turns = np.degrees([one.polar_angles, one.pressure_angles])
            name = f"{lobe.measured.name}-contour.csv"
            columns = np.column_stack([angles, turns[0], *lengths, turns[1]])
            files.append(write_text(folder / name, csv_of(HEADINGS, columns.tolist(), 9)))
    return files
