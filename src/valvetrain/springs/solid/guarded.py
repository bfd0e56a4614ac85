"""The solver as a program that ends with this process, however that ends, and work folders that
nobody leaves behind.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import IO

from valvetrain.solution.atomic import is_abandoned, lock

#: Begin of the names of work folders, and the file in each that its maker keeps locked.
PREFIX, LOCK = "valvetrain-solid-", ".in-use"
GUARDIAN = Path(__file__).with_name("guardian.py")


def start(
    program: Sequence[str], folder: str, environment: dict[str, str], log: IO[bytes]
) -> subprocess.Popen[bytes]:
    """Start ``program`` in ``folder``, its words in ``log``. Where there are forks, a guardian
    stands between: it ends with this
    process, and the program with it. Out of the terminal's group, Ctrl-C reaches neither;
    :func:`end` ends both."""
    guard = [sys.executable, "-I", "-S", str(GUARDIAN), folder] if hasattr(os, "fork") else []
    return subprocess.Popen(
        [*guard, *program],
        cwd=folder,
        env=environment,
        stdin=subprocess.PIPE,
        stdout=log,
        stderr=subprocess.STDOUT,
        start_new_session=bool(guard),
    )


def end(process: subprocess.Popen[bytes], patience: float = 10.0) -> None:
    """End what :func:`start` began, if it still runs."""
    assert process.stdin is not None
    with suppress(OSError):
        process.stdin.close()  # tells the guardian
    if hasattr(os, "fork"):
        with suppress(subprocess.TimeoutExpired):
            process.wait(patience)
    if process.poll() is None:
        process.kill()
        process.wait()


@contextmanager
def work_folder() -> Iterator[str]:
    """A temporary folder, removed at the end; those that killed processes left are removed first."""
    _sweep()
    with tempfile.TemporaryDirectory(prefix=PREFIX, ignore_cleanup_errors=True) as folder:
        handle = os.open(Path(folder, LOCK), os.O_WRONLY | os.O_CREAT, 0o600)
        try:
            lock(handle)
            yield folder
        finally:
            os.close(handle)


@cache
def _sweep() -> None:
    """Once per process: remove this user's work folders whose makers are gone."""
    with suppress(OSError):
        for folder in Path(tempfile.gettempdir()).glob(f"{PREFIX}*"):
            if (
                not folder.is_symlink()
                and (not hasattr(os, "getuid") or folder.lstat().st_uid == os.getuid())
                and is_abandoned(folder / LOCK)
            ):
                shutil.rmtree(folder, ignore_errors=True)
