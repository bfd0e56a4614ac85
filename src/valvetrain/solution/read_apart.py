"""Untrusted files (without a checksum) are tried in a process of its own: the library of the format
may hang or crash.
"""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
import threading
import time
import warnings
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Any, NoReturn

from valvetrain.errors import InputError

#: Bytes of memory and seconds of processor time for one file, and file size that adds one second.
MAX_MEMORY, MAX_SECONDS, BYTES_A_SECOND = 4_000_000_000, 10, 50_000_000
#: Wall time over processor time: the machine may be busy.
_PATIENCE = 6
#: Seconds before a process that a full machine did not start is tried again.
_PAUSES = (0.5, 3.0)
#: How a trial ends: the reader returned, or raised an InputError; it needed too much memory; it
#: raised anything else; killed.
_READ, _TOO_LARGE, _UNREADABLE, _ENDED = 0, 3, 4, -1
#: Output of a trial once the reader is loaded: what ends it from then on is caused by the file.
_BEGUN = b"begun"


def tried_apart(reader: str, path: Path, where: str, unreadable: str) -> None:
    """Call a reader (``module:function``, of one path) in a process of its own, and refuse a file
    from which it does not return.

    Its result is dropped, as is an :class:`InputError` of its own: the caller calls it again, now
    that it is known to end. Raises :class:`InputError` for bytes that crash or hang the process or
    need more than :data:`MAX_MEMORY`, with the sentence ``unreadable`` for those at which the
    reader raises anything else, and where no such process can be started.
    """
    seconds = MAX_SECONDS + path.stat().st_size // BYTES_A_SECOND
    tried = in_a_new_process(reader, path, seconds)
    end = tried if isinstance(tried, int) else in_a_fork(reader, path, seconds)
    if end is None:
        raise InputError(
            f"is not read, for files of others are tried in a process of their own, and {no_interpreter(str(tried))}",
            where,
        )
    if end == _TOO_LARGE:
        raise InputError(
            f"is damaged: reading it needs more than {MAX_MEMORY / 1e9:g} GB; write it again",
            where,
        )
    if end == _UNREADABLE:
        raise InputError(unreadable, where)
    if end != _READ:
        raise InputError(
            "is damaged: the library of the format does not come back from reading it; write it again",
            where,
        )


def no_interpreter(reason: str = "") -> str:
    """Message that no process of Python can be started here; ``reason``: how the one that was tried
    ended.
    """
    python, ended = str(sys.executable)[-80:], f" ({reason})" if reason else ""
    return f"'{python}' (sys.executable) does not start as a Python that finds the reader{ended}; set it to one, or use the command line"


def in_a_new_process(reader: str, path: Path, seconds: int) -> int | str:
    """How the trial ended; a text where it did not begin: no interpreter, or one that does not find
    the reader.

    A process that the system could not start or ended before it began, as a full machine does, is
    tried again.
    """
    end = _in_a_new_process(reader, path, seconds)
    for pause in _PAUSES:
        if not isinstance(end, _Passing):
            break
        time.sleep(pause)
        end = _in_a_new_process(reader, path, seconds)
    return end


class _Passing(str):
    """Why a trial did not begin, where a later one may."""


def _in_a_new_process(reader: str, path: Path, seconds: int) -> int | str:
    command = [
        sys.executable,
        "-P",
        "-c",
        f"from {__name__} import serve; serve()",
        reader,
        str(path.absolute()),
        str(seconds),
    ]
    try:
        done = subprocess.run(
            command,
            timeout=_PATIENCE * seconds,
            env=apart_environment(),
            check=False,
            stdin=subprocess.DEVNULL,
            capture_output=True,
        )
    except subprocess.TimeoutExpired as late:
        return _ENDED if late.stdout == _BEGUN else f"not ready after {_PATIENCE * seconds} s"
    except OSError as error:
        passing = error.errno in (errno.EAGAIN, errno.ENOMEM)
        return (_Passing if passing else str)(error.strerror or "the system does not start it")
    except TypeError:
        return "there is none"
    if done.stdout == _BEGUN:
        return int(done.returncode)
    if done.returncode < 0:
        return _Passing(f"ended by signal {-done.returncode} before it began")
    last = done.stderr.decode(errors="replace").strip().splitlines()[-1:]
    return (
        "".join(char if char.isprintable() else " " for char in last[0][:120])
        if last
        else f"ended with status {done.returncode}"
    )


def in_a_fork(reader: str, path: Path, seconds: int) -> int | None:
    """As :func:`in_a_new_process`, in a fork of this one, which needs no interpreter; None where
    that is not safe.

    Locks of other threads would stay locked in the fork; some systems have no forks.
    """
    if not hasattr(os, "fork") or threading.active_count() > 1:
        return None
    try:
        function = _function(reader)
    except ImportError:
        return None
    with warnings.catch_warnings(
        action="ignore"
    ):  # threads of the numerical libraries, which hold no locks now
        child = os.fork()
    if not child:
        _try(function, path, seconds)
    last = time.monotonic() + _PATIENCE * seconds
    with suppress(ChildProcessError):  # of a caller that ignores the ends of its children
        while not (ended := os.waitpid(child, os.WNOHANG))[0]:
            if time.monotonic() > last:
                os.kill(child, signal.SIGKILL)
            time.sleep(0.001)
        return os.waitstatus_to_exitcode(ended[1])
    return None


def apart_environment() -> dict[str, str]:
    """Environment of such a process: import paths of the caller, no plugins of HDF5, one thread."""
    paths = os.pathsep.join(os.path.abspath(part or ".") for part in sys.path)
    return os.environ | {
        "PYTHONPATH": paths,
        "HDF5_PLUGIN_PRELOAD": "::",
        "OPENBLAS_NUM_THREADS": "1",
        "OMP_NUM_THREADS": "1",
    }


def serve() -> None:
    """Entry of the process: read the file of the arguments within bounds; the exit status says how
    that ended.
    """
    reader, path, seconds = sys.argv[1:4]
    function = _function(reader)
    os.write(1, _BEGUN)
    for stream in (1, 2):  # drop what a library prints
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream)
    _try(function, Path(path), int(seconds))


def _function(reader: str) -> Any:
    module, _, name = reader.partition(":")
    return getattr(import_module(module), name)


def _try(function: Any, path: Path, seconds: int) -> NoReturn:
    """End this process with the status of reading the file."""
    end = _UNREADABLE
    try:
        bound_process(MAX_MEMORY + _mapped(), seconds)
        function(path)
        end = _READ
    except InputError:  # which the reader raises again for the caller
        end = _READ
    except MemoryError:
        end = _TOO_LARGE
    finally:
        os._exit(end)


def _mapped() -> int:
    """Bytes that this process has mapped before it reads, 0 where the system does not report them."""
    with suppress(OSError, ValueError):
        return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0]) * os.sysconf(
            "SC_PAGE_SIZE"
        )
    return 0


def bound_process(memory: int, seconds: int) -> None:
    """Bound memory (bytes) and processor time (s) of this process, where the system can, within its
    present bounds.
    """
    with suppress(ImportError):
        import resource

        for name, value in (("RLIMIT_AS", memory), ("RLIMIT_CPU", seconds), ("RLIMIT_CORE", 0)):
            with suppress(AttributeError, ValueError, OSError):
                kind = getattr(resource, name)
                present = resource.getrlimit(kind)
                finite = (own for own in present if own != resource.RLIM_INFINITY)
                bound = min([value, *finite])
                resource.setrlimit(kind, (bound, bound))
