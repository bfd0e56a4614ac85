"""Static curve and modes about the installed state, in one run of the solver."""

from __future__ import annotations

from dataclasses import dataclass

from valvetrain.solution.modes import ModalResult
from valvetrain.solution.static import StaticCurve
from valvetrain.springs.solid import deck as steps
from valvetrain.springs.solid.jobs import SolidSpring
from valvetrain.springs.solid.results import read_printed

#: Wall time (s) of statics and modes on :data:`REFERENCE_UNKNOWNS` with coils in contact, and the
#: power of the unknowns with which it grows: measured on one core (docs/solid-reference.md), good to
#: a factor of two.
STATICS_SECONDS, REFERENCE_UNKNOWNS, GROWTH = 26.0, 5400, 1.17
#: Time of statics and modes with the coarser mesh of the error bar (two thirds of the unknowns, no
#: modes) over that without.
COARSER_MESH = 1.4


@dataclass(frozen=True, eq=False)
class InstalledStatics:
    """Curve from the free state to a little beyond the installed one, modes about the installed
    state, wall time (s) of the solver.
    """

    curve: StaticCurve
    modes: ModalResult
    wall_time: float


def installed_statics(
    model: SolidSpring, installed: float, reach: float, modes: int = 12, points: int = 12
) -> InstalledStatics:
    """Compress to ``installed`` (m, may be 0), find the lowest ``modes`` there, and continue to
    ``reach`` (m).

    At least ``points`` increments up to the installed state, four beyond. A solver that gives up
    leaves what it reached, with a status.
    """
    printout, quiet = steps.Printout(axis=True, pairs=len(model.pairs)), steps.Printout(axis=True)
    first, largest = 0.5 / points, 1.0 / points
    find = steps.frequency_step(modes, quiet, preloaded=installed > 0)
    if installed > 0:
        further = steps.static_step(reach, printout, first=0.25, largest=0.25)
        output = model.run(
            model.deck(
                steps.static_step(installed, printout, first=first, largest=largest), find, further
            )
        )
    else:
        output = model.run(
            model.deck(find, steps.static_step(reach, printout, first=first, largest=largest))
        )
    printed = read_printed(output.printed)
    ends = (installed, reach) if installed > 0 else (reach, None)
    curve = model.curve_from(printed, ends[0], output.status, ends[1])
    return InstalledStatics(
        curve, model.modes_from(printed, installed, output.status), output.wall_time
    )


def statics_seconds(unknowns: int) -> float:
    """Wall time (s) to expect of :func:`installed_statics`."""
    return float(STATICS_SECONDS * (unknowns / REFERENCE_UNKNOWNS) ** GROWTH)
