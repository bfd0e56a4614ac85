"""Coil clashes as events, from the contact forces between a coil and the one below: one rule for every model and system."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.quantities.cycle import is_closed
from valvetrain.solution.event import Detail, Event
from valvetrain.solution.result import Solution

Array = NDArray[np.float64]
TURN = 2 * np.pi
#: A contact that lasts longer than this (cam rad) is coils at rest on each other while the spring is compressed, not a blow of surge.
RESTING_ANGLE = TURN / 12


@dataclass(frozen=True, slots=True)
class ClashRule:
    """When contacts count as one clash; forces in N, time in s.

    A pair is in contact from where its force passes ``off_force`` to where it falls below, if it passes ``on_force`` between
    (hysteresis). Contacts of neighbouring pairs that begin within ``merge_time`` of each other are one clash: a coil that
    rolls down on the next. A contact already there at the first sample is no clash: the coil rests. A closed cycle has no first
    sample, so there only a contact without end is no clash.
    """

    on_force: float = 1.0
    off_force: float = 0.2
    merge_time: float = 0.3e-3


@dataclass(frozen=True, slots=True)
class _Contact:
    """One pair in contact over samples ``first`` to ``last``."""

    pair: int
    first: int
    last: int


@dataclass(frozen=True, slots=True, eq=False)
class _Pairs:
    """Coil pairs of one spring over time, by place on the wire: force (N) and gap (m), both (sample, pair)."""

    time: Array
    cam_angle: Array
    places: Array
    force: Array
    gap: Array


def clash_events(solution: Solution, rule: ClashRule = ClashRule()) -> tuple[Event, ...]:
    """Events of kind ``clash`` by start time; empty for a model without coil pairs.

    Size is the peak of the summed force (N); details: ``impulse`` (N s, trapezoid), ``energy`` (J, largest energy stored in the pressed
    pairs: half of force times overlap, summed), ``peak_cam_angle`` (rad, unwrapped), ``upper_coil`` and ``lower_coil`` (whole coils
    counted from 1 at the seat, of the pair that is hit hardest), ``first_pair`` and ``last_pair`` (coil numbers of the upper partner at
    the ends of the touching stretch), ``cause``. In a nested pair ``where`` names the spring.
    """
    found: list[Event] = []
    for spring in solution.springs:
        pairs = _pairs_of(solution, spring)
        if pairs is None:
            continue
        period = len(solution.time) if is_closed(solution) else 0
        contacts = [one for pair in range(len(pairs.places)) for one in _contacts(pairs.force[:, pair], pair, rule)]
        for group in _clashes(contacts, pairs.time, rule):
            # A closed cycle stands three times in a row; what begins in the middle one has its whole neighbourhood there.
            if not period or period <= min(contact.first for contact in group) < 2 * period:
                found.append(_event(pairs, group, f"{spring} " if len(solution.springs) > 1 else ""))
    return tuple(sorted(found, key=lambda event: event.time))


def _pairs_of(solution: Solution, spring: str) -> _Pairs | None:
    name = solution.channel_of(spring, "coil_contact_force")
    if not solution.has(name, solution.channel_of(spring, "coil_gap")) or len(solution.time) < 2:
        return None
    values = solution.channels[name]
    label = next((label for label, axis in values.coords.items() if axis.dims == values.dims[1:]), None)
    if label is None or values.shape[1] == 0:
        return None
    places = np.asarray(values.coords[label].values)
    order = np.argsort(places)
    force = np.nan_to_num(np.asarray(values.values)[:, order])
    gap = np.nan_to_num(solution.channel(solution.channel_of(spring, "coil_gap"))[:, order], nan=0.0, posinf=0.0)
    time, angle = solution.time, solution.cam_angle
    if not is_closed(solution):
        return _Pairs(time, angle, places[order], force, gap)
    period, turn = (len(axis) * (axis[-1] - axis[0]) / (len(axis) - 1) for axis in (time, angle))
    times, angles = (np.concatenate([axis - length, axis, axis + length]) for axis, length in ((time, period), (angle, turn)))
    return _Pairs(times, angles, places[order], np.tile(force, (3, 1)), np.tile(gap, (3, 1)))


def _contacts(force: Array, pair: int, rule: ClashRule) -> list[_Contact]:
    found = []
    for first, last in runs(force > rule.off_force):
        if first > 0 and np.max(force[first : last + 1]) > rule.on_force:
            found.append(_Contact(pair, first, last))
    return found


def runs(mask: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last index of every unbroken stretch of True."""
    edges = np.diff(np.concatenate(([0], mask.astype(np.int8), [0])))
    return list(zip(np.flatnonzero(edges == 1).tolist(), (np.flatnonzero(edges == -1) - 1).tolist(), strict=True))


def upper_coil_of(place: float) -> int:
    """Whole coil, counted from 1 at the seat, in which coil number ``place`` lies: 1.9 and 2.0 lie in coil 2."""
    return max(2, int(np.ceil(place - 1e-9)))


def _clashes(contacts: list[_Contact], time: Array, rule: ClashRule) -> list[list[_Contact]]:
    """Groups of contacts, joined from neighbour to neighbour."""
    owner = list(range(len(contacts)))

    def root(index: int) -> int:
        while owner[index] != index:
            index = owner[index]
        return index

    by_pair: dict[int, list[int]] = {}
    for index, contact in enumerate(contacts):
        by_pair.setdefault(contact.pair, []).append(index)
    for index, contact in enumerate(contacts):
        for other in by_pair.get(contact.pair - 1, []):
            below = contacts[other]
            together = contact.first <= below.last + 1 and below.first <= contact.last + 1
            if together and abs(time[contact.first] - time[below.first]) <= rule.merge_time:
                owner[root(other)] = root(index)
    groups: dict[int, list[_Contact]] = {}
    for index, contact in enumerate(contacts):
        groups.setdefault(root(index), []).append(contact)
    return list(groups.values())


def _event(pairs: _Pairs, group: list[_Contact], spring: str) -> Event:
    time, angle = pairs.time, pairs.cam_angle
    first, last = min(contact.first for contact in group), max(contact.last for contact in group)
    # Contacts begin and end between samples: half a step is added either side, and the trapezoid closes on nil force.
    start, end = max(first - 1, 0), min(last + 1, len(time) - 1)
    summed, stored = np.zeros(end - start + 1), np.zeros(end - start + 1)
    for contact in group:
        mine, inside = slice(contact.first, contact.last + 1), slice(contact.first - start, contact.last - start + 1)
        force = pairs.force[mine, contact.pair]
        summed[inside] += force
        stored[inside] += 0.5 * force * np.maximum(-pairs.gap[mine, contact.pair], 0.0)
    strongest = max(group, key=lambda contact: float(np.max(pairs.force[contact.first : contact.last + 1, contact.pair])))
    top, coil = start + int(np.argmax(summed)), upper_coil_of(pairs.places[strongest.pair])
    begin, finish = float(time[start] + time[first]) / 2, float(time[last] + time[end]) / 2
    resting = angle[end] - angle[start] > RESTING_ANGLE
    details: dict[str, Detail] = {
        "impulse": float(np.trapezoid(summed, time[start : end + 1])), "energy": float(np.max(stored)),
        "peak_cam_angle": float(angle[top]), "upper_coil": coil, "lower_coil": coil - 1,
        "first_pair": float(min(pairs.places[contact.pair] for contact in group)),
        "last_pair": float(max(pairs.places[contact.pair] for contact in group)),
        "cause": "coils come to rest on each other as the spring closes" if resting else "coils meet under surge",
    }  # fmt: skip
    where = f"{spring}coils {coil - 1}-{coil}"
    return Event("clash", float(angle[start] + angle[first]) / 2, begin, finish - begin, float(np.max(summed)), "N", where, details)


def clash_numbers(solution: Solution, events: tuple[Event, ...]) -> dict[str, float]:
    """Count, largest force (N) and impulse (N s), and energy (J; of all and the largest) of the clashes of one cycle.

    Empty where the model has no coil pairs; ``events`` are those of the cycle.
    """
    if all(_pairs_of(solution, spring) is None for spring in solution.springs):
        return {}
    clashes = [event for event in events if event.kind == "clash"]
    energies = [float(event.details["energy"]) for event in clashes]
    return {
        "clash_count": float(len(clashes)), "peak_clash_force": max((event.size for event in clashes), default=0.0),
        "clash_energy": float(sum(energies)), "largest_clash_energy": max(energies, default=0.0),
        "largest_clash_impulse": max((float(event.details["impulse"]) for event in clashes), default=0.0),
    }  # fmt: skip
