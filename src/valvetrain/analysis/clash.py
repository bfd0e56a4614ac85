"""Coil clashes as events, from the contact forces between a coil and the one below."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.solution.event import Event
from valvetrain.solution.result import Solution

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class ClashRule:
    """When a contact counts as one clash; forces in N.

    A contact begins when a pair passes ``on_force`` and reaches back and forth to where it is below ``off_force`` (hysteresis).
    Neighbouring pairs in contact together are one clash. Two peaks of its summed force are two clashes when the force
    between falls below ``release_share`` of the lower one. Pairs never released are no clash: the coil rests there.
    """

    on_force: float = 1.0
    off_force: float = 0.2
    release_share: float = 0.25


def clash_events(solution: Solution, rule: ClashRule = ClashRule()) -> tuple[Event, ...]:
    """Events of kind ``clash`` by start time; empty for a model without coil pairs.

    Size is the peak of the summed force (N); details: ``impulse`` (N s, trapezoid), ``peak_cam_angle`` (rad, unwrapped),
    ``upper_coil`` and ``lower_coil`` (whole coils counted from 1 at the seat), ``first_pair`` and ``last_pair`` (coil numbers
    of the upper partner at the ends of the touching stretch).
    """
    if not solution.has("coil_contact_force"):
        return ()
    places = np.asarray(solution.channels["upper_coil"].values)
    order = np.argsort(places)
    force = np.nan_to_num(solution.channel("coil_contact_force")[:, order])
    events: list[Event] = []
    for coil in range(2, int(np.ceil(np.max(places, initial=1.0))) + 1):
        mine = (places[order] > coil - 1 + 1e-9) & (places[order] <= coil + 1e-9)
        if np.any(mine):
            events += _coil_events(solution, force[:, mine], places[order][mine], coil, rule)
    return tuple(sorted(events, key=lambda event: event.time))


def _coil_events(solution: Solution, force: Array, places: Array, coil: int, rule: ClashRule) -> list[Event]:
    from scipy.ndimage import label

    touching = force > rule.off_force
    released = ~np.all(touching, axis=0)
    patches, count = label(touching & released, structure=np.ones((3, 3)))
    events = []
    for patch in range(1, count + 1):
        member = patches == patch
        if not np.any(force[member] > rule.on_force):
            continue
        summed = np.where(member, force, 0.0).sum(axis=1)
        for first, last in split_at_releases(summed, rule.release_share):
            pairs = places[np.any(member[first : last + 1], axis=0)]
            events.append(_event(solution, summed, first, last, pairs, coil))
    return events


def split_at_releases(summed: Array, release_share: float) -> list[tuple[int, int]]:
    """First and last sample of each clash in one stretch of contact, cut at valleys below ``release_share`` of the lower peak."""
    inside = np.flatnonzero(summed > 0)
    first, last = int(inside[0]), int(inside[-1])
    bounds, peak, valley = [first], summed[first], first
    for index in range(first + 1, last + 1):
        if summed[index] < summed[valley]:
            valley = index
        rise = summed[valley] < release_share * min(peak, summed[index])
        if rise and valley > bounds[-1]:
            bounds.append(valley)
            peak, valley = summed[index], index
        elif summed[index] > peak:
            peak, valley = summed[index], index
    ends = [*bounds[1:], last]
    return list(zip(bounds, ends, strict=True))


def _event(solution: Solution, summed: Array, first: int, last: int, pairs: Array, coil: int) -> Event:
    # The contact began and ended between samples: half a step is added either side, and the trapezoid closes on nil force.
    start, end = max(first - 1, 0), min(last + 1, len(summed) - 1)
    time, angle = solution.time, solution.cam_angle
    top = first + int(np.argmax(summed[first : last + 1]))
    impulse = float(np.trapezoid(summed[start : end + 1], time[start : end + 1]))
    details = {
        "impulse": impulse, "peak_cam_angle": float(angle[top]), "upper_coil": coil, "lower_coil": coil - 1,
        "first_pair": float(pairs[0]), "last_pair": float(pairs[-1]),
    }  # fmt: skip
    begin, finish = (float(time[start]) + float(time[first])) / 2, (float(time[last]) + float(time[end])) / 2
    where = f"coils {coil - 1}-{coil}"
    return Event("clash", float(angle[start] + angle[first]) / 2, begin, finish - begin, float(summed[top]), "N", where, details)


def separation_quantities(events: tuple[Event, ...], spike_angle: float, reach: float = np.radians(15.0)) -> dict[str, float]:
    """Contact, separation and contact again of coils 1 and 2 at the main clash.

    ``events``: clashes of the reported cycle. ``spike_angle`` (rad): angle of the main spike, in the same turn count.
    The separation taken is the one that begins nearest to the spike, within ``reach`` (rad); none gives nothing.
    """
    mine = [event for event in events if event.kind == "clash" and event.details.get("upper_coil") == 2]
    openings = []
    for before, after in itertools.pairwise(mine):
        end_time = before.time + before.duration
        if after.time > end_time:
            rate = after.cam_angle - before.cam_angle
            end_angle = before.cam_angle + rate * before.duration / (after.time - before.time)
            openings.append((abs(end_angle - spike_angle), end_angle, after.cam_angle, after.time - end_time))
    openings = [item for item in openings if item[0] <= reach]
    if not openings:
        return {}
    _, start, end, duration = min(openings)
    turn = 2 * np.pi * np.floor(start / (2 * np.pi))
    return {
        "coil_1_2_bounce_start_cam_angle": start - turn,
        "coil_1_2_bounce_end_cam_angle": end - turn,
        "coil_1_2_bounce_duration": duration,
    }
