"""Saved runs of a workspace, as the run store has them: listed, found, served and removed;
nothing is written twice.
"""

from __future__ import annotations

import json
import threading
import zipfile
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal

from valvetrain.errors import InputError
from valvetrain.runs.run_folders import ANSWER, CASE_FILE, homes, refuse_living, safe_name
from valvetrain.runs.saved_runs import SavedRun, read_answer
from valvetrain.solution.atomic import atomic_path, write_bytes
from valvetrain.units.text import clipped
from valvetrain.workbench.side_files import StoredFile, stored_files
from valvetrain.workbench.store import checked_name, inside, writing

RunFiles = Literal["case", "data", "report", "csv"]
#: Answers of studies of points, which are saved next to the runs.
STUDIES, STUDY_ANSWER = "study", "study.json"
#: Folder of a run with the tests that were laid over it; they are none of its results.
TESTS = "laid-over"
#: Largest study.json that is read, and largest folder that is served (bytes).
MAX_ANSWER, MAX_HANDED = 50_000_000, 2_000_000_000


@dataclass(frozen=True)
class Run:
    """A saved run.

    Parameters
    ----------
    run_id : ``CASE/DATE-TIME-DIGEST``, the folder below ``runs``
    folder : where it is
    case : name of the case it was made from
    command : ``run``, ``compare``, ``sweep``, ``static``, ``modes``, ``study``, ...
    created_at : ISO 8601, UTC
    completed : every part came out
    failures : a sentence per part that did not
    title : title of the case
    models : words of the spring models that ran
    engine_speeds : crank speeds (rpm)
    verdict : the fact that decides, or what is damaged
    """

    run_id: str
    folder: Path
    case: str
    command: str
    created_at: str
    completed: bool
    failures: tuple[str, ...] = ()
    title: str = ""
    models: tuple[str, ...] = ()
    engine_speeds: tuple[float, ...] = ()
    verdict: str = ""

    @property
    def answer(self) -> Mapping[str, Any]:
        """The whole ``run.json`` (``study.json`` of a study), as ``--json`` prints it; empty where
        it has gone.
        """
        name = STUDY_ANSWER if self.folder.parent.name == STUDIES else ANSWER
        try:
            return _answer(self.folder / name, (self.folder / name).stat().st_mtime_ns)
        except (OSError, InputError):
            return {}

    @property
    def page(self) -> Path | None:
        """The report page; None where none was written."""
        path = self.folder / "report.html"
        return path if path.is_file() and not path.is_symlink() else None


def list_saved(root: Path, case: str | None = None) -> list[Run]:
    """Every saved run below ``root``, newest first, of one ``case`` where given; studies of points
    too.
    """
    found = []
    for home in homes(root=root):
        for folder in home.iterdir() if home.name == STUDIES or case in (None, home.name) else ():
            path = folder / (STUDY_ANSWER if home.name == STUDIES else ANSWER)
            if folder.is_symlink() or path.is_symlink():
                continue
            with suppress(OSError):  # no run, or removed meanwhile
                run = _card(root, folder, path, path.stat().st_mtime_ns)
                found += [run] if case in (None, run.case) else []
    return sorted(found, key=lambda run: (run.created_at, run.run_id), reverse=True)


def saved_run(root: Path, run_id: str) -> Run:
    """The run of that id. Raises :class:`InputError` for a name that leads elsewhere, or where
    there is none.
    """
    parts = run_id.split("/") if isinstance(run_id, str) else []
    if len(parts) != 2:
        raise InputError(f"'{clipped(str(run_id), 60)}' is no run; choose one of the list", "run")
    folder = inside(root, *parts)
    path = inside(folder, STUDY_ANSWER if parts[0] == STUDIES else ANSWER)
    if not path.is_file():
        raise InputError(
            f"there is no run '{clipped(run_id, 60)}'; it may have been removed", "run"
        )
    found = _card(root, folder, path, path.stat().st_mtime_ns)
    if not found.created_at:
        raise InputError(found.verdict, run_id)
    return found


def file_of(root: Path, passing: Path, run_id: str, kind: RunFiles) -> Path:
    """The file to serve of a run; archives are made below ``passing``."""
    run = saved_run(root, run_id)
    if kind == "case":
        return _there(run.folder / CASE_FILE, run, "case file")
    if kind == "report":
        return _there(run.folder / "report.html", run, "report page")
    if kind not in ("data", "csv"):
        raise InputError(
            f"'{clipped(str(kind), 20)}' is none of case, data, report, csv; choose one", "download"
        )
    files = [
        path
        for path in sorted(run.folder.rglob("*"))
        if is_ours(path, run.folder) and (kind == "data" or path.suffix == ".csv")
    ]
    if not files:
        raise InputError(f"run '{run.run_id}' holds no such files; repeat it", "download")
    if sum(path.stat().st_size for path in files) > MAX_HANDED:
        raise InputError(
            f"run '{run.run_id}' is larger than {MAX_HANDED / 1e9:.0f} GB; take it from its folder",
            "download",
        )
    name = f"{safe_name(run.case)}-{run.folder.name}-{kind}.zip"
    target = inside(passing, "downloads", name)
    with (
        writing("this archive", "download"),
        atomic_path(target) as temporary,
        zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
    ):
        for path in files:
            archive.write(path, f"{run.folder.name}/{path.relative_to(run.folder).as_posix()}")
    return target


def _there(path: Path, run: Run, what: str) -> Path:
    if path.is_symlink() or path.parent.is_symlink() or not path.is_file():
        raise InputError(f"run '{run.run_id}' has no {what}; repeat it", "download")
    return path


def is_ours(path: Path, folder: Path) -> bool:
    """Whether a path is a plain file of the run, reached over no link."""
    ways = [
        path,
        *(parent for parent in path.parents if parent != folder and folder in parent.parents),
    ]
    foreign = path.name.startswith(".") or path.relative_to(folder).parts[0] == TESTS
    foreign = foreign or ".." in path.parts
    return path.is_file() and not foreign and not any(way.is_symlink() for way in ways)


@lru_cache(maxsize=32)
def _answer(path: Path, _: int) -> Mapping[str, Any]:
    """The answer in a file; empty for another program's. Raises :class:`InputError` for a damaged
    one.
    """
    if path.name == ANSWER:
        return read_answer(path.parent)
    return read_object(path, MAX_ANSWER)


def read_object(path: Path, most: int) -> dict[str, Any]:
    """The JSON object in a file; empty where there is none, or one of more than ``most`` bytes."""
    try:
        found = json.loads(path.read_text("utf-8")) if path.stat().st_size <= most else {}
    except (OSError, ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}


@lru_cache(maxsize=5000)
def _card(root: Path, folder: Path, path: Path, changed: int) -> Run:
    """What a list shows of a run, of a damaged one why it is (without a time); cached until its
    answer is written again, so that a long list is not read again and again.
    """
    run_id = folder.relative_to(root).as_posix()
    try:
        answer = _answer(path, changed)
        reason = "" if answer else "this is not what a run writes; repeat the run"
    except InputError as error:
        reason = error.reason
    if reason:
        case = clipped(folder.parent.name, 200)
        shown_id = clipped(run_id, 200)
        return Run(shown_id, folder, case, "", "", False, verdict=f"damaged: {reason}")
    saved = SavedRun(folder, answer)
    verdict = str(saved.verdict.get("text", ""))
    written = datetime.fromtimestamp(changed // 10**9, UTC).isoformat()  # a study says no time
    return Run(
        run_id,
        folder,
        clipped(saved.case, 200),
        clipped(saved.command, 40),
        clipped(saved.created_at, 40) or written,
        bool(answer.get("completed", True)),
        tuple(clipped(one, 1000) for one in saved.failures),
        clipped(str(answer.get("title", "")), 200),
        tuple(map(clipped, saved.models)),
        saved.engine_speeds,
        clipped(verdict[:1].upper() + verdict[1:], 1000),
    )


#: Bounds of the tests of one run: files, and bytes together.
MAX_TESTS, MAX_TESTS_BYTES = 5, 25_000_000
#: What is checked still holds when it is written: one change of the saved tests at a time.
_turn = threading.RLock()


def saved_tests(run: Run) -> list[StoredFile]:
    """Tests laid over a run, the newest first."""
    return sorted(stored_files(run.folder / TESTS), key=lambda one: (-one.changed, one.name))


def saved_test(run: Run, name: str) -> StoredFile:
    """The test of that name. Raises :class:`InputError` where there is none."""
    test = next((one for one in saved_tests(run) if one.name == checked_name(name)), None)
    if test is None:
        raise InputError(
            f"there is no test '{clipped(name, 60)}' over this run; it may have been removed",
            "test",
        )
    return test


def keep_test(run: Run, name: str, content: bytes) -> StoredFile:
    """Store the file of a test with a run, in place of one of the same ``name``.

    Raises :class:`InputError` beyond the bounds, for a name that no file here may bear, for a run in progress, and
    where it cannot be written.
    """
    path = inside(run.folder, TESTS, name)
    with _turn:
        others = [one.size for one in saved_tests(run) if one.name != name]
        if len(others) >= MAX_TESTS or sum(others) + len(content) > MAX_TESTS_BYTES:
            most = f"{MAX_TESTS} tests of {MAX_TESTS_BYTES / 1e6:.0f} MB"
            raise InputError(
                f"with a run are saved at most {most}; remove one that is laid over it", name
            )
        refuse_living(run.folder)
        with writing("this test", name):
            write_bytes(path, content)
        return saved_test(run, name)


def remove_test(run: Run, name: str) -> None:
    """Remove a test that was laid over a run. Raises :class:`InputError` where there is none."""
    with _turn, writing("the workspace"):
        saved_test(run, name).path.unlink(missing_ok=True)
        with suppress(OSError):  # where others are left
            (run.folder / TESTS).rmdir()
