"""Where results are shown: sentence, page, pictures and JSON."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import partial
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from valvetrain import registry
from valvetrain.errors import InputError, MissingExtraError, RunFailedError, UnknownNameError
from valvetrain.parameters.summary import rpm
from valvetrain.solution.atomic import write_text
from valvetrain.solution.definition import label_cut_off
from valvetrain.solution.display import MAX_ROWS, table
from valvetrain.solution.force_peak import bandwidth_of
from valvetrain.solution.netcdf import save_netcdf
from valvetrain.solution.provenance import CaseRecord
from valvetrain.solution.result import Solution, save_csv
from valvetrain.solution.status import TRACEBACK_VARIABLE, PartialFailures
from valvetrain.solution.study import Study
from valvetrain.units.reader import for_reader
from valvetrain.views.answer import Answer
from valvetrain.views.files import FreeNames, remove_earlier
from valvetrain.views.json import study_json
from valvetrain.views.page import page_of
from valvetrain.views.shown import Shown
from valvetrain.views.study_files import (
    CSV_SPACING,
    StudyFiles,
    at_wire_points,
    comparison_table,
    event_table,
    files_of,
    frequency_table,
    quantity_table,
    static_table,
    sweep_table,
)
from valvetrain.views.style import in_reader_units
from valvetrain.views.terminal import SIGN

if TYPE_CHECKING:
    import plotly.graph_objects as go

#: Scale of pictures of pixels, which are then sharp in print.
SCALE = 2


#: Key of a case whose value is the cut-off of the peaks of spring forces.
CUT_OFF_KEY = "operation.force_bandwidth"


def state_cut_off(result: object) -> None:
    """Let labels state the cut-off of the runs of a result, or of the case of its plan."""
    runs, plan = getattr(result, "solutions", ()), getattr(result, "plan", None)
    case = getattr(plan, "case", None)
    if runs:
        label_cut_off(bandwidth_of(runs[0].provenance))
    elif case is not None:
        varies = any(one.key == CUT_OFF_KEY for one in getattr(plan, "varied", ()))
        label_cut_off(math.nan if varies else case.operation.force_bandwidth)


def answer_of(result: object) -> Shown | None:
    """What is shown of a result, by the class that the registry lists (kind ``answers``); None where none is listed.

    >>> import valvetrain as vt
    >>> answer_of(vt.simulate("job-t", "2000 rpm", models=["massless"])).verdict.code
    'K104'
    """
    word = type(result).__name__
    made: Shown | None = None
    if word in registry.places("answers"):
        state_cut_off(result)
        made = registry.find("answers", word)(result)
    return made


def answer_of_run(run: Solution) -> Answer:
    """What is shown of one run: that of a study of it alone."""
    return Answer(Study(CaseRecord(run.provenance.case_name), solutions=(run,)))


def sentence_of(result: object) -> str:
    """The verdict of a result in one sentence; empty where it shows nothing."""
    try:
        answer = answer_of(result)
        return "" if answer is None else str(answer.verdict or "")
    except Exception:  # a sentence must not cost the numbers it is about
        if os.environ.get(TRACEBACK_VARIABLE):
            raise
        return ""


def answer_json(study: Study) -> dict[str, Any]:
    """A study as plain values for JSON, every number with its unit, the findings in their order.

    Parameters
    ----------
    study : what ``simulate``, ``run_up``, ``compare`` or ``sweep`` gave

    Returns
    -------
    dict that ``json.dumps`` takes; ``findings`` as :meth:`Finding.to_dict` gives them

    Examples
    --------
    >>> import valvetrain as vt
    >>> found = answer_json(vt.simulate("job-t", "2000 rpm", models=["massless"]))
    >>> found["findings"][0]["code"], found["runs"][0]["quantities"]["peak_spring_force"]["unit"]
    ('K104', 'N')
    """
    data = study_json(study)
    data["source_findings"] = data.pop("findings")
    data["findings"] = [one.to_dict() for one in Answer(study).findings]
    return data


def write_study(
    study: Study | Any, folder: str | os.PathLike[str], page: bool = True, figures: str = ""
) -> StudyFiles:
    """Write the data files of a study and, on request, its page and pictures.

    Parameters
    ----------
    study : what ``simulate``, ``compare`` or ``sweep`` gave, or another result that has a
        ``report``: of a study of points, an optimisation, an identification, a measurement
    folder : made if absent; files of an earlier study there that are unchanged are removed
    page : write report.html, one file that needs no network
    figures : ``"svg"``, ``"png"`` or ``"pdf"`` writes every figure of the page as a picture too

    Returns
    -------
    StudyFiles with the paths: folder, page (None without), data, figures

    Raises
    ------
    InputError : a folder that cannot be written; RunFailedError where the disk took some files
        only, with their names

    Examples
    --------
    >>> import valvetrain as vt
    >>> study = vt.simulate("job-t", "2000 rpm", models=["massless"])
    >>> written = vt.write_study(study, "results", page=False)
    >>> sorted(file.name for file in written.data)[:3]
    ['massless-2000rpm.csv', 'massless-2000rpm.nc', 'modes-job-t-finite-element.csv']
    """
    if not isinstance(study, Study):
        if not hasattr(study, "report"):
            raise InputError(
                f"a {type(study).__name__} has no page; give a study or another result with a report"
            )
        written: StudyFiles = study.report(folder)
        return written
    files = write_answer(study, Path(folder), page, figures)
    if files.gaps:
        raise RunFailedError(
            f"not all of the study could be written to '{folder}', the rest is there: {'; '.join(files.gaps)}"
        )
    return files


def write_answer(
    study: Study,
    folder: Path,
    page: bool,
    figures: str,
    written_before: Callable[[Solution], Path | None] = lambda _: None,
) -> StudyFiles:
    """As :func:`write_study`; a part that fails is named among the ``gaps`` and costs no other.

    ``written_before`` gives the file that a solution was written to as it came, which then only takes its name.
    """
    names, gaps = FreeNames(), PartialFailures()
    files: list[Path] = []

    def write(name: str, make: Callable[..., Path]) -> None:
        path = gaps.part(f"file '{name}' could not be written", None, make, folder / name)
        files.extend([path] if path is not None else [])

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"folder '{folder}' cannot be written ({error.strerror}); choose another"
        ) from error
    for run in study.solutions:
        if run.arrays.variables and len(run.time):
            stem = names.free(f"{run.label}-{rpm(run.engine_speed):.10g}rpm")
            before = written_before(run)
            write(f"{stem}.nc", before.replace if before else partial(save_netcdf, run))
            write(
                f"{stem}.csv",
                lambda path, run=run: save_csv(at_wire_points(run, CSV_SPACING), path),
            )
    for one in study.rest:
        whose = f"{one.spring}-{one.model}"
        if one.curve is not None:
            stem = names.free(f"static-{whose}")
            write(f"{stem}.nc", partial(save_netcdf, one.curve))
            write(f"{stem}.csv", lambda path, one=one: write_text(path, static_table(one, one.curve)))  # fmt: skip
        if one.modes is not None:
            stem = names.free(f"modes-{whose}")
            write(f"{stem}.nc", partial(save_netcdf, one.modes))
            write(f"{stem}.csv", lambda path, one=one: write_text(path, frequency_table(one.modes)))  # fmt: skip
    tables: dict[str, Callable[[], str]] = {
        "quantities": partial(quantity_table, study),
        "events": partial(event_table, study),
        "comparison": partial(comparison_table, study.comparisons),
    }
    for label in study.labels if study.over_speed else ():
        tables[names.free(f"sweep-{label}")] = partial(sweep_table, study, label)
    for name, build in tables.items():
        content = gaps.part(f"table '{name}'", "", build)
        if content.count("\n") > 1:
            write(f"{name}.csv", lambda path, content=content: write_text(path, content))
    answer = Answer(study)
    shown: Path | None = None
    if page:
        shown = gaps.part("report page", None, write_page, answer, folder, gaps)
    pictures: tuple[Path, ...] = ()
    if shown and figures:
        pictures = gaps.part("pictures", (), write_figures, answer, folder, figures)
    written = (*files, *pictures, *filter(None, (shown,)))
    gaps.part("list of files", (), remove_earlier, folder, "report", written)
    return StudyFiles(folder, shown, tuple(files), pictures, gaps.sentences)


def write_page(answer: Shown, folder: Path, gaps: PartialFailures) -> Path | None:
    """Write the page of an answer as ``report.html``; None, and a sentence among the ``gaps``, where that fails."""
    state_cut_off(getattr(answer, "study", answer))
    with for_reader():
        text = gaps.part("report page", None, page_of, answer.for_reader(), gaps)
    return None if text is None else write_text(folder / "report.html", text)


def report_result(result: object, folder: Path, **options: Any) -> StudyFiles:
    """Write the page of a result of a tool, and its files, to ``folder``; ``options`` are for its answer."""
    answer: Any = registry.find("answers", type(result).__name__)(result, **options)
    if hasattr(answer, "folder"):
        answer = replace(answer, folder=folder)
    gaps, files = PartialFailures(), answer.write(folder)
    page = write_page(answer, folder, gaps)
    return files_of(folder, [*files, *filter(None, (page,))], gaps.sentences)


def write_figures(answer: Shown, folder: Path, ending: str = "svg") -> tuple[Path, ...]:
    """Write every figure of an answer as ``figures/NAME.svg``, or with another ``ending``, by plotly's exporter.

    Raises :class:`MissingExtraError` without the package ``kaleido`` and a Chrome or Chromium, which draw them.
    """
    place = folder / "figures"
    place.mkdir(parents=True, exist_ok=True)
    written = []
    try:
        for name, fig in figures_of(answer).items():
            path = place / f"{name}.{ending}"
            with for_reader():
                in_reader_units(fig).write_image(path, width=900, scale=SCALE)
            written.append(path)
    except (ImportError, ValueError, RuntimeError) as error:
        raise MissingExtraError(
            "pictures need Chrome or Chromium and the extra 'figures': pip install 'valvetrain[figures]'"
        ) from error
    return tuple(written)


def figures_of(answer: Shown) -> dict[str, go.Figure]:
    """Every figure that an answer has data for, by name, the one that opens the page first.

    >>> import valvetrain as vt
    >>> study = vt.simulate("job-t", "2000 rpm", models=["massless"])
    >>> list(figures_of(answer_of(study)))[0]
    'force'
    """
    made = ((name, spec.make(answer.facts)) for name, spec in answer.figures().items())
    return {name: fig for name, fig in made if fig is not None}


def figure_for_user(result: object, name: str = "") -> go.Figure:
    """The figure ``name`` of a result by plotly, the first without a name.

    Raises :class:`UnknownNameError` for a name that it has no figure of, :class:`InputError` where nothing can be drawn.
    """
    answer = answer_of(result)
    specs = {} if answer is None else answer.figures()
    for word in (name,) if name else tuple(specs):
        if answer and word in specs and (made := specs[word].make(answer.facts)) is not None:
            return made
    if answer is None or not name:
        raise InputError(f"this {type(result).__name__} holds nothing to draw")
    raise UnknownNameError(name, figures_of(answer), "figure")


def html_for_notebook(result: Any) -> str:
    """Verdict and rows of a result as HTML, its text, and its first table or its data where it has no rows; what cannot be
    made never costs the result.
    """
    head, first, data = "", None, ""
    with suppress(Exception):
        if (answer := answer_of(result)) is not None:
            if answer.verdict:
                head = f"<p><strong>{escape(str(answer.verdict))}</strong></p>"
            if rows := [
                (one.label, *one.cells, f"{SIGN[one.mark]} {one.remark}") for one in answer.lines
            ]:
                head += table("", ("", *answer.headings, ""), rows)
            elif (first := next(iter(answer.tables().values()), None)) is None:
                data = result.to_pandas().to_html(max_rows=MAX_ROWS)
    text = repr(result).removeprefix(sentence_of(result)).strip()
    return head + table(text, first.columns if first else (), first.rows if first else ()) + data
