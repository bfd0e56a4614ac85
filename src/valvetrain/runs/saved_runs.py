"""Saved runs: inputs and ``run.json`` of every run in a folder of its own, read back, listed and
found by name.

A folder holds ``inputs/case.toml`` (the resolved case, from which the run is repeated), the files
that the case names, ``run.json`` (answer, versions, options, checksum) and whatever the study
wrote. It is a run once its ``run.json`` is there.
"""

from __future__ import annotations

import hashlib
import json
import shlex
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from valvetrain.errors import InputError
from valvetrain.parameters.bounded_file import named_file
from valvetrain.runs.run_folders import (
    ANSWER,
    CASE_FILE,
    LATEST,
    MAX_BYTES,
    ROOT,
    homes,
    remove_files,
)
from valvetrain.solution.atomic import digest, write_bytes, write_text

_CHECKSUM = "checksum"
#: Entry of ``run.json`` with what its names mean where that has changed, and the name that it is about.
DEFINITIONS, FORCE = "definitions", "peak_spring_force"


class Measured(BaseModel):
    """A number of ``run.json`` (SI) with its unit."""

    value: float | None = None
    unit: str = ""


class AnsweredRun(BaseModel):
    """A run of ``run.json``, as far as it is read back."""

    label: str | None = None
    model: str | None = None
    engine_speed: Measured | None = None
    quantities: dict[str, Measured] = {}


class Choices(BaseModel):
    """The options of ``run.json``, as far as they are read back: crank speeds in rpm, names of models."""

    engine_speeds: list[float] = []
    models: list[str] = []


class StoredFinding(BaseModel):
    """A finding of ``run.json``, as far as it is read back."""

    code: str
    text: str


class Answer(BaseModel):
    """The entries of ``run.json`` that are read back."""

    created_at: str = ""
    digest: str = ""
    case: str = ""
    command: str = ""
    files: list[str] = []
    choices: Choices = Choices()
    command_line: list[str] = []
    failures: list[str] = []
    findings: list[StoredFinding] = []
    quantities: dict[str, Measured] = {}
    quantities_by_label: dict[str, dict[str, Measured]] = {}
    runs: list[AnsweredRun] = []


@dataclass(frozen=True)
class Inputs:
    """Inputs of a run: name of the case, its resolved file (TOML), the files it names, and the
    options of the command.
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
    def command(self) -> str:
        """The command, such as ``run`` or ``sweep``."""
        return str(self.answer.get("command", ""))

    @property
    def case_file(self) -> Path:
        """The resolved case file, from which the run is repeated."""
        return self.folder / CASE_FILE

    @property
    def choices(self) -> Mapping[str, Any]:
        """Options of the command."""
        choices: Mapping[str, Any] = self.answer.get("choices", {})
        return choices

    @property
    def models(self) -> tuple[str, ...]:
        """Names of the spring models that ran."""
        return tuple(self.choices.get("models", ()))

    @property
    def engine_speeds(self) -> tuple[float, ...]:
        """Crank speeds (rpm)."""
        return tuple(map(float, self.choices.get("engine_speeds", ())))

    @property
    def failures(self) -> tuple[str, ...]:
        """A sentence for each part that failed."""
        return tuple(self.answer.get("failures", ()))

    @property
    def state(self) -> str:
        """How the run ended: ``completed``, ``failed`` or, by a signal, ``interrupted``."""
        if self.answer.get("completed"):
            return "completed"
        statuses = (one.get("status") for one in self.answer.get("runs", ()))
        codes = [status.get("code") for status in statuses if isinstance(status, dict)]
        stopped = any(sentence.startswith("interrupted") for sentence in self.failures)
        return "interrupted" if stopped or "interrupted" in codes else "failed"

    @property
    def verdict(self) -> Mapping[str, Any]:
        """The stored finding that decides, with ``code`` and ``text``; empty where none was stored."""
        return next(iter(self.answer.get("findings", ())), {})

    @property
    def command_line(self) -> str:
        """The command that made it, for a shell; empty where it was not stored."""
        return shlex.join(self.answer.get("command_line", ()))


def collect_inputs(case: str, text: str, folder: Path, choices: Mapping[str, Any]) -> Inputs:
    """The inputs of a run whose case file is in ``folder``, with the files that it names, renamed
    to their last part.

    Raises :class:`InputError` when one of them can no longer be read.
    """
    plain = tomllib.loads(text)
    if "name" not in plain:  # read again, the case retains its name
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


def save_run(folder: Path, inputs: Inputs, answer: Mapping[str, Any]) -> SavedRun:
    """Write inputs and ``run.json`` (last: it makes the folder a run), and remove the files of an
    earlier run that this one did not write. ``answer["files"]`` are paths relative to the folder.
    """
    earlier: dict[str, Any] = {}
    with suppress(InputError):
        earlier = read_answer(folder)
    for name, content in inputs.side_files.items():
        write_bytes(folder / CASE_FILE.parent / name, content)
    write_text(folder / CASE_FILE, inputs.text)
    written = [
        f"{CASE_FILE.parent.as_posix()}/{name}" for name in ("case.toml", *inputs.side_files)
    ]
    files = [*dict.fromkeys((*answer.get("files", ()), *written))]
    whole = {**answer, "digest": inputs.digest, "choices": dict(inputs.choices), "files": files}
    remove_files(folder, set(map(str, earlier.get("files", ()))) - set(map(str, files)))
    write_text(folder / ANSWER, answer_text(whole))
    return SavedRun(folder, whole)


def check_inputs(run: SavedRun) -> None:
    """Raise :class:`InputError` where the inputs of a saved run have changed; a run without a
    digest passes.
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


def list_saved_runs(case: str = "", root: Path = ROOT) -> tuple[SavedRun, ...]:
    """Every run with a readable ``run.json`` under ``root``, newest first, of one ``case`` where
    given.
    """
    found = list[tuple[int, SavedRun]]()
    for home in homes(case, root):
        for path in home.glob(f"*/{ANSWER}"):
            with suppress(OSError, InputError):  # a folder may go meanwhile, or be damaged
                written = path.stat().st_mtime_ns
                if not path.parent.is_symlink() and (answer := read_answer(path.parent)):
                    found.append((written, SavedRun(path.parent, answer)))
    # runs of one second follow each other by the time at which they were written
    newest = sorted(found, key=lambda one: (one[1].created_at, one[0]), reverse=True)
    return tuple(run for _, run in newest)


def find_run(name: str, root: Path = ROOT) -> SavedRun:
    """The run of that ``name``: its folder (or a file in it), its digest or the begin of it,
    ``CASE/latest``, a case, or ``latest``.

    Raises :class:`InputError` when none fits.
    """
    if not name.strip() or "\0" in name:
        raise InputError("a run is named by its folder, its digest, a case or 'latest'; give one")
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
    """The run of a folder, its ``run.json`` or its case file; None where there is none.

    Raises :class:`InputError` where its ``run.json`` is damaged.
    """
    parents = {ANSWER: (path.parent,), CASE_FILE.name: (path.parent.parent,)}
    try:
        for folder in (path, *parents.get(path.name, ())):
            if folder.name == LATEST and folder.is_file():  # where links are not possible
                folder = folder.parent / folder.read_text("utf-8").strip()
            if folder.is_dir() and (answer := read_answer(folder)):
                return SavedRun(folder, answer)
    except (OSError, ValueError):
        return None
    return None


def answer_text(answer: Mapping[str, Any]) -> str:
    """The text of ``run.json``: the answer and its checksum."""
    plain = json.loads(json.dumps(answer, allow_nan=False, default=str))
    return _lines(plain | {_CHECKSUM: _sum(plain)}) + "\n"


def _lines(answer: Mapping[str, Any]) -> str:
    """JSON with a line for each entry, and each part of an entry: an indent of every level takes
    ten times as long.
    """
    write = json.JSONEncoder(allow_nan=False).encode
    entries = []
    for key, value in answer.items():
        if isinstance(value, dict) and value:
            parts = (f"{write(name)}: {write(part)}" for name, part in value.items())
            text = "{\n    " + ",\n    ".join(parts) + "\n  }"
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            text = "[\n    " + ",\n    ".join(map(write, value)) + "\n  ]"
        else:
            text = write(value)
        entries.append(f"  {write(key)}: {text}")
    return "{\n" + ",\n".join(entries) + "\n}"


def read_answer(folder: Path) -> dict[str, Any]:
    """The ``run.json`` of a folder; empty where there is none, or another program's.

    Raises :class:`InputError` for a damaged one: it cannot be read, was changed, or has entries of
    another type.
    """
    path = folder / ANSWER
    try:
        if not path.is_file():
            return {}
        if path.stat().st_size > MAX_BYTES:
            raise InputError("is too large for the answer of a run; repeat the run", str(path))
        found = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError, RecursionError, MemoryError) as error:
        raise InputError("is damaged: it is no JSON; repeat the run", str(path)) from error
    if not isinstance(found, dict) or "created_at" not in found:
        return {}
    checksum = found.pop(_CHECKSUM, None)
    try:
        same = checksum is None or checksum == _sum(found)
    except (ValueError, RecursionError):
        same = False
    if not same:
        raise InputError(
            "is damaged: its numbers are not those that were written (checksum); repeat the run",
            str(path),
        )
    try:
        Answer.model_validate(found, strict=True)
    except ValidationError as error:
        raise InputError(
            f"is damaged: '{error.errors()[0]['loc'][0]}' is not what a run writes; repeat the run",
            str(path),
        ) from None
    return found


def _sum(answer: Mapping[str, Any]) -> str:
    return digest(json.dumps(answer, sort_keys=True).encode())


def is_number(item: Any) -> bool:
    """Whether a value of JSON is a number."""
    return isinstance(item, (int, float)) and not isinstance(item, bool)
