"""``valvetrain study``, ``optimise`` and ``identify``: files that define points of a case, a search or an identification."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from valvetrain.cli.options import (
    DaskOption,
    JsonOption,
    LimitOption,
    OpenOption,
    QuietOption,
    WorkersOption,
    asks,
    at_end,
    points_folder,
    read_workers,
)
from valvetrain.cli.outcome import WORTH_SAYING, deliver, tell
from valvetrain.cli.run_answer import show_page
from valvetrain.errors import InputError

if TYPE_CHECKING:
    from valvetrain.explore.results import ExploreAnswer
    from valvetrain.runs.cost import Cost

#: Finished points, below the folder of a study, a search or an identification.
POINTS = "points"
AGAIN = "start the command again to continue"


def register(app: typer.Typer) -> None:
    """Add ``study``."""
    app.command("study")(study)


def register_optimise(app: typer.Typer) -> None:
    """Add ``optimise``."""
    app.command("optimise")(optimise)


def register_identify(app: typer.Typer) -> None:
    """Add ``identify``."""
    app.command("identify")(identify)


def study(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE", help="Study file (docs/studies.md): case, varied quantities, outputs."
        ),
    ],
    output: Annotated[Path | None, points_folder("runs/studies/FILE")] = None,
    dask: DaskOption = "",
    workers: WorkersOption = None,
    limit: LimitOption = None,
    open_page: OpenOption = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Parameter study: grid, list or random draws over any quantities of a case; tolerances with
    Sobol indices.
    """
    from valvetrain.explore.files import case_words
    from valvetrain.explore.study import estimate_study, read_plan, read_study_file, run_plan
    from valvetrain.explore.study_answer import StudyAnswer
    from valvetrain.runs.cost import read_limits
    from valvetrain.session import call_case

    limits, count = read_limits(limit), read_workers(workers, dask)
    text = read_study_file(file)
    plan = read_plan(text)
    call_case(case_words(text))
    at_end(partial(call_case, []))
    folder = _folder("studies", file, output)
    estimate = estimate_study(plan, count)
    _announce(estimate.cost, limits, folder, f"{estimate.points} points, {{}}; finished ones")
    _compile("statics", "transient", *(["train"] if plan.case and plan.case.train else []))
    compute = partial(run_plan, plan, count, limits=limits)
    _answer("study", plan.title, folder, compute, StudyAnswer, open_page)


def optimise(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="Optimisation file (docs/optimisation.md): ranges, objectives, bounds.",
        ),
    ],
    output: Annotated[Path | None, points_folder("runs/optimise/FILE")] = None,
    dask: DaskOption = "",
    workers: WorkersOption = None,
    limit: LimitOption = None,
    open_page: OpenOption = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Search the best spring or lift law within bounds on space, coil bind, stress, float and
    clash. A cut search is resumed.
    """
    from valvetrain.explore import optimise as search
    from valvetrain.explore.files import case_words
    from valvetrain.explore.objective import read_optimum
    from valvetrain.explore.optimum_answer import answer_of_search
    from valvetrain.explore.optimum_file import read_optimum_file
    from valvetrain.runs.cost import read_limits
    from valvetrain.session import call_case

    limits, count = read_limits(limit), read_workers(workers, dask)
    text = read_optimum_file(file)
    plan = read_optimum(text)
    call_case(case_words(text))
    at_end(partial(call_case, []))
    folder = _folder("optimise", file, output)
    estimate = search.estimate_search(plan, count)
    announcement = f"{estimate.trials} trials, {{}} at most; finished points"
    _announce(estimate.cost, limits, folder, announcement, fewer=search.FEWER)
    requests = [one.outputs.request for one in plan.plans.values()]
    moves = any(one.motion for one in requests)
    if moves or not all(one.sizes_alone for one in requests):
        train = ["train"] if plan.case and plan.case.train else []
        _compile("statics", *(["transient"] if moves else []), *train)
    compute = partial(search.run_search, plan, count, limits=limits)
    _answer("optimise", plan.title, folder, compute, answer_of_search, open_page)


def identify(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE", help="Identification file: case, quantities with priors, measurements."
        ),
    ],
    method: Annotated[
        str, asks("--method", "METHOD", "least-squares or nested instead of the file's.")
    ] = "",
    seed: Annotated[int | None, asks("--seed", "N", "Seed of all random numbers.")] = None,
    output: Annotated[Path | None, points_folder("runs/identify/FILE")] = None,
    dask: DaskOption = "",
    workers: WorkersOption = None,
    limit: LimitOption = None,
    open_page: OpenOption = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Identify quantities of a case from measurements: likeliest values, intervals, separate
    solutions. A cut search is resumed.
    """
    from valvetrain.explore.identification_answer import IdentificationAnswer
    from valvetrain.explore.identification_file import read_request
    from valvetrain.explore.identify import identify_request
    from valvetrain.runs.cost import read_limits

    limits, count = read_limits(limit), read_workers(workers, dask)
    request = read_request(file)
    changes: dict[str, Any] = {"method": method} if method else {}
    changes |= {} if seed is None else {"seed": seed}
    try:
        search = request.search.changed(**changes)
    except InputError as error:
        raise InputError(error.reason, f"--{error.where}") from None
    request = replace(request, search=search)
    folder = _folder("identify", file, output)

    def reported(phrase: str, seconds: float) -> None:
        if seconds > WORTH_SAYING:
            tell(f"this will take {phrase}; finished points are stored in '{folder / POINTS}'")

    def compute(folder: Path, progress: Any) -> Any:
        return identify_request(
            request, folder=folder, workers=count, report=progress, limits=limits, tell=reported
        )

    _answer("identify", request.title, folder, compute, IdentificationAnswer, open_page)


def _folder(kind: str, file: Path, output: Path | None) -> Path:
    """Folder of the results, by default by the name of the file."""
    from valvetrain.runs.run_folders import ROOT, safe_name

    return output or ROOT / kind / safe_name(file.stem)


def _announce(cost: Cost, limits: Any, folder: Path, text: str, **fewer: str) -> None:
    """Refuse a request beyond the limits, and say what takes long."""
    from valvetrain.runs.cost import cost_text, refuse_cost

    refuse_cost(cost, limits, **fewer)
    estimate = cost_text(cost)
    if cost.seconds > WORTH_SAYING:
        tell(f"{text.format(estimate)} are stored in '{folder / POINTS}'")


def _compile(*kernels: str) -> None:
    from valvetrain.cli.progress import announce_compilation

    announce_compilation(*kernels)


def _answer(
    command: str,
    title: str,
    folder: Path,
    compute: Callable[..., Any],
    answer: Callable[[Any, Path], ExploreAnswer],
    open_page: bool,
) -> None:
    """Compute a result and deliver its answer; what is there of one that is stopped, with the exit code of Ctrl-C."""
    from valvetrain.cli.guard import interrupted
    from valvetrain.cli.progress import progress_bar
    from valvetrain.explore.engine import Interrupted

    made: ExploreAnswer | None = None
    try:
        with progress_bar(title) as report:
            made = answer(compute(folder=folder / POINTS, progress=report), folder)
    except Interrupted as cut:
        made = answer(cut.result, folder)
    except KeyboardInterrupt:
        pass
    if made is not None:
        with suppress(*([typer.Exit] if made.stopped else [])):
            _deliver(command, made, open_page and not made.stopped)
    if made is None or made.stopped:
        text = f"interrupted: the finished points are stored in '{folder / POINTS}'; {AGAIN}"
        raise typer.Exit(interrupted(text))


def _deliver(command: str, answer: ExploreAnswer, open_page: bool) -> None:
    """Write files and page of an answer, and print it."""
    from valvetrain.cli.outcome import Outcome, plain, to_json
    from valvetrain.cli.progress import busy
    from valvetrain.explore.results import answer_json, write_files
    from valvetrain.solution.atomic import write_text
    from valvetrain.solution.partial_failures import PartialFailures
    from valvetrain.views.terminal import screen

    assert answer.folder is not None
    folder, gaps, name = answer.folder, PartialFailures(), f"{command}.json"
    with busy("writing files"):
        data = {"command": command, **answer_json(answer)}
        files = write_files(answer, gaps)
        page = next((path for path in files if path.name == "report.html"), None)
        data |= {"folder": str(folder), "files": [*map(str, files)], "page": page and str(page)}
        text = to_json(plain(data)) + "\n"
        gaps.part(f"file '{name}'", None, write_text, folder / name, text)
    if page is not None and open_page:
        show_page(page)

    def show(console: Any) -> None:
        console.print(screen(answer, str(page or ""), str(folder)))

    deliver(Outcome(data, show, (*answer.failures, *gaps.sentences)))
