"""Events and named numbers of a run, the same for every system and every spring model."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from valvetrain import registry
from valvetrain.arrays import Array
from valvetrain.quantities.clash import (
    END_KINDS,
    clash_events,
    clash_numbers,
    end_events,
    find_clash_window,
    main_clash_quantities,
)
from valvetrain.quantities.cycle import Cycle, Frame, is_closed, reported_cycle
from valvetrain.quantities.forces import (
    counted_quantities,
    energy_quantities,
    force_quantities,
    lift_quantities,
    surge_quantities,
)
from valvetrain.quantities.stress import stress_quantities, with_wire_stress
from valvetrain.quantities.train_events import LOGGED, RigidCycle, rigid_cycle, train_events
from valvetrain.quantities.train_numbers import (
    margin_quantities,
    train_quantities,
)
from valvetrain.quantities.valve_events import lost_durations, run_events
from valvetrain.solution.channels import Variable
from valvetrain.solution.definition import tables
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Event, PartialFailures

#: Channels of rigid theory that are added to a train's run -> SI unit and words.
RIGID_CHANNELS = {
    "rigid_valve_lift": ("valve_lift", "m", "valve lift of rigid parts"),
    "rigid_contact_force": ("contact_force", "N", "contact force at the cam of rigid parts"),
    "rigid_spring_force": ("spring_force", "N", "spring force at rest at the valve lift of rigid parts"),
    "rigid_spring_margin": ("spring_margin", "N", "spring force at rest and inertia less weight and gas at the valve"),
    "rigid_hertz_pressure": ("hertz_pressure", "Pa", "contact pressure at the cam of rigid parts"),
}  # fmt: skip
PRESSURE = "cam_contact_pressure"


def evaluate(solution: Solution, frame: Frame = Frame()) -> Solution:
    """The run with its events and every quantity that its channels support (docs/quantities.md); SI
    units, angles in cam rad.

    What the run does not cover, because it lacks the channel or ended early, is absent; a part that
    fails is among its ``gaps``. A run that holds numbers that are not finite comes back with
    nothing found. ``frame.source`` adds the quantities of a published study. Raises
    :class:`InputError` for an unknown source.
    """
    names = ("valve_lift", "seat_force", "retainer_force")
    if len(solution.time) < 3 or not all(
        np.all(np.isfinite(solution.channel(name))) for name in names if solution.has(name)
    ):
        return solution.with_found((), {})
    gaps = PartialFailures(solution.gaps)
    solution = gaps.part("stress of the wire", solution, with_wire_stress, solution, frame)
    cycle = gaps.part("reported cycle", None, reported_cycle, solution)
    rigid = None
    if frame.rigid is not None and is_closed(solution):
        rigid = gaps.part("motion of rigid parts", None, rigid_cycle, solution, frame.rigid)
    # coils can touch but where no spring has a contact stiffness
    meets = not frame.springs or any(spring.contact.stiffness > 0 for spring in frame.springs)
    events = _events(solution, frame, rigid, meets, gaps)
    found = dict[str, float]()
    if cycle is not None and cycle.whole:
        found = _whole_cycle(cycle, frame, events, meets, gaps)
    found |= gaps.part("energy", {}, energy_quantities, solution, cycle)
    found |= gaps.part("counted numbers", {}, counted_quantities, solution)
    if rigid is not None:
        assert frame.rigid is not None
        found |= gaps.part("numbers of the train", {}, train_quantities, solution, rigid, events)
        found |= gaps.part("valve events", {}, run_events, solution, events, frame.top_dead_centre)
        found |= gaps.part("duration lost", {}, lost_durations, found, frame.rigid)
        found |= gaps.part("margins of rigid parts", {}, margin_quantities, frame.rigid)
        if frame.permitted_seating_velocity is not None:
            found["permitted_seating_velocity"] = frame.permitted_seating_velocity
    kind = "train" if is_closed(solution) else "spring"
    for row in (one for rows in tables().values() for one in rows):
        if row.compute is not None and kind in row.systems:
            value = gaps.part(row.label, None, row.compute, solution)
            found |= {} if value is None else {row.name: float(value)}
    if rigid is not None:
        solution = gaps.part("channels of rigid parts", solution, _with_rigid, solution, frame)
    if solution.has(PRESSURE):
        found["peak_cam_contact_pressure"] = float(np.max(solution.channel(PRESSURE)))
    done = solution.with_found(events, found, gaps.sentences)
    if not frame.source:
        return done
    source = registry.find("sources", frame.source)
    found |= gaps.part(f"numbers of {frame.source}", {}, source.quantities, done, frame)
    return done.with_found(events, found, gaps.sentences)


def _events(
    solution: Solution,
    frame: Frame,
    rigid: RigidCycle | None,
    meets: bool,
    gaps: PartialFailures,
) -> tuple[Event, ...]:
    none: tuple[Event, ...] = ()
    clashes = none
    if meets:
        find = partial(clash_events, surge_frequencies=frame.surge_frequencies)
        clashes = gaps.part("clashes", none, find, solution)
    other = tuple(
        event for event in solution.events if event.kind not in (*LOGGED, *END_KINDS, "clash")
    )
    if rigid is not None:
        other = gaps.part("events of the train", none, lambda: tuple(train_events(solution, rigid)))
    ends = gaps.part("ends of the springs", none, end_events, solution)
    return tuple(sorted((*other, *clashes, *ends), key=lambda event: event.cam_angle))


def _whole_cycle(
    cycle: Cycle, frame: Frame, events: tuple[Event, ...], meets: bool, gaps: PartialFailures
) -> dict[str, float]:
    solution = cycle.solution
    found = gaps.part("forces", {}, force_quantities, cycle) | gaps.part(
        "lift", {}, lift_quantities, cycle, frame.springs
    )
    found |= gaps.part("surge", {}, surge_quantities, cycle, frame) | gaps.part(
        "stress", {}, stress_quantities, cycle, frame
    )
    if meets:
        first = float(cycle.solution.cam_angle[cycle.samples.start])
        late = tuple(
            event for event in events if is_closed(solution) or event.cam_angle >= first - 1e-9
        )
        found |= gaps.part("clash", {}, clash_numbers, solution, late)
    if (
        frame.surge_frequency is not None
        and frame.lift_event is not None
        and solution.has("seat_force", "valve_lift")
    ):
        search = cycle, frame.surge_frequency, frame.lift_event
        window = gaps.part("main clash", None, find_clash_window, *search)
        if window is not None:
            found |= gaps.part("main clash", {}, main_clash_quantities, cycle, window)
    return found


def _with_rigid(solution: Solution, frame: Frame) -> Solution:
    """The run with the channels of rigid parts and, of a cam whose contact has an area, its pressure:
    that of the contact's place on the rigid cam under the computed force.
    """
    rigid = frame.rigid
    assert rigid is not None

    def at_samples(column: str) -> Array:
        return np.interp(solution.cam_angle, rigid.cam_angle, rigid[column], period=2 * np.pi)

    added = {
        name: Variable(("sample",), at_samples(column), {"units": unit, "long_name": label})
        for name, (column, unit, label) in RIGID_CHANNELS.items()
        if column in rigid.columns
    }
    if "pressure_root" in rigid.columns and solution.has("cam_contact_force"):
        force = np.maximum(solution.channel("cam_contact_force"), 0.0)
        attributes = {"units": "Pa", "long_name": "Hertz pressure of the cam contact"}
        added[PRESSURE] = Variable(
            ("sample",), at_samples("pressure_root") * np.sqrt(force), attributes
        )
    return replace(solution, channels=solution.arrays.assign(added))
