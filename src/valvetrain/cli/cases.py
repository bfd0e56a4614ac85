"""``valvetrain cases`` and ``check``: the library, and what a case file says."""

from __future__ import annotations

import sys
import warnings
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from valvetrain.cli.options import (
    ElementsOption,
    ImplausibleOption,
    JsonOption,
    OutputOption,
    QuietOption,
    SetOption,
    SpringOption,
    UnitsOption,
    read_models,
    take_folder,
    take_units,
)
from valvetrain.errors import InputError, UnusualValueWarning

if TYPE_CHECKING:
    from rich.console import Console

    from valvetrain.parameters.case import Case, CaseSummary
    from valvetrain.system.problem import Problem


#: Cases of no engine, on which spring models are measured.
BENCHMARKS = ("clamped-helix", "job-c", "job-t", "uniform-spring")


def register_cases(app: typer.Typer) -> None:
    """Add the command."""
    app.command("cases")(cases)


def cases(
    name: Annotated[
        str | None,
        typer.Argument(metavar="[NAME]", help="Print the file of this case.", show_default=False),
    ] = None,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """List the cases that ship with the package, or print one of their files."""
    from valvetrain.cli.outcome import Outcome, deliver, to_json
    from valvetrain.parameters.loading import LIBRARY, library_names, list_cases

    if name is None:
        found = list_cases()
        data = {
            "command": "cases",
            "cases": [
                {key: getattr(one, key) for key in ("name", "title", "holds", "sources")}
                for one in found
            ],
        }
        deliver(Outcome(data, lambda console: _show_cases(console, found)))
        return
    from valvetrain.errors import InputError
    from valvetrain.parameters.changes import nearest

    if name not in library_names():
        raise InputError(
            f"there is no case '{name[:60]}' in the library; {nearest(name, library_names())}"
        )
    text = (LIBRARY / f"{name}.toml").read_text(encoding="utf-8")
    if as_json or not quiet:
        sys.stdout.write(
            to_json({"command": "cases", "case": name, "text": text}) + "\n" if as_json else text
        )


def _show_cases(console: Console, found: tuple[CaseSummary, ...]) -> None:
    from valvetrain.citations import references
    from valvetrain.cli.outcome import plain_table

    def source(keys: tuple[str, ...]) -> str:
        known = (references().get(key.split(",")[0]) for key in keys)
        return "; ".join(
            _short(reference.field("author"), reference.field("year"))
            for reference in known
            if reference is not None
        )

    groups = (
        ("engines and their springs", [one for one in found if one.name not in BENCHMARKS]),
        ("benchmarks of spring models", [one for one in found if one.name in BENCHMARKS]),
    )
    for title, some in groups:
        rows = ((one.name, one.title, source(one.sources)) for one in some)
        console.print(plain_table(("name", "title", "source"), rows, title))
        console.print()
    console.print("  next: valvetrain run tdi-pushrod")


def _short(authors: str, year: str) -> str:
    families = [author.split(",")[0].strip("{} ") for author in authors.split(" and ")]
    return f"{families[0]}{' et al.' if len(families) > 1 else ''} ({year})"


def register_check(app: typer.Typer) -> None:
    """Add the command."""
    app.command("check")(check)


def check(
    case: Annotated[
        str,
        typer.Argument(
            metavar="FILE", help="Case file, or name of a library case.", show_default=False
        ),
    ],
    spring: SpringOption = None,
    settings: SetOption = None,
    elements_per_coil: ElementsOption = None,
    implausible: ImplausibleOption = False,
    output: OutputOption = None,
    units: UnitsOption = "si",
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Check a case file: what is in doubt, its values as they were understood, or what is wrong with it, and
    where. With --output a page with a picture to scale.
    """
    from valvetrain.cli.cam_facts import cam_facts, gear_of
    from valvetrain.cli.case_facts import case_facts, case_quantities, spring_loads
    from valvetrain.cli.options import choose_case, folder_of
    from valvetrain.cli.outcome import Outcome, deliver, plain_table
    from valvetrain.cli.run_answer import SavedRequest, keep_run
    from valvetrain.findings.engine import measured
    from valvetrain.findings.rules_case import CaseFacts
    from valvetrain.findings.words import Words
    from valvetrain.solution.partial_failures import PartialFailures
    from valvetrain.system.build import lift_law_of
    from valvetrain.views.case_answer import CaseAnswer
    from valvetrain.views.json import quantities_object
    from valvetrain.views.results import write_page
    from valvetrain.views.terminal import screen

    take_units(units)
    chosen = choose_case(case, settings, elements_per_coil)
    take_folder(output)
    problem = put_together(chosen, read_models(spring), implausible)
    quantities = case_quantities(chosen, problem)
    cam, durations = cam_facts(chosen, problem)
    loads = spring_loads(chosen, problem)
    facts = CaseFacts(chosen, quantities | cam, gear_of(problem), problem is not None, case)
    law = None if chosen.lift_law is None else lift_law_of(chosen)

    def answer() -> CaseAnswer:
        said = case_facts(chosen, loads)
        named = {one.name: state for one, state in loads.items()}
        return CaseAnswer(facts, said, named, durations, law)

    data: dict[str, Any] = {
        "command": "check", "case": chosen.name, "title": chosen.title, "holds": _holds(chosen), "facts": dict(case_facts(chosen, loads)),
        "quantities": quantities_object(quantities | cam),
        "durations": [
            {"lift": measured(lift, "m"), "crank_angle": measured(angle, "rad")} for lift, angle in durations.items()
        ],
        "findings": [one.to_dict() for one in replace(answer(), words=Words()).findings],
    }  # fmt: skip
    gaps = PartialFailures()
    if output is not None:
        request = SavedRequest("check", chosen, output, folder_of(case))

        def write(folder: Path) -> list[Path]:
            return list(filter(None, (write_page(answer(), folder, gaps),)))

        data["page"] = str(output / "report.html")
        keep_run(request, chosen.record().text, {}, data, write, gaps=gaps)

    def show(console: Console) -> None:
        made = answer()
        console.print(screen(made, data.get("page", "")))
        console.print()
        console.print(plain_table(("", ""), made.said))

    deliver(Outcome(data, show, gaps.sentences))


def put_together(case: Case, models: tuple[str, ...], implausible: bool = False) -> Problem | None:
    """Build everything that ``run`` builds, the springs of every set too, since some errors appear
    only there; a set that no run uses is warned of. None for a lift law alone.

    ``implausible``: values pass that no valvetrain can have.
    """
    from valvetrain.runs.refusals import refusals_before_run
    from valvetrain.system.build import build, lift_law_of

    if case.train is None and not case.springs:
        lift_law_of(case)
        return None
    problem = build(case, spring_models=models)
    problem.must_run()
    refused = refusals_before_run(problem, implausible)
    if refused and (models or len(refused) == len(problem.members)):
        raise InputError(next(iter(refused.values())), "--model" if models else "")
    used = {member.spring_set for member in problem.members}
    for name in () if case.train is None else case.train.springs:
        try:
            for member in build(case, spring_models=models, spring_set=(name,)).members:
                if not member.refusal and not member.model.needs_rest:
                    member.system(built=problem.built)
        except InputError as error:
            if name in used:
                raise
            warnings.warn(
                f"spring set '{name}', which is not in use, cannot run: {error.reason}",
                UnusualValueWarning,
                stacklevel=2,
            )
    return problem


def _holds(case: Case) -> list[str]:
    named = (
        ("spring", case.springs),
        ("lift_law", case.lift_law),
        ("train", case.train),
        ("published", case.published),
    )
    return [name for name, held in named if held]
