"""From the fitted wire to the spring of a case: which end is the lower one, ground turns, the round
wire equivalent to an ellipse.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from valvetrain.arrays import Array
from valvetrain.parameters.curves import Constant, Curve, PiecewiseLinear
from valvetrain.parameters.winding import EndCoil
from valvetrain.scan.fit import FittedSpring
from valvetrain.scan.result import ScanCurves

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


def upside_down(fitted: FittedSpring) -> bool:
    """Whether the lower end is above: it is the wider one, else the one with the closer coils, else as scanned."""
    first, last = fitted.tips
    edge = 1.0 if last - first > 3 else 0.0
    halves = np.linspace(first + edge, last - edge, 200).reshape(2, -1)
    (radius, _), (_, pitch) = fitted.tube.line(halves), fitted.tube.line(halves, 1)
    for (below, above), wider in ((radius.mean(axis=1), True), (pitch.mean(axis=1), False)):
        if abs(below - above) > SIGNIFICANT * (below + above) / 2:
            return bool((above > below) is wider)
    return False


def curves_of(fitted: FittedSpring, over: bool) -> tuple[ScanCurves, tuple[float, float]]:
    """The wire from its lower tip, its heights above the lower seat plane, and the distance of the seat planes (m) with
    its standard deviation: ground faces, else the outermost wire. ``over``: the lower end is above in the scan.
    """
    (first, last), tube = fitted.tips, fitted.tube
    turn = np.linspace(first, last, int(np.ceil((last - first) * STATIONS)) + 1)
    (radius, height), (_, pitch) = tube.line(turn), tube.line(turn, 1)
    (radius_sd, height_sd), (_, pitch_sd) = tube.spreads(turn), tube.spreads(turn, 1)
    angle = 2 * np.pi * tube.hand * turn
    line = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])
    half, (lower, upper) = float(tube.section[0]), fitted.faces
    low = height.min() - half if lower is None else lower.height
    high = height.max() + half if upper is None else upper.height
    spreads = [float(sd) if face is None else face.spread for face, sd in zip(fitted.faces, height_sd[[0, -1]], strict=True)]  # fmt: skip
    above = high - height if over else height - low
    columns = (2 * radius, 2 * radius_sd, above, height_sd, np.maximum(pitch, 0.0), pitch_sd)
    curves = [1e-3 * column for column in (*columns, fitted.frame.outside(line))]
    if over:
        curves = [curve[::-1] for curve in curves]
    return ScanCurves(turn - first, *curves), (1e-3 * float(high - low), 1e-3 * float(np.hypot(spreads[0], spreads[1])))  # fmt: skip


def round_wire(mean: float, ellipticity: float) -> float:
    """Diameter of the round wire that twists as an ellipse of half axes mean (1 +- ellipticity)
    does.

    Its torsion constant pi a^3 b^3 / (a^2 + b^2) (Timoshenko and Goodier, Theory of elasticity) is
    that of a circle, pi d^4 / 32.
    """
    a, b = mean * (1 + ellipticity), mean * (1 - ellipticity)
    return float((32 * (a * b) ** 3 / (a**2 + b**2)) ** 0.25)


def define(
    fitted: FittedSpring, scan: ScanCurves, free_length: float, turns: Array, over: bool
) -> dict[str, Any]:
    """What a spring definition takes beside material and name. A round wire that twists alike replaces an ellipse; gaps
    between coils are preserved. ``turns`` (k, 4): coil, wire diameter (m), its standard deviation and points of every turn.
    """
    mean, along, across = fitted.tube.section * (1.0, fitted.ovate, fitted.ovate)
    diameter = round_wire(float(mean), float(np.hypot(along, across)))
    coil = tuple(scan.coil.tolist())
    # One wire diameter, or one a turn where the turns differ by more than chance.
    wire: Curve = Constant(1e-3 * diameter)
    far = np.abs(turns[:, 1] - 2e-3 * mean)
    varied = (far > VARIED * turns[:, 2]) & (far > MIN_VARIED * turns[:, 1])
    if len(turns) > 2 and not fitted.ovate and np.count_nonzero(varied) >= 2:
        wire = PiecewiseLinear(tuple(turns[:, 0].tolist()), tuple(turns[:, 1].tolist()))
    # Straight lines then rise as the smooth curve does, and what the round wire is higher than the
    # section goes into the pitch.
    bend = np.pad(np.diff(scan.pitch, 2), 1)
    wider = 1e-3 * max(diameter - 2 * mean * (1 - along), 0.0)
    pitch = np.maximum(scan.pitch - bend / 12 + wider, 0.0)
    half = 1e-3 * float(mean * (1 - along))
    faces = fitted.faces[::-1] if over else fitted.faces
    diameters = scan.mean_diameter
    return {
        "wire_diameter": wire,
        "mean_diameter": PiecewiseLinear(coil, tuple(diameters.tolist())),
        "pitch": PiecewiseLinear(coil, tuple(pitch.tolist())),
        "total_coils": coil[-1],
        "lower_end": _end(scan.coil, scan.height, diameters / 2, half, faces[0] is not None),
        "upper_end": _end(
            scan.coil,
            free_length - scan.height[::-1],
            diameters[::-1] / 2,
            half,
            faces[1] is not None,
        ),
        "hand": "right" if fitted.tube.hand > 0 else "left",
    }


def _end(coil: Array, height: Array, radius: Array, half: float, ground: bool) -> EndCoil:
    """The end coil, its curves from the tip inward and above its seat plane: closed where the first turn touches its
    neighbour; ground up to where the face leaves the wire.
    """
    places = np.array([[0.0, 0.5], [1.0, 1.5]])
    rise, widening = (np.diff(np.interp(places, coil, curve), axis=0) for curve in (height, radius))
    closed = bool(np.hypot(rise, widening).min() < 2 * half * (1 + CLOSED))
    if not ground:
        return EndCoil("closed" if closed else "open")
    # Turn at which the underside of the wire leaves the face for good.
    above = height - half
    below = np.flatnonzero((above <= 0) & (coil < 2.5))
    turns = 0.0
    if len(below):
        near = slice(below[-1], below[-1] + 2)
        turns = float(np.interp(0.0, above[near], coil[near]))
    turns = float(np.clip(turns, 0.0, min(2.0, coil[-1] / 2 - 0.3)))
    return EndCoil("closed-ground" if closed else "open-ground", turns, turns)
