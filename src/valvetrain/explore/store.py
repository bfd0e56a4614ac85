"""The store of finished points: an append-only file of JSON lines, each with a checksum of its own.

A killed process leaves at most one line that is not whole; it and what is behind it are computed
again. Studies, searches and identifications store their points in the same way.
"""

from __future__ import annotations

import hashlib
import json
import os
import platform
import re
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.explore.outputs import Outcome
from valvetrain.solution.atomic import append_whole, check_target, digest, lock, remove_abandoned
from valvetrain.solution.provenance import collect_provenance
from valvetrain.solution.status import COMPLETED, Status

Array = NDArray[np.float64]
#: Numbers of a point by name (SI); None for a point that cannot be computed.
Numbers = Mapping[str, float] | None
#: Name of the file in the folder of the points.
FILE = "points.jsonl"
#: First line of a file whose keys are digests of all that a point depends on.
BY_DIGEST = "valvetrain points by digest"
#: Ends of a point that a second trial may change: they are not written.
NOT_WRITTEN = ("worker-lost", "interrupted")
IMPOSSIBLE = Status("refused", "the point cannot be computed")
_CHECKSUM = 16


class Store:
    """Finished points by their keys, in a file of ``folder`` (None: in memory only). Use it as a
    context.

    ``identity``: what the outcomes depend on where the keys do not say it; a file of another one is
    refused, and so is one that another process writes. ``before``: points that were in the file;
    ``computed``: those that came since. ``at_a_time``: most points that :meth:`through` computes
    before it writes them, 0 for all of a batch.

    >>> with Store(None) as store:
    ...     store.add(b"one", Outcome(values={"peak_spring_force": 510.0}))
    ...     store.outcome(b"one")["peak_spring_force"]
    510.0
    """

    def __init__(self, folder: Path | None, identity: str = BY_DIGEST) -> None:
        self.folder = folder
        self.computed = self.before = self.at_a_time = 0
        self._names: dict[tuple[str, ...], tuple[str, ...]] = {}
        #: (names, a value each), with the status in front where it is not completed: compact
        self._points: dict[bytes, tuple[Any, ...]] = {}
        self._handle = -1
        if folder is not None:
            self._open(folder, identity)

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __len__(self) -> int:
        return len(self._points)

    def __contains__(self, key: bytes) -> bool:
        return key in self._points

    def outcome(self, key: bytes) -> Outcome:
        """The outcome of a stored point."""
        status, names, values = self._parts(key)
        return Outcome(status, dict(zip(names, values, strict=True)))

    def numbers(self, key: bytes) -> Numbers:
        """The numbers of a stored point; None where it did not complete."""
        status, names, values = self._parts(key)
        return dict(zip(names, values, strict=True)) if status.completed else None

    def add(self, key: bytes, outcome: Outcome) -> None:
        """Store a finished point; it survives a kill of this process after the return."""
        self._remember(key, outcome)
        self.computed += 1
        if self._handle >= 0 and outcome.status.code not in NOT_WRITTEN:
            append_whole(self._handle, _line(_record(key, outcome)))

    def close(self) -> None:
        """Bring the file to the disk and give it free for the next process."""
        if self._handle >= 0:
            try:
                os.fsync(self._handle)
            finally:
                os.close(self._handle)
                self._handle = -1

    def through(
        self, evaluate: Callable[[Array], Sequence[Numbers]], part: bytes = b""
    ) -> Callable[[Array], list[Numbers]]:
        """``evaluate`` with every point computed once; ``part`` separates several computations of
        the same points. The key of a point is the bytes of its values.
        """

        def stored(points: Array) -> list[Numbers]:
            keys = [part + key_of(point) for point in points]
            missing = {key: row for row, key in enumerate(keys) if key not in self._points}
            new = list(missing.items())
            size = self.at_a_time or max(len(new), 1)
            for first in range(0, len(new), size):
                batch = new[first : first + size]
                found = evaluate(points[[row for _, row in batch]])
                for (key, _), numbers in zip(batch, found, strict=True):
                    self.add(key, Outcome(IMPOSSIBLE) if numbers is None else _outcome(numbers))
            return [self.numbers(key) for key in keys]

        return stored

    def points(self, quantities: int) -> list[tuple[Array, Numbers]]:
        """Values of ``quantities`` and numbers of every point of :meth:`through` without a
        part.
        """
        return [
            (np.frombuffer(key, dtype=float), self.numbers(key))
            for key in self._points
            if len(key) == 8 * quantities
        ]

    def _parts(self, key: bytes) -> tuple[Status, tuple[str, ...], tuple[float, ...]]:
        first, *rest = self._points[key]
        if isinstance(first, Status):
            return first, rest[0], tuple(rest[1:])
        return COMPLETED, first, tuple(rest)

    def _remember(self, key: bytes, outcome: Outcome) -> None:
        names = tuple(outcome.values)
        names = self._names.setdefault(names, names)
        compact = (names, *map(float, outcome.values.values()))
        self._points[key] = compact if outcome.status == COMPLETED else (outcome.status, *compact)

    def _open(self, folder: Path, identity: str) -> None:
        path = folder / FILE
        check_target(path, "output")
        folder.mkdir(parents=True, exist_ok=True)
        remove_abandoned(folder)
        self._handle = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o666)
        try:
            if not lock(self._handle):
                raise InputError(
                    "another process works on the points there; wait for it, or choose another folder",
                    str(folder)[:120],
                )
            self._read(path, identity)
        except BaseException:
            os.close(self._handle)
            self._handle = -1
            raise

    def _read(self, path: Path, identity: str) -> None:
        end = 0
        with path.open("rb") as file:
            for number, line in enumerate(file):
                record = _content(line)
                if record is None:
                    break
                if number:
                    self._remember(*_point(record))
                elif record != identity:
                    raise InputError(_other(str(record), identity), str(path))
                end += len(line)
        self.before = len(self._points)
        os.ftruncate(self._handle, end)
        if end == 0:
            append_whole(self._handle, _line(identity))


def key_of(point: Array) -> bytes:
    """The bytes of a point's values."""
    return np.ascontiguousarray(point, dtype=float).tobytes()


def _outcome(numbers: Mapping[str, float]) -> Outcome:
    return Outcome(values={name: float(value) for name, value in numbers.items()})


def _record(key: bytes, outcome: Outcome) -> list[Any]:
    status = outcome.status
    if status == IMPOSSIBLE:
        return [key.hex(), None]
    reported: list[Any] = [key.hex(), dict(outcome.values)]
    if status != COMPLETED:
        reported.append([status.code, status.message, status.time, status.where, status.remedy])
    return reported


def _point(record: Sequence[Any]) -> tuple[bytes, Outcome]:
    key, values, *status = record
    if values is None:
        return bytes.fromhex(key), Outcome(IMPOSSIBLE)
    return bytes.fromhex(key), Outcome(Status(*status[0]) if status else COMPLETED, values)


def _line(record: object) -> bytes:
    body = json.dumps(record, separators=(",", ":")).encode()
    return digest(body)[:_CHECKSUM].encode() + b" " + body + b"\n"


def _content(line: bytes) -> Any:
    """The record of a line; None where its bytes are not those that were written."""
    body = line[_CHECKSUM + 1 : -1]
    if (
        not line.endswith(b"\n")
        or line[: _CHECKSUM + 1] != digest(body)[:_CHECKSUM].encode() + b" "
    ):
        return None
    return json.loads(body)


def _other(there: str, identity: str) -> str:
    """Why a file with another first line is refused."""
    request, _, version = identity.partition(" ")
    if version and there.partition(" ")[0] == request and there != BY_DIGEST:
        return (
            "holds points that another version of valvetrain or of its libraries computed; continue with that version, or "
            "remove the file to start again"
        )
    return "holds points of another identification or of a study; give another folder"


#: Folders that compute no point: a change there makes no stored point stale.
_NOT_COMPUTING = (
    "cli findings views validation workbench lift spring_card scan film rig compare_test".split()
)
_NOT_COMPUTING_FILES = re.compile(
    r"_(page|charts|command|summary|facts|rules|answer|figures|files)\.py$"
)


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
    combined = hashlib.blake2b(digest_size=16)
    for text in (
        origin.package_version,
        origin.python_version,
        *map(str, sorted(origin.dependencies.items())),
        platform.machine(),
    ):
        combined.update(text.encode() + b"\0")
    for path in computing_sources():
        combined.update(path.read_bytes() + b"\0")
    return combined.hexdigest()
