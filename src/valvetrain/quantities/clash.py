"""Coil clashes as events, from the contact forces between a coil and the one below."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.solution.event import Event
from valvetrain.solution.result import Solution

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class ClashRule:
    """When contacts count as one clash; forces in N, time in s.

    A pair is in contact from where its force passes ``off_force`` to where it falls below, if it passes ``on_force`` between
    (hysteresis). Contacts of neighbouring pairs that begin within ``merge_time`` of each other are one clash: a coil that
    rolls down on the next. A contact already there at the first sample is no clash: the coil rests.
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


def clash_events(solution: Solution, rule: ClashRule = ClashRule()) -> tuple[Event, ...]:
    """Events of kind ``clash`` by start time; empty for a model without coil pairs.

    Size is the peak of the summed force (N); details: ``impulse`` (N s, trapezoid), ``peak_cam_angle`` (rad, unwrapped),
    ``upper_coil`` and ``lower_coil`` (whole coils counted from 1 at the seat, of the pair that is hit hardest), ``first_pair``
    and ``last_pair`` (coil numbers of the upper partner at the ends of the touching stretch).
    """
    if not solution.has("coil_contact_force") or len(solution.time) < 2:
        return ()
    places = np.asarray(solution.channels["upper_coil"].values)
    order = np.argsort(places)
    force, places = np.nan_to_num(solution.channel("coil_contact_force")[:, order]), places[order]
    contacts = [found for pair in range(len(places)) for found in _contacts(force[:, pair], pair, rule)]
    events = [_event(solution, force, places, group) for group in _clashes(contacts, solution.time, rule)]
    return tuple(sorted(events, key=lambda event: event.time))


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


def _event(solution: Solution, force: Array, places: Array, group: list[_Contact]) -> Event:
    time, angle = solution.time, solution.cam_angle
    first, last = min(contact.first for contact in group), max(contact.last for contact in group)
    # Contacts begin and end between samples: half a step is added either side, and the trapezoid closes on nil force.
    start, end = max(first - 1, 0), min(last + 1, len(time) - 1)
    summed = np.zeros(end - start + 1)
    for contact in group:
        summed[contact.first - start : contact.last - start + 1] += force[contact.first : contact.last + 1, contact.pair]
    strongest = max(group, key=lambda contact: float(np.max(force[contact.first : contact.last + 1, contact.pair])))
    top, coil = start + int(np.argmax(summed)), upper_coil_of(places[strongest.pair])
    begin, finish = float(time[start] + time[first]) / 2, float(time[last] + time[end]) / 2
    details = {
        "impulse": float(np.trapezoid(summed, time[start : end + 1])), "peak_cam_angle": float(angle[top]),
        "upper_coil": coil, "lower_coil": coil - 1, "first_pair": float(min(places[contact.pair] for contact in group)),
        "last_pair": float(max(places[contact.pair] for contact in group)),
    }  # fmt: skip
    where = f"coils {coil - 1}-{coil}"
    return Event("clash", float(angle[start] + angle[first]) / 2, begin, finish - begin, float(np.max(summed)), "N", where, details)
