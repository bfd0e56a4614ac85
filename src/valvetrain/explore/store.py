"""Finished points on disk, keyed by the digest of their content: a journal takes each as it comes,
and whole chunks take its place.

A journal line carries a checksum of its own, so that what a killed process left half-written is
known; chunks are NetCDF files with a
closing checksum, written whole or not at all. Nothing is ever changed in place.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import platform
import re
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.errors import InputError
from valvetrain.explore.point import Outcome
from valvetrain.solution.atomic import (
    append_whole,
    check_target,
    checked_content,
    closing_line,
    digest,
    remove_abandoned,
    write_bytes,
)
from valvetrain.solution.channels import ChannelArrays, Variable
from valvetrain.solution.netcdf import write_arrays
from valvetrain.solution.provenance import collect_provenance
from valvetrain.solution.status import COMPLETED, STATUS_CODES, Status

JOURNAL, CHUNKS = "journal.jsonl", "chunk-*.nc"
#: Points of a chunk; until there are so many they stand in the journal.
CHUNK = 256
#: Ends of a point that a second trial may change: they are not kept.
NOT_KEPT = ("worker-lost", "interrupted")
_TEXT, _FORM = "valvetrain_study_points", 1


class PointStore:
    """The finished points in ``folder`` (None: in memory only) with ``outputs`` in this order; one
    process at a time.

    ``outcome(key)`` reads one, ``add(key, outcome)`` keeps one; ``key in store`` tells whether it
    is there. Memory: 16 bytes and a place
    per point, and the values.
    """

    def __init__(self, folder: Path | None, outputs: Sequence[str]) -> None:
        self.folder, self.outputs = folder, tuple(outputs)
        self._places: dict[bytes, int] = {}
        self._values = np.zeros((0, len(self.outputs)))
        self._statuses: dict[int, Status] = {}
        self._journalled: list[bytes] = []
        self._handle = -1
        if folder is not None:
            self._open(folder)

    def __len__(self) -> int:
        return len(self._places)

    def __contains__(self, key: bytes) -> bool:
        return key in self._places

    def outcome(self, key: bytes) -> Outcome:
        """The outcome of a point that is there."""
        place = self._places[key]
        row = self._values[place]
        values = {
            name: float(value)
            for name, value in zip(self.outputs, row, strict=True)
            if not np.isnan(value)
        }
        return Outcome(self._statuses.get(place, COMPLETED), values)

    def row(self, key: bytes) -> np.ndarray[Any, Any]:
        """Values (SI) of a point that is there, nan for those that it does not have."""
        return np.asarray(self._values[self._places[key]])

    def status(self, key: bytes) -> Status:
        """How a point that is there ended."""
        return self._statuses.get(self._places[key], COMPLETED)

    def add(self, key: bytes, outcome: Outcome) -> None:
        """Keep a finished point; on disk before this returns, as far as the system is concerned."""
        row = [float(outcome.values.get(name, np.nan)) for name in self.outputs]
        self._hold(key, row, outcome.status)
        if self.folder is not None and outcome.status.code not in NOT_KEPT:
            self._journalled.append(
                key
            )  # first, so that a chunk has it wherever a signal stops this
            append_whole(self._handle, _line(key, row, outcome.status))
        if len(self._journalled) >= CHUNK:
            self.flush()

    def flush(self) -> None:
        """Make a chunk of what stands in the journal."""
        if self.folder is None or not self._journalled:
            return
        keys = self._journalled
        places = [self._places[key] for key in keys]
        content = _chunk(
            keys,
            self._values[places],
            [self._statuses.get(place, COMPLETED) for place in places],
            self.outputs,
        )
        name = f"chunk-{digest(b''.join(sorted(keys)))}.nc"
        write_bytes(self.folder / name, content)
        os.ftruncate(self._handle, 0)
        self._journalled = []

    def close(self) -> None:
        """End: what is in the journal becomes a chunk, and the next process may come."""
        try:
            self.flush()
        finally:
            if self._handle >= 0:
                os.close(self._handle)
                self._handle = -1

    def _hold(self, key: bytes, row: Sequence[float], status: Status) -> None:
        place = self._places.setdefault(key, len(self._places))
        if place >= len(self._values):
            grown = np.full((max(64, 2 * len(self._values)), len(self.outputs)), np.nan)
            grown[: len(self._values)] = self._values
            self._values = grown
        self._values[place] = row
        self._statuses.pop(place, None)
        if status != COMPLETED:
            self._statuses[place] = status

    def _open(self, folder: Path) -> None:
        check_target(folder / JOURNAL, "--output")
        folder.mkdir(parents=True, exist_ok=True)
        remove_abandoned(folder)
        self._handle = os.open(folder / JOURNAL, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o644)
        try:
            _refuse_second(self._handle, folder)
            for path in sorted(folder.glob(CHUNKS)):
                for key, row, status in _read_chunk(path, self.outputs):
                    self._hold(key, row, status)
            left = _read_journal(folder / JOURNAL, len(self.outputs))
            for key, row, status in left:
                if key not in self._places:
                    self._journalled.append(key)
                self._hold(key, row, status)
            if left or (folder / JOURNAL).stat().st_size:
                self.flush()
                os.ftruncate(self._handle, 0)
        except BaseException:
            os.close(self._handle)
            self._handle = -1
            raise


_Row = tuple[bytes, list[float], Status]


def _refuse_second(handle: int, folder: Path) -> None:
    try:
        import fcntl
    except ImportError:
        return
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        raise InputError(
            f"another process works on the points in '{str(folder)[:120]}'; wait for it, or give another folder"
        ) from None


def _line(key: bytes, row: Sequence[float], status: Status) -> bytes:
    """One point as a line: checksum, then JSON with the values to the last bit."""
    own: dict[str, Any] = {"key": key.hex(), "values": [value.hex() for value in row]}
    if status != COMPLETED:
        own["status"] = [status.code, status.message, status.time, status.where, status.remedy]
    text = json.dumps(own).encode()
    return digest(text).encode() + b" " + text + b"\n"


def _read_journal(path: Path, outputs: int) -> list[_Row]:
    """Whole lines of a journal; one that is not whole, where a process was killed, ends it."""
    found: list[_Row] = []
    for line in path.read_bytes().split(b"\n")[:-1]:
        checksum, _, text = line.partition(b" ")
        if digest(text).encode() != checksum:
            break
        own = json.loads(text)
        row = [float.fromhex(value) for value in own["values"]]
        if len(row) == outputs:
            found.append(
                (
                    bytes.fromhex(own["key"]),
                    row,
                    Status(*own["status"]) if "status" in own else COMPLETED,
                )
            )
    return found


def _chunk(
    keys: Sequence[bytes],
    values: np.ndarray[Any, Any],
    statuses: Sequence[Status],
    outputs: Sequence[str],
) -> bytes:
    codes = np.array([STATUS_CODES.index(one.code) for one in statuses], dtype=np.int8)
    told = {
        str(n): [one.message, one.time, one.where, one.remedy]
        for n, one in enumerate(statuses)
        if one != COMPLETED
    }
    text = json.dumps(
        {"form": _FORM, "outputs": list(outputs), "sentences": told, "codes": list(STATUS_CODES)},
        sort_keys=True,
    )
    arrays = ChannelArrays(
        {
            "key": Variable(("point", "byte"), np.frombuffer(b"".join(keys), dtype=np.uint8).reshape(len(keys), -1), {}),
            "value": Variable(("point", "output"), np.ascontiguousarray(values), {"long_name": "outputs, SI"}),
            "status": Variable(("point",), codes, {"long_name": "place of the status among its codes"}),
        }, {},
    )  # fmt: skip
    stream = io.BytesIO()
    write_arrays(stream, arrays, {_TEXT: text})
    content = stream.getvalue()
    return content + closing_line(content)


def _read_chunk(path: Path, outputs: Sequence[str]) -> Iterator[_Row]:
    """Points of a chunk, none where its outputs are others. Raises :class:`InputError` for a file
    that is not as it was written.
    """
    import h5py

    content, closed = checked_content(path)
    remedy = "remove the file, and its points are computed again"
    if not closed:
        raise InputError(f"is damaged: its closing line is missing; {remedy}", str(path))
    try:
        with h5py.File(io.BytesIO(content), "r") as file:
            text = file[_TEXT][()]
            keys, values, codes = file["key"][...], file["value"][...], file["status"][...]
        told: Mapping[str, Any] = json.loads(text)
        if told["form"] != _FORM:
            raise ValueError("form")
        if tuple(told["outputs"]) != tuple(outputs):
            return
        names, sentences = told["codes"], told["sentences"]
        rows = [
            (
                keys[n].tobytes(),
                values[n].tolist(),
                Status(names[codes[n]], *sentences[str(n)]) if str(n) in sentences else COMPLETED,
            )
            for n in range(len(keys))
        ]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(
            f"is no chunk of a study's points ({type(error).__name__}); {remedy}", str(path)
        ) from error
    yield from rows


#: Folders that show, read or ask and compute no point: a change there makes no stored point stale.
_NOT_COMPUTING = (
    "cli",
    "report",
    "validation",
    "workbench",
    "lift",
    "spring_card",
    "scan",
    "film",
    "rig",
    "compare_test",
)
_NOT_COMPUTING_FILES = re.compile(r"_(page|charts|command|summary)\.py$")


def computing_sources() -> list[Path]:
    """Source files whose change can move the numbers of a point, in order."""
    root = Path(__file__).parents[1]
    return [
        path
        for path in sorted(root.rglob("*.py"))
        if path.relative_to(root).parts[0] not in _NOT_COMPUTING
        and not _NOT_COMPUTING_FILES.search(path.name)
    ]


@cache
def versions_digest() -> str:
    """A digest of all that computes: source text, versions of Python and of the libraries, kind of
    machine.
    """
    origin = collect_provenance("", "")
    told = hashlib.blake2b(digest_size=16)
    for words in (
        origin.package_version,
        origin.python_version,
        *map(str, sorted(origin.dependencies.items())),
        platform.machine(),
    ):
        told.update(words.encode() + b"\0")
    for path in computing_sources():
        told.update(path.read_bytes() + b"\0")
    return told.hexdigest()
