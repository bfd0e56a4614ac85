"""Folders of runs: ``runs/CASE/DATE-TIME-DIGEST``, made, locked while a process writes, listed
where a run was killed.
"""

from __future__ import annotations

import json
import os
import re
import shlex
import tempfile
import unicodedata
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from valvetrain.errors import InputError
from valvetrain.solution.atomic import (
    SUFFIX,
    is_abandoned,
    is_living,
    lock,
    remove_abandoned,
    write_text,
)
from valvetrain.units.text import clipped

ROOT, LATEST, CASE_FILE, ANSWER = Path("runs"), "latest", Path("inputs") / "case.toml", "run.json"
#: End of the name of a folder whose run is in progress or was killed, and the list of its finished
#: runs.
UNFINISHED, LIST = "-unfinished", "unfinished-runs.jsonl"
#: Longest run.json, or list of finished runs, that is read (bytes).
MAX_BYTES = 200_000_000
_RUN_FILE = re.compile(r"run-\d{4,}\.nc")
#: Begin of the name of a run's folder: date and time (UTC).
_BEGUN = re.compile(r"(\d{8}-\d{6})-")
_TIME_FORMAT = "%Y%m%d-%H%M%S"


def safe_name(text: str) -> str:
    """A name that is valid as that of a folder."""
    plain = re.sub(r"[^\w.-]+", "-", unicodedata.normalize("NFC", text))[:80]
    return plain.encode()[:120].decode(errors="ignore").strip(".-") or "case"


def homes(case: str = "", root: Path = ROOT) -> list[Path]:
    """Folders that hold the runs of a case each: of ``case``, or of all."""
    if case:
        return [root / safe_name(case)]
    return sorted(path for path in root.glob("*") if path.is_dir() and not path.is_symlink())


def new_folder(case: str, digest: str, created_at: datetime, root: Path = ROOT) -> Path:
    """Make the folder of a new run, ``root/CASE/DATE-TIME-DIGEST``; never one that exists.

    Raises :class:`InputError` when it cannot be made.
    """
    home, stem = root / safe_name(case), f"{created_at.astimezone(UTC):{_TIME_FORMAT}}-{digest}"
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


def unfinished_folder(case: str, created_at: datetime, root: Path = ROOT) -> Path:
    """Make the folder of a run in progress, which :func:`finish_folder` renames; remove what killed
    runs of the case left empty.
    """
    remove_empty(root / safe_name(case))
    return new_folder(case, UNFINISHED[1:], created_at, root)


def finish_folder(
    folder: Path, case: str, digest: str, created_at: datetime, root: Path = ROOT
) -> Path:
    """Give a folder of :func:`unfinished_folder` the name of its run."""
    final = new_folder(case, digest, created_at, root)
    try:
        final.rmdir()
        folder.rename(final)
    except OSError:
        return folder
    return final


def mark_unfinished(folder: Path) -> int:
    """Begin the list of finished runs in ``folder``, locked as long as this process lives, and
    return its open file.
    """
    folder.mkdir(parents=True, exist_ok=True)
    refuse_living(folder)
    if (folder / LIST).is_file():  # of a killed run, whose files this one replaces
        names = []
        for line in whole_lines(folder / LIST):
            with suppress(ValueError, TypeError, KeyError):
                names.append(str(json.loads(line)["file"]))
        remove_files(folder, (*filter(_RUN_FILE.fullmatch, names), LIST))
    handle = os.open(folder / LIST, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
    if not lock(handle):  # begun at the same moment
        os.close(handle)
        refuse_living(folder)
    os.ftruncate(handle, 0)
    return handle


def refuse_living(folder: Path) -> None:
    """Refuse, with an :class:`InputError`, a folder into which another living run writes."""
    if (folder / LIST).is_file() and is_living(folder / LIST):
        raise _occupied(folder)


def _occupied(folder: Path) -> InputError:
    return InputError(
        f"another run writes into folder '{clipped(str(folder), 120)}'; wait for it or choose another",
        "--output",
    )


def remove_files(folder: Path, names: Iterable[str]) -> None:
    """Remove files of a folder; names that lead out of it are ignored."""
    base = folder.resolve()
    for name in names:
        path = (base / name).resolve()
        if path.is_relative_to(base) and path.is_file():
            path.unlink()


def whole_lines(path: Path) -> list[bytes]:
    """Lines of a list of finished runs without an incomplete last one, at which a process was
    killed.
    """
    try:
        return path.read_bytes().split(b"\n")[:-1]
    except OSError:
        return []


def remove_empty(home: Path) -> None:
    """Remove what killed runs left in the folders of a case: half-written files, and folders
    without a finished run.
    """
    with suppress(OSError):
        for folder in home.iterdir():
            if folder.is_symlink() or not folder.is_dir() or (folder / ANSWER).exists():
                continue
            remove_abandoned(folder)
            rows, left = folder / LIST, [path.name for path in folder.iterdir()]
            empty = UNFINISHED in folder.name and left == [LIST] and not rows.stat().st_size
            if empty and is_abandoned(rows):
                rows.unlink()
                folder.rmdir()


def check_folder(folder: Path, home: bool = False, resumes: str = "") -> None:
    """Refuse, with an :class:`InputError`, a folder that cannot be written, or that holds other
    files than those of a run.

    ``home``: it holds the folders of runs. ``resumes``: a file by which an interrupted run is
    recognised.
    """
    shown = clipped(str(folder), 120)
    try:
        there = next(
            path
            for path in (folder.absolute(), *folder.absolute().parents)
            if os.path.lexists(path) or path.exists()
        )
        ours = any((folder / name).is_file() for name in (ANSWER, LIST, resumes) if name)
        foreign = (
            not home
            and folder.is_dir()
            and not ours
            and any(path for path in folder.iterdir() if not path.name.endswith(SUFFIX))
        )
    except (OSError, ValueError) as error:
        cause = getattr(error, "strerror", None) or error
        raise InputError(
            f"'{shown}' is not a usable folder name ({cause}); choose another", "--output"
        ) from None
    existing = clipped(str(there), 120)
    if not there.is_dir():
        what = (
            "a link that leads nowhere"
            if there.is_symlink() and not there.exists()
            else "a file, not a folder"
        )
        raise InputError(f"'{existing}' is {what}; choose another", "--output")
    try:
        # Some folders take no file, whatever their permissions say.
        os.rmdir(tempfile.mkdtemp(prefix=".valvetrain.", dir=there))
    except OSError as error:
        raise InputError(
            f"folder '{existing}' may not be written to ({error.strerror}); choose another",
            "--output",
        ) from None
    refuse_living(folder)
    if foreign:
        raise InputError(
            f"folder '{shown}' holds files that no run wrote; choose an empty or a new one",
            "--output",
        )


def lock_folder(folder: Path) -> Callable[[], None]:
    """Make ``folder`` and lock it for this process; the function that releases it and removes new
    folders left empty.

    Raises :class:`InputError` where another living process has it. Without locks of folders,
    nothing is locked.
    """
    new = []
    for path in (folder, *folder.parents):
        if path.exists():
            break
        new.append(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        handle = os.open(folder, os.O_RDONLY)
    except OSError:
        return lambda: _remove_new(new)

    def release() -> None:
        os.close(handle)
        _remove_new(new)

    if not lock(handle):
        release()
        raise _occupied(folder)
    return release


def _remove_new(folders: list[Path]) -> None:
    with suppress(OSError):
        for path in folders:
            path.rmdir()


def link_latest(folder: Path) -> None:
    """Point ``latest`` next to ``folder`` to it: a link, or a text file with the folder's name
    where links are impossible.
    """
    link, new = folder.parent / LATEST, folder.parent / f".{LATEST}.{os.getpid()}"
    with suppress(OSError):
        new.unlink(missing_ok=True)
        os.symlink(folder.name, new, target_is_directory=True)
        os.replace(new, link)
        return
    write_text(link, folder.name + "\n")


@dataclass(frozen=True)
class UnfinishedFolder:
    """Folder of a run in progress or killed: ``case``, ``created_at`` (UTC, ISO 8601), whether the
    run is ``living``, the number of ``finished`` runs and of ``files``, and the command that began
    it (empty where it was killed before its first run was finished).
    """

    folder: Path
    case: str
    created_at: str
    living: bool
    finished: int
    files: int
    command_line: tuple[str, ...] = ()

    @property
    def command(self) -> str:
        """The command that began it, for a shell."""
        return shlex.join(self.command_line)


def unfinished_runs(case: str = "", root: Path = ROOT) -> tuple[UnfinishedFolder, ...]:
    """Every folder under ``root`` that a run began and did not finish, newest first, of one
    ``case`` where given.
    """
    found = []
    for home in homes(case, root):
        with suppress(OSError):
            for folder in home.iterdir():
                if not folder.is_symlink() and folder.is_dir() and (one := _unfinished(folder)):
                    found.append(one)
    return tuple(sorted(found, key=lambda one: (one.created_at, one.folder.name), reverse=True))


def _unfinished(folder: Path) -> UnfinishedFolder | None:
    begun, rows = _BEGUN.match(folder.name), folder / LIST
    unfinished = rows.is_file() or UNFINISHED in folder.name
    if begun is None or (folder / ANSWER).exists() or not unfinished:
        return None
    try:
        created_at = datetime.strptime(begun[1], _TIME_FORMAT).replace(tzinfo=UTC).isoformat()
    except ValueError:
        return None
    lines = whole_lines(rows) if rows.is_file() and rows.stat().st_size <= MAX_BYTES else []
    command: object = ()
    with suppress(ValueError, RecursionError, IndexError, AttributeError):
        command = json.loads(lines[0]).get("command_line", ())
    return UnfinishedFolder(
        folder,
        folder.parent.name,
        created_at,
        rows.is_file() and is_living(rows),
        len(lines),
        sum(path.is_file() and path.name != LIST for path in folder.iterdir()),
        tuple(map(str, command)) if isinstance(command, list) else (),
    )
