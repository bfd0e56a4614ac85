"""Files that no checksum vouches for are tried in a process of its own: the library of the format may never come back from them."""

from __future__ import annotations

import os
import subprocess
import sys
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Any

from valvetrain.errors import InputError

#: Bytes of memory and seconds of the processor that trying one file may take, and bytes for each of which a second is added.
MOST_MEMORY, MOST_SECONDS, BYTES_A_SECOND = 4_000_000_000, 10, 50_000_000
#: Seconds of the clock for each of the processor: the machine may be busy.
_PATIENCE = 6
_TOO_LARGE = 3


def tried_apart(reader: str, path: Path, where: str) -> None:
    """Call a reader (``module:function``, of one path) in a process of its own, and refuse the file that it does not come back from.

    What the reader finds, or raises, is not handed on: the caller calls it again, now that it is known to end. Raises
    :class:`InputError` for bytes that end or hang the process, or that ask for more than :data:`MOST_MEMORY`.
    """
    seconds = MOST_SECONDS + path.stat().st_size // BYTES_A_SECOND
    command = [sys.executable, "-P", "-c", f"from {__name__} import serve; serve()", reader, str(path.absolute()), str(seconds)]
    silent: dict[str, Any] = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.DEVNULL)
    try:
        code = subprocess.run(command, timeout=_PATIENCE * seconds, env=apart_environment(), check=False, **silent).returncode
    except subprocess.TimeoutExpired:
        code = -1
    if code == _TOO_LARGE:
        raise InputError(f"is damaged: reading it asks for more than {MOST_MEMORY / 1e9:g} GB; write it again", where)
    if code:
        raise InputError("is damaged: the library of the format does not come back from reading it; write it again", where)


def apart_environment() -> dict[str, str]:
    """Variables of such a process: paths of the caller, so that a format of another package is found; no plugins of HDF5, one thread."""
    paths = os.pathsep.join(part for part in sys.path if part)
    return os.environ | {"PYTHONPATH": paths, "HDF5_PLUGIN_PRELOAD": "::", "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}


def serve() -> None:
    """The other side: read the file that the arguments name, under bounds, and tell by the exit status whether that ended."""
    reader, path, seconds = sys.argv[1:4]
    bound_process(MOST_MEMORY, int(seconds))
    module, _, name = reader.partition(":")
    function = getattr(import_module(module), name)
    try:
        function(Path(path))
    except MemoryError:
        os._exit(_TOO_LARGE)
    except Exception:  # the caller meets it again, and has the words for it
        pass
    os._exit(0)


def bound_process(memory: int, seconds: int) -> None:
    """Bound memory (bytes) and processor time (s) of this process, where the system can."""
    with suppress(ImportError, ValueError, OSError):
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
