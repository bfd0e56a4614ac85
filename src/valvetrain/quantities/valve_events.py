"""Where a lift passes a height: opening and closing at lash, at 1 mm and at 0.050 in, of the lobe,
of the rigid valve and of a run.

Curves are solved, not read off their samples: a lift law directly, a run by the cubic of lift and
velocity between samples.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from valvetrain.arrays import Array
from valvetrain.cam.contract import LiftLaw
from valvetrain.cam.pieces import solve
from valvetrain.measured.cam_events import against_dead_centre
from valvetrain.mechanism.rigid import OPEN_SHARE, RigidKinematics
from valvetrain.quantities.kinematics import RigidMotion, RigidTable
from valvetrain.quantities.signal import ring_peak
from valvetrain.quantities.train_events import spans_above
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Event

_TURN = 2 * np.pi
#: Name of a height in names of quantities -> the height (m).
HEIGHTS = {"1_mm": 1e-3, "50_thou": 0.050 * 25.4e-3}
#: Angles at which a lift law is looked at before its crossings are solved.
GRID = 1440


def lift_crossings(cam_lift: Callable[[Array], Array], height: float) -> tuple[float, float] | None:
    """Cam angles (rad) at which ``cam_lift`` (m over cam rad, periodic) rises through ``height``
    (m) before its largest value and falls through it after; the first in one turn from zero, the
    second after it. None where it never is above, or always.
    """
    angle = np.arange(GRID) * _TURN / GRID
    lift = np.asarray(cam_lift(angle))
    if (around := _around_top(lift, height)) is None:
        return None
    before, after = around
    step = _TURN / GRID
    opens = _between(cam_lift, height, before * step, (before + 1) * step)
    closes = _between(cam_lift, height, after * step, (after - 1) * step)
    return opens % _TURN, opens % _TURN + (closes - opens) % _TURN


def _around_top(lift: Array, height: float) -> tuple[int, int] | None:
    """Places of the last sample before the largest lift, and of the first after it, that are not above ``height``; None where
    all are, or none.
    """
    top, down = int(np.argmax(lift)), np.flatnonzero(lift <= height)
    if len(down) in (0, len(lift)):
        return None
    before, after = ((sign * (down - top)) % len(lift) for sign in (-1, 1))
    return int(down[np.argmin(before)]), int(down[np.argmin(after)])


def _between(lift: Callable[[Array], Array], height: float, low: float, high: float) -> float:
    """Where ``lift`` passes ``height`` between an angle at which it is at most that and one at
    which it is more.
    """
    below, above = height - float(lift(np.array(low))), float(lift(np.array(high))) - height
    if above <= 0:  # a node on the height, by rounding above it in the grid
        return high
    if below > 1e-6 * above:
        found = solve(
            lambda angle: float(lift(np.array(angle))) - height, (low, high), within=1e-12
        )
        return low if found is None else found
    while (
        abs(high - low) > 1e-12
    ):  # it rests at that height on one side: no sign changes, only the answer to "above"
        middle = (low + high) / 2
        low, high = (low, middle) if float(lift(np.array(middle))) > height else (middle, high)
    return high


def top_of(kinematics: RigidKinematics) -> float:
    """Largest lift (m) of a rigid valve."""
    angle = np.arange(GRID) * _TURN / GRID
    return ring_peak(np.asarray(kinematics.valve_lift(angle)))


def open_window(kinematics: RigidKinematics) -> tuple[float, float]:
    """Begin and end (cam rad; the end may pass the turn) of the stretch around the largest lift of
    a rigid valve in which it is above :data:`OPEN_SHARE` of that; the whole turn of a lift that
    never falls below.
    """
    found = lift_crossings(kinematics.valve_lift, OPEN_SHARE * top_of(kinematics))
    return (0.0, _TURN) if found is None else found


def event_numbers(
    subject: str, word: str, crossings: tuple[float, float] | None, top: float | None = None
) -> dict[str, float]:
    """Quantities of one pair of crossings: cam angles of opening and closing, crank angle between
    them; none where it never opens. With ``top``, the cam angle (rad) of top dead centre of gas exchange, the crank angles
    against dead centre too.
    """
    if crossings is None:
        return {}
    opens, closes = crossings
    timed = {} if top is None else against_dead_centre(2 * (opens - top), 2 * (closes - top))
    return {f"{event.lower()}_{word}_crank_angle": angle for event, angle in timed.items()} | {
        f"{subject}_{word}_opening_cam_angle": opens % _TURN,
        f"{subject}_{word}_closing_cam_angle": closes % _TURN,
        f"{subject}_{word}_open_crank_angle_range": 2 * (closes - opens),
    }


def rigid_events(kinematics: RigidKinematics) -> dict[str, float]:
    """Events of the lobe (where the lift law is one) and of the rigid valve at the heights of
    :data:`HEIGHTS`, of the valve at lash too.
    """
    found: dict[str, float] = {}
    law = kinematics.law.lift
    if kinematics.law_of == "drive":
        for word, height in HEIGHTS.items():
            found |= event_numbers("lobe", word, lift_crossings(law, height))
    label, heights = ("lash", *HEIGHTS), np.array([0.0, *HEIGHTS.values()])
    for word, height in zip(label, kinematics.law_lift(heights).tolist(), strict=True):
        found |= event_numbers("rigid_valve", word, lift_crossings(law, height))
    return found


def closing_ramp(law: LiftLaw) -> dict[str, float]:
    """Cam angles (rad) between which the closing ramp of a lift law runs; empty of a law without ramps."""
    height = getattr(law, "ramp_lift", 0.0)
    ends = [lift_crossings(law.lift, one) for one in (height, 0.0)] if height > 0 else []
    names = ("closing_ramp_begin_cam_angle", "closing_ramp_end_cam_angle")
    return {name: one[1] % _TURN for name, one in zip(names, ends, strict=False) if one}


def nose_ends(motion: RigidMotion) -> dict[str, float]:
    """Cam angles (rad) between which the valve of rigid parts is slowed over the nose."""
    angle, slowed = motion.cam_angle, -motion.derivatives[2]
    nose = float(angle[int(np.argmax(motion.derivatives[0]))])
    # some laws have no acceleration at full lift, where the nose does not end
    for begin, end in spans_above(angle, slowed, -1e-3 * float(slowed.max())):
        if (nose - begin) % _TURN <= end - begin:
            names = ("rigid_nose_begin_cam_angle", "rigid_nose_end_cam_angle")
            return dict(zip(names, (begin % _TURN, end % _TURN), strict=True))
    return {}


def run_events(
    solution: Solution, events: Sequence[Event], top: float | None = None
) -> dict[str, float]:
    """Events of the valve of one closed turn: off its seat as the integrator saw it, and at every
    height of :data:`HEIGHTS`; against dead centre too where ``top``, its cam angle (rad), is known.
    """
    found: dict[str, float] = {}
    first = next(
        (event for event in events if event.kind == "seating" and event.details.get("touch") == 1),
        None,
    )
    if first is not None and "release_cam_angle" in first.details:
        opens = float(first.details["release_cam_angle"]) % _TURN
        flight = opens, opens + (first.cam_angle - opens) % _TURN
        found |= event_numbers("valve", "lash", flight, top)
    if not solution.has("valve_lift", "valve_velocity"):
        return found
    lift, rate = (
        solution.channel("valve_lift"),
        solution.channel("valve_velocity") / (solution.engine_speed / 2),
    )
    for word, height in HEIGHTS.items():
        ends = sampled_crossings(solution.cam_angle, lift, rate, height)
        found |= event_numbers("valve", word, ends, top)
    return found


def lost_durations(numbers: Mapping[str, float], rigid: RigidTable) -> dict[str, float]:
    """Crank angle (rad) at every height of :data:`HEIGHTS` by which the valve of a run, whose numbers are
    ``numbers``, is open for less than that of rigid parts; none of what never opens.
    """
    lift = np.asarray(rigid["valve_lift"], dtype=float)
    known = rigid.columns.get("valve_velocity")
    rate = (
        np.gradient(lift, rigid.cam_angle)
        if known is None
        else np.asarray(known, dtype=float) / rigid.cam_speed
    )
    lost: dict[str, float] = {}
    for word, height in HEIGHTS.items():
        own = numbers.get(f"valve_{word}_open_crank_angle_range")
        crossings = sampled_crossings(rigid.cam_angle, lift, rate, height)
        if own is not None and crossings is not None:
            lost[f"valve_{word}_lost_crank_angle_range"] = 2 * (crossings[1] - crossings[0]) - own
    return lost


def sampled_crossings(
    cam_angle: Array, valve_lift: Array, rate: Array, height: float
) -> tuple[float, float] | None:
    """As :func:`lift_crossings`, of one closed turn of samples (S,) evenly over ``cam_angle``
    (rad); ``rate``: m per cam rad.

    Between samples is the cubic of both lifts and rates, so that the crossings are right to the
    fourth power of the interval.
    """
    count, around = len(valve_lift), _around_top(valve_lift, height)
    if around is None:
        return None
    before, after = around
    step = _TURN / count

    def crossing(first: int) -> float:
        second = (first + 1) % count
        low, high, slope, end = (
            float(value)
            for value in (valve_lift[first], valve_lift[second], rate[first], rate[second])
        )
        rise, slope, end = high - low, slope * step, end * step
        cubic = np.array([slope + end - 2 * rise, 3 * rise - 2 * slope - end, slope, low - height])
        roots = np.roots(cubic) if np.any(cubic[:-1]) else np.zeros(0)
        real = roots[np.abs(roots.imag) < 1e-9].real
        inside = real[(real >= -1e-9) & (real <= 1 + 1e-9)]
        share = float(inside[0]) if len(inside) else (height - low) / rise
        return float(cam_angle[first]) + share * step

    opens, closes = crossing(before), crossing((after - 1) % count)
    return opens % _TURN, opens % _TURN + (closes - opens) % _TURN
