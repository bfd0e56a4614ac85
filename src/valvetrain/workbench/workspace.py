"""The workspace of a workbench: a folder with cases, saved runs and one database, and everything
that may be done to them.

``cases/NAME/case.toml`` (and the files it names next to it), ``runs/`` as the run store saves it,
``jobs/`` inputs of running jobs,
``workbench.sqlite``. Cases and runs are plain files that the command line reads too.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache, wraps
from pathlib import Path
from typing import Concatenate, ParamSpec, TypeVar

from valvetrain.errors import InputError
from valvetrain.parameters.bounded_file import MAX_BYTES
from valvetrain.parameters.case import Case
from valvetrain.parameters.changes import nearest
from valvetrain.parameters.loading import (
    LIBRARY,
    library_names,
    list_cases,
    parse_case,
    parse_toml,
    read_text,
)
from valvetrain.parameters.overrides import split_notes
from valvetrain.parameters.templates import KINDS, template_text
from valvetrain.solution.atomic import lock, write_bytes, write_text
from valvetrain.system.build import build
from valvetrain.units.text import clipped
from valvetrain.workbench.edits import (
    read_change,
    refuse_foreign_files,
    with_law,
    with_name,
    with_table,
    with_value,
)
from valvetrain.workbench.form import CaseForm
from valvetrain.workbench.saved_runs import (
    Run,
    RunFiles,
    file_of,
    list_saved,
    saved_run,
)
from valvetrain.workbench.side_files import (
    CASE_FILE,
    StoredFile,
    check_bounds,
    found_file,
    names_in,
    new_folder,
    not_sent,
    passing_folder,
    remove_passing,
    stored_files,
)
from valvetrain.workbench.starts import first_values
from valvetrain.workbench.store import Store, case_name, checked_name, inside, writing

#: Name of a case in its workspace: that of its folder, and of the case itself.
CaseId = str
#: Most cases of one workspace, and changes of each that can be taken back.
MAX_CASES, MAX_CHANGES = 500, 50
_LAST_CHANGE = "SELECT id, before FROM changes WHERE name = ? AND after = ? ORDER BY id DESC"
_FORGET_CHANGES = (
    "DELETE FROM changes WHERE name = ? AND id NOT IN "
    "(SELECT id FROM changes WHERE name = ? ORDER BY id DESC LIMIT ?)"
)
_Given = ParamSpec("_Given")
_Result = TypeVar("_Result")


def _in_turn(
    method: Callable[Concatenate[Workspace, _Given], _Result],
) -> Callable[Concatenate[Workspace, _Given], _Result]:
    """One of the methods that check something and then write: no two of them at a time, so that
    what was checked still holds.
    """

    @wraps(method)
    def waiting(self: Workspace, /, *given: _Given.args, **named: _Given.kwargs) -> _Result:
        with self.turn, writing("the workspace"):
            return method(self, *given, **named)

    return waiting


def binding(case: Case) -> str:
    """The sentence by which a run of ``case`` is refused for a spring that is solid within the lift;
    empty where none is, or the case cannot be built for another reason.
    """
    if not case.springs and case.train is None:
        return ""
    try:
        build(case, spring_models=("massless",))
    except InputError as error:
        return error.reason if "reaches coil bind" in error.reason else ""
    return ""


@lru_cache(maxsize=2 * MAX_CASES)
def _contents(path: Path, changed: int) -> tuple[str, tuple[str, ...]]:
    """Title and tables of a case file, cached until it is ``changed``. Raises :class:`InputError`
    for what is none.
    """
    tree = parse_toml(read_text(path), path.parent.name)
    holds = tuple(key for key in ("spring", "lift_law", "train", "published") if key in tree)
    return clipped(str(tree.get("title", "")), 120), holds


@dataclass(frozen=True, slots=True)
class CaseCard:
    """What a list of cases shows of one.

    Parameters
    ----------
    name : what :meth:`Workspace.new_case` takes (library and templates), or the :data:`CaseId` of a
        case of the workspace
    title : one line
    kind : ``library``, ``template`` or ``case``
    holds : tables it has, such as ``spring``, ``lift_law``, ``train``
    fault : why it cannot be opened; empty where it can
    """

    name: str
    title: str
    kind: str
    holds: tuple[str, ...] = ()
    fault: str = ""


class Workspace:
    """A folder of cases and runs, made where it is not there.

    Parameters
    ----------
    folder : the folder

    Raises
    ------
    InputError : a folder that cannot be made or written, or whose database is of another version
    """

    def __init__(self, folder: Path) -> None:
        self.folder = Path(folder).absolute()
        self.cases_folder, self.runs_folder, self.jobs_folder = (
            self.folder / name for name in ("cases", "runs", "jobs")
        )
        try:
            for place in (self.folder, self.cases_folder, self.runs_folder, self.jobs_folder):
                place.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(
                f"folder '{clipped(str(self.folder), 120)}' cannot be used ({error.strerror}); choose another",
                "--folder",
            ) from None
        self.store, self.turn = Store(self.folder), threading.RLock()

    def hold(self) -> Callable[[], None]:
        """Hold the workspace for this process, as a server does; what releases it.

        Raises :class:`InputError` where another server holds it.
        """
        with writing("this workspace", "--folder"):
            handle = os.open(self.folder / "workbench.lock", os.O_RDWR | os.O_CREAT, 0o600)
        if not lock(handle):
            os.close(handle)
            name = clipped(str(self.folder), 120)
            raise InputError(
                f"another server works in '{name}'; stop it, or choose another folder", "--folder"
            )
        remove_passing(self.cases_folder)
        return lambda: os.close(handle)

    # cases

    def library(self) -> list[CaseCard]:
        """Cases of the library, and templates to begin with, which :meth:`new_case` takes by their
        names.
        """
        cards = [CaseCard(one.name, one.title, "library", one.holds) for one in list_cases()]
        return cards + [
            CaseCard(kind, f"Template: {title}", "template") for kind, title in KINDS.items()
        ]

    def cases(self) -> list[CaseCard]:
        """Cases of the workspace, changed last first."""
        found = []
        for folder in self.cases_folder.iterdir():
            if folder.name.startswith(".") or not os.path.lexists(folder / CASE_FILE):
                continue
            title, holds, fault, changed = "", tuple[str, ...](), "", 0
            try:
                path = self._file(folder.name)
                changed = path.stat().st_mtime_ns
                title, holds = _contents(path, changed)
            except InputError as error:
                fault = str(error)
            except OSError:  # removed meanwhile
                continue
            name = clipped(folder.name, 200)
            found.append((changed, CaseCard(name, title, "case", holds, fault)))
        return [card for _, card in sorted(found, key=lambda one: one[0], reverse=True)]

    @_in_turn
    def new_case(self, name: str, template_or_library: str, numbered: bool = False) -> CaseId:
        """A new case from a case of the library or a template (:meth:`library`); its id, ``numbered`` where the name is
        taken.

        Raises :class:`InputError` for a name that is taken or cannot be one, and an unknown source.
        """
        ours = self._free(name, numbered)
        sides = dict[str, bytes]()
        if template_or_library in library_names():
            text = (LIBRARY / f"{template_or_library}.toml").read_text("utf-8")
            named = (LIBRARY / file for file in names_in(text))
            sides = {path.name: path.read_bytes() for path in named}
        else:
            text = template_text(template_or_library).replace("NAME", ours)
        return self._put(ours, text, sides)

    def upload(
        self, name: str, content: bytes, side_files: Mapping[str, bytes] | None = None
    ) -> CaseId:
        """A new case from an uploaded file ``name``; its id, with a number where the name is taken.
        ``side_files``: files it names.

        Raises :class:`InputError` with the reader's own sentence for what is no case, too large, or
        names files elsewhere or not sent.
        """
        if len(content) > MAX_BYTES:
            raise InputError(
                f"is larger than {MAX_BYTES / 1e6:.3g} MB, so it is no case; give another file",
                clipped(name, 60),
            )
        try:
            text = content.decode("utf-8-sig")
        except UnicodeDecodeError:
            raise InputError(
                "is no text file; a case is TOML in UTF-8", clipped(name, 60)
            ) from None
        sides = dict(side_files or {})
        refuse_foreign_files(text, where=clipped(name, 60))
        check_bounds(sides, "upload")

        def read(folder: Path) -> None:
            try:
                parse_case(text, "case", folder, clipped(name, 60))
            except InputError:
                if missing := not_sent(text, sides):
                    raise InputError(missing, clipped(name, 60)) from None
                raise

        with self.turn:
            return self._put(self._free(name, numbered=True), text, sides, read)

    def opened(self, case: Case) -> CaseId:
        """The case here that has the text of ``case``, else a copy of it."""
        sound = (one.name for one in self.cases() if not one.fault)
        same = (one for one in sound if self.text(one) == case.text)
        return next(same, None) or self.upload(f"{case.name}.toml", case.text.encode())

    def text(self, case: CaseId) -> str:
        """The present case file. Raises :class:`InputError` for an unknown case."""
        return read_text(self._file(case))

    def read(self, case: CaseId) -> Case:
        """The case, read. Raises :class:`InputError` with the reader's sentence."""
        return self.parse(case, self.text(case))

    def parse(self, case: CaseId, toml: str) -> Case:
        """``toml`` as the case would be read, with the files next to it. Raises :class:`InputError` otherwise."""
        refuse_foreign_files(toml, where=case)
        return parse_case(toml, case, self._file(case).parent, case)

    @_in_turn
    def set_value(self, case: CaseId, key: str, text_value: str) -> None:
        """Set a value by its key path as ``--set`` would, empty text removing it; comments of the
        file stay.

        Raises :class:`InputError` with the reader's sentence, and changes nothing, for a value that
        is refused.
        """
        before = self.text(case)
        path, value, changed = read_change(before, key, text_value, self.case_folder(case), case)
        if (sentence := binding(changed)) and not binding(self.parse(case, before)):
            raise InputError(sentence, path)
        self._write(case, with_value(before, path, value))

    @_in_turn
    def add_table(self, case: CaseId, key: str) -> None:
        """Give a case a table that its form offers, with values to begin with.

        Raises :class:`InputError`, and changes nothing, for a table that it may not get.
        """
        text = self.text(case)
        keys = [one.key for one in CaseForm(text).additions]
        if key not in keys:
            reason = f"'{clipped(key, 60)}' is no table that this case may get"
            raise InputError(f"{reason}; {nearest(key, keys)}", "table")
        start = first_values(self.read(case), split_notes(parse_toml(text, case))[0], key)
        made = with_table(text, key, start)
        self.parse(case, made)
        self._write(case, made)

    @_in_turn
    def change_law(self, case: CaseId, kind: str) -> None:
        """Give a case a lift law of another kind: what both kinds know stays, the rest is assumed.

        Raises :class:`InputError`, and changes nothing, for a kind whose values cannot be given for
        it.
        """
        text, refused = self.text(case), None
        for file in [one.name for one in self.side_files(case)] or [""]:
            made = with_law(text, kind, file)
            try:
                self.parse(case, made)
            except InputError as error:
                refused = error
                continue
            self._write(case, made)
            return
        reason = refused.reason if refused is not None else ""
        raise InputError(
            f"kind '{kind}' needs more than this lift law gives ({reason}); a file that it reads is added below 'Files of this case', "
            "other values are written in the downloaded case",
            "lift_law.kind",
        )

    def last_change(self, case: CaseId) -> tuple[int, str] | None:
        """Number of the last change of a case that was made here, and its text before it; None where there
        is none, or the file was changed otherwise since.
        """
        with self.store.connected() as base:
            row = base.execute(_LAST_CHANGE, (case, self.text(case))).fetchone()
        return None if row is None else (row["id"], row["before"])

    @_in_turn
    def undo(self, case: CaseId) -> None:
        """Take back the last change of a case. Raises :class:`InputError` where there is none, and where a
        file is gone that the case then named.
        """
        change = self.last_change(case)
        if change is None:
            raise InputError("there is no change of this case to take back", case)
        number, before = change
        self.parse(case, before)
        with self.store.connected() as base:
            base.execute("DELETE FROM changes WHERE name = ? AND id >= ?", (case, number))
            write_text(self._file(case), before)

    @_in_turn
    def duplicate(self, case: CaseId) -> CaseId:
        """A copy of a case; its id."""
        text, ours = self.text(case), self._free(case, numbered=True)
        return self._put(ours, text, self.files(case))

    def files(self, case: CaseId) -> dict[str, bytes]:
        """Files next to a case, by name."""
        return {one.name: one.path.read_bytes() for one in stored_files(self.case_folder(case))}

    def side_files(self, case: CaseId) -> tuple[StoredFile, ...]:
        """The files next to a case, by name. Raises :class:`InputError` for an unknown case."""
        return stored_files(self.case_folder(case), names_in(self.text(case)))

    def side_file(self, case: CaseId, name: str) -> Path:
        """The path of a file next to a case. Raises :class:`InputError` where there is none."""
        return found_file(self._file(case).parent, name)

    @_in_turn
    def attach(self, case: CaseId, name: str, content: bytes) -> None:
        """Put a file (a table of lifts) next to a case, which may then name it.

        Raises :class:`InputError` beyond the bounds, and for another content of a file that the
        case names, with which it cannot be read.
        """
        sizes = {one.name: one.size for one in stored_files(self.case_folder(case))}
        check_bounds({**sizes, checked_name(name): len(content)}, name, new=(name,))
        if name in (named := names_in(text := self.text(case))):
            others = {one: held for one, held in self.files(case).items() if one in named}
            with passing_folder(self.cases_folder, {**others, name: content}) as folder:
                parse_case(text, case, folder, case)
        write_bytes(inside(self._file(case).parent, name), content)

    @_in_turn
    def detach(self, case: CaseId, name: str) -> None:
        """Remove a file next to a case. Raises :class:`InputError` where there is none, or the case
        names it.
        """
        path = self.side_file(case, name)
        if name in names_in(self.text(case)):
            raise InputError(
                "the case names this file, so it stays; name another in its place first", name
            )
        path.unlink(missing_ok=True)

    # runs

    def runs(self, case: CaseId | None = None) -> list[Run]:
        """Saved runs, newest first; of one case where given."""
        return list_saved(self.runs_folder, case)

    def run(self, run_id: str) -> Run:
        """The run of an id such as ``CASE/20261122-130942-447e4694``. Raises :class:`InputError`
        where there is none.
        """
        return saved_run(self.runs_folder, run_id)

    def download(self, run_id: str, kind: RunFiles) -> Path:
        """The file to serve: ``case`` (TOML), ``data`` (all files, zip), ``report`` (HTML) or
        ``csv`` (all tables, zip).

        The path is inside the workspace. Raises :class:`InputError` for an unknown run or kind,
        or a run without such a file.
        """
        return file_of(self.runs_folder, self.jobs_folder, run_id, kind)

    # inside

    def case_folder(self, case: CaseId) -> Path:
        """Folder of a case. Raises :class:`InputError` for an unknown one."""
        return self._file(case).parent

    def _file(self, case: CaseId) -> Path:
        path = inside(self.cases_folder, case, CASE_FILE)
        if not path.is_file():
            raise InputError(
                f"there is no case '{clipped(case, 40)}' here; it may have been renamed or removed",
                "case",
            )
        return path

    def _free(self, name: str, numbered: bool = False) -> CaseId:
        ours = case_name(name)
        taken = {
            path.name.lower()
            for path in self.cases_folder.iterdir()
            if not path.name.startswith(".")
        }
        if len(taken) >= MAX_CASES:
            raise InputError(
                f"there are {MAX_CASES} cases here; remove some, or use another folder", "name"
            )
        if numbered:
            return next(
                one
                for n in range(1, MAX_CASES + 2)
                if (one := ours if n == 1 else f"{ours}-{n}").lower() not in taken
            )
        if ours.lower() in taken:
            raise InputError(f"there is a case '{ours}' already; choose another name", "name")
        return ours

    def _write(self, case: CaseId, text: str) -> None:
        """Write a case, and what it was before, so that the change can be taken back."""
        before = self.text(case)
        if text == before:
            return
        with self.store.connected() as base:
            base.execute(
                "INSERT INTO changes (name, before, after) VALUES (?, ?, ?)", (case, before, text)
            )
            base.execute(_FORGET_CHANGES, (case, case, MAX_CHANGES))
            write_text(self._file(case), text)

    def _put(
        self,
        ours: CaseId,
        text: str,
        sides: Mapping[str, bytes],
        read: Callable[[Path], object] = lambda folder: None,
    ) -> CaseId:
        refuse_foreign_files(text)
        new_folder(self.cases_folder, ours, with_name(text, ours), sides, read)
        return ours
