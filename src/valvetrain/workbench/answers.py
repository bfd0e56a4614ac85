"""A saved run next to another run, or to test data."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from valvetrain.compare_test import ModelAgainstTest, compare_study_with_test
from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.parameters.loading import read_case
from valvetrain.runs.differences import differences
from valvetrain.runs.saved_runs import SavedRun
from valvetrain.solution.netcdf import load_netcdf
from valvetrain.solution.study import Study
from valvetrain.system.build import build
from valvetrain.units.text import clipped
from valvetrain.views.saved import DifferenceAnswer
from valvetrain.workbench.saved_runs import Run, is_ours
from valvetrain.workbench.store import inside

#: Largest file of a test (bytes).
MAX_TEST = 20_000_000


def compare(run_a: Run, run_b: Run) -> DifferenceAnswer:
    """What differs between two runs, as ``valvetrain compare-runs`` reports it.

    Raises :class:`InputError` where the inputs on disk are not those that a run was made from.
    """
    one, other = SavedRun(run_a.folder, run_a.answer), SavedRun(run_b.folder, run_b.answer)
    return DifferenceAnswer(differences(one, other))


def against(run: Run, name: str, test_data: bytes) -> ModelAgainstTest:
    """Measured cycles, or a table of measured values, against the curves of a run, as ``valvetrain
    compare-test`` has them.

    Parameters
    ----------
    run : a saved run
    name : name of the file of the test, whose ending stays
    test_data : its content

    Raises
    ------
    InputError : a file that the reader refuses, with its sentence; a quantity or speed that no run
        has
    """
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
            return compare_study_with_test(study, case, path)
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


def _values(entry: Any) -> dict[str, float]:
    rows = entry.items() if isinstance(entry, Mapping) else ()
    return {
        name: float(one["value"])
        for name, one in rows
        if isinstance(one, Mapping) and isinstance(one.get("value"), (int, float))
    }
