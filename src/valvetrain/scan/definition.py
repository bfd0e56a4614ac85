"""From the fitted wire to the spring of a case: which end is the lower one, ground turns, the round
wire equivalent to an ellipse.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from valvetrain.parameters.curves import Constant, Curve, PiecewiseLinear
from valvetrain.parameters.material import Material
from valvetrain.parameters.spring import EndCoil, SpringDefinition
from valvetrain.scan.fit import FittedSpring
from valvetrain.scan.result import ScannedSpring

Array = NDArray[np.float64]
#: Stations of the curves per turn.
STATIONS = 16
#: Difference of diameter or pitch of both halves, as a share, from which it shows which end is the
#: lower one.
SIGNIFICANT = 0.02
#: Gap at the end of the first turn, in wire diameters, up to which an end is closed.
CLOSED = 0.25
#: Standard deviations and share by which turns of the wire must differ to be more than one wire
#: diameter.
VARIED, MIN_VARIED = 6.0, 5e-3


@dataclass(frozen=True, eq=False)
class Wire:
    """The wire axis at ``coil`` (k,) from the lower tip: radius, height and rise per turn with
    their scatter, in mm, turned so that the
    lower end is below; ``faces``: heights of the ground faces, lower and upper, None where there
    are none."""

    coil: Array
    radius: Array
    radius_spread: Array
    height: Array
    height_spread: Array
    pitch: Array
    pitch_spread: Array
    faces: tuple[float | None, float | None]
    turned_over: bool


def wire_of(fitted: FittedSpring, turn_over: bool) -> Wire:
    """The wire from its lower tip: the wider end is the lower one, else the one with the closer
    coils, else as scanned.
    """
    first, last = fitted.tips
    coil = np.linspace(0.0, last - first, int(np.ceil((last - first) * STATIONS)) + 1)
    turn = np.clip(coil + first, first, last)
    (radius, height), (radius_sd, height_sd) = fitted.tube.line(turn), fitted.tube.spreads(turn)
    (_, pitch), (_, pitch_sd) = fitted.tube.line(turn, 1), fitted.tube.spreads(turn, 1)
    faces = [None if face is None else face.height for face in fitted.faces]
    over = _upside_down(coil, radius, pitch) != turn_over
    if over:
        radius, radius_sd, pitch, pitch_sd = (
            radius[::-1],
            radius_sd[::-1],
            pitch[::-1],
            pitch_sd[::-1],
        )
        height, height_sd = -height[::-1], height_sd[::-1]
        faces = [None if face is None else -face for face in faces[::-1]]
    return Wire(
        coil,
        radius,
        radius_sd,
        height,
        height_sd,
        np.maximum(pitch, 0.0),
        pitch_sd,
        (faces[0], faces[1]),
        over,
    )


def _upside_down(coil: Array, radius: Array, pitch: Array) -> bool:
    """Whether the lower end is above: it is the wider one, else the one with the closer coils."""
    inner = (
        (coil > 1.0) & (coil < coil[-1] - 1.0) if coil[-1] > 3 else np.ones(len(coil), dtype=bool)
    )
    lower = coil < coil[-1] / 2
    for values, wider in ((radius, True), (pitch, False)):
        below, above = float(np.mean(values[inner & lower])), float(np.mean(values[inner & ~lower]))
        if abs(below - above) > SIGNIFICANT * (below + above) / 2:
            return (above > below) is wider
    return False


def round_wire(mean: float, ellipticity: float) -> float:
    """Diameter of the round wire that twists as an ellipse of half axes mean (1 +- ellipticity)
    does.

    Its torsion constant pi a^3 b^3 / (a^2 + b^2) (Timoshenko and Goodier, Theory of elasticity) is
    that of a circle, pi d^4 / 32.
    """
    a, b = mean * (1 + ellipticity), mean * (1 - ellipticity)
    return float((32 * (a * b) ** 3 / (a**2 + b**2)) ** 0.25)


def wire_curve(fitted: FittedSpring, turns: Array, round_: float) -> Curve:
    """Wire diameter (m) over the coil: one value, or one a turn where the turns differ by more than
    chance.
    """
    values, spreads = turns[:, 1], turns[:, 2]
    if len(turns) > 2 and not fitted.ovate:
        far = np.abs(values - 2 * fitted.tube.section[0])
        if np.count_nonzero((far > VARIED * spreads) & (far > MIN_VARIED * values)) >= 2:
            return PiecewiseLinear(tuple(turns[:, 0].tolist()), tuple((1e-3 * values).tolist()))
    return Constant(1e-3 * round_)


def define(
    fitted: FittedSpring, wire: Wire, turns: Array, material: Material, name: str
) -> SpringDefinition:
    """The spring definition. A round wire that twists alike replaces an ellipse; gaps between coils are preserved."""
    mean, size = (
        float(fitted.tube.section[0]),
        float(np.hypot(*fitted.tube.section[1:])) if fitted.ovate else 0.0,
    )
    diameter = round_wire(mean, size)
    along = float(fitted.tube.section[1]) if fitted.ovate else 0.0
    wider = diameter - 2 * mean * (
        1 - along
    )  # beyond the height of the section; the gaps between coils are preserved
    bend = np.diff(wire.pitch, 2)
    rise = (
        wire.pitch - np.concatenate([[0.0], bend, [0.0]]) / 12
    )  # straight lines between them then rise as the smooth curve does
    pitch = PiecewiseLinear(
        tuple(wire.coil.tolist()), tuple((1e-3 * np.maximum(rise + max(wider, 0.0), 0.0)).tolist())
    )
    width = PiecewiseLinear(tuple(wire.coil.tolist()), tuple((2e-3 * wire.radius).tolist()))
    ends = [_end(wire, mean * (1 - along), upper) for upper in (False, True)]
    hand = "right" if fitted.tube.hand > 0 else "left"
    return SpringDefinition(
        wire_curve(fitted, turns, diameter),
        width,
        pitch,
        float(wire.coil[-1]),
        material,
        ends[0],
        ends[1],
        hand,  # type: ignore[arg-type]
        name,
    )


def _end(wire: Wire, half: float, upper: bool) -> EndCoil:
    """The end coil: closed where the first turn touches its neighbour; ground up to where the face
    leaves the wire.
    """
    coil = wire.coil
    height = wire.height if not upper else -wire.height[::-1]
    radius = wire.radius if not upper else wire.radius[::-1]
    face = wire.faces[0] if not upper else (None if wire.faces[1] is None else -wire.faces[1])
    at = np.array([0.5, 1.5])
    up, out = np.interp(at, coil, height), np.interp(at, coil, radius)
    closed = float(
        np.hypot(np.interp(1.0, coil, height) - height[0], np.interp(1.0, coil, radius) - radius[0])
    ) < 2 * half * (1 + CLOSED)
    closed = closed or float(np.hypot(up[1] - up[0], out[1] - out[0])) < 2 * half * (1 + CLOSED)
    if face is None:
        return EndCoil("closed" if closed else "open")
    ground = _ground_turns(coil, height - half - face)
    ground = float(np.clip(ground, 0.0, min(2.0, coil[-1] / 2 - 0.3)))
    return EndCoil("closed-ground" if closed else "open-ground", ground, ground)


def _ground_turns(coil: Array, above: Array) -> float:
    """Turn at which the underside of the wire leaves the face for good."""
    below = np.flatnonzero((above <= 0) & (coil < 2.5))
    if not len(below):
        return 0.0
    last = int(below[-1])
    if last + 1 >= len(coil):
        return float(coil[last])
    share = above[last] / (above[last] - above[last + 1])
    return float(coil[last] + share * (coil[last + 1] - coil[last]))


def turned_over(scan: ScannedSpring) -> ScannedSpring:
    """The same spring, turned over."""
    wire, curves, section = scan.definition, scan.curves, scan.section
    turns, shown = section.turns[::-1].copy(), section.shown * np.array([1.0, -1.0])
    turns[:, 0] = wire.total_coils - turns[:, 0]
    laws = {
        name: _reversed(getattr(wire, name), wire.total_coils)
        for name in ("wire_diameter", "mean_diameter", "pitch")
    }
    swapped = {"lower": "upper", "upper": "lower"}
    hidden = tuple(swapped[name] for name in scan.coverage.hidden_tips)
    other = wire.replace(**laws, lower_end=wire.upper_end, upper_end=wire.lower_end)
    names = (
        "mean_diameter",
        "mean_diameter_spread",
        "height_spread",
        "pitch",
        "pitch_spread",
        "centre_line",
    )
    flipped = {name: getattr(curves, name)[::-1] for name in names}
    return replace(
        scan,
        definition=other,
        curves=replace(curves, **flipped, height=scan.free_length[0] - curves.height[::-1]),
        section=replace(section, turns=turns, shown=shown, inclination=-section.inclination),
        lower_end=scan.upper_end,
        upper_end=scan.lower_end,
        coverage=replace(scan.coverage, hidden_tips=hidden),
        axis_direction=-scan.axis_direction,
    )


def _reversed(law: Curve, total: float) -> Curve:
    if not isinstance(law, PiecewiseLinear):
        return law
    return PiecewiseLinear(tuple(total - coil for coil in law.coils[::-1]), law.values[::-1])
