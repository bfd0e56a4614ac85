"""One call for every system: integrate in time and hand back a solution."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from valvetrain.errors import InputError
from valvetrain.integrate.contract import Integrator, Periodic, RunOptions, Until
from valvetrain.integrate.rod_leapfrog import joined
from valvetrain.registry import find, words
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.result import Solution
from valvetrain.system.contract import TRAIN, System
from valvetrain.system.prescribed import PrescribedSpring

if TYPE_CHECKING:
    from valvetrain.integrate.contract import Orbit


def run(
    system: System,
    cam_speed: float,
    until: Until = Periodic(),
    options: RunOptions = RunOptions(),
    provenance: Provenance | None = None,
) -> Solution:
    """Integrate ``system`` at ``cam_speed`` (rad/s) for so long as ``until`` says.

    The solution holds the channels of docs/architecture.md over the last cam turn, a status and
    statistics; events and named quantities
    are found by ``quantities.evaluate``. Raises :class:`InputError` for a cam speed that is not
    positive, an unknown integrator or one
    that does not serve the system; whatever happens in the run itself is its status.
    """
    _check(cam_speed)
    origin = provenance or _origin(system, cam_speed)
    if isinstance(system, PrescribedSpring) and len(system.springs) > 1:
        parts = tuple(run(member, cam_speed, until, options, origin) for member in system.members())
        return joined(parts, system.spring_names, origin)
    return integrator_for(system, until, options.integrator).run(
        system, cam_speed, until, options, origin
    )


def run_to_orbit(
    system: System,
    cam_speed: float,
    until: Until = Periodic(),
    options: RunOptions = RunOptions(),
    provenance: Provenance | None = None,
) -> tuple[Solution, Orbit | None]:
    """As :func:`run`, and of a train the motion it ended on, which ``RunOptions.start`` takes at
    another speed; None of what has none.
    """
    if system.kind != TRAIN:
        return run(system, cam_speed, until, options, provenance), None
    from valvetrain.integrate.train_leapfrog import TrainLeapfrog

    _check(cam_speed)
    found = integrator_for(system, until, options.integrator)
    if not isinstance(found, TrainLeapfrog):
        return run(system, cam_speed, until, options, provenance), None
    return found.run_to_orbit(
        system, cam_speed, until, options, provenance or _origin(system, cam_speed)
    )


def integrator_for(system: System, until: Until, word: str | None = None) -> Integrator:
    """The integrator called ``word``, or the first of the registry that serves. Raises
    :class:`InputError` where none does.
    """
    for name in (word,) if word else words("integrators"):
        found = find("integrators", name)
        assert isinstance(found, Integrator)
        if found.serves(system, until):
            return found
    raise InputError(
        f"no integrator {f'{word!r} ' if word else ''}runs a {system.kind} for {type(until).__name__}; choose another"
    )


def _check(cam_speed: float) -> None:
    if not (math.isfinite(cam_speed) and cam_speed > 0):
        raise InputError(f"the cam speed must be positive; it is {cam_speed:g} rad/s")


def _origin(system: System, cam_speed: float) -> Provenance:
    name = system.springs[0].name if system.springs else ""
    return Provenance(
        system.name, name, 2 * cam_speed, system=system.kind, springs=system.spring_names
    )
