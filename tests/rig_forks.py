"""Reads many damaged recordings, each in a process of its own forked from this one: ``python
rig_forks.py FOLDER COUNT SEED``.

FOLDER holds whole recordings. Prints one JSON object: name -> list of [what was done, outcome],
outcome being "read", a sentence, or
"ended SIGNAL" where the process died, which the caller of the package is told as a sentence.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
from pathlib import Path

import numpy as np

from valvetrain.errors import InputError
from valvetrain.rig.reader import MAX_SECONDS, form_of, read_here
from valvetrain.solution.read_apart import MAX_MEMORY, bound_process


def damaged(whole: bytes, random: np.random.Generator) -> tuple[str, bytes]:
    """The content cut short, with bits flipped, with bytes exchanged, or with a claim of great size
    in its head.
    """
    kind = int(random.integers(4))
    if kind == 0:
        place = int(random.integers(1, len(whole)))
        return f"cut at {place}", whole[:place]
    changed = bytearray(whole)
    head = min(len(whole), 4096)
    if kind == 1:
        places = random.integers(len(whole), size=8)
        for place in places:
            changed[place] ^= 1 << int(random.integers(8))
        return f"flipped at {places.tolist()}", bytes(changed)
    if kind == 2:
        place = int(random.integers(head))
        changed[place : place + 4] = random.bytes(4)
        return f"exchanged at {place}", bytes(changed[: len(whole)])
    place = int(random.integers(head // 8)) * 8
    changed[place : place + 8] = b"\xff\xff\xff\xff\xff\xff\xff\x7f"
    return f"claims at {place}", bytes(changed[: len(whole)])


def outcome(content: bytes, name: str) -> str:
    """What reading the content ends in."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, name)
        path.write_bytes(content)
        try:
            form_of(path, name)
        except InputError as error:
            return str(error)
        told = Path(folder, "told")
        child = os.fork()
        if not child:
            try:
                bound_process(MAX_MEMORY, MAX_SECONDS)
                os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
                os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
                sizes = [len(channel.values) for channel in read_here(path).channels]
                told.write_text(f"read {sum(sizes)}", encoding="utf-8")
            except InputError as error:
                told.write_text(str(error), encoding="utf-8")
            except BaseException as error:
                told.write_text(f"ended by {type(error).__name__}", encoding="utf-8")
            finally:
                os._exit(0)
        _, status = os.waitpid(child, 0)
        return (
            told.read_text(encoding="utf-8")
            if told.is_file()
            else f"ended {os.waitstatus_to_exitcode(status)}"
        )


def main(folder: Path, count: int, seed: int) -> None:
    """Damage and read every file of the folder ``count`` times."""
    import asammdf  # noqa: F401  so that every fork has the libraries already
    import h5py  # noqa: F401
    import nptdms  # noqa: F401
    import pyuff  # noqa: F401
    from scipy import io  # noqa: F401

    found = {}
    for path in sorted(folder.iterdir()):
        random, whole = np.random.default_rng(seed), path.read_bytes()
        made = [("nothing", whole), *(damaged(whole, random) for _ in range(count))]
        found[path.name] = [(what, outcome(content, path.name)) for what, content in made]
    print(json.dumps(found))


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
