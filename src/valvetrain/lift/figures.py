"""Figures of the trade of a lobe, each with its standard deviation: durations, lobe centre, area,
ramp velocities, overlap.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from valvetrain.arrays import Array, Ints
from valvetrain.errors import InputError
from valvetrain.findings.words import Amount
from valvetrain.measured.cam_events import EVENTS, side_of
from valvetrain.measured.contours import Contour
from valvetrain.measured.lift_file import MeasuredLift
from valvetrain.measured.lift_smoothing import BAND, DEGREE, SmoothedLift
from valvetrain.units import unit_factor
from valvetrain.units.reader import shown_system

#: Lifts (m) at which durations are reported: 1 mm of makers' books and 0.050 in of cam cards, which gives the lobe
#: centre and comes first in imperial units.
CARD = 0.050 * 25.4e-3
HEIGHTS = (1e-3, CARD)
#: Lift (m) at which ramp velocities are reported: 0.006 in, the advertised height of cam cards.
RAMP_HEIGHT = 0.006 * 25.4e-3
#: Stations of the grid on which figures are read, and number of draws behind a standard deviation.
STATIONS, DRAWS = 8001, 200
#: Share by which the acceleration around its largest value falls short of it where it jumps, and how far (rad) around is;
#: spacing (rad) of stations above which finer ones tell more than a better probe, and no jump is seen.
JUMP, AROUND, COARSE = 0.15, np.radians(1), np.radians(2.5)

#: Standard deviations from which a station is off the law, and length (m) that no probe resolves.
OFF, RESOLVED = 4.0, 1e-7
#: Share of a figure below which its 95 % interval is that of a law, not of a probe.
FINE = 5e-5
#: Beginnings of the figures whose angle is of the crank.
OF_CRANK = ("overlap", "event_", *map(str.lower, EVENTS))


@dataclass(frozen=True, slots=True)
class LiftFigure:
    """One figure: ``value`` and its ``spread`` (standard deviation), both SI, its ``label`` and the ``unit`` of its text."""

    name: str
    label: str
    value: float
    spread: float
    unit: str

    @property
    def amount(self) -> Amount:
        """The figure, a length or an angle, with half of its 95 % interval."""
        turns = "crank_angle" if self.name.startswith(OF_CRANK) else "cam_angle"
        return Amount("lift" if self.unit == "mm" else turns, self.value, BAND * self.spread)


@dataclass(frozen=True, eq=False)
class LobeResult:
    """One lobe: as measured, smoothed, its figures, and the contour of its cam where that is known."""

    measured: MeasuredLift
    smoothed: SmoothedLift
    figures: tuple[LiftFigure, ...]
    contour: Contour | None = None

    @property
    def values(self) -> dict[str, float]:
        """Value (SI) of each figure by its name."""
        return {one.name: one.value for one in self.figures}

    @property
    def off(self) -> Ints:
        """Places of the stations, of those of the law, that are more than :data:`OFF` standard deviations off it."""
        away = max(OFF * self.smoothed.noise, RESOLVED)
        return np.flatnonzero(np.abs(self.smoothed.residuals) > away)


def lift_figures(smoothed: SmoothedLift, heights: Sequence[float] = ()) -> tuple[LiftFigure, ...]:
    """Figures of one lobe.

    Parameters
    ----------
    smoothed : from :func:`smooth_lift`
    heights : lifts (m) at which durations are reported in addition to 0.050 in and 1 mm

    Returns
    -------
    One LiftFigure each; angles in cam rad, velocities in m/rad, accelerations in m/rad2, the area
    in m rad

    Raises
    ------
    InputError : a height at or above the peak lift

    Examples
    --------
    >>> import valvetrain as vt
    >>> angles = np.radians(np.arange(90.0, 271.0))
    >>> lobe = vt.measured.smooth_lift(angles, 9e-3 * np.clip(1 - ((angles - np.pi) / np.radians(60)) ** 2, 0, None) ** 3, noise=1e-7)
    >>> {one.name: round(one.value * 1e3, 2) for one in lift_figures(lobe)}["peak_lift"]
    9.0
    """
    grid = np.linspace(*smoothed.event, STATIONS)
    every = np.vstack([smoothed.coefficients, smoothed.draws(DRAWS, 0)])
    curves = [_curves(smoothed, every, grid, derivative) for derivative in range(4)]
    peak = float(curves[0][0].max())
    levels = {height_text(height): height for height in _every(heights)}
    for label, height in levels.items():
        if not 0 < height < peak:
            if height in HEIGHTS:
                continue
            raise InputError(
                f"a duration at {label} was requested, but the lobe rises {1e3 * peak:.3f} mm; request one below it",
                "heights",
            )
    found = [
        figure_of("peak_lift", "peak lift", curves[0].max(axis=1), "mm"),
        figure_of("nose_angle", "angle of peak lift", _peak(grid, curves[0]), "deg"),
    ]
    for label, height in levels.items():
        if height < peak:
            opening, closing = crossings(grid, curves[0], height)
            if height == CARD:
                words = "lobe centre, midway between its flanks at 0.050 in"
                found.append(figure_of("lobe_centre", words, (opening + closing) / 2, "deg"))
            ends = {"duration": closing - opening, "opening": opening, "closing": closing}
            for name, values in ends.items():
                found.append(figure_of(f"{name}_at_{height_key(label)}", f"{name} at {label}", values, "deg"))  # fmt: skip
    area = np.asarray(np.trapezoid(curves[0], grid, axis=1))
    found.append(figure_of("lift_area", "area under the lift", area, "mm deg"))
    if peak > RAMP_HEIGHT:
        flanks = zip(("opening", "closing"), crossings(grid, curves[0], RAMP_HEIGHT), strict=True)
        for side, angle in flanks:
            slopes = [
                np.interp(one, grid, curve) for one, curve in zip(angle, curves[1], strict=True)
            ]
            words = f"ramp velocity, {side}, at {height_text(RAMP_HEIGHT)}"
            found.append(figure_of(f"{side}_ramp_velocity", words, np.abs(slopes), "mm/deg"))
    jumps = [overshoot(smoothed, sign)[1] for sign in (1, -1)]
    rows = (
        ("largest_velocity", "largest velocity, opening", curves[1].max(axis=1), "mm/deg", 0.0),
        ("least_velocity", "largest velocity, closing", -curves[1].min(axis=1), "mm/deg", 0.0),
        ("largest_acceleration", "acceleration, flanks", curves[2].max(axis=1), "um/deg^2", jumps[0]),
        ("nose_acceleration", "acceleration, nose", curves[2].min(axis=1), "um/deg^2", jumps[1]),
        ("largest_jerk", "largest jerk, either way", np.abs(curves[3]).max(axis=1), "mm/deg^3", 0.0)
    )  # fmt: skip
    found += [figure_of(*row) for row in rows]
    return tuple(found)


def overshoot(smoothed: SmoothedLift, sign: int) -> tuple[float, float]:
    """Cam angle (rad) of the largest acceleration of a ``sign``, and by how much (m/rad2) it may overshoot there; zero where
    the acceleration around it is nearly as large, or the stations are too far apart to show a jump.
    """
    grid, spacing = (
        np.linspace(*smoothed.event, STATIONS),
        float(np.median(np.diff(smoothed.cam_angles))),
    )
    accelerations, near = sign * smoothed.lift(grid, 2), max(AROUND, spacing)
    place, largest = float(grid[np.argmax(accelerations)]), float(np.max(accelerations))
    before, after = smoothed.lift(place + near * np.array([-1, 1]), 1)
    around = float(sign * (after - before) / (2 * near))
    return place, largest - around if spacing <= COARSE and around < (1 - JUMP) * largest else 0.0


def pair_figures(
    intake: SmoothedLift, exhaust: SmoothedLift, heights: Sequence[float] = ()
) -> tuple[LiftFigure, ...]:
    """Lobe separation (cam rad) and overlap (crank rad) at 0.050 in, 1 mm and ``heights`` (m) of
    two lobes on one zero of the angle.
    """
    ends: dict[str, dict[float, tuple[Array, Array]]] = {}
    for seed, (name, lift) in enumerate((("intake", intake), ("exhaust", exhaust))):
        grid = np.linspace(*lift.event, STATIONS)
        curves = _curves(lift, np.vstack([lift.coefficients, lift.draws(DRAWS, seed)]), grid, 0)
        ends[name] = {
            height: crossings(grid, curves, height)
            for height in _every(heights)
            if height < curves[0].max()
        }
        if CARD not in ends[name]:
            raise InputError(
                f"the {name} lobe rises {1e3 * float(curves[0].max()):.3f} mm, so it has no lobe centre at 0.050 in; check its unit"
            )
    centre = {name: np.asarray(found[CARD]).mean(axis=0) for name, found in ends.items()}
    turn = 2 * np.pi
    ahead = np.round((centre["intake"] - centre["exhaust"])[0] / turn) * turn
    apart = np.abs(centre["intake"] - centre["exhaust"] - ahead)
    figures = [figure_of("lobe_separation", "lobe separation", apart, "deg")]
    for height in _every(heights):
        if all(height in found for found in ends.values()):
            label = height_text(height)
            lap = 2 * (ends["exhaust"][height][1] + ahead - ends["intake"][height][0])
            figures.append(
                figure_of(f"overlap_at_{height_key(label)}", f"overlap at {label}", lap, "deg")
            )
    return tuple(figures)


def _every(heights: Sequence[float]) -> tuple[float, ...]:
    """Lifts (m) of durations: those of the reader's units first, further ``heights`` last."""
    return (*(HEIGHTS if shown_system() == "si" else HEIGHTS[::-1]), *heights)


def crossings(grid: Array, curves: Array, height: float) -> tuple[Array, Array]:
    """Where each of ``curves`` (curves, stations) first rises through ``height`` and last falls
    through it, in the unit of ``grid``.
    """
    above = curves > height
    first, last = np.argmax(above, axis=1), curves.shape[1] - 1 - np.argmax(above[:, ::-1], axis=1)
    row = np.arange(len(curves))

    def between(left: Ints) -> Array:
        left = np.clip(left, 0, curves.shape[1] - 2)
        low, high = curves[row, left], curves[row, left + 1]
        share = np.where(high == low, 0.0, (height - low) / np.where(high == low, 1.0, high - low))
        return np.asarray(grid[left] + np.clip(share, 0.0, 1.0) * (grid[left + 1] - grid[left]))

    return between(first - 1), between(last)


def _curves(lift: SmoothedLift, coefficients: Array, grid: Array, derivative: int) -> Array:
    from scipy.interpolate import BSpline

    found: Array = np.ascontiguousarray(
        BSpline(lift.knots, coefficients.T, DEGREE)(grid, nu=derivative).T
    )
    return found


def _peak(grid: Array, curves: Array) -> Array:
    """Angles of the largest value of each curve, by the parabola through its three highest
    stations.
    """
    place = np.clip(np.argmax(curves, axis=1), 1, curves.shape[1] - 2)
    row = np.arange(len(curves))
    left, top, right = (curves[row, place + step] for step in (-1, 0, 1))
    bend = left - 2 * top + right
    share = np.where(bend < 0, 0.5 * (left - right) / np.where(bend < 0, bend, -1.0), 0.0)
    return np.asarray(grid[place] + np.clip(share, -1.0, 1.0) * (grid[1] - grid[0]))


def figure_of(name: str, label: str, values: Array, unit: str, beyond: float = 0.0) -> LiftFigure:
    """The figure of the mean law, the first of ``values`` (SI), with the spread of the others; ``beyond``: by how much the
    largest acceleration may overshoot.
    """
    spread = float(np.hypot(np.std(values[1:]), beyond / BAND))
    return LiftFigure(name, label, float(values[0]), spread, unit)


#: Unit of a figure -> that of readers of inches; and how parts of a unit are written.
INCHES = {
    "mm": "inch", "mm deg": "inch deg", "mm/deg": "thou/deg", "um/deg^2": "thou/deg^2", "mm/deg^3": "thou/deg^3"
}  # fmt: skip
WRITTEN = {"um": "µm", "inch": "in", "degree": "deg", "^2": "²", "^3": "³"}


def figure_text(figure: LiftFigure, units: str = "si") -> str:
    """A figure with its 95 % interval, which has two digits, in the units of the trade or of readers of inches; an interval
    below :data:`FINE` is not written.

    >>> figure_text(LiftFigure("peak_lift", "peak lift", 9.1e-3, 2e-6, "mm"))
    '9.1000 ± 0.0039 mm'
    """
    unit = INCHES.get(figure.unit, figure.unit) if units == "imperial" else figure.unit
    size = unit_factor(unit)
    if unit == "deg":
        unit = "crank deg" if figure.name.startswith(OF_CRANK) else "cam deg"
    for part, written in WRITTEN.items():
        unit = unit.replace(part, written)
    value, spread = figure.value / size, BAND * figure.spread / size
    if (event := figure.name[:3].upper()) in EVENTS:
        value, side = abs(value), side_of(event, value)
        unit = f"crank deg {side}"
    spread *= spread > FINE * abs(value)
    digits = max(0, min(6, 1 - int(np.floor(np.log10(spread))))) if spread > 0 else 0
    exact = f"{value:.5g}" if figure.name.startswith(OF_CRANK) else f"{value:#.5g}"
    text = f"{value:.{digits}f}" if spread > 0 else exact
    if (
        figure.name == "largest_jerk" and spread > value
    ):  # a size is not below zero, however wide the band
        text = f"0 to {value + spread:.{digits}f}"
    elif spread > 0:
        text += f" ± {spread:.{digits}f}"
    return f"{text} {unit}".strip().replace("-", "−")


_NAMED: Mapping[float, str] = {CARD: "0.050 in", RAMP_HEIGHT: "0.006 in"}


def height_text(height: float) -> str:
    """A height (m) as the trade writes it."""
    return _NAMED.get(height, f"{1e3 * height:.6g} mm")


def height_key(label: str) -> str:
    """The text of a height in names of figures."""
    return (
        label.replace("0.050 in", "50_thou")
        .replace("0.006 in", "6_thou")
        .replace(" ", "_")
        .replace(".", "p")
    )
