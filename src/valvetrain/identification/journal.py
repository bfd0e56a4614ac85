"""Every evaluated point of an identification, kept as it comes: what is started again finds it and
goes the same way.

All methods are deterministic, so a search that begins anew over kept points meets the same ones
until it comes to where it was cut. Each
record is a line with its own checksum; one that a kill cut short is no record.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.identification.posterior import Evaluate, Outcome
from valvetrain.solution.atomic import digest, lock

Array = NDArray[np.float64]
NAME = "points.jsonl"
_SUM = 16


class Journal:
    """Outcomes of points by their bits, in a file of the folder ``folder``; None keeps them in
    memory alone.

    ``identity`` is what the outcomes depend on (case, file, version): a journal of another is
    refused, and so is one that another process
    writes. ``before``: points that were there; ``computed``: those that came since. ``at_a_time``:
    most points that
    are computed before they are written, 0 for all that are asked for at once. Use it as a context.
    """

    def __init__(self, folder: Path | None, identity: str) -> None:
        self._known: dict[bytes, Outcome] = {}
        self._file = None
        self.computed = self.before = self.at_a_time = 0
        if folder is None:
            return
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / NAME
        handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        self._file = os.fdopen(handle, "r+b")
        if not lock(handle):
            self._file.close()
            raise InputError(
                "another process works on this identification; wait for it, or choose another folder",
                str(folder),
            )
        try:
            self._read(identity, path)
        except BaseException:
            self._file.close()
            raise

    def __enter__(self) -> Journal:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._file is not None:
            self._file.flush()
            os.fsync(self._file.fileno())
            self._file.close()

    def __len__(self) -> int:
        return len(self._known)

    def through(self, evaluate: Evaluate, part: bytes = b"") -> Evaluate:
        """``evaluate`` with every point computed once: those that are known are read, the others
        written as they come.

        ``part`` keeps apart what several computations tell of one point.
        """

        def recorded(points: Array) -> Sequence[Outcome]:
            keys = [part + np.ascontiguousarray(point, dtype=float).tobytes() for point in points]
            new = [
                place
                for place, key in enumerate(keys)
                if key not in self._known and key not in keys[:place]
            ]
            size = self.at_a_time or max(len(new), 1)
            for first in range(0, len(new), size):
                places = new[first : first + size]
                found = evaluate(points[places])
                self._write(
                    [(keys[place], outcome) for place, outcome in zip(places, found, strict=True)]
                )
            return [self._known[key] for key in keys]

        return recorded

    def points(self, quantities: int) -> list[tuple[Array, Outcome]]:
        """Every known point (values of so many ``quantities``) and its outcome, without those of a
        part.
        """
        known = [
            (key, outcome) for key, outcome in self._known.items() if len(key) == 8 * quantities
        ]
        return [(np.frombuffer(key, dtype=float), outcome) for key, outcome in known]

    def outcome(self, point: Array) -> Outcome:
        """What is known of a point; None also of one that was never computed."""
        return self._known.get(np.ascontiguousarray(point, dtype=float).tobytes())

    def _read(self, identity: str, path: Path) -> None:
        assert self._file is not None
        end = 0
        for number, line in enumerate(self._file):
            record = _content(line)
            if record is None:
                break  # what a kill cut short, and anything behind it, is computed again
            end += len(line)
            if number == 0:
                if record != identity:
                    asked, _, version = identity.partition(" ")
                    if version and str(record).partition(" ")[0] == asked:
                        raise InputError(
                            "holds points that another version of valvetrain or of its libraries computed; go on with that version, or "
                            "remove the file to begin anew",
                            str(path),
                        )
                    raise InputError(
                        "holds points of another identification; give another folder", str(path)
                    )
            else:
                point, outcome = record
                self._known[bytes.fromhex(point)] = outcome
        self.before = len(self._known)
        self._file.truncate(end)
        self._file.seek(end)
        if end == 0:
            self._file.write(_line(identity))
            self._file.flush()

    def _write(self, found: Sequence[tuple[bytes, Outcome]]) -> None:
        lines = []
        for key, outcome in found:
            told = (
                None if outcome is None else {name: float(value) for name, value in outcome.items()}
            )
            self._known[key] = told
            lines.append(_line([key.hex(), told]))
        self.computed += len(found)
        if self._file is not None:
            self._file.write(b"".join(lines))
            self._file.flush()


def read_points(path: Path, quantities: int) -> list[tuple[Array, Outcome]]:
    """Every point of a file of computed points (values of so many ``quantities`` in SI) and its
    outcome, without those of a part.

    Raises :class:`InputError` where the file cannot be read or holds none.
    """
    try:
        with path.open("rb") as file:
            records = [_content(line) for line in file]
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", str(path)) from None
    whole = records[1 : records.index(None)] if None in records else records[1:]
    found = [
        (np.frombuffer(bytes.fromhex(key), dtype=float), outcome)
        for key, outcome in whole
        if len(key) == 16 * quantities
    ]
    if not found:
        raise InputError(f"holds no points of {quantities} quantities", str(path))
    return found


def _line(record: object) -> bytes:
    body = json.dumps(record, separators=(",", ":")).encode()
    return digest(body)[:_SUM].encode() + b" " + body + b"\n"


def _content(line: bytes) -> Any:
    """The record of a line; None where its bytes are not those that were written."""
    body = line[_SUM + 1 : -1]
    if not line.endswith(b"\n") or digest(body)[:_SUM].encode() != line[:_SUM]:
        return None
    return json.loads(body)


def finite(outcome: Outcome, key: str) -> float:
    """One number of an outcome, NaN where it is not there."""
    return math.nan if outcome is None else float(outcome.get(key, math.nan))
