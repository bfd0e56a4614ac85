"""What happens in one closed cycle of a train: loft, float, loss of contact, seating, bounce, each
with its cause.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from valvetrain.arrays import Array, Ints
from valvetrain.integrate.clash import runs
from valvetrain.integrate.transitions import CONTACTS_LOGGED, openings_by_law
from valvetrain.mechanism.rigid import OPEN_SHARE
from valvetrain.quantities.kinematics import RigidTable
from valvetrain.quantities.signal import ring_peak, ring_top
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Cause, Detail, Event

SMALLEST_GAP = 2e-6
"""Gaps below this (m) are vibration of a contact, not an event, while the valve is near its seat; wide
open any gap is one, as in the search over engine speed.
"""
MARGINAL = 2.5 * SMALLEST_GAP

#: Share of the speed at which rigid parts lose contact from which those that flex do so for the same reason.
ALSO_RIGID = 0.98
#: Kinds of a loss of contact while the valve should be driven: of the cam, of another contact.
LOSSES = LOFT, LOSS = "loft", "loss-of-contact"
#: Closings of contacts that the integrator logged are read and then dropped.
LOGGED = ("touch",)
#: Losses of contact that follow on each other within this angle (rad) are one stretch in which the
#: train is open.
NEXT_TO = 1e-9


@dataclass(frozen=True, eq=False)
class RigidCycle:
    """Rigid motion at the samples of a run (S,): lift (m), acceleration (m/s2), contact force at
    the cam (N); ``top`` (m) and ``nose`` (cam rad): its largest lift and its position, whatever
    the samples; ``open_spans``: begin and end (cam rad) of the stretches off the seat; ``wide_open``: of
    that around the nose in which it is above :data:`OPEN_SHARE` of its largest lift; ``drive``: its
    contacts from cam to valve (``cam``, ``valve_tip``); ``loss_share``: as in a rigid table.
    """

    valve_lift: Array
    valve_acceleration: Array
    contact_force: Array
    top: float
    nose: float
    open_spans: tuple[Span, ...]
    wide_open: tuple[Span, ...]
    drive: tuple[str, ...]
    loss_share: float = 0.0


def rigid_cycle(solution: Solution, rigid: RigidTable) -> RigidCycle:
    """The rigid table, which may have any number of samples, at the cam angles of a run."""
    names = ("valve_lift", "valve_acceleration", "contact_force")
    moved, slowed, pressed = (
        np.interp(solution.cam_angle, rigid.cam_angle, rigid[name], period=TURN) for name in names
    )
    opened = rigid.open_spans or tuple(spans_above(rigid.cam_angle, rigid["valve_lift"]))
    lift = rigid["valve_lift"]
    top, nose = ring_peak(lift), ring_top(rigid.cam_angle, lift)
    high = spans_above(rigid.cam_angle, lift, OPEN_SHARE * top)
    wide = tuple((begin, end) for begin, end in high if (nose - begin) % TURN <= end - begin)
    return RigidCycle(
        moved, slowed, pressed, top, nose, opened, wide, rigid.drive, rigid.loss_share
    )


def drive_forces(solution: Solution) -> dict[str, float]:
    """Least force (N) of every contact of the drive (``valve_tip``) over every step with the valve open;
    empty where the integrator did not look.
    """
    return {
        name.removeprefix("least_").removesuffix("_contact_force"): float(value)
        for name, value in solution.statistics.items()
        if name.startswith("least_") and name.endswith("_contact_force")
    }


def train_events(solution: Solution, rigid: RigidCycle) -> tuple[Event, ...]:
    """All events of one closed cycle but clashes, in order of cam angle."""
    losses = _contact_losses(solution, rigid)
    found = [*losses, *_floats(solution, rigid, losses), *_seatings_and_bounces(solution, rigid)]
    return tuple(sorted(found, key=lambda event: event.cam_angle))


def counted_losses(events: Iterable[Event]) -> list[Event]:
    """The losses of contact that count, the largest gap first."""
    counted = (event for event in events if event.kind in LOSSES and event.counts)
    return sorted(counted, key=lambda event: -event.size)


def lost_spans(events: Iterable[Event], turn: float) -> list[Span]:
    """Cam angles in which any contact of the drive is lost; ``turn``: time (s) of a cam revolution."""
    return [
        span_of(event.cam_angle, event.cam_angle + event.duration / turn * TURN)
        for event in events
        if event.kind in LOSSES
    ]


def marginal_duration(events: Iterable[Event]) -> float:
    """Time (s) of the losses of contact that count by gaps up to :data:`MARGINAL`, each of which another
    division of the springs may not have.
    """
    return sum(one.duration for one in counted_losses(events) if one.size < MARGINAL)


def _contact_losses(solution: Solution, rigid: RigidCycle) -> list[Event]:
    """Loft at the cam and losses of contact elsewhere while the rigid valve is open: wide open by any
    gap, as the search over engine speed counts them; size is the largest gap (m). They count where the valve is
    wide open and the contact carries no force there at some step.
    """
    logged = solution.statistics.get(CONTACTS_LOGGED) == 1
    if logged and not any(event.kind in LOGGED for event in solution.events):
        return [
            event for event in solution.events if event.kind in LOSSES
        ]  # found before, when the log was there
    found, least_forces = [], drive_forces(solution)
    for place in rigid.drive:
        if not solution.has(f"{place}_gap"):
            continue
        kind = LOFT if place == "cam" else LOSS
        gap = solution.channel(f"{place}_gap")
        for begin, end, largest in (
            _logged_spans(solution, place, gap) if logged else _sampled_spans(solution, gap)
        ):
            for part in shared([(begin, end)], rigid.open_spans):
                whole = part[1] - part[0] >= (end - begin) * (1 - 1e-9)
                size = largest if whole else _largest_within(solution.cam_angle, gap, part)
                wide = bool(shared([part], rigid.wide_open))
                if size > (0.0 if wide else SMALLEST_GAP):
                    details = _loss_details(solution, rigid, place, part, end)
                    one = _event(solution, kind, part, size, place, details)
                    counts = wide and least_forces.get(place, 0.0) <= 0
                    found.append(replace(one, counts=counts))
        found += _unloaded(solution, rigid, place, found)
    return found


def _unloaded(
    solution: Solution, rigid: RigidCycle, place: str, losses: Sequence[Event]
) -> list[Event]:
    """Losses of a contact that carries no force with the valve wide open and yet has no gap: its damping
    holds it back. To the samples, of no gap; none next to one of the ``losses`` there.
    """
    least = drive_forces(solution).get(place, np.nan)
    known = lost_spans([one for one in losses if one.where == place], _period(solution))
    if not (least <= 0 and rigid.wide_open) or shared(known, rigid.wide_open):
        return []
    angle, (begin, end) = solution.cam_angle, rigid.wide_open[0]
    inside = (angle - begin) % TURN <= end - begin
    force = np.where(inside, solution.channel(f"{place}_contact_force"), np.inf)
    none = force <= max(0.0, float(np.min(force)))  # between samples: at the one next to it
    return [
        _event(
            solution,
            LOFT if place == "cam" else LOSS,
            part,
            0.0,
            place,
            _loss_details(solution, rigid, place, part, part[1]),
        )
        for part in spans_above(angle, np.where(none, 1.0, -1.0))
    ]


def _logged_spans(solution: Solution, place: str, gap: Array) -> list[tuple[float, float, float]]:
    """Release, touch (cam rad) and largest gap (m) of every stretch in which a contact is open, as
    the integrator saw them.
    """
    touches = [event for event in solution.events if event.kind in LOGGED and event.where == place]
    if not touches and np.min(gap) > 0:
        return [(0.0, TURN, float(np.max(gap)))]
    releases = [float(event.details["release_cam_angle"]) % TURN for event in touches]
    return [
        (release, release + (event.cam_angle - release) % TURN, float(event.details["largest_gap"]))
        for event, release in zip(touches, releases, strict=True)
    ]


def _sampled_spans(solution: Solution, gap: Array) -> list[tuple[float, float, float]]:
    """The same from the samples of a run without such a log."""
    spans = spans_above(solution.cam_angle, gap, SMALLEST_GAP)
    return [(*span, _largest_within(solution.cam_angle, gap, span)) for span in spans]


def _largest_within(cam_angle: Array, values: Array, span: Span) -> float:
    """Largest value within a span, its ends among it, straight between samples."""
    inside = (cam_angle - span[0]) % TURN <= span[1] - span[0]
    ends = np.interp(np.array(span), cam_angle, values, period=TURN)
    return max(float(np.max(values[inside], initial=-np.inf)), float(np.max(ends)))


def _loss_details(
    solution: Solution, rigid: RigidCycle, place: str, part: Span, landing: float
) -> dict[str, Detail]:
    """Cause of a loss and where the contact closes again, which may be after the rigid valve has."""
    force = solution.channel(f"{place}_contact_force")
    last = int(np.argmin((solution.cam_angle - landing) % TURN))
    return {
        **_cause_within(solution, rigid, part),
        "landing_cam_angle": landing % TURN,
        "landing_force": float(np.max(force[np.arange(last - 1, last + 7) % len(force)])),
    }


def _floats(solution: Solution, rigid: RigidCycle, losses: Sequence[Event]) -> list[Event]:
    """Loss of control over the nose: the valve runs above its rigid lift with the train open; size
    is the excess lift (m).
    """
    angle, excess = solution.cam_angle, solution.channel("valve_lift") - rigid.valve_lift
    slowing = spans_above(
        angle, -rigid.valve_acceleration, -1e-9 * float(np.max(np.abs(rigid.valve_acceleration)))
    )
    over = shared(spans_above(angle, rigid.valve_lift, 0.3 * rigid.top), slowing)
    above = shared(over, spans_above(angle, excess, 10 * SMALLEST_GAP))
    lost = _joined(lost_spans(losses, _period(solution)))
    return [
        _event(
            solution,
            "float",
            part,
            _largest_within(angle, excess, part),
            "valve",
            _cause_within(solution, rigid, part),
        )
        for part in shared(above, lost)
    ]


def _joined(spans: Sequence[Span]) -> list[Span]:
    """The same stretches, those that meet made one."""
    found: list[Span] = []
    for begin, end in sorted(spans):
        if found and begin <= found[-1][1] + NEXT_TO:
            found[-1] = found[-1][0], max(end, found[-1][1])
        else:
            found.append((begin, end))
    if len(found) > 1 and found[-1][1] >= found[0][0] + TURN - NEXT_TO:
        first = found.pop(0)
        found[-1] = found[-1][0], max(found[-1][1], first[1] + TURN)
    return found


@dataclass(frozen=True)
class _Opening:
    """The valve off its seat once: release and touch (cam rad), closing velocity (m/s), height (m)."""

    release: float
    touch: float
    velocity: float
    height: float


def _seatings_and_bounces(solution: Solution, rigid: RigidCycle) -> list[Event]:
    """Every touch of the seat with its velocity (m/s) and which one it is, and every bounce with
    its height (m): an opening that no event of the lift law makes.
    """
    logged = [event for event in solution.events if event.kind in ("seating", "bounce")]
    if logged:  # found by an evaluation before this one, from what the integrator saw
        return logged
    openings = [  # of every step: the same for any number of samples
        _Opening(float(event.details["release_cam_angle"]), event.cam_angle, event.size, height)
        for event in solution.events
        if event.kind == "touch"
        and event.where == "seat"
        and (height := float(event.details["largest_gap"])) > SMALLEST_GAP
    ] or _sampled_openings(solution)
    found, bounces = [], 0
    spans = np.array([(one.release, one.touch) for one in openings]).reshape(-1, 2)
    heights = np.array([one.height for one in openings])
    law = openings_by_law(spans, heights, solution.cam_angle, rigid.valve_lift)
    for turn in range(len(openings)):
        place = (law[0] + turn) % len(openings)
        one, bounced = openings[place], place not in law
        touch: dict[str, Detail] = {
            "touch": turn + 1,
            "cause": Cause.BOUNCE_ENDS if bounced else Cause.FLANK_ENDS,
            "release_cam_angle": one.release,
        }
        time = _time_at(solution, one.touch)
        found.append(Event("seating", one.touch, time, 0.0, one.velocity, "m/s", "seat", touch))
        if bounced:
            bounces += 1
            length = (one.touch - one.release) % TURN
            window = _between(solution, one.release, length)
            force, static = (
                float(np.mean(solution.channel(name)[window]))
                for name in ("retainer_force", "static_retainer_force")
            )
            slack = force / max(static, 1e-9)
            cause = Cause.REBOUND if slack > 0.8 else Cause.REBOUND_IN_SURGE
            details: dict[str, Detail] = {
                "bounce": bounces,
                "cause": cause,
                "spring_force_share": slack,
            }
            span = one.release, one.release + length
            found.append(_event(solution, "bounce", span, one.height, "seat", details))
    return found


def _sampled_openings(solution: Solution) -> list[_Opening]:
    """From the samples, of a run without such a log: from the last two before the touch the valve
    continues, straight in velocity.

    Second order, and free of what the impact did to the velocity after it.
    """
    lift = solution.channel("valve_lift")
    gap = solution.channel("seat_gap" if solution.has("seat_gap") else "valve_lift")
    angle, rate, count = solution.cam_angle, solution.channel("valve_velocity"), len(lift)
    step, seconds, found = (
        float(angle[1] - angle[0]),
        float(solution.time[1] - solution.time[0]),
        [],
    )
    for start, last_open in runs(lift > SMALLEST_GAP, ring=True):
        length = last_open - start + 1
        if length == count:
            return []
        last, before = (start + length - 1) % count, (start + length - 2) % count
        speed = float(-rate[last])
        ahead = float(np.clip(gap[last] / speed, 0.0, 2 * seconds)) if speed > 0 else seconds
        velocity = speed + float(rate[before] - rate[last]) * ahead / seconds
        height = float(np.max(lift[np.arange(start, start + length) % count]))
        found.append(
            _Opening(
                float(angle[start]), float(angle[last]) + ahead * step / seconds, velocity, height
            )
        )
    return found


def _between(solution: Solution, release: float, length: float) -> Ints:
    """Samples of the open stretch; the nearest one where it is shorter than their interval."""
    angle = solution.cam_angle
    inside = np.flatnonzero((angle - release) % TURN <= length)
    return (
        inside
        if len(inside)
        else np.array([np.argmin(np.abs((angle - release + np.pi) % TURN - np.pi))])
    )


def _period(solution: Solution) -> float:
    return len(solution.time) * float(solution.time[1] - solution.time[0])


def _time_at(solution: Solution, angle: float) -> float:
    rate = (solution.cam_angle[1] - solution.cam_angle[0]) / (solution.time[1] - solution.time[0])
    return float(solution.time[0] + (angle - solution.cam_angle[0]) / rate)


def _cause_within(solution: Solution, rigid: RigidCycle, part: Span) -> dict[str, Detail]:
    return cause_in(solution, rigid, _between(solution, part[0], part[1] - part[0]))


def cause_in(solution: Solution, rigid: RigidCycle, window: Ints) -> dict[str, Detail]:
    """The cause of a loss of contact or float at the samples of a ``window``, which every event, run and critical speed has
    from here; of surge also what it takes off the spring force (N) as the stretch begins.

    It is inertia where rigid parts lose contact too: there, or with the valve wide open at this speed. It is surge where
    that takes a tenth of the spring force, or, without the inertia of the spring, half of what rigid parts leave on the cam.
    """
    first = window[: max(1, len(window) // 4)]
    angle = solution.cam_angle[window]
    wide = any(np.any((angle - begin) % TURN <= end - begin) for begin, end in rigid.wide_open)
    if np.min(rigid.contact_force[window]) <= 0 or (wide and rigid.loss_share >= ALSO_RIGID):
        return {"cause": Cause.INERTIA}
    force, static = (
        float(np.mean(solution.channel(name)[first]))
        for name in ("retainer_force", "static_retainer_force")
    )
    surging, left = _surging(solution, rigid)[first], rigid.contact_force[first]
    if force < 0.9 * static or np.mean(surging) > 0.5 * np.mean(left):
        return {"cause": Cause.SURGE, "spring_force_loss": static - force}
    return {"cause": Cause.VIBRATION}


def _surging(solution: Solution, rigid: RigidCycle) -> Array:
    """What the spring lacks (N) of its static force at each sample, less what follows the acceleration of the valve: that is
    the inertia of the spring's mass, of which rigid parts have their share.
    """
    lacks = solution.channel("static_retainer_force") - solution.channel("retainer_force")
    slowed = -rigid.valve_acceleration
    moving = max(0.0, float(lacks @ slowed)) / max(float(slowed @ slowed), 1e-9)
    return np.asarray(lacks - moving * slowed)


def _event(
    solution: Solution, kind: str, span: Span, size: float, where: str, details: dict[str, Detail]
) -> Event:
    lasts = (span[1] - span[0]) / TURN * _period(solution)
    return Event(kind, span[0], _time_at(solution, span[0]), lasts, size, "m", where, details)


#: Cam angles (rad) of begin, within the first turn, and end, which may pass it.
Span = tuple[float, float]
TURN = 2 * np.pi


def spans_above(cam_angle: Array, values: Array, level: float = 0.0) -> list[Span]:
    """Where one closed turn of even samples is above ``level``, straight between samples; the
    whole turn where it always does.
    """
    above = values > level
    if np.all(above):
        return [(0.0, TURN)]
    step = TURN / len(values)
    rises, falls = (
        np.flatnonzero(change)
        for change in (~above & np.roll(above, -1), above & ~np.roll(above, -1))
    )

    def crossing(place: int) -> float:
        low, high = float(values[place]), float(values[(place + 1) % len(values)])
        return float(cam_angle[place]) + step * (level - low) / (high - low)

    found = []
    for rise in rises.tolist():
        fall = int(falls[np.argmin((falls - rise) % len(values))])
        begin = crossing(rise)
        found.append(span_of(begin, begin + (crossing(fall) - begin) % TURN))
    return found


def span_of(begin: float, end: float) -> Span:
    """A span whose begin is within the first turn, at most a turn long."""
    first = begin % TURN
    return first, first + min(end - begin, TURN)


def shared(first: Iterable[Span], second: Sequence[Span]) -> list[Span]:
    """Parts that are in both sets."""
    found = []
    for begin, end in first:
        for low, high in second:
            for turn in (-TURN, 0.0, TURN):
                left, right = max(begin, low + turn), min(end, high + turn)
                if right > left:
                    found.append(span_of(left, right))
    return found


def covered(spans: Sequence[Span]) -> float:
    """Angle (rad) that the spans cover together, what several cover counted once."""
    cut = sorted(
        part
        for begin, end in spans
        for part in ((begin, min(end, TURN)), (0.0, max(end - TURN, 0.0)))
    )
    total, reached = 0.0, 0.0
    for begin, end in cut:
        total += max(0.0, end - max(begin, reached))
        reached = max(reached, end)
    return total
