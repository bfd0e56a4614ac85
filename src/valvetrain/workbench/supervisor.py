"""The process between a server and one job: it runs the command line, bounds its time and memory,
and ends it with the server.

``python -m valvetrain.workbench.supervisor SECONDS BYTES LOCK WORD...`` runs ``valvetrain WORD...``
and locks the file LOCK as long as it
lives. Standard input is the lifeline: when it
ends, because the server closed it or was killed, the job is requested to stop, saves what it finished,
and is killed where it does not obey.
It computes nothing of the package.
"""

from __future__ import annotations

import ctypes
import json
import os
import select
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

from valvetrain.solution.atomic import lock

#: What a job is given to write what it finished, once it is requested to stop; time between two looks
#: at the server, and at the memory (s).
GRACE, LOOK, WEIGH = 15.0, 0.1, 0.5
#: What is run: the command line of this package.
PROGRAM = [sys.executable, "-m", "valvetrain"]
#: Exit codes of this process in addition to those of the command line: ended for its time, for its memory.
TIME_UP, MEMORY_UP = 64, 65
#: Address space that libraries reserve and never touch (bytes).
RESERVED = 4e9
_stop: list[int] = []
_PR_SET_PDEATHSIG, _KILL = 1, getattr(signal, "SIGKILL", signal.SIGTERM)


def main(arguments: list[str]) -> int:
    """Run the command line with ``arguments[3:]``, at most ``arguments[0]`` seconds and ``arguments[1]`` bytes;
    its exit code or one of those above.
    """
    seconds, memory = float(arguments[0]), float(arguments[1])
    held = os.open(arguments[2], os.O_RDWR | os.O_CREAT, 0o600)
    lock(held)
    begun, stop_time, reason, weighed = time.monotonic(), 0.0, 0, 0.0
    with suppress(ValueError):
        for name in ("SIGTERM", "SIGINT"):
            signal.signal(getattr(signal, name), lambda *_: _stop.append(1))
    lifeline = sys.stdin.fileno()
    progress = os.environ.get("VALVETRAIN_PROGRESS", "")
    job = subprocess.Popen(
        [*PROGRAM, *arguments[3:]], stdin=subprocess.DEVNULL, close_fds=True,
        pass_fds=(int(progress),) if progress.isdecimal() else (), preexec_fn=(lambda: _bound(memory)) if os.name == "posix" else None,
        start_new_session=True,
    )  # fmt: skip
    while job.poll() is None:
        if not stop_time:
            now = time.monotonic()
            if now - begun > seconds:
                reason = TIME_UP
            elif now - weighed > WEIGH:
                reason, weighed = MEMORY_UP if memory_of_group(job.pid) > memory else 0, now
            if reason or _stop or _ended(lifeline):
                stop_time = time.monotonic()
                with suppress(OSError):
                    job.send_signal(signal.SIGTERM)
            continue
        if time.monotonic() - stop_time > (GRACE if reason != MEMORY_UP else GRACE / 4):
            _kill_group(job)
        time.sleep(LOOK)
    code = job.wait()
    _kill_group(job)  # workers that a job left behind
    os.close(held)
    return reason or (code if code >= 0 else 128 - code)


def _ended(lifeline: int) -> bool:
    """Whether the server is gone; waits a little for it."""
    ready, _, _ = select.select([lifeline], [], [], LOOK)
    return bool(ready) and not os.read(lifeline, 1024)


def _bound(memory: float) -> None:
    """In the new process, before it begins: bounded memory, and an end with this process."""
    bound_memory(memory + RESERVED)
    if sys.platform == "linux":
        with suppress(AttributeError, OSError):
            ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


def bound_memory(most: float) -> None:
    """Give this process no more address space than ``most`` (bytes), and no core dumps."""
    with suppress(ImportError):
        import resource

        for kind, bound in ((resource.RLIMIT_AS, int(most)), (resource.RLIMIT_CORE, 0)):
            hard = resource.getrlimit(kind)[1]
            least = bound if hard == resource.RLIM_INFINITY else min(bound, hard)
            with suppress(ValueError, OSError):
                resource.setrlimit(kind, (least, least))


def _kill_group(job: subprocess.Popen[bytes]) -> None:
    """Kill the job with every worker of its own."""
    with suppress(OSError, AttributeError):
        os.killpg(job.pid, _KILL)
    with suppress(OSError):
        job.kill()


def memory_of_group(group: int) -> float:
    """Bytes of memory that the processes of a ``group`` hold, pages they share counted once each; 0
    where the system does not report it.
    """
    total = 0.0
    for entry in Path("/proc").glob("[0-9]*"):
        with suppress(OSError, ValueError, IndexError):
            if os.getpgid(int(entry.name)) == group:
                fields = (entry / "statm").read_text("ascii").split()
                total += (int(fields[1]) - int(fields[2])) * os.sysconf("SC_PAGE_SIZE")
    return total


def read_progress(line: bytes) -> tuple[float | None, str] | None:
    """Share and text of a line of progress; None for one that is none."""
    try:
        message = json.loads(line)
        share, text = message["share"], str(message["text"])[:200]
        return (None if share is None else min(1.0, max(0.0, float(share)))), text
    except (ValueError, KeyError, TypeError):
        return None


if __name__ == "__main__":
    code = main(sys.argv[1:])
    with suppress(OSError):
        sys.stdout.flush()
    sys.exit(code)
