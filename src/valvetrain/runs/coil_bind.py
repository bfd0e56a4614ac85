"""Where a train presses its spring solid: the run ends there, with the status ``coil-bind``."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.quantities.forces import bind_clearances, force_quantities
from valvetrain.solution.result import Solution
from valvetrain.solution.status import Status

#: Codes of runs that gave all of their samples.
ENDED = ("completed", "not-converged")
#: First words of numbers that the integrator found on every step of the whole revolution.
OF_EVERY_STEP = ("peak_", "minimum_")


def bound(solution: Solution, springs: tuple[InstalledSpring, ...]) -> Solution:
    """The run up to where the retainer passes the lift at which the first of ``springs`` is solid,
    with the status ``coil-bind``.

    Only models with coil contact represent it, so later values are invalid: of channels, events and
    numbers those remain that come before. A spring without installed and solid height is not
    judged; nor is a run that diverged.
    """
    known = [(spring.room, spring) for spring in springs if spring.room is not None]
    if not known or solution.status.code not in ENDED or not solution.has("valve_lift"):
        return solution
    travel, spring = min(known, key=lambda pair: pair[0])
    past = solution.channel("valve_lift") >= travel
    if not np.any(past):
        return solution
    index = int(np.argmax(past))
    angle = float(np.degrees(solution.cam_angle[index]) % 360)
    message = (
        f"spring '{spring.name}' is solid at {travel * 1e3:.4g} mm of lift, which the retainer passes at {angle:.1f} cam degrees, "
        "where the run ends"
    )
    remedy = (
        "run slower, or fit a spring that holds the valve and has more travel to its solid height"
    )
    status = Status("coil-bind", message, float(solution.time[index]), spring.name, remedy)
    return replace(_until(solution, index, travel, springs), status=status)


def _until(
    solution: Solution, index: int, travel: float, springs: tuple[InstalledSpring, ...]
) -> Solution:
    """The run before sample ``index``, at which the lift passes ``travel`` (m)."""
    end = float(solution.time[index])
    statistics = {
        name: value
        for name, value in solution.statistics.items()
        if not any(word in name for word in OF_EVERY_STEP)
    }
    channels = solution.arrays.at({"sample": range(index)})
    cut = replace(solution, channels=channels, statistics=statistics)
    found = {"peak_valve_lift": travel, **bind_clearances(springs, travel)}
    if index > 2:
        forces = force_quantities(reported_cycle(cut))
        found |= {name: force for name, force in forces.items() if not name.startswith("below_")}
    if cut.has("rigid_valve_lift"):
        above = travel - float(solution.channel("rigid_valve_lift")[index])
        found["float_excess_lift"] = max(above, 0.0)
    events = (event for event in solution.events if event.time <= end)
    return cut.with_found(events, {k: v for k, v in found.items() if k in solution.quantities})
