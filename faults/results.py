"""Damaged result files: bytes exchanged, and answers that lie under a right checksum."""

from __future__ import annotations

import json
import tempfile
from functools import cache
from pathlib import Path
from random import Random
from typing import Any

import numpy as np

from faults import inputs
from faults.questions import Finding, command, refused
from valvetrain.errors import InputError
from valvetrain.solution.atomic import closing_line, digest

#: What is damaged: numbers of a run, a curve, frequencies, the answer and the case of a saved run.
KINDS = ("multi-mass-*.nc", "static-*.nc", "modes-*.nc", "run.json", "inputs/case.toml")
RUN = ("run", "job-t", "--model", "multi-mass", "--workers", "1", "--no-report", "--quiet")


@cache
def whole() -> dict[str, bytes]:
    """One whole file of each kind, of a run made here."""
    with tempfile.TemporaryDirectory() as folder:
        assert command(*RUN, "--output", f"{folder}/out")[0] == 0
        return {kind: next(Path(folder, "out").glob(kind)).read_bytes() for kind in KINDS}


def mutant(chance: Random) -> bytes:
    """A line that says kind and manner, then the bytes of the damaged file."""
    kind = chance.choice((*KINDS, "run.json"))
    content, lies = whole()[kind], chance.random() < 0.4
    if lies and kind == "run.json":
        return b"run.json lying\n" + _lying(chance, json.loads(content))
    if lies and kind.endswith(".nc"):
        body = inputs.damaged(chance, content[: -len(closing_line(b""))])
        return f"{kind} lying\n".encode() + body + chance.choice((closing_line(body), b""))
    return f"{kind} damaged\n".encode() + inputs.damaged(chance, content)


def _lying(chance: Random, answer: dict[str, Any]) -> bytes:
    """An answer with a few values exchanged, under the checksum of these."""
    del answer["checksum"]
    try:
        answer = inputs.mutated(chance, answer, mild=0.4)
        answer["checksum"] = digest(json.dumps(answer, sort_keys=True).encode())
        return json.dumps(answer).encode()
    except (ValueError, RecursionError):
        return b"[" * 100_000


def ask(content: bytes) -> str:
    """Read a damaged file by its reader: it refuses in a sentence, or gives what the whole one gives."""
    head, _, body = content.partition(b"\n")
    kind, manner = head.decode().split()
    if kind in KINDS[3:]:
        return _ask_folder(kind, manner, body)
    found = []
    for name, part in (("whole.nc", whole()[kind]), ("damaged.nc", body)):
        Path(name).write_bytes(part)
        try:
            found.append(_load(kind, Path(name)))
        except InputError as error:
            return refused(error)
    if manner == "damaged" and not _same(*found):
        raise Finding("damage was read as data")
    return "answered"


def _load(kind: str, path: Path) -> Any:
    from valvetrain.solution import netcdf

    return netcdf.load_result(path)


def _same(one: Any, other: Any) -> bool:
    if hasattr(one, "identical"):
        return bool(one.identical(other))
    pairs = [(getattr(one, name), getattr(other, name)) for name in one.__dataclass_fields__]
    return all(np.array_equal(a, b) if isinstance(a, np.ndarray) else a == b for a, b in pairs)


def _ask_folder(kind: str, manner: str, body: bytes) -> str:
    """Two saved runs, one of them damaged: listed, checked and compared."""
    for name in ("whole", "damaged"):
        for part in KINDS[3:]:
            path = Path("runs", "job-t", name, part)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(body if (name, part) == ("damaged", kind) else whole()[part])
    codes = [command("runs")[0], command("check", "runs/job-t/damaged")[0]]
    code, out, said = command("compare-runs", "runs/job-t/whole", "runs/job-t/damaged")
    if not {*codes, code} <= {0, 2}:
        raise Finding(f"exit codes {codes} {code}: {said[-200:]}")
    if manner == "damaged" and code == 0 and out.count("are the same") < 2:
        raise Finding(f"damage was taken for a difference: {out[:300]}")
    return "refused" if code else "answered"
