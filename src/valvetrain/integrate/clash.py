"""Coil clashes as events, from the force between each coil and the one below over time: one rule
for every model and system.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from valvetrain.arrays import Array, Flags, Ints
from valvetrain.coil_contact.record import contact_spacing
from valvetrain.integrate.clash_kernels import hardest_impact
from valvetrain.solution.status import Cause, Detail, Event
from valvetrain.springs.contract import ContactWatch

TURN = 2 * np.pi
#: A contact that lasts longer than this (cam rad) is coils at rest on each other while the spring
#: is compressed, not an impact of surge.
RESTING_ANGLE = TURN / 12
#: Longest duration of an impact of coils, as a share of the first natural period of the spring, which is
#: the clock of all that its coils do: the time within which neighbours that touch belong to one clash.
IMPACT_SHARE = 0.2
#: Lengths at which an impact is looked for, as shares of that.
IMPACT_LENGTHS = 2.0 ** (-np.arange(17) / 4)
#: Statistic that says that a solution's clashes were found by the integrator, and on which spacing.
RECORDED = "contact_record_interval_duration"


@dataclass(frozen=True, slots=True)
class ClashRule:
    """When contacts count as one clash; forces in N, times as shares of the first natural period.

    A pair is in contact from where its force passes ``off_force`` to where it falls below, if it
    passes ``on_force`` between (hysteresis). Contacts of neighbouring pairs that begin within
    ``merge_share`` of each other are one clash: a coil that rolls down on the next. A pair that
    parts for less than ``rebound_share`` only rings: it stays in the same contact. A contact already
    there at the first sample is no clash: the coil rests. A closed cycle has no first sample, so
    there only a contact without end is no clash.
    """

    on_force: float = 1.0
    off_force: float = 0.2
    merge_share: float = IMPACT_SHARE
    rebound_share: float = 5e-3


@dataclass(frozen=True, slots=True, eq=False)
class PairSeries:
    """Coil pairs of one spring over n times: ``time`` (s), ``cam_angle`` (rad, unwrapped),
    ``ranks`` (p,): place of each in the row of all pairs, ascending; ``places`` (p,): coil number
    of the upper partner; ``force`` (N) between the partners and ``energy`` (J) stored in their
    contact, both (p, n); ``first_period`` (s): first natural period of the spring.
    """

    time: Array
    cam_angle: Array
    ranks: Ints
    places: Array
    force: Array
    energy: Array
    first_period: float

    def where(self, chosen: Ints) -> PairSeries:
        """Some of the pairs."""
        if len(chosen) == len(self.ranks):
            return self
        force, energy = (
            np.ascontiguousarray(values[chosen]) for values in (self.force, self.energy)
        )
        ranks, places = self.ranks[chosen], self.places[chosen]
        return replace(self, ranks=ranks, places=places, force=force, energy=energy)

    def closed(self) -> PairSeries:
        """The same cam revolution three times in a row."""
        inside = self.cam_angle < self.cam_angle[0] + TURN * (1 - 1e-9)
        angle, time = self.cam_angle[inside], self.time[inside]
        period = TURN * (time[-1] - time[0]) / (angle[-1] - angle[0])
        times, angles = (
            np.concatenate([axis - length, axis, axis + length])
            for axis, length in ((time, period), (angle, TURN))
        )
        force, energy = (np.tile(one[:, inside], 3) for one in (self.force, self.energy))
        return replace(self, time=times, cam_angle=angles, force=force, energy=energy)


def impact_impulse(time: Array, force: Array, impact_time: float) -> float:
    """Impulse (N s) of the hardest impact in the ``force`` (N) of one contact over even ``time`` (s):
    what it gives within ``impact_time`` (s) beyond what it holds.

    The largest over begin and length of the integral of force less holding force, which is the
    greater of its means over that time before and after. A contact shorter than that gives its
    whole impulse; a mass m that lands at v on what it then rests on gives m (v + rebound velocity)
    to a tenth, however long it rests; coils that close slowly give none.
    """
    step = float(time[-1] - time[0]) / (len(time) - 1)
    reach = impact_time / step
    pad, count = int(np.ceil(reach)) + 1, len(force)
    area = np.concatenate(([0.0], np.cumsum(0.5 * (force[1:] + force[:-1])))) * step
    area = np.concatenate((np.zeros(pad), area, np.full(2 * pad, area[-1])))
    return float(hardest_impact(area, pad, count, reach, IMPACT_LENGTHS))


def steps_between(watch: ContactWatch | None, time_step: float, steps: int = 0) -> int:
    """Steps (of ``time_step``, s) between two rows of a record of contacts over as many ``steps``:
    the watch's interval, whatever samples are stored, and more where the record would be too large.
    """
    if watch is None:
        return 1
    return contact_spacing(watch.interval, time_step, steps, watch.entries)


@dataclass(frozen=True, slots=True)
class _Contact:
    """One pair in contact over times ``first`` to ``last``."""

    pair: int
    first: int
    last: int


def find_clashes(
    pairs: PairSeries, spring: str = "", closed: bool = False, rule: ClashRule = ClashRule()
) -> tuple[Event, ...]:
    """Events of kind ``clash`` by start time; ``spring``: name for ``where``; ``closed``:
    the series is one cam revolution of a motion that repeats, where it is whole.

    Size is the peak of the summed force (N); details: ``impulse`` (N s, see
    :func:`impact_impulse`), ``energy`` (J, largest energy stored in the pressed pairs at one time),
    ``peak_cam_angle`` (rad, unwrapped), ``upper_coil`` and ``lower_coil`` (whole coils counted from
    1 at the seat, of the pair that is hit hardest), ``first_pair`` and ``last_pair`` (coil numbers
    of the upper partner at the ends of the touching stretch), ``cause``.
    """
    if len(pairs.time) < 2 or not pairs.places.size:
        return ()
    angle = pairs.cam_angle
    span = len(angle) / (len(angle) - 1) * (angle[-1] - angle[0])
    closed = closed and bool(span > TURN * (1 - 1e-9))
    pairs = pairs.where(np.flatnonzero(np.max(pairs.force, axis=1) > rule.on_force))
    pairs = pairs.closed() if closed else pairs
    period = len(pairs.time) // 3 if closed else 0
    contacts = [one for pair in range(len(pairs.force)) for one in _contacts(pairs, pair, rule)]
    found = [
        _event(pairs, group, f"{spring} " if spring else "")
        for group in _clashes(contacts, pairs, rule)
        # A closed cycle appears three times in a row; what begins in the middle one has its whole
        # neighbourhood there.
        # Half a step before it counts as its own.
        if not period or period < min(contact.first for contact in group) <= 2 * period
    ]
    return tuple(sorted(found, key=lambda event: event.time))


def _contacts(pairs: PairSeries, pair: int, rule: ClashRule) -> list[_Contact]:
    time, force, found = pairs.time, pairs.force[pair], list[_Contact]()
    rebound = rule.rebound_share * pairs.first_period
    for first, last in runs(force > rule.off_force):
        if found and time[first] - time[found[-1].last] <= rebound:
            found[-1] = _Contact(pair, found[-1].first, last)
        else:
            found.append(_Contact(pair, first, last))
    return [
        one
        for one in found
        if one.first > 0 and np.max(force[one.first : one.last + 1]) > rule.on_force
    ]


def runs(mask: Flags, ring: bool = False) -> list[tuple[int, int]]:
    """First and last index of every unbroken stretch of True; on a ``ring`` one that passes its end
    continues beyond the last index.
    """
    edges = np.diff(np.concatenate(([0], mask.astype(np.int8), [0])))
    found = list(
        zip(
            np.flatnonzero(edges == 1).tolist(),
            (np.flatnonzero(edges == -1) - 1).tolist(),
            strict=True,
        )
    )
    if ring and len(found) > 1 and mask[0] and mask[-1]:
        (_, last), (first, _) = found.pop(0), found.pop()
        found.append((first, last + len(mask)))
    return found


def _clashes(contacts: list[_Contact], pairs: PairSeries, rule: ClashRule) -> list[list[_Contact]]:
    """Groups of contacts, joined from neighbour to neighbour."""
    time, ranks, merge = pairs.time, pairs.ranks.tolist(), rule.merge_share * pairs.first_period
    owner = list(range(len(contacts)))

    def root(index: int) -> int:
        while owner[index] != index:
            index = owner[index]
        return index

    by_pair: dict[int, list[int]] = {}
    for index, contact in enumerate(contacts):
        by_pair.setdefault(ranks[contact.pair], []).append(index)
    for index, contact in enumerate(contacts):
        for other in by_pair.get(ranks[contact.pair] - 1, []):
            below = contacts[other]
            together = contact.first <= below.last + 1 and below.first <= contact.last + 1
            if together and abs(time[contact.first] - time[below.first]) <= merge:
                owner[root(other)] = root(index)
    groups: dict[int, list[_Contact]] = {}
    for index, contact in enumerate(contacts):
        groups.setdefault(root(index), []).append(contact)
    return list(groups.values())


def _event(pairs: PairSeries, group: list[_Contact], spring: str) -> Event:
    time, angle = pairs.time, pairs.cam_angle
    first, last = min(contact.first for contact in group), max(contact.last for contact in group)
    # Contacts begin and end between samples: half a step is added either side, and the trapezoid
    # closes on nil force.
    start, end = max(first - 1, 0), min(last + 1, len(time) - 1)
    summed, stored = np.zeros((2, end - start + 1))
    for contact in group:
        mine, inside = (
            slice(contact.first, contact.last + 1),
            slice(contact.first - start, contact.last - start + 1),
        )
        summed[inside] += pairs.force[contact.pair, mine]
        stored[inside] += pairs.energy[contact.pair, mine]
    strongest = max(
        group,
        key=lambda contact: float(
            np.max(pairs.force[contact.pair, contact.first : contact.last + 1])
        ),
    )
    top = start + int(np.argmax(summed))
    coil = max(2, int(np.ceil(pairs.places[strongest.pair] - 1e-9)))  # 1.9 and 2.0 are in coil 2
    begin, finish = float(time[start] + time[first]) / 2, float(time[last] + time[end]) / 2
    rests = angle[end] - angle[start] > RESTING_ANGLE
    details: dict[str, Detail] = {
        "impulse": impact_impulse(time[start : end + 1], summed, IMPACT_SHARE * pairs.first_period),
        "energy": float(np.max(stored)),
        "peak_cam_angle": float(angle[top]), "upper_coil": coil, "lower_coil": coil - 1,
        "first_pair": float(min(pairs.places[contact.pair] for contact in group)),
        "last_pair": float(max(pairs.places[contact.pair] for contact in group)),
        "cause": Cause.COILS_REST if rests else Cause.COILS_STRIKE,
    }  # fmt: skip
    return Event(
        "clash",
        float(angle[start] + angle[first]) / 2,
        begin,
        finish - begin,
        float(np.max(summed)),
        "N",
        f"{spring}coils {coil - 1}-{coil}",
        details,
    )
