"""A script that starts a program and sees to it that the program never outlives the process it
works for.

``guardian.py FOLDER PROGRAM ...``: when the pipe on standard input closes, because its master let
it go or was killed, the program is
killed with all that it started, and the work folder removed. It runs alone and needs the
standard library alone.
"""

from __future__ import annotations

import ctypes
import os
import select
import shutil
import signal
import sys
from contextlib import suppress

_ASKS = ("SIGINT", "SIGTERM", "SIGHUP")
_PR_SET_PDEATHSIG = 1


def main(folder: str, program: list[str]) -> int:
    """Guard ``program`` in ``folder``; its exit code, negative where a signal ended it."""
    for name in _ASKS:
        signal.signal(
            getattr(signal, name), signal.SIG_IGN
        )  # the master decides; when it ends, so does this
    woken, wakes = os.pipe()
    os.set_blocking(wakes, False)
    signal.signal(signal.SIGCHLD, lambda *_: None)
    signal.set_wakeup_fd(wakes)
    child = os.fork()
    if child == 0:
        _become(program)
    while True:
        ended, state = os.waitpid(child, os.WNOHANG)
        if ended:
            with suppress(
                ProcessLookupError, PermissionError
            ):  # what the program started, where somebody killed the program alone
                os.killpg(child, signal.SIGKILL)
            return os.waitstatus_to_exitcode(state)
        if 0 in select.select([0, woken], [], [], 1.0)[0]:
            for kill in (os.killpg, os.kill):
                with suppress(ProcessLookupError, PermissionError):
                    kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
            shutil.rmtree(folder, ignore_errors=True)
            return -signal.SIGKILL


def _become(program: list[str]) -> None:
    """In the forked process: be the program, in a group of its own, ended by the system where the
    guardian is killed itself.
    """
    try:
        signal.set_wakeup_fd(-1)
        for name in (*_ASKS, "SIGCHLD"):
            signal.signal(getattr(signal, name), signal.SIG_DFL)
        os.setpgid(0, 0)
        if sys.platform == "linux":
            with suppress(AttributeError, OSError):
                ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        os.execvp(program[0], program)
    finally:
        os._exit(127)


if __name__ == "__main__":
    code = main(sys.argv[1], sys.argv[2:])
    sys.exit(code if code >= 0 else 128 - code)
