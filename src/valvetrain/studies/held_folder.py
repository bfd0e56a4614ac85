"""A folder that one command writes into: taken before its work begins, so that two begun at the
same moment never mix their files.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from valvetrain.errors import InputError
from valvetrain.solution.atomic import lock
from valvetrain.units.text import clipped


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
