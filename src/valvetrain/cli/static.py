"""``valvetrain static`` and ``modes``: springs at rest, and their natural frequencies."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated

import typer

from valvetrain.cli.options import MAX_COUNTED, read_amounts, read_count, read_length
from valvetrain.cli.run_answer import StudyRequest, answer_study, rest_command
from valvetrain.errors import InputError

if TYPE_CHECKING:
    from valvetrain.cli.progress import Report
    from valvetrain.solution.study import Study


def register(app: typer.Typer) -> None:
    """Add the command ``static``."""
    app.command("static")(static)


def register_modes(app: typer.Typer) -> None:
    """Add the command ``modes``."""
    app.command("modes")(modes)


def _repeated(flag: str, metavar: str, label: str) -> typer.models.OptionInfo:
    """An option of amounts that may be given several times."""
    found: typer.models.OptionInfo = typer.Option(
        flag, metavar=metavar, help=label, show_default=False
    )
    return found


@rest_command
def static(
    request: StudyRequest,
    to: Annotated[
        str | None,
        typer.Option(
            "--to",
            metavar="LENGTH",
            help="Largest compression, such as '12 mm' (default: beyond full lift).",
        ),
    ] = None,
    steps: Annotated[int, typer.Option("--steps", metavar="N", help="Number of even steps.")] = 24,
    height: Annotated[
        list[str] | None,
        _repeated(
            "--height", "LENGTH", "Height between the seats to solve too: '32 mm'. Repeatable."
        ),
    ] = None,
    load: Annotated[
        list[str] | None,
        _repeated("--load", "FORCE", "Load to solve as well: '400 N'. Repeatable."),
    ] = None,
) -> None:
    """Force, stiffness and stress over compression, coils closing, of every spring of a case, and
    at heights and loads requested.
    """
    from valvetrain.cli.progress import announce_compilation
    from valvetrain.runs.cost import FEWER_AT_REST, refuse_cost
    from valvetrain.runs.request_cost import static_cost
    from valvetrain.runs.statics import static_study

    largest = read_length(to, "--to")
    read_count(steps, 2, MAX_COUNTED, "--steps")
    heights = read_amounts(height, "length", "--height")
    loads = read_amounts(load, "force", "--load")
    models, sets = request.spring_models, request.spring_sets
    # a load takes some dozen heights to find
    points = steps + len(heights) + 12 * len(loads)
    cost = static_cost(request.case, models, spring_sets=sets, heights=points)
    refuse_cost(cost, request.limits, fewer=FEWER_AT_REST)
    announce_compilation("statics")
    answer_study(
        request,
        lambda report, _: static_study(
            request.case,
            request.spring_models,
            spring_sets=request.spring_sets,
            largest_compression=largest,
            steps=steps,
            heights=heights,
            loads=loads,
            progress=report,
            implausible=request.implausible,
        ),
        choices={"steps": steps},
    )


@rest_command
def modes(
    request: StudyRequest,
    count: Annotated[
        int, typer.Option("--count", metavar="N", help="Number of modes, lowest first.")
    ] = 24,
    compression: Annotated[
        str | None,
        typer.Option(
            "--compression",
            metavar="LENGTH",
            help="Compression to compute them at: '7 mm' (default: installed).",
        ),
    ] = None,
    attached_mass: Annotated[
        str | None,
        typer.Option(
            "--attached-mass",
            metavar="MASS",
            help="Mass that moves with the retainer: '50 g' (default: both ends fixed).",
            show_default=False,
        ),
    ] = None,
    free_end: Annotated[
        bool,
        typer.Option(
            "--free-end", help="The retainer end is free to move along the axis, without a mass."
        ),
    ] = False,
) -> None:
    """Natural frequencies of springs, both ends fixed or one with a mass; of a train also with its
    springs, as one.
    """
    from valvetrain.cli.progress import announce_compilation
    from valvetrain.runs.cost import FEWER_AT_REST, refuse_cost
    from valvetrain.runs.request_cost import static_cost
    from valvetrain.runs.statics import CURVE_OF_MODES, static_study
    from valvetrain.runs.train_runs import train_modes

    case, models, sets = request.case, request.spring_models, request.spring_sets
    read_count(count, 1, MAX_COUNTED, "--count")
    mass, state = _mass(attached_mass, free_end), read_length(compression, "--compression")
    cost = static_cost(case, models, spring_sets=sets, heights=CURVE_OF_MODES, modes=count)
    refuse_cost(cost, request.limits, fewer=FEWER_AT_REST)
    announce_compilation("statics")

    def compute(report: Report, _: object) -> Study:
        study = static_study(
            case,
            models,
            spring_sets=sets,
            command="modes",
            compression=state,
            modes=count,
            attached_mass=mass,
            progress=report,
            implausible=request.implausible,
        )
        if case.train is None or state is not None:
            return study
        lowest = (one.lowest(count) for one in train_modes(case, models, spring_set=sets))
        return replace(study, train_modes=tuple(lowest))

    answer_study(request, compute, choices={"count": count})


def _mass(attached: str | None, free_end: bool) -> float | None:
    """Mass (kg) that moves with the retainer, 0 for a free end; None for both ends fixed."""
    if free_end and attached is not None:
        raise InputError(
            "a free end has no mass attached; give --free-end or --attached-mass", "--free-end"
        )
    if free_end or attached is None:
        return 0.0 if free_end else None
    masses = read_amounts([attached], "mass", "--attached-mass")
    if len(masses) != 1 or masses[0] < 0:
        raise InputError(
            f"'{attached}' is no mass; give one of zero or more, such as '50 g'", "--attached-mass"
        )
    return masses[0]
