"""Contacts of a spring as events: clashes of its coils with their forces, impulses and energies, and ends that leave
seat or retainer.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from valvetrain.arrays import Array, Flags
from valvetrain.integrate.clash import RECORDED, ClashRule, PairSeries, find_clashes, runs
from valvetrain.quantities.cycle import Cycle, is_closed
from valvetrain.quantities.forces import within_cycle
from valvetrain.quantities.signal import (
    Index,
    extreme_series,
    fine_filtered,
    fine_series,
    prominent_peaks,
)
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Cause, Event
from valvetrain.solution.study import LiftEvent


def clash_events(
    solution: Solution,
    rule: ClashRule = ClashRule(),
    surge_frequencies: tuple[float, ...] = (),
) -> tuple[Event, ...]:
    """Events of kind ``clash`` by start time, from the integrator's own steps where it recorded
    them, else from the samples with the ``surge_frequencies`` (Hz) of the springs.

    Empty for a model without coil pairs. From the samples, the energy of a pressed pair is half of
    force times overlap.
    """
    if _recorded(solution):
        return tuple(event for event in solution.events if event.kind == "clash")
    found: list[Event] = []
    known = [1 / frequency for frequency in surge_frequencies]
    unknown = UNKNOWN_PERIOD * 2 * TURN / solution.engine_speed
    for place, spring in enumerate(solution.springs):
        period = known[place] if len(known) == len(solution.springs) else unknown
        pairs = _pairs_of(solution, spring, period)
        if pairs is not None:
            found += find_clashes(
                pairs, spring if len(solution.springs) > 1 else "", is_closed(solution), rule
            )
    return tuple(sorted(found, key=lambda event: event.time))


def _recorded(solution: Solution) -> bool:
    """Whether the integrator recorded clashes in any spring of the run."""
    return any(name.endswith(RECORDED) for name in solution.statistics)


def _pairs_of(solution: Solution, spring: str, first_period: float) -> PairSeries | None:
    name = solution.channel_of(spring, "coil_contact_force")
    if not solution.has(name, solution.channel_of(spring, "coil_gap")) or len(solution.time) < 2:
        return None
    places = solution.arrays.along(name)
    if places is None or not len(places):
        return None
    order = np.argsort(places)
    force = np.nan_to_num(solution.channel(name)[:, order])
    gap = np.nan_to_num(
        solution.channel(solution.channel_of(spring, "coil_gap"))[:, order], nan=0.0, posinf=0.0
    )
    energy = 0.5 * force * np.maximum(-gap, 0.0)
    ranks, chosen = np.arange(len(order)), places[order]
    return PairSeries(
        solution.time, solution.cam_angle, ranks, chosen, force.T, energy.T, first_period
    )


def clash_numbers(solution: Solution, events: tuple[Event, ...]) -> dict[str, float]:
    """Count, largest force (N; of all and of those under surge) and impulse (N s), and energy (J; of all and the largest) of the
    clashes of one cycle.

    Empty where the model has no coil pairs; ``events`` are those of the cycle.
    """
    if not _recorded(solution) and all(
        _pairs_of(solution, spring, 1.0) is None for spring in solution.springs
    ):
        return {}
    clashes = [event for event in events if event.kind == "clash"]
    energies = [float(event.details["energy"]) for event in clashes]
    return {
        "clash_count": float(len(clashes)),
        "peak_clash_force": max((event.size for event in clashes), default=0.0),
        "surge_clash_peak_force": max(
            (event.size for event in clashes if event.details.get("cause") != Cause.COILS_REST),
            default=0.0,
        ),
        "clash_energy": float(sum(energies)),
        "largest_clash_energy": max(energies, default=0.0),
        "largest_clash_impulse": max(
            (float(event.details["impulse"]) for event in clashes), default=0.0
        ),
    }


def next_to_largest(events: Iterable[Event], detail: str) -> float:
    """Largest ``impulse`` (N s) or ``energy`` (J), by ``detail``, of a clash at the time of the largest one
    and less than a coil from it, which a finer division may count as one with it; 0 where there is none.
    """
    clashes = [event for event in events if event.kind == "clash"]
    sizes = [float(event.details[detail]) for event in clashes]
    if not clashes:
        return 0.0
    largest = clashes[sizes.index(max(sizes))]
    return max(
        (
            size
            for size, clash in zip(sizes, clashes, strict=True)
            if clash is not largest and _overlap(clash, largest)
        ),
        default=0.0,
    )


def _overlap(clash: Event, other: Event) -> bool:
    """Whether two clashes of a spring are at one time and less than a coil apart."""
    early, late = sorted((clash, other), key=lambda event: event.time)
    firsts, lasts = (
        [float(event.details[end]) for event in (clash, other)]
        for end in ("first_pair", "last_pair")
    )
    same = clash.where.partition("coils")[0] == other.where.partition("coils")[0]
    return same and max(firsts) - min(lasts) < 1.0 and late.time <= early.time + early.duration


#: A spike exceeds its surroundings by this share of the force range of the run, so that a ripple on the falling
#: flank is none.
SPIKE_SHARE = 0.01
#: The main clash is the first spike after the event that rises above the base circle's force by
#: this share of the highest one.
MAIN_SHARE = 0.6
#: Its window reaches this share of a period of the first mode to either side.
WINDOW_SHARE = 0.3
#: Bandwidth over the first natural frequency, some 10 kHz, in which the spike is found and its angle read: raw
#: force has ripples of the contact on top.
FINDING_BANDWIDTH = 16.0
#: Bandwidth (Hz) in which the height of a spike by itself is stated: below 10 kHz it still moves by a tenth
#: with contact constants, below 5 kHz by a hundredth.
SPIKE_BANDWIDTH = 5e3
#: The impulse is taken over this share of a period of the first mode, some 0.1 ms, either side of the spike: a
#: collision of valve spring coils takes some 80 us.
IMPULSE_SHARE = 1 / 16
#: Share of a cam revolution taken for the first natural period of a spring whose frequency is unknown.
UNKNOWN_PERIOD = 1 / 16


TURN = 2 * np.pi


@dataclass(frozen=True, slots=True)
class ClashWindow:
    """Cam angles (rad) of begin and end of the main clash of a spring of a ``surge_frequency`` (Hz), in a
    revolution that is counted from the ``end_of_event`` (rad).
    """

    first: float
    last: float
    surge_frequency: float
    end_of_event: float


@dataclass(frozen=True, eq=False)
class _Force:
    """Seat force of the reported cycle, from the end of the event round to it, as finely as the run holds
    it: time (s), cam angle (rad), raw, ``filtered`` to find spikes and to give their ``height`` (N).
    """

    time: Array
    cam_angle: Array
    raw: Array
    filtered: Array
    height: Array
    base: float


def find_clash_window(
    cycle: Cycle, surge_frequency: float, lift_event: LiftEvent
) -> ClashWindow | None:
    """Window about the main clash of a run; None where no coil meets another or the samples are too
    coarse. ``surge_frequency`` in Hz.
    """
    end = float(lift_event.end)
    force = _force(cycle, surge_frequency, end)
    if force is None:
        return None
    after = float(lift_event.start) + TURN  # before the next event, wherever the cycle begins
    late = np.flatnonzero(force.cam_angle < after)
    part = force.filtered[late]
    peaks = prominent_peaks(part, max(SPIKE_SHARE * float(np.ptp(force.raw)), 1e-12))
    if len(peaks) == 0:
        return None
    height = part[peaks] - force.base
    if not np.max(height) > 0:  # of ends that lift, no spike rises above the base circle's force
        return None
    main = peaks[int(np.flatnonzero(height >= MAIN_SHARE * np.max(height))[0])]
    centre = float(force.cam_angle[late][main])
    half = WINDOW_SHARE * cycle.solution.engine_speed / 2 / surge_frequency
    window = ClashWindow(max(end, centre - half), min(after, centre + half), surge_frequency, end)
    return window if _touched(cycle, window) else None


def _touched(cycle: Cycle, window: ClashWindow) -> bool:
    """Whether two coils come into contact within the window; without contact a spike is a wave, not
    a clash.
    """
    inside, solution = _within(cycle.cam_angle, window), cycle.solution
    names = [solution.channel_of(spring, "coil_contact_force") for spring in solution.springs]
    if not any(
        solution.has(name) for name in names
    ):  # a run with end forces alone still has its clashes
        first = float(solution.cam_angle[cycle.samples.start])
        begun = [event.cam_angle - first for event in solution.events if event.kind == "clash"]
        return bool(np.any(_within(np.array(begun), window)))
    pressed = [cycle.channel(name) > 0 for name in names if solution.has(name)]
    return any(
        bool(np.any(force & ~np.roll(force, 1, axis=0) & inside[:, None])) for force in pressed
    )


def _within(cam_angle: Array, window: ClashWindow) -> Flags:
    """Whether cam angles (rad) are in a window, whatever revolution they are counted in."""
    return np.asarray((cam_angle - window.first) % TURN <= window.last - window.first)


def main_clash_quantities(cycle: Cycle, window: ClashWindow) -> dict[str, float]:
    """Height raw and below 5 kHz (N), cam angle (rad) and impulse (N s) of the spike in
    ``window`` (docs/quantities.md).

    The impulse is that of the raw force above the base circle's mean over a sixteenth of a period of
    the first mode either side of the angle: a fixed time, since the width of a spike with ripples on it is no smooth function of the
    mesh.
    """
    force = _force(cycle, window.surge_frequency, window.end_of_event)
    if force is None:
        return {}
    inside = np.flatnonzero((force.cam_angle >= window.first) & (force.cam_angle <= window.last))
    if len(inside) < 5:
        return {}
    every, values = extreme_series(cycle.solution, "seat_force", "highest")
    mine, begin = within_cycle(cycle, every)
    on_steps = values[mine][_within(every[mine] - begin, window)]
    angle = _vertex(force.cam_angle, force.filtered, inside)
    above, reach = force.raw - force.base, IMPULSE_SHARE / window.surge_frequency
    trapezes = 0.5 * (above[1:] + above[:-1]) * np.diff(force.time)
    summed = np.concatenate(([0.0], np.cumsum(trapezes)))
    centre = float(np.interp(angle, force.cam_angle, force.time))
    first, last = np.interp([centre - reach, centre + reach], force.time, summed)
    return {
        "main_clash_peak_force": max(
            float(np.max(force.raw[inside])), float(np.max(on_steps, initial=-np.inf))
        ),
        "main_clash_below_5_khz_peak_force": float(np.max(force.height[inside])),
        "main_clash_cam_angle": angle % TURN,
        "main_clash_impulse": float(last - first),
    }


def _force(cycle: Cycle, surge_frequency: float, end_of_event: float) -> _Force | None:
    if not cycle.whole:
        return None
    solution = cycle.solution
    time, angle, raw = fine_series(solution)
    cutoffs = FINDING_BANDWIDTH * surge_frequency, SPIKE_BANDWIDTH
    filtered, height = (fine_filtered(solution, cutoff) for cutoff in cutoffs)
    if filtered is None or height is None:
        return None
    mine, begin = within_cycle(cycle, angle)
    within = angle[mine] - begin
    whole_turns, place = divmod(end_of_event, TURN)
    first = int(np.searchsorted(within, place))
    order = np.roll(np.arange(mine.start, mine.start + len(within)), -first)
    ahead = order < mine.start + first  # of the next revolution, which is like this one
    turned = np.roll(within, -first) + TURN * (whole_turns + ahead)
    at = time[order] + TURN / (solution.engine_speed / 2) * ahead
    lift = np.interp(within, cycle.cam_angle, cycle.channel("valve_lift"))
    closed = lift <= 1e-3 * float(np.max(lift))
    if not np.any(
        closed
    ):  # a valve that never comes to its seat has no force to count a spike from
        return None
    base = float(np.mean(raw[mine][closed]))
    return _Force(at, turned, raw[order], filtered[order], height[order], base)


def _vertex(angle: Array, values: Array, inside: Index) -> float:
    """Angle of the largest value: vertex of the parabola through it and three neighbours to either
    side.
    """
    top = int(inside[int(np.argmax(values[inside]))])
    near = slice(max(top - 3, 0), top + 4)
    place = angle[near] - angle[top]
    fit = np.polyfit(place, values[near], 2)
    if not fit[0] < 0:
        return float(angle[top])
    return float(angle[top] + np.clip(-fit[1] / (2 * fit[0]), place[0], place[-1]))


#: Ends of a spring that leave seat or retainer. A model of linear modes, whose ends are fixed, cannot lift them: it pulls.
LIFT_OFF, STRIKE, PULL = "end-lift-off", "end-strike", "end-pull"
END_KINDS = (LIFT_OFF, STRIKE, PULL)
#: Forces (N) below this are none; bonded ends pass it in less than a step.
NOTHING = 1e-9
#: A contact that opens for less than this (s) vibrates; the spring has not left it.
SHORTEST = 2e-5
#: Models of linear modes, which belong to fixed ends.
FIXED_END_MODELS = ("modal-uniform", "modal-varied")


def end_events(solution: Solution) -> tuple[Event, ...]:
    """Events of the ends of every spring of a run by start time: ``end-lift-off`` (size: time off
    the seat, s) and ``end-strike`` (size: closing velocity, m/s); ``end-pull`` where the end of a
    model that cannot lift would pull.
    """
    found: list[Event] = []
    for spring in solution.springs:
        for end in ("seat", "retainer"):
            name = solution.channel_of(spring, f"{end}_force")
            if solution.has(name):
                found += _of_end(solution, spring, end, name)
    return tuple(sorted(found, key=lambda event: event.time))


def _of_end(solution: Solution, spring: str, end: str, channel: str) -> list[Event]:
    time, angle, force = fine_series(solution, channel)
    period, closed = time[-1] - time[0], is_closed(solution)
    where = f"{spring} {end}" if len(solution.springs) > 1 else end
    found: list[Event] = []
    for first, last in runs(np.abs(force) < NOTHING, closed):
        begin, stop = first % len(time), (last + 1) % len(time)
        if closed:
            lasts = float((time[stop] - time[begin]) % period)
        else:
            lasts = float(time[min(last + 1, len(time) - 1)] - time[begin])
        if lasts < SHORTEST:
            continue
        kind = PULL if solution.model in FIXED_END_MODELS else LIFT_OFF
        found.append(Event(kind, float(angle[begin]), float(time[begin]), lasts, lasts, "s", where))
        met = closed or last + 1 < len(time)
        velocity = (
            None
            if kind == PULL or not met
            else _closing(solution, spring, end, float(time[begin]), float(time[stop]))
        )
        if velocity is not None:
            found.append(
                Event(STRIKE, float(angle[stop]), float(time[stop]), 0.0, velocity, "m/s", where, {"time_off": lasts})
            )  # fmt: skip
    return found


def _closing(solution: Solution, spring: str, end: str, begin: float, stop: float) -> float | None:
    """Velocity (m/s) with which an end comes down at ``stop``: straight from the last two samples
    before, of the end coil or of the first moving point of the wire; None without sections.
    """
    name = solution.channel_of(spring, "axial_velocity")
    if not solution.has(name):
        return None
    speed = solution.channel(name)
    towards = -speed if end == "seat" else speed + solution.channel("retainer_velocity")[:, None]
    order = range(speed.shape[1]) if end == "seat" else range(speed.shape[1] - 1, -1, -1)
    scale = float(np.max(np.abs(speed)))
    point = next((k for k in order if np.max(np.abs(towards[:, k])) > 1e-6 * scale), None)
    if point is None:
        return None
    last = int(np.searchsorted(solution.time, stop, side="right")) - 1
    if last < 1 or solution.time[last - 1] < begin or begin > stop:
        return float(max(towards[last, point], 0.0))
    slope = (towards[last, point] - towards[last - 1, point]) / (
        solution.time[last] - solution.time[last - 1]
    )
    return float(max(towards[last, point] + slope * (stop - solution.time[last]), 0.0))
