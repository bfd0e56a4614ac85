"""``valvetrain cases`` and ``check``: the library, and what a case file says."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from valvetrain.cli.request import AnswerLine, SavedLine, command_of, command_without_case
from valvetrain.errors import InputError, UnusualValueWarning
from valvetrain.runs.request_fields import option, read_text
from valvetrain.runs.requests import SpringRequest

if TYPE_CHECKING:
    from rich.console import Console

    from valvetrain.parameters.case import Case
    from valvetrain.system.problem import Problem


#: Table of a case file -> what a case has of it.
HELD = {"spring": "springs", "lift_law": "lift_law", "train": "train", "published": "published"}


@dataclass(frozen=True, kw_only=True)
class CasesLine(AnswerLine):
    """The command line of ``cases``."""

    name: str = option(read_text, "Print the file of this case.", metavar="[CASE]", default="")


@dataclass(frozen=True, kw_only=True)
class Check(SpringRequest):
    """A case whose file is checked."""

    command = "check"


def cases(line: CasesLine) -> None:
    """List the cases that ship with the package, or print one of their files."""
    from valvetrain.cli.outcome import Outcome, deliver, plain_table
    from valvetrain.parameters.changes import nearest
    from valvetrain.parameters.loading import LIBRARY, library_names, list_cases

    if not line.name:
        found = list_cases()
        keys = ("name", "title", "holds", "sources")
        data = {
            "command": "cases",
            "cases": [{key: getattr(one, key) for key in keys} for one in found],
        }
        rows = [
            (one.name, ", ".join(one.holds), one.title, ", ".join(one.sources)) for one in found
        ]
        table = plain_table(("name", "holds", "title", "source"), rows)
        step = "next: valvetrain run tdi-pushrod, or valvetrain new my-engine --kind pushrod for your own"
        deliver(Outcome(data, lambda console: console.print(table, step, sep="\n")))
        return
    if line.name not in library_names():
        raise InputError(
            f"there is no case '{line.name[:60]}' in the library; {nearest(line.name, library_names())}"
        )
    text = (LIBRARY / f"{line.name}.toml").read_text(encoding="utf-8")
    data = {"command": "cases", "case": line.name, "text": text}
    deliver(Outcome(data, lambda console: console.out(text, end="")))


register_cases = command_without_case("cases", CasesLine, cases)


def check(request: Check, line: SavedLine, folder: Path) -> None:
    """Check a case file: what is in doubt, its values as they were understood, or what is wrong with it, and
    where. With --output a page with the spring force available and needed.
    """
    from valvetrain.cli.cam_facts import cam_facts, gear_of
    from valvetrain.cli.case_facts import case_facts, case_quantities, rigid_at_top, spring_loads
    from valvetrain.cli.outcome import Outcome, deliver, plain_table
    from valvetrain.cli.run_answer import SavedRequest, keep_run, show_page
    from valvetrain.findings.engine import measured
    from valvetrain.findings.rules_case import CaseFacts
    from valvetrain.findings.words import Words
    from valvetrain.session import called_case
    from valvetrain.solution.status import PartialFailures
    from valvetrain.system.build import lift_law_of
    from valvetrain.units.reader import for_reader
    from valvetrain.views.case_answer import CaseAnswer
    from valvetrain.views.json import quantities_object
    from valvetrain.views.terminal import screen

    chosen = request.case
    if request.spring_sets:
        if chosen.train is None or len(request.spring_sets) > 1:
            raise InputError("check looks at one spring set of a train; name one", "--spring-set")
        chosen = chosen.replace(train=chosen.train.replace(spring_set=request.spring_sets[0]))
    problem = put_together(chosen, request.models, request.implausible)
    quantities = case_quantities(chosen, problem)
    cam, durations = cam_facts(chosen, problem)
    loads = spring_loads(chosen, problem)
    facts = CaseFacts(
        chosen, quantities | cam, gear_of(problem), problem is not None, called_case()
    )
    law = None if chosen.lift_law is None else lift_law_of(chosen)
    named = {one.name: state for one, state in loads.items()}

    def answer() -> CaseAnswer:
        with for_reader():
            said = case_facts(chosen, loads)
        return CaseAnswer(facts, said, named, durations, law, rigid_at_top(chosen, problem))

    data: dict[str, Any] = {
        "command": "check", "case": chosen.name, "title": chosen.title,
        "holds": [name for name, held in HELD.items() if getattr(chosen, held)],
        "facts": dict(case_facts(chosen, loads)),
        "quantities": quantities_object(quantities | cam),
        "durations": [
            {"lift": measured(lift, "m"), "crank_angle": measured(angle, "rad")} for lift, angle in durations.items()
        ],
        "findings": [one.to_dict() for one in replace(answer(), words=Words()).findings],
    }  # fmt: skip
    gaps = PartialFailures()
    if line.output is not None:
        from valvetrain.views.results import write_page

        saved = SavedRequest(request.command, chosen, line.output, folder)

        def write(folder: Path) -> list[Path]:
            return list(filter(None, (write_page(answer(), folder, gaps),)))

        data["page"] = str(line.output / "report.html")
        keep_run(saved, chosen.record().text, {}, data, write, gaps=gaps)
        if line.open_page:
            show_page(line.output / "report.html")

    def show(console: Console) -> None:
        made = answer()
        console.print(screen(made, data.get("page", "")))
        console.print()
        console.print(plain_table(("", ""), made.said))

    deliver(Outcome(data, show, gaps.sentences))


register_check = command_of(Check, SavedLine, check, limit=None)


def first_answer(case: Case) -> str:
    """What ``check`` says first of a case, without any run. Raises :class:`InputError` for what is wrong with it."""
    from valvetrain.cli.cam_facts import cam_facts, gear_of
    from valvetrain.cli.case_facts import case_quantities
    from valvetrain.findings.rules_case import CaseFacts
    from valvetrain.views.case_answer import CaseAnswer

    problem = put_together(case, ())
    values = case_quantities(case, problem) | cam_facts(case, problem)[0]
    facts = CaseFacts(case, values, gear_of(problem), problem is not None)
    return f"{CaseAnswer(facts).verdict}"


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
