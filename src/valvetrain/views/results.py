"""Where a study is shown: its sentence, page, pictures and JSON."""

from __future__ import annotations

import os
from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from valvetrain.errors import InputError, MissingExtraError, RunFailedError
from valvetrain.report import notebook
from valvetrain.report.json import study_json
from valvetrain.report.study import StudyFiles, write_parts
from valvetrain.report.verdict import state_cut_off
from valvetrain.runs.error_bars import UncertaintyStudy
from valvetrain.solution.atomic import write_text
from valvetrain.solution.partial_failures import PartialFailures
from valvetrain.solution.provenance import CaseRecord
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study
from valvetrain.units.reader import for_reader
from valvetrain.views.answer import Answer, Shown
from valvetrain.views.figures import figure_of, figures_of
from valvetrain.views.page import page_of
from valvetrain.views.refinement import RefineAnswer
from valvetrain.views.terminal import SIGN

if TYPE_CHECKING:
    import plotly.graph_objects as go

#: Scale of pictures of pixels, which are then sharp in print.
SCALE = 2


def sentence_of(study: Study) -> str:
    """The verdict of a study in one sentence; empty of one that shows nothing."""
    verdict = Answer(study).verdict
    return "" if verdict is None else str(verdict)


def sentence_of_run(run: Solution) -> str:
    """The verdict of one run in one sentence, as that of a study of it alone."""
    return sentence_of(Study(CaseRecord(run.provenance.case_name), solutions=(run,)))


def sentence_of_refinement(study: UncertaintyStudy) -> str:
    """The verdict of a refinement in one sentence."""
    verdict = RefineAnswer(study).verdict
    return "" if verdict is None else str(verdict)


def _shown(result: object) -> Shown | None:
    """What is shown of a study or a refinement; None of any other result."""
    if isinstance(result, UncertaintyStudy):
        return RefineAnswer(result)
    return Answer(result) if isinstance(result, Study) else None


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
    >>> found = answer_json(vt.simulate("job-t", "2000 rpm", spring_models=["massless"]))
    >>> found["findings"][0]["code"], found["runs"][0]["quantities"]["peak_spring_force"]["unit"]
    ('K104', 'N')
    """
    data = study_json(study)
    data["source_findings"] = data.pop("findings")
    data["findings"] = [one.to_dict() for one in Answer(study).findings]
    return data


def write_study(
    study: Study | Any, folder: str | os.PathLike[str], page: bool = True, figures: bool = False
) -> StudyFiles:
    """Write the data files of a study and, on request, its page and pictures.

    Parameters
    ----------
    study : what ``simulate``, ``compare`` or ``sweep`` gave, or another result that has a
        ``report``: of a study of points, an optimisation, an identification, a measurement
    folder : made if absent; files of an earlier study there that are unchanged are removed
    page : write report.html, one file that needs no network
    figures : write every figure of the page as an SVG picture too

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
    >>> study = vt.simulate("job-t", "2000 rpm", spring_models=["massless"])
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


def write_answer(study: Study, folder: Path, page: bool, figures: bool, **more: Any) -> StudyFiles:
    """As :func:`write_study`; a part that fails is named among the ``gaps`` and costs no other. ``more`` is for
    :func:`valvetrain.report.study.write_parts`.
    """
    return write_parts(study, folder, _write_page, page, figures, **more)


def _write_page(
    study: Study, folder: Path, figures: bool, gaps: PartialFailures
) -> tuple[Path | None, tuple[Path, ...]]:
    """The page of a study, and its figures as pictures."""
    state_cut_off(study)
    with for_reader():
        text = gaps.part("report page", None, page_of, Answer(study), gaps)
    if text is None:
        return None, ()
    written = write_text(folder / "report.html", text)
    pictures = gaps.part("pictures", (), write_figures, study, folder) if figures else ()
    return written, pictures


def write_figures(study: Study, folder: Path) -> tuple[Path, ...]:
    """Write every figure of a study as ``figures/NAME.svg`` by plotly's exporter.

    Raises :class:`MissingExtraError` without the package ``kaleido`` and a Chrome or Chromium, which draw them.
    """
    place = folder / "figures"
    place.mkdir(parents=True, exist_ok=True)
    found = []
    try:
        for name, fig in figures_of(study).items():
            path = place / f"{name}.svg"
            fig.write_image(path, width=900, scale=SCALE)
            found.append(path)
    except (ImportError, ValueError, RuntimeError) as error:
        raise MissingExtraError(
            "pictures need kaleido and Chrome or Chromium; install them, such as by 'pip install kaleido'"
        ) from error
    return tuple(found)


def figure_for_user(result: object, name: str = "") -> go.Figure:
    """The figure ``name`` of a study, or the first of a result, by plotly."""
    if isinstance(result, Study):
        return figure_of(result, name)
    if isinstance(result, UncertaintyStudy) and (made := RefineAnswer(result).figure()) is not None:
        return made
    return notebook.figure_of(result)


def picture_for_notebook(result: object) -> str:
    """Verdict and rows of a study as HTML; of another result its verdict and first figure."""
    answer = _shown(result)
    if answer is None:
        return notebook.picture_of(result)
    head = f"<p><strong>{escape(str(answer.verdict or ''))}</strong></p>"
    rows = "".join(
        "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in cells) + "</tr>"
        for cells in (
            ("", *answer.headings, ""),
            *((one.label, *one.cells, f"{SIGN[one.mark]} {one.remark}") for one in answer.lines),
        )
    )
    return f"{head}<table>{rows}</table>" if answer.lines else head


def tables_in_full(study: Study) -> Mapping[str, Any]:
    """Printed values and what the source states, for ``--published``."""
    from valvetrain.views.tables import tables_of

    return {
        key: one for key, one in tables_of(Answer(study)).items() if key in ("published", "source")
    }
