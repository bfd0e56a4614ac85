"""``valvetrain compare``: a case by several spring models side by side, solid finite elements among
them where they are asked for.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Annotated

import typer

from valvetrain.cli.outcome import tell
from valvetrain.cli.study_command import StudyRequest, answer_study, study_command
from valvetrain.errors import InputError
from valvetrain.studies.cost import time_words

if TYPE_CHECKING:
    from valvetrain.studies.solid import SolidMotion

SOLID = "solid"
SolidElementsOption = Annotated[
    int | None,
    typer.Option(
        "--solid-elements-per-coil",
        metavar="N",
        help="Solid elements along a coil (default: 12).",
        show_default=False,
    ),
]
SolidCoreOption = Annotated[
    int | None,
    typer.Option(
        "--solid-core",
        metavar="N",
        help="Solid cells across the section's core (default: 1).",
        show_default=False,
    ),
]
SolidRingsOption = Annotated[
    int | None,
    typer.Option(
        "--solid-rings",
        metavar="N",
        help="Rings of solid cells around the core (default: 1).",
        show_default=False,
    ),
]
SolidMotionOption = Annotated[
    str | None,
    typer.Option(
        "--solid-motion",
        metavar="FIRST:LAST",
        show_default=False,
        help="Move the spring by the lift law with solid finite elements too, between two cam angles such as '85:105 deg'; takes minutes.",
    ),
]
SolidTimeOption = Annotated[
    str | None,
    typer.Option(
        "--solid-time-limit",
        metavar="TIME",
        help="Longest run of the solver, such as '30 min' (default).",
        show_default=False,
    ),
]


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("compare")(compare)


@study_command
def compare(
    request: StudyRequest,
    solid_elements_per_coil: SolidElementsOption = None,
    solid_core: SolidCoreOption = None,
    solid_rings: SolidRingsOption = None,
    solid_motion: SolidMotionOption = None,
    solid_time_limit: SolidTimeOption = None,
) -> None:
    """Run a case by several spring models, side by side; a spring alone by solid finite elements
    too.
    """
    from valvetrain.cli.limits import refuse_beyond
    from valvetrain.cli.progress import announce_compilation
    from valvetrain.studies.compare import compare_study

    wanted = SOLID in request.spring_models
    given = (solid_elements_per_coil, solid_core, solid_rings, solid_motion, solid_time_limit)
    if any(value is not None for value in given) and not wanted:
        raise InputError(
            "options of the solid model need the solid model; add --spring finite-element,solid",
            "--solid-...",
        )
    if wanted and request.case.train is not None:
        name = request.case.name
        raise InputError(
            f"solid finite elements run for a spring alone, and case '{name}' is a train; leave solid out",
            "--spring",
        )
    refuse_beyond(request)
    motion = read_motion(solid_motion, request)
    if wanted:
        _tell_cost(request, motion)
    announce_compilation(
        *(("train",) if request.case.train is not None else ("statics", "transient"))
    )
    answer_study(
        request,
        lambda report, finished: compare_study(
            request.case,
            engine_speeds=request.engine_speeds,
            spring_models=request.spring_models,
            spring_sets=request.spring_sets,
            solid=motion,
            workers=request.workers,
            progress=report,
            finished=finished,
            created_at=request.created_at.isoformat(),
            limits=request.limits,
            implausible=request.implausible,
        ),
    )


def read_motion(words: str | None, request: StudyRequest) -> SolidMotion | None:
    """The stretch of motion between two cam angles from ``'85:105 deg'``; None for None. Raises
    :class:`InputError`.
    """
    if words is None:
        return None
    from valvetrain.studies.solid import SolidMotion
    from valvetrain.units import parse_quantity

    match = re.fullmatch(r"\s*([^:\s]+)\s*:\s*([^:\s]+)\s+(\S+)\s*", words)
    if match is None:
        raise InputError(
            f"'{words[:40]}' is no stretch of motion; write two cam angles such as '85:105 deg'",
            "--solid-motion",
        )
    engine_speeds = request.engine_speeds or request.case.operation.engine_speeds
    if len(engine_speeds) != 1:
        count = len(engine_speeds)
        raise InputError(
            f"a motion needs one engine speed, not {count}; add such as --engine-speed '4200 rpm'",
            "--solid-motion",
        )
    first, last = (
        parse_quantity(f"{match[place]} {match[3]}", "angle", "--solid-motion") for place in (1, 2)
    )
    return SolidMotion(first, last, engine_speeds[0])


def _tell_cost(request: StudyRequest, motion: SolidMotion | None) -> None:
    """Say what the solids will take, and refuse what lies beyond the bound; a solver that is not
    there is found out as well.
    """
    from valvetrain.cam.build import build_lift_law
    from valvetrain.studies.cost import Cost, refuse_cost
    from valvetrain.studies.solid import check_motion, solid_cost, solid_of

    if motion is not None:
        check_motion(build_lift_law(request.case.lift_law), motion)
    for spring in request.case.springs:
        cost = solid_cost(spring, motion)
        words = f"solid finite elements: {cost.elements} elements, {cost.unknowns} unknowns; statics and modes take about "
        words += time_words(cost.statics)
        tell(
            words
            if motion is None
            else f"{words}, the motion of {cost.increments} increments about {time_words(cost.motion)}"
        )
        longest = solid_of(spring).time_limit
        refuse_cost(
            Cost(min(cost.motion, longest)), request.limits, fewer="solid elements or cam degrees"
        )
