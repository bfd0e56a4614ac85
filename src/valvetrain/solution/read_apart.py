"""Untrusted files (without a checksum) are tried in a process of its own: the library of the format
may hang or crash.
"""

from __future__ import annotations

import errno
import os
import subprocess
import sys
import time
from contextlib import suppress
from importlib import import_module
from pathlib import Path

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


def tried_apart(reader: str, path: Path, where: str, unreadable: str, seconds: int = 0) -> None:
    """Call a reader (``module:function``, of one path) in a process of its own, and refuse a file
    from which it does not return.

    Its result is dropped, as is an :class:`InputError` of its own: the caller calls it again, now
    that it is known to end. Raises :class:`InputError` for bytes that crash or hang the process or
    need more than :data:`MAX_MEMORY` or ``seconds`` (0: :data:`MAX_SECONDS`), with the sentence ``unreadable`` for those at which the
    reader raises anything else, and where no such process can be started.
    """
    seconds = (seconds or MAX_SECONDS) + path.stat().st_size // BYTES_A_SECOND
    end = _in_a_new_process(reader, path, seconds)
    if isinstance(end, str):
        raise InputError(
            f"is not read, for files of others are tried in a process of their own, and '{str(sys.executable)[-80:]}' "
            f"(sys.executable) does not start as a Python that finds the reader ({end}); set it to one, or use the command line",
            where,
        )
    sentences = {
        _TOO_LARGE: f"is damaged: reading it needs more than {MAX_MEMORY / 1e9:g} GB; write it again",
        _UNREADABLE: unreadable,
    }
    if end != _READ:
        lost = "is damaged: the library of the format does not come back from reading it; write it again"
        raise InputError(sentences.get(end, lost), where)


def _in_a_new_process(reader: str, path: Path, seconds: int) -> int | str:
    """How the trial ended; a text where it did not begin: no interpreter, or one that does not find
    the reader. What a full machine did not start, or ended before it began, is tried again.
    """
    code = f"from {__name__} import serve; serve()"
    command = [str(sys.executable), "-P", "-c", code, reader, str(path.absolute()), str(seconds)]
    paths = os.pathsep.join(os.path.abspath(part or ".") for part in sys.path)
    threads = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    # import paths of the caller, no plugins of HDF5
    environment = os.environ | threads | {"PYTHONPATH": paths, "HDF5_PLUGIN_PRELOAD": "::"}
    reason = "there is none"
    for pause in (*_PAUSES, 0.0):
        try:
            done = subprocess.run(
                command, timeout=_PATIENCE * seconds, env=environment, check=False, stdin=subprocess.DEVNULL, capture_output=True
            )  # fmt: skip
        except subprocess.TimeoutExpired as late:
            return _ENDED if late.stdout == _BEGUN else f"not ready after {_PATIENCE * seconds} s"
        except OSError as error:
            reason = error.strerror or "the system does not start it"
            if error.errno not in (errno.EAGAIN, errno.ENOMEM):
                return reason
        else:
            if done.stdout == _BEGUN:
                return int(done.returncode)
            if done.returncode >= 0:
                last = done.stderr.decode(errors="replace").strip().splitlines()[-1:]
                reason = last[0][:120] if last else f"ended with status {done.returncode}"
                return "".join(char if char.isprintable() else " " for char in reason)
            reason = f"ended by signal {-done.returncode} before it began"
        time.sleep(pause)
    return reason


def serve() -> None:
    """Entry of the process: read the file of the arguments within bounds; the exit status says how
    that ended.
    """
    reader, path, seconds = sys.argv[1:4]
    module, _, name = reader.partition(":")
    function, end = getattr(import_module(module), name), _UNREADABLE
    os.write(os.dup(1), _BEGUN)  # the copy keeps the pipe open: a timeout then tells what it read
    for stream in (1, 2):  # drop what a library prints
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream)
    mapped = 0  # bytes that this process has before it reads, where the system reports them
    with suppress(OSError, ValueError):
        pages = Path("/proc/self/statm").read_text(encoding="ascii").split()[0]
        mapped = int(pages) * os.sysconf("SC_PAGE_SIZE")
    try:
        bound_process(MAX_MEMORY + mapped, int(seconds))
        function(Path(path))
        end = _READ
    except InputError:  # which the reader raises again for the caller
        end = _READ
    except MemoryError:
        end = _TOO_LARGE
    finally:
        os._exit(end)


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
