"""``valvetrain study``, ``optimise`` and ``identify``: files that define points of a case, a search or an identification."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from valvetrain.cli.outcome import WORTH_SAYING, at_end, deliver, tell
from valvetrain.cli.parts import PartsLine, answer_parts
from valvetrain.cli.request import CommandLine, command_of
from valvetrain.cli.run_answer import show_page
from valvetrain.explore.execution import Watch
from valvetrain.explore.requests import FileRequest, Identify, Optimise, Study
from valvetrain.runs.requests import Parts

if TYPE_CHECKING:
    from valvetrain.explore.results import ExploreAnswer

#: Finished points, below the folder of a study, a search or an identification.
POINTS = "points"


def study(request: Study | Parts, line: PartsLine, folder: Path) -> None:
    """Parameter study: grid, list or random draws over any quantities of a case; tolerances with
    Sobol indices. With --parts: which part of an engine gains most engine speed.
    """
    if isinstance(request, Parts):
        answer_parts(request, line, folder)
    else:
        _answer(request, line)


register = command_of(Study, PartsLine, study)


def optimise(request: Optimise, line: CommandLine, _: Path) -> None:
    """Search the best spring or lift law within bounds on space, coil bind, stress, float and
    clash. A cut search is resumed.
    """
    _answer(request, line)


register_optimise = command_of(Optimise, CommandLine, optimise)


def identify(request: Identify, line: CommandLine, _: Path) -> None:
    """Identify quantities of a case from measurements: likeliest values, intervals, separate
    solutions. A cut search is resumed.
    """
    _answer(request, line)


register_identify = command_of(Identify, CommandLine, identify)


def _answer(request: FileRequest, line: CommandLine) -> None:
    """Compute a result and deliver its answer; what is there of one that is stopped, with the exit code of Ctrl-C."""
    from valvetrain.cli.guard import interrupted
    from valvetrain.cli.progress import announce_runs, progress_bar
    from valvetrain.explore.engine import Interrupted
    from valvetrain.explore.files import case_words
    from valvetrain.runs.run_folders import ROOT, safe_name
    from valvetrain.session import call_case
    from valvetrain.units.reader import follow_case
    from valvetrain.views.results import answer_of

    folder = request.output or ROOT / request.command / safe_name(Path(request.file).stem)
    request = replace(request, output=folder / POINTS)
    plan = request.plan  # what is wrong with the file is said first
    follow_case(request.text.text + getattr(plan.case, "text", ""))
    stored = f"finished points are stored in '{folder / POINTS}'"

    def announce(text: str, seconds: float) -> None:
        announce_runs(plan.case)  # once the request was found to be within its limits
        if seconds > WORTH_SAYING:
            tell(f"{text}; {stored}")

    call_case(case_words(request.text))
    at_end(partial(call_case, []))
    result: Any = None
    try:
        with progress_bar(plan.title) as report:
            result = request.compute(Watch(report, announce, "--limit "))
    except Interrupted as cut:
        result = cut.result
    except KeyboardInterrupt:
        pass
    shown: Any = None if result is None else answer_of(result)
    answer: ExploreAnswer | None = shown and replace(shown, folder=folder)
    stopped = answer is None or answer.stopped
    if answer is not None:
        with suppress(*([typer.Exit] if stopped else [])):
            _deliver(request.command, answer, line.open_page and not stopped)
    if stopped:
        text = f"interrupted: {stored}; start the command again to continue"
        raise typer.Exit(interrupted(text))


def _deliver(command: str, answer: ExploreAnswer, open_page: bool) -> None:
    """Write files and page of an answer, and print it."""
    from valvetrain.cli.outcome import Outcome, plain, to_json
    from valvetrain.cli.progress import busy
    from valvetrain.explore.results import answer_json
    from valvetrain.solution.atomic import write_text
    from valvetrain.solution.status import PartialFailures
    from valvetrain.views.results import write_page
    from valvetrain.views.terminal import screen

    assert answer.folder is not None
    folder, gaps, name = answer.folder, PartialFailures(), f"{command}.json"
    with busy("writing files"):
        data = {"command": command, **answer_json(answer)}
        files = [gaps.part(f"file '{one}'", None, write, folder / one) for one, write in answer.files().items()]  # fmt: skip
        page = write_page(answer, folder, gaps)
        written = [str(path) for path in (*files, page) if path is not None]
        data |= {"folder": str(folder), "files": written, "page": page and str(page)}
        text = to_json(plain(data)) + "\n"
        gaps.part(f"file '{name}'", None, write_text, folder / name, text)
    if page is not None and open_page:
        show_page(page)

    def show(console: Any) -> None:
        console.print(screen(answer.for_reader(), str(page or ""), str(folder)))

    deliver(Outcome(data, show, (*answer.failures, *gaps.sentences)))
