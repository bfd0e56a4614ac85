"""Runs are kept: each in a folder of its own with its inputs whole, listed, found again and
compared. Nothing is printed here.

``runs/CASE/DATE-TIME-DIGEST`` holds ``inputs/case.toml`` (the resolved case, from which the run is
repeated), the files the case
names, ``run.json`` (answer, versions, options) and whatever the study wrote. A folder counts as a
run once its ``run.json`` is there.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import tempfile
import tomllib
import unicodedata
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from valvetrain.errors import InputError
from valvetrain.parameters.bounded_file import named_file
from valvetrain.runs.saved_answer import ANSWER, answer_text, read_answer
from valvetrain.solution.atomic import (
    SUFFIX,
    is_abandoned,
    is_living,
    lock,
    remove_abandoned,
    write_bytes,
    write_text,
)
from valvetrain.units.text import clipped

ROOT, LATEST, CASE_FILE = Path("runs"), "latest", Path("inputs") / "case.toml"
#: End of the name of a folder whose run goes on or was killed, and the list of its finished runs.
UNFINISHED, LIST = "-unfinished", "unfinished-runs.jsonl"
_RUN_FILE = re.compile(r"run-\d{4,}\.nc")


@dataclass(frozen=True)
class Inputs:
    """What a run was made from: name of the case, its resolved file (TOML), the files it names, and
    the choices made beside it.
    """

    case: str
    text: str
    side_files: Mapping[str, bytes] = field(default_factory=dict)
    choices: Mapping[str, Any] = field(default_factory=dict)

    @property
    def digest(self) -> str:
        """Eight hexadecimal digits, the same for the same inputs."""
        found = hashlib.sha256(self.text.encode())
        for name, content in sorted(self.side_files.items()):
            found.update(f"\0{name}\0".encode() + content)
        found.update(json.dumps(self.choices, sort_keys=True, default=str).encode())
        return found.hexdigest()[:8]


@dataclass(frozen=True)
class SavedRun:
    """A run on disk: its folder and its ``run.json``."""

    folder: Path
    answer: Mapping[str, Any]

    @property
    def created_at(self) -> str:
        """UTC time of the run, ISO 8601."""
        return str(self.answer.get("created_at", ""))

    @property
    def digest(self) -> str:
        """Digest of the inputs."""
        return str(self.answer.get("digest", ""))

    @property
    def case(self) -> str:
        """Name of the case."""
        return str(self.answer.get("case", ""))

    @property
    def case_file(self) -> Path:
        """The resolved case file, from which the run is repeated."""
        return self.folder / CASE_FILE


def collect_inputs(case: str, text: str, folder: Path, choices: Mapping[str, Any]) -> Inputs:
    """The inputs of a run whose case file lay in ``folder``; files it names are taken along and
    named by their last part.

    Raises :class:`InputError` when one of them can no longer be read.
    """
    plain = tomllib.loads(text)
    if "name" not in plain:  # read again, the case keeps its name
        text = f"name = {json.dumps(case)}\n{text}"
    if not any("file" in table for table in _tables(plain)):
        return Inputs(case, text, {}, choices)
    import tomlkit  # keeps comments and order where a name is to be changed

    document = tomlkit.parse(text)
    side_files: dict[str, bytes] = {}
    for table in _tables(document):
        name = table.get("file")
        named = name.get("value") if isinstance(name, dict) else name
        if not isinstance(named, str):
            continue
        try:
            content = named_file(folder, named).read_bytes()
        except (OSError, ValueError) as error:
            raise InputError(
                f"the file '{named}' that case '{case}' names cannot be read; put it back", case
            ) from error
        short = _free_name(Path(named).name, content, side_files)
        side_files[short] = content
        if short != named:
            (name if isinstance(name, dict) else table)[
                "value" if isinstance(name, dict) else "file"
            ] = short
    return Inputs(case, tomlkit.dumps(document), side_files, choices)


def new_folder(inputs: Inputs, created_at: datetime, root: Path = ROOT) -> Path:
    """Make the folder of a new run, ``root/CASE/DATE-TIME-DIGEST``; one that is there already is
    never taken.

    Raises :class:`InputError` when it cannot be made.
    """
    return _free_folder(
        root / safe_name(inputs.case), f"{created_at.astimezone(UTC):%Y%m%d-%H%M%S}-{inputs.digest}"
    )


def unfinished_folder(case: str, created_at: datetime, root: Path = ROOT) -> Path:
    """Make the folder of a run that goes on; :func:`finish_folder` gives it its name. What killed
    runs of the case left empty goes.
    """
    home = root / safe_name(case)
    remove_empty(home)
    return _free_folder(home, f"{created_at.astimezone(UTC):%Y%m%d-%H%M%S}{UNFINISHED}")


def finish_folder(folder: Path, inputs: Inputs, created_at: datetime, root: Path = ROOT) -> Path:
    """Give a folder of :func:`unfinished_folder` the name of its run."""
    final = new_folder(inputs, created_at, root)
    try:
        final.rmdir()
        folder.rename(final)
    except OSError:
        return folder
    return final


def mark_unfinished(folder: Path) -> int:
    """Begin the list of finished runs in ``folder``, locked for as long as this process lives; the
    open file.
    """
    folder.mkdir(parents=True, exist_ok=True)
    refuse_living(folder)
    remove_unfinished(folder)
    handle = os.open(folder / LIST, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
    if not lock(handle):  # begun at the same moment
        os.close(handle)
        refuse_living(folder)
    os.ftruncate(handle, 0)
    return handle


def refuse_living(folder: Path) -> None:
    """Refuse, with an :class:`InputError`, a folder into which another run, which lives, writes."""
    if (folder / LIST).is_file() and is_living(folder / LIST):
        raise InputError(
            f"another run writes into folder '{clipped(str(folder), 120)}'; wait for it or choose another",
            "--output",
        )


def remove_unfinished(folder: Path) -> None:
    """Remove what a killed run listed in ``folder``, which another one takes."""
    if (folder / LIST).is_file() and not is_living(folder / LIST):
        _remove(folder, (*(name for name in _listed(folder) if _RUN_FILE.fullmatch(name)), LIST))


def _listed(folder: Path) -> list[str]:
    """Files that a killed run listed in ``folder``."""
    found = []
    for line in whole_lines(folder / LIST):
        with suppress(ValueError, TypeError, KeyError):
            found.append(str(json.loads(line)["file"]))
    return found


def whole_lines(path: Path) -> list[bytes]:
    """Lines of a list of finished runs; one that is not whole, where a process was killed, is none."""
    try:
        return path.read_bytes().split(b"\n")[:-1]
    except OSError:
        return []


def remove_empty(home: Path) -> None:
    """Remove what killed runs left in the folders of a case: half-written files, and folders that
    hold no finished run.
    """
    with suppress(OSError):
        for folder in home.iterdir():
            if folder.is_symlink() or not folder.is_dir() or (folder / ANSWER).exists():
                continue
            remove_abandoned(folder)
            rows, left = folder / LIST, [path.name for path in folder.iterdir()]
            if (
                UNFINISHED in folder.name
                and left == [LIST]
                and not rows.stat().st_size
                and is_abandoned(rows)
            ):
                rows.unlink()
                folder.rmdir()


def _free_folder(home: Path, stem: str) -> Path:
    for count in range(1, 1000):
        folder = home / (stem if count == 1 else f"{stem}-{count}")
        try:
            folder.mkdir(parents=True)
            return folder
        except FileExistsError:
            continue
        except OSError as error:
            raise InputError(
                f"folder '{folder}' cannot be made ({error.strerror}); choose another", "--output"
            ) from None
    raise InputError(f"'{home}' holds a thousand runs of this second; tidy it up", "--output")


def check_folder(folder: Path, kept: bool = False, resumes: str = "") -> None:
    """Refuse, with an :class:`InputError`, a folder that cannot be written, or, unless runs are
    ``kept`` in it, one that holds something
    else than an earlier run or, by the file ``resumes``, what is left of one that was cut."""
    shown = clipped(str(folder), 120)
    try:
        there = next(
            path
            for path in (folder.absolute(), *folder.absolute().parents)
            if os.path.lexists(path) or path.exists()
        )
        ours = any((folder / name).is_file() for name in (ANSWER, LIST, resumes) if name)
        foreign = (
            not kept
            and folder.is_dir()
            and not ours
            and any(path for path in folder.iterdir() if not path.name.endswith(SUFFIX))
        )
    except (OSError, ValueError) as error:
        words = getattr(error, "strerror", None) or error
        raise InputError(
            f"'{shown}' is no usable folder name ({words}); choose another", "--output"
        ) from None
    place = clipped(str(there), 120)
    if not there.is_dir():
        what = (
            "a link that leads nowhere"
            if there.is_symlink() and not there.exists()
            else "a file, not a folder"
        )
        raise InputError(f"'{place}' is {what}; choose another", "--output")
    try:
        os.rmdir(
            tempfile.mkdtemp(prefix=".valvetrain.", dir=there)
        )  # some folders take nothing, whatever their permissions say
    except OSError as error:
        raise InputError(
            f"folder '{place}' may not be written to ({error.strerror}); choose another", "--output"
        ) from None
    refuse_living(folder)
    if foreign:
        raise InputError(
            f"folder '{shown}' holds files that no run wrote; choose an empty or a new one",
            "--output",
        )


def keep(folder: Path, inputs: Inputs, answer: Mapping[str, Any]) -> SavedRun:
    """Write inputs and ``run.json`` (last: it makes the folder a run); files that an earlier run
    left here and this one did not
    write again are removed. ``answer["files"]`` are paths relative to the folder."""
    earlier = _read_answer(folder)
    for name, content in inputs.side_files.items():
        write_bytes(folder / CASE_FILE.parent / name, content)
    write_text(folder / CASE_FILE, inputs.text)
    written = [
        f"{CASE_FILE.parent.as_posix()}/{name}" for name in ("case.toml", *inputs.side_files)
    ]
    files = [*dict.fromkeys((*answer.get("files", ()), *written))]
    whole = {**answer, "digest": inputs.digest, "choices": dict(inputs.choices), "files": files}
    _remove(folder, set(map(str, earlier.get("files", ()))) - set(map(str, files)))
    write_text(folder / ANSWER, answer_text(whole))
    return SavedRun(folder, whole)


def check_inputs(run: SavedRun) -> None:
    """Raise :class:`InputError` where the inputs of a kept run are not those that it was made from;
    a run without a digest passes.
    """
    names = [
        str(name)
        for name in run.answer.get("files", ())
        if str(name).startswith(f"{CASE_FILE.parent.as_posix()}/")
    ]
    try:
        text = run.case_file.read_bytes().decode()
        side_files = {
            Path(name).name: (run.folder / name).read_bytes()
            for name in names
            if Path(name).name != CASE_FILE.name
        }
        same = (
            Inputs(run.case, text, side_files, run.answer.get("choices", {})).digest == run.digest
        )
    except (OSError, ValueError) as error:
        raise InputError(
            "the inputs of this run cannot be read; repeat the run", str(run.folder)
        ) from error
    if run.digest and not same:
        raise InputError(
            "the inputs in this folder are not those of its run, they were changed or damaged; repeat the run",
            str(run.folder),
        )


def link_latest(folder: Path) -> None:
    """Point ``latest`` beside ``folder`` to it: a link, or where links are not possible a text file
    with the folder's name.
    """
    link, new = folder.parent / LATEST, folder.parent / f".{LATEST}.{os.getpid()}"
    with suppress(OSError):
        new.unlink(missing_ok=True)
        os.symlink(folder.name, new, target_is_directory=True)
        os.replace(new, link)
        return
    write_text(link, folder.name + "\n")


def homes(case: str = "", root: Path = ROOT) -> list[Path]:
    """Folders that hold the runs of a case each: of ``case``, or of all."""
    return (
        [root / safe_name(case)]
        if case
        else sorted(path for path in root.glob("*") if path.is_dir() and not path.is_symlink())
    )


def list_saved_runs(case: str = "", root: Path = ROOT) -> tuple[SavedRun, ...]:
    """Every run under ``root``, newest first, of one ``case`` where given. Folders without a
    readable ``run.json`` are left out.
    """
    found = []
    for home in homes(case, root):
        for folder in home.glob("*"):
            if not folder.is_symlink() and (answer := _read_answer(folder)):
                found.append(SavedRun(folder, answer))
    return tuple(sorted(found, key=lambda run: (run.created_at, run.folder.name), reverse=True))


def find_run(name: str, root: Path = ROOT) -> SavedRun:
    """The run called ``name``: its folder (or a file in it), its digest or the begin of it,
    ``CASE/latest``, a case, or ``latest``.

    Raises :class:`InputError` when none fits.
    """
    if not name.strip() or "\0" in name:
        raise InputError("a run is called by its folder, its digest, a case or 'latest'; give one")
    if run := run_of_path(Path(name)):
        return run
    runs = list_saved_runs(root=root)
    case, _, last = name.partition("/")
    if name == LATEST and runs:
        return runs[0]
    if last in ("", LATEST) and (mine := [run for run in runs if run.case == case]):
        return mine[0]
    fits = [
        run
        for run in runs
        if run.folder.name == name or (len(name) >= 4 and run.digest.startswith(name))
    ]
    if not fits and (run := run_of_path(root / name)):
        return run
    if not fits:
        raise InputError(
            f"there is no run '{name[:80]}' under '{root}'; 'valvetrain runs' lists those there are"
        )
    return fits[0]


def run_of_path(path: Path) -> SavedRun | None:
    """The run that a folder, its ``run.json`` or its case file belongs to; None where there is
    none. Raises :class:`InputError` where its
    ``run.json`` is damaged."""
    try:
        places = (
            (path, path.parent)
            if path.name == ANSWER
            else (path, path.parent.parent)
            if path.name == CASE_FILE.name
            else (path,)
        )
        for folder in places:
            if folder.name == LATEST and folder.is_file():  # where links are not possible
                folder = folder.parent / folder.read_text("utf-8").strip()
            if folder.is_dir() and (answer := read_answer(folder)):
                return SavedRun(folder, answer)
    except (OSError, ValueError):
        return None
    return None


def safe_name(text: str) -> str:
    """A name as a folder may bear it."""
    plain = re.sub(r"[^\w.-]+", "-", unicodedata.normalize("NFC", text))[:80]
    return plain.encode()[:120].decode(errors="ignore").strip(".-") or "case"


def _tables(item: Any) -> Iterator[Any]:
    if isinstance(item, dict):
        yield item
        for value in item.values():
            yield from _tables(value)
    elif isinstance(item, list):
        for value in item:
            yield from _tables(value)


def _free_name(name: str, content: bytes, taken: Mapping[str, bytes]) -> str:
    stem, suffix, count = Path(name).stem, Path(name).suffix, 1
    while name == CASE_FILE.name or taken.get(name, content) != content:
        count += 1
        name = f"{stem}-{count}{suffix}"
    return name


def _read_answer(folder: Path) -> dict[str, Any]:
    """The ``run.json`` of a folder; empty where there is none that can be read."""
    try:
        return read_answer(folder)
    except InputError:
        return {}


def _remove(folder: Path, names: Iterable[str]) -> None:
    base = folder.resolve()
    for name in names:
        path = (base / name).resolve()
        if path.is_relative_to(base) and path.is_file():
            path.unlink()


def hold_folder(folder: Path) -> Callable[[], None]:
    """Make ``folder`` and lock it for this process; what gives it back, and removes again what was
    made and stayed empty.

    Raises :class:`InputError` where another process that lives has it. Where folders cannot be
    locked, nothing is.
    """
    made = []
    for path in (folder, *folder.parents):
        if path.exists():
            break
        made.append(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        handle = os.open(folder, os.O_RDONLY)
    except OSError:
        return lambda: _remove_empty(made)

    def release() -> None:
        os.close(handle)
        _remove_empty(made)

    if not lock(handle):
        release()
        raise InputError(
            f"another run writes into folder '{clipped(str(folder), 120)}'; wait for it or choose another",
            "--output",
        )
    return release


def _remove_empty(made: list[Path]) -> None:
    with suppress(OSError):
        for path in made:
            path.rmdir()
