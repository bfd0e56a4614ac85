"""``valvetrain compare``: a case by several spring models side by side, solid finite elements among them where they are asked for."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import typer

from valvetrain.cli.options import read_count
from valvetrain.cli.outcome import tell
from valvetrain.cli.study_command import StudyRequest, answer_study, study_command
from valvetrain.errors import InputError

if TYPE_CHECKING:
    from valvetrain.studies.solid_comparison import SolidChoice, SolidCost

SOLID = "solid"
SolidElementsOption = Annotated[
    int | None,
    typer.Option("--solid-elements-per-coil", metavar="N", help="Solid elements along a coil (default: 12).", show_default=False),
]
SolidCoreOption = Annotated[
    int | None, typer.Option("--solid-core", metavar="N", help="Solid cells across the section's core (default: 1).", show_default=False)
]
SolidRingsOption = Annotated[
    int | None, typer.Option("--solid-rings", metavar="N", help="Rings of solid cells around the core (default: 1).", show_default=False)
]
SolidMotionOption = Annotated[
    str | None,
    typer.Option(
        "--solid-motion", metavar="FIRST:LAST", show_default=False,
        help="Move the spring by the lift law with solid finite elements too, between two cam angles such as '85:105 deg'; takes minutes.",
    ),
]  # fmt: skip
SolidTimeOption = Annotated[
    str | None,
    typer.Option("--solid-time-limit", metavar="TIME", help="Longest run of the solver, such as '30 min' (default).", show_default=False),
]


@dataclass(frozen=True)
class SolidOptions:
    """The options of the solid model as given; None for those that were not."""

    elements_per_coil: int | None = None
    core: int | None = None
    rings: int | None = None
    ride: str | None = None
    time_limit: str | None = None

    @property
    def given(self) -> bool:
        """Whether any was given."""
        return any(value is not None for value in (self.elements_per_coil, self.core, self.rings, self.ride, self.time_limit))


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("compare")(compare)


@study_command
def compare(
    request: StudyRequest, solid_elements_per_coil: SolidElementsOption = None, solid_core: SolidCoreOption = None,
    solid_rings: SolidRingsOption = None, solid_motion: SolidMotionOption = None, solid_time_limit: SolidTimeOption = None,
) -> None:  # fmt: skip
    """Run a case by several spring models, side by side; a spring alone by solid finite elements too."""
    from valvetrain.cli.limits import refuse_beyond
    from valvetrain.cli.progress import announce_compilation
    from valvetrain.studies.compare import compare_study

    options = SolidOptions(solid_elements_per_coil, solid_core, solid_rings, solid_motion, solid_time_limit)
    wanted = SOLID in request.spring_models
    if options.given and not wanted:
        raise InputError("options of the solid model need the solid model; add --spring finite-element,solid", "--solid-...")
    if wanted and request.case.train is not None:
        name = request.case.name
        raise InputError(f"solid finite elements run for a spring alone, and case '{name}' is a train; leave solid out", "--spring")
    refuse_beyond(request)
    choice = read_choice(request, options)
    if wanted:
        from valvetrain.studies.solid_comparison import solid_cost

        tell(_cost_words(solid_cost(request.case, choice), choice))
    announce_compilation("statics", "transient", "train")
    answer_study(
        request,
        lambda report: compare_study(
            request.case, engine_speeds=request.engine_speeds, spring_models=request.spring_models, solid=choice,
            workers=request.workers, progress=report, created_at=request.created_at.isoformat(),
        ),
        at_once=not wanted,
    )  # fmt: skip


def read_choice(request: StudyRequest, options: SolidOptions) -> SolidChoice:
    """The options as numbers. Raises :class:`InputError` for those that cannot be."""
    from valvetrain.studies.solid_comparison import SolidChoice
    from valvetrain.units import parse_quantity

    choice = SolidChoice()
    time_limit = choice.time_limit
    if options.time_limit is not None:
        time_limit = parse_quantity(options.time_limit, "time", "--solid-time-limit")
        if not time_limit > 0:
            raise InputError(f"'{options.time_limit}' is no time to compute in; give such as '30 min'", "--solid-time-limit")
    ride = read_motion(options.ride)
    engine_speeds = request.engine_speeds or request.case.operation.engine_speeds
    if ride is not None and len(engine_speeds) != 1:
        raise InputError(
            f"a motion needs one engine speed, not {len(engine_speeds)}; add such as --engine-speed '4200 rpm'", "--solid-motion"
        )
    return SolidChoice(
        read_count(options.elements_per_coil or choice.elements_per_coil, 4, 200, "--solid-elements-per-coil"),
        read_count(choice.core if options.core is None else options.core, 1, 12, "--solid-core"),
        read_count(choice.rings if options.rings is None else options.rings, 1, 12, "--solid-rings"),
        time_limit, ride, engine_speeds[0] if ride is not None else 0.0,
    )  # fmt: skip


def read_motion(words: str | None) -> tuple[float, float] | None:
    """First and last cam angle (rad) from ``'85:105 deg'``; None for None. Raises :class:`InputError`."""
    if words is None:
        return None
    from valvetrain.units import parse_quantity

    match = re.fullmatch(r"\s*([^:\s]+)\s*:\s*([^:\s]+)\s+(\S+)\s*", words)
    if match is None:
        raise InputError(f"'{words[:40]}' is no stretch of motion; write two cam angles such as '85:105 deg'", "--solid-motion")
    first, last = (parse_quantity(f"{match[place]} {match[3]}", "angle", "--solid-motion") for place in (1, 2))
    return first, last


def _cost_words(cost: SolidCost, choice: SolidChoice) -> str:
    size = f"{cost.elements} elements, {cost.unknowns} unknowns"
    words = f"solid finite elements: {size}; statics and modes take about {_about(cost.statics)}"
    if choice.ride is not None:
        words += f", the motion of {cost.increments} increments about {_about(cost.ride)}"
    return f"{words}; each run is stopped after {_about(choice.time_limit)}"


def _about(seconds: float) -> str:
    return f"{max(1.0, seconds):.0f} s" if seconds < 90 else f"{seconds / 60:.0f} min"
