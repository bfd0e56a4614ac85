"""Answers of a saved run: its numbers, figures and tables as its report has them, and next to another
run or test data.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from valvetrain.compare_test import ModelAgainstTest, compare_study_with_test, compare_test_page
from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.parameters.loading import read_case
from valvetrain.report.page import render
from valvetrain.report.read_page import (
    PageFigure,
    PageMotion,
    PageSection,
    PageSentence,
    PageTable,
    read_page,
    sections_of,
)
from valvetrain.report.run_summary import INPUT_HEADS, RESULT_HEADS, input_rows, result_rows
from valvetrain.runs.differences import input_differences, result_differences
from valvetrain.runs.saved_runs import SavedRun
from valvetrain.solution.definition import is_defined, label_of, shown, topics
from valvetrain.solution.netcdf import load_netcdf
from valvetrain.solution.study import Study
from valvetrain.system.build import build
from valvetrain.units.text import clipped
from valvetrain.workbench.saved_runs import Run, is_ours
from valvetrain.workbench.store import inside

#: Parts of an answer, by the names that pages know them by.
AnswerFigure, AnswerTable, AnswerSection, AnswerSentence, AnswerMotion = (
    PageFigure,
    PageTable,
    PageSection,
    PageSentence,
    PageMotion,
)
#: Largest file of a test (bytes), and rows of a comparison.
MAX_TEST, MAX_ROWS = 20_000_000, 200


@dataclass(frozen=True, slots=True)
class Number:
    """One quantity of a run.

    Parameters
    ----------
    name, label : its name, and its words
    value : the value in ``unit`` (as shown), None where it is not finite
    unit : unit shown
    run : label and speed of the run it belongs to, empty for what belongs to the case
    topic : what it answers, empty for the numbers that are not shown first
    """

    name: str
    label: str
    value: float | None
    unit: str
    run: str = ""
    topic: str = ""


@dataclass(frozen=True, eq=False)
class RunsCompared:
    """Two runs side by side: ``inputs`` that differ, ``results`` that differ (headline numbers first,
    then the largest difference).
    """

    inputs: PageTable
    results: PageTable


@dataclass(frozen=True, eq=False)
class Overlaid:
    """Test data over a run: a ``figure``, ``sentences`` with the verdict, and all ``sections`` of
    the comparison.
    """

    figure: PageFigure | None
    sentences: tuple[str, ...]
    sections: tuple[PageSection, ...] = ()


def numbers(run: Run) -> list[Number]:
    """The numbers of a run in the units shown, headline numbers first.

    Parameters
    ----------
    run : a saved run (:meth:`Workspace.run`)
    """
    place = {
        name: (row, topic)
        for row, (name, topic) in enumerate(
            (name, topic) for topic, names in topics().items() for name in names
        )
    }
    found = [
        _number(name, entry, whose, place.get(name, (0, ""))[1])
        for whose, name, entry in _quantities(run.answer)
    ]
    return sorted(found, key=lambda one: place.get(one.name, (len(place), ""))[0])


def sections(run: Run) -> list[PageSection]:
    """The sections of a run's report page: answers, force, coils, orders, static curve, modes,
    stress and so on, as far as it has them.

    Empty for a run without a page. Raises :class:`InputError` for a page that is damaged.
    """
    page = run.page
    if page is None:
        return []
    return list(_read(page, page.stat().st_mtime_ns))


def figures(run: Run) -> list[PageFigure]:
    """Every figure of a run, in the order of its page."""
    return [
        part for section in sections(run) for part in section.parts if isinstance(part, PageFigure)
    ]


def compare(run_a: Run, run_b: Run) -> RunsCompared:
    """What differs between two runs, as ``valvetrain compare-runs`` reports it.

    Raises :class:`InputError` where the inputs on disk are not those that a run was made from.
    """
    one, other = SavedRun(run_a.folder, run_a.answer), SavedRun(run_b.folder, run_b.answer)
    inputs = input_rows(input_differences(one, other))[:MAX_ROWS]
    results = result_rows(result_differences(one, other))[:MAX_ROWS]
    right = tuple(place in (2, 3, 5) for place in range(len(RESULT_HEADS)))
    return RunsCompared(
        PageTable("Inputs that differ", INPUT_HEADS, tuple(inputs)),
        PageTable("Results that differ", RESULT_HEADS, tuple(results), right),
    )


def overlay(
    run: Run, name: str, test_data: bytes, quantity: str = "", channel: int = 0
) -> Overlaid:
    """Measured cycles, or a table of measured values, against the curves of a run, as ``valvetrain
    compare-test`` reports it.

    Parameters
    ----------
    run : a saved run
    name : name of the file of the test, whose ending stays
    test_data : its content
    quantity, channel : as ``--quantity`` and ``--channel``

    Raises
    ------
    InputError : a file that the reader refuses, with its sentence; a quantity or speed that no run
        has
    """
    found = against(run, name, test_data, quantity, channel)
    parts = sections_of(render(compare_test_page(found))) if found.runs else ()
    drawn = [part for section in parts for part in section.parts if isinstance(part, PageFigure)]
    said = tuple(
        part.text
        for section in parts
        if section.key == "verdict"
        for part in section.parts
        if isinstance(part, PageSentence)
    )
    return Overlaid(
        drawn[0] if drawn else None,
        said or found.failures or ("no run of this kind completed",),
        tuple(parts),
    )


def against(
    run: Run, name: str, test_data: bytes, quantity: str = "", channel: int = 0
) -> ModelAgainstTest:
    """The run against the test; arguments and errors as :func:`overlay`."""
    if len(test_data) > MAX_TEST:
        raise InputError(
            f"is larger than {MAX_TEST / 1e6:.0f} MB; cut the recording into cycles first",
            name[:60],
        )
    study, case = saved_study(run)
    with tempfile.TemporaryDirectory(prefix="valvetrain-test-") as folder:
        suffix = "".join(char for char in Path(name).suffix[:10] if char.isalnum() or char == ".")
        path = inside(Path(folder), f"test{suffix}")
        path.write_bytes(test_data)
        try:
            return compare_study_with_test(study, case, path, quantity=quantity, channel=channel)
        except InputError as error:
            raise InputError(
                error.reason,
                error.where.replace(str(path), name[:60]).replace(path.name, name[:60]),
            ) from None


def saved_study(run: Run) -> tuple[Study, Case]:
    """The study of a saved run with its solutions read from disk, and its case.

    Raises :class:`InputError` for a run without solutions, as a sweep stores none, and for damaged
    files.
    """
    case = read_case(run.folder / "inputs" / "case.toml")
    paths = [
        run.folder / str(one) for one in run.answer.get("files", ()) if str(one).endswith(".nc")
    ]
    for path in paths:
        if not is_ours(path, run.folder):
            raise InputError("this file of the run is missing; repeat the run", clipped(path.name))
    runs = tuple(
        load_netcdf(path) for path in paths if not path.name.startswith(("static-", "modes-"))
    )
    if not runs:
        raise InputError(
            f"a {run.command} stores no curves to lay a test over; run the case at the speed of the test",
            "test",
        )
    still = {
        str(name): _values(entry)
        for name, entry in run.answer.get("quantities_by_label", {}).items()
    }
    still = {"": _values(run.answer.get("quantities", {}))} | still
    return Study(
        case.record(), run.command, runs, still=still, lift_event=build(case).lift_event
    ), case


@lru_cache(maxsize=8)
def _read(page: Path, _: int) -> tuple[PageSection, ...]:
    return read_page(page)


def _values(entry: Any) -> dict[str, float]:
    rows = entry.items() if isinstance(entry, Mapping) else ()
    return {
        name: float(one["value"])
        for name, one in rows
        if isinstance(one, Mapping) and isinstance(one.get("value"), (int, float))
    }


def _quantities(answer: Mapping[str, Any]) -> Iterator[tuple[str, str, Mapping[str, Any]]]:
    """(label and speed, name, value with its unit) of every quantity of an answer."""
    for entry in (answer.get("runs"),):
        for one in entry if isinstance(entry, list) else ():
            speed = one.get("engine_speed")
            known = isinstance(speed, Mapping) and isinstance(speed.get("value"), (int, float))
            at = f", {speed['value']:.10g} {speed.get('unit', 'rpm')}" if known else ""
            yield from (
                (f"{one.get('label', '')}{at}", name, row)
                for name, row in _rows(one.get("quantities"))
            )
    yield from (("", name, row) for name, row in _rows(answer.get("quantities")))
    for label, entry in (answer.get("quantities_by_label") or {}).items():
        yield from ((str(label), name, row) for name, row in _rows(entry))


def _rows(entry: Any) -> Iterator[tuple[str, Mapping[str, Any]]]:
    for name, row in entry.items() if isinstance(entry, Mapping) else ():
        if isinstance(row, Mapping) and "value" in row:
            yield str(name), row


def _number(name: str, entry: Mapping[str, Any], whose: str, topic: str) -> Number:
    value, unit = entry.get("value"), str(entry.get("unit", ""))
    if isinstance(value, (int, float)) and is_defined(name):
        found, unit = shown(name, float(value))
        return Number(name, label_of(name), float(found), unit, whose, topic)
    return Number(
        name,
        label_of(name),
        float(value) if isinstance(value, (int, float)) else None,
        unit,
        whose,
        topic,
    )
