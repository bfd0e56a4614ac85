"""The fast chain while a slider moves: a worker process that holds the case built and answers with
one force curve.
"""

from __future__ import annotations

import json
import os
import select
import subprocess
import sys
import threading
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

from valvetrain.errors import InputError
from valvetrain.parameters.bounded_file import SIDE_FILES_VARIABLE

_NOTHING: Mapping[str, str] = MappingProxyType({})
#: Chains that live at a time in one server, and the slow model.
MAX_LIVE, ROD = 4, "finite-element"
#: Longest wait (s) for a curve of the chain, the first one compiling included, and for one of the
#: rod; memory of a worker (bytes).
MAX_CURVE_POINTS, MAX_ROD_LENGTH, MEMORY = 120.0, 300.0, 8e9


@dataclass(frozen=True, slots=True)
class LiveResult:
    """One curve.

    Parameters
    ----------
    angle_deg : cam angles (cam degrees)
    force_N : spring force on the retainer, of all springs together (N)
    seconds : time it took in the worker (s)
    sentence : what went wrong, or is to be said of the curve; empty where there is nothing
    quantities : words -> (value, unit shown) of a few numbers, such as the largest force
    engine_speed : crank speed (rpm)
    skipped : no curve was computed, for a newer one was requested meanwhile
    model : name of the spring model
    """

    angle_deg: tuple[float, ...] = ()
    force_N: tuple[float, ...] = ()
    seconds: float = 0.0
    sentence: str = ""
    quantities: Mapping[str, tuple[float, str]] = field(default_factory=dict)
    engine_speed: float = 0.0
    skipped: bool = False
    model: str = ""


class LiveChain:
    """A case in a worker process of its own; use it as a context, or call :meth:`close`.

    Parameters
    ----------
    case_text : the case (TOML)
    spring_model : ``multi-mass``, ``massless`` or ``wave-rod``; empty: the chain of masses, of a train
        the model that its runs take unless that is the reduced rod, whose tables take seconds
    engine_speed : crank speed, such as ``"5600 rpm"``; empty: the highest of the case
    folder : of the files that the case names

    Raises
    ------
    InputError : more than :data:`MAX_LIVE` at a time
    """

    _living = 0
    _count = threading.Lock()

    def __init__(
        self, case_text: str, spring_model: str = "", engine_speed: str = "", folder: Path = Path()
    ) -> None:
        self.engine_speed = engine_speed
        with LiveChain._count:
            if LiveChain._living >= MAX_LIVE:
                raise InputError(f"{MAX_LIVE} sliders are in use; close one of them", "slider")
            LiveChain._living += 1
        self._closed = False
        self._chain = _Worker(case_text, folder, spring_model, MAX_CURVE_POINTS, warm=True)
        self._rod = _Worker(case_text, folder, ROD, MAX_ROD_LENGTH)
        self._search = _Worker(case_text, folder, spring_model, MAX_ROD_LENGTH)
        self._chain.begin()

    def curve(self, changes: Mapping[str, str] = _NOTHING, engine_speed: str = "") -> LiveResult:
        """The curve of the case with ``changes`` (key path -> text, as ``--set`` takes them); a
        refusal is its ``sentence``.

        Blocks for tens of milliseconds; a page calls it in a thread. Of calls that wait, only the
        last is computed, the others come back
        ``skipped``.
        """
        return self._chain.ask(changes, engine_speed or self.engine_speed)

    def rod(self, changes: Mapping[str, str] = _NOTHING, engine_speed: str = "") -> LiveResult:
        """The curve by the geometrically exact rod, in seconds; :meth:`cancel` ends it, and so does
        a new call of :meth:`rod`.
        """
        self._rod.stop()
        return self._rod.ask(changes, engine_speed or self.engine_speed)

    def float_speed(self, changes: Mapping[str, str] = _NOTHING) -> LiveResult:
        """The float speed (rpm) of a train, in ``quantities``, by a search of few runs, in seconds;
        a sweep searches finer. :meth:`cancel` ends it, and so does a new call; a refusal is its ``sentence``.
        """
        self._search.interrupt()
        return self._search.ask(changes, "", float=True)

    def cancel(self) -> None:
        """End a rod and a search that run; their calls come back ``skipped``."""
        self._rod.stop()
        self._search.interrupt()

    def close(self) -> None:
        """End the workers."""
        with LiveChain._count:
            if self._closed:
                return
            self._closed = True
            LiveChain._living -= 1
        self._chain.close()
        self._rod.close()
        self._search.close()

    def __enter__(self) -> LiveChain:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class _Worker:
    """The process, started at its first use and again after it was ended; ``warm``: it computes a
    curve before the first request.
    """

    def __init__(
        self, case_text: str, folder: Path, spring_model: str, longest: float, warm: bool = False
    ) -> None:
        entry = {
            "case_text": case_text,
            "folder": str(folder),
            "spring_model": spring_model,
            "memory": MEMORY,
            "warm": warm,
        }
        self._first = json.dumps(entry)
        self._longest, self._process, self._closed = longest, None, False
        self._turn, self._last = threading.Lock(), 0
        self._busy = False

    _process: subprocess.Popen[bytes] | None

    def ask(self, changes: Mapping[str, str], engine_speed: str, **more: bool) -> LiveResult:
        """The answer of the process, or skipped where a newer question came while this one waited."""
        self._last = mine = self._last + 1
        with self._turn:
            if self._last != mine or self._closed:
                return LiveResult(skipped=True)
            process = self._begun()
            self._busy = True
            try:
                assert process.stdin is not None and process.stdout is not None
                request = {"changes": dict(changes), "engine_speed": engine_speed, **more}
                process.stdin.write((json.dumps(request) + "\n").encode())
                process.stdin.flush()
                line = _line(process, self._longest)
            except (OSError, ValueError):
                line = b""  # it was ended
            finally:
                self._busy = False
            if not line:
                self._end(process)
                if self._last != mine or self._closed:
                    return LiveResult(skipped=True)
                label = (
                    f"took longer than {self._longest:.0f} s"
                    if line is None
                    else "ended without an answer"
                )
                return LiveResult(
                    sentence=f"the curve {label}; choose fewer elements or a higher speed"
                )
            return _result(json.loads(line))

    def begin(self) -> None:
        """Start the process, so that it is ready for the first request."""
        with self._turn:
            self._begun()

    def stop(self) -> None:
        """End the process if it computes."""
        self._last += 1
        process = self._process
        if process is not None and self._busy:
            process.kill()

    def interrupt(self) -> None:
        """Ask a search of the process to stop, which it does between two runs."""
        process = self._process
        if process is not None and self._busy and process.stdin is not None:
            with suppress(OSError, ValueError):
                process.stdin.write(b"stop\n")
                process.stdin.flush()

    def close(self) -> None:
        """End the process for good."""
        self._closed = True
        if self._process is not None:
            self._end(self._process)

    def _begun(self) -> subprocess.Popen[bytes]:
        process = self._process
        if process is None or process.poll() is not None:
            environment = {
                **os.environ,
                SIDE_FILES_VARIABLE: "1",
                "OPENBLAS_NUM_THREADS": "1",
                "OMP_NUM_THREADS": "1",
                "NUMBA_NUM_THREADS": "1",
            }
            process = self._process = subprocess.Popen(
                [sys.executable, "-m", "valvetrain.workbench.live_worker"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL, env=environment, start_new_session=True,
            )  # fmt: skip
            assert process.stdin is not None
            with suppress(OSError):  # one that has ended at once is found out at the next request
                process.stdin.write(self._first.encode() + b"\n")
                process.stdin.flush()
        return process

    @staticmethod
    def _end(process: subprocess.Popen[bytes]) -> None:
        process.kill()
        process.wait()
        for stream in (process.stdin, process.stdout):
            with suppress(OSError, AttributeError):
                stream.close()  # type: ignore[union-attr]


def _line(process: subprocess.Popen[bytes], longest: float) -> bytes | None:
    """One line of the process's answer; empty where it ended, None where it took longer than that
    (s).
    """
    assert process.stdout is not None
    last, found = time.monotonic() + longest, b""
    while not found.endswith(b"\n"):
        ready, _, _ = select.select([process.stdout], [], [], max(0.0, last - time.monotonic()))
        if not ready:
            return None
        part = os.read(process.stdout.fileno(), 1 << 20)
        if not part:
            return b""
        found += part
    return found


def _result(entry: Mapping[str, Any]) -> LiveResult:
    angle, force = (tuple(entry.get(name, ())) for name in ("angle_deg", "force_N"))
    quantities = {
        label: (float(value), str(unit))
        for label, (value, unit) in entry.get("quantities", {}).items()
    }
    return LiveResult(
        angle,
        force,
        float(entry["seconds"]),
        str(entry["sentence"]),
        quantities,
        float(entry.get("engine_speed", 0.0)),
        bool(entry.get("skipped", False)),
        model=str(entry.get("model", "")),
    )
