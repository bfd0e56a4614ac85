"""The fast chain while a slider moves: a worker process that holds the case built and answers with
one force curve.
"""

from __future__ import annotations

import multiprocessing
import os
import threading
from collections.abc import Mapping
from contextlib import suppress
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from types import MappingProxyType

from valvetrain.errors import InputError
from valvetrain.parameters.bounded_file import SIDE_FILES_VARIABLE
from valvetrain.workbench.live_result import LiveResult
from valvetrain.workbench.supervisor import bound_memory

_NOTHING: Mapping[str, str] = MappingProxyType({})
#: Chains that live at a time in one server, and the slow model.
MAX_LIVE, ROD = 4, "finite-element"
#: Longest wait (s) for a curve of the chain, the first one compiling included, and for one of the
#: rod; memory of a worker (bytes).
MAX_CURVE_TIME, MAX_ROD_TIME, MEMORY = 120.0, 300.0, 8e9


class LiveChain:
    """A case in a worker process of its own; use it as a context, or call :meth:`close`.

    Parameters
    ----------
    case_text : the case (TOML)
    folder : of the files that the case names
    spring_model : name of a model; empty: the chain of masses, of a train the model that its runs take unless that is
        the reduced rod, whose tables take seconds

    Raises
    ------
    InputError : more than :data:`MAX_LIVE` at a time
    """

    _living = 0
    _count = threading.Lock()

    def __init__(self, case_text: str, folder: Path = Path(), spring_model: str = "") -> None:
        with LiveChain._count:
            if LiveChain._living >= MAX_LIVE:
                raise InputError(f"{MAX_LIVE} sliders are in use; close one of them", "slider")
            LiveChain._living += 1
        self._closed = False
        self._chain = _Worker(case_text, folder, spring_model, MAX_CURVE_TIME, warm=True)
        self._rod = _Worker(case_text, folder, ROD, MAX_ROD_TIME)
        self._search = _Worker(case_text, folder, spring_model, MAX_ROD_TIME)
        self._chain.begin()

    def curve(self, changes: Mapping[str, str] = _NOTHING, engine_speed: str = "") -> LiveResult:
        """The curve of the case with ``changes`` (key path -> text, as ``--set`` takes them); a
        refusal is its ``sentence``.

        Blocks for tens of milliseconds; a page calls it in a thread. Of calls that wait, only the
        last is computed, the others come back
        ``skipped``.
        """
        return self._chain.ask("answer", dict(changes), engine_speed)

    def rod(self, changes: Mapping[str, str] = _NOTHING, engine_speed: str = "") -> LiveResult:
        """The curve by the geometrically exact rod, in seconds; :meth:`cancel` ends it, and so does
        a new call of :meth:`rod`.
        """
        self._rod.stop()
        return self._rod.ask("answer", dict(changes), engine_speed)

    def float_speed(self, changes: Mapping[str, str] = _NOTHING) -> LiveResult:
        """The float speed (rpm) of a train, in ``quantities``, by a search of few runs, in seconds;
        a sweep searches finer. :meth:`cancel` ends it, and so does a new call; a refusal is its ``sentence``.
        """
        self._search.interrupt()
        return self._search.ask("float_speed", dict(changes))

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
        self._case = (case_text, folder, spring_model, warm)
        self._longest, self._closed, self._busy = longest, False, False
        self._turn, self._last = threading.Lock(), 0

    _process: BaseProcess | None = None
    _pipe: Connection

    def ask(self, method: str, *given: object) -> LiveResult:
        """The answer of a method of the case in the process, or skipped where a newer question came while this one waited."""
        self._last = mine = self._last + 1
        with self._turn:
            if self._last != mine or self._closed:
                return LiveResult(skipped=True)
            process = self._begun()
            self._busy, label = True, "ended without an answer"
            try:
                self._pipe.send((method, given))
                if self._pipe.poll(self._longest):
                    answer: LiveResult = self._pipe.recv()
                    return answer
                label = f"took longer than {self._longest:.0f} s"
            except (OSError, EOFError):
                pass  # it was ended
            finally:
                self._busy = False
            self._end(process)
            if self._last != mine or self._closed:
                return LiveResult(skipped=True)
            return LiveResult(
                sentence=f"the curve {label}; choose fewer elements or a higher speed"
            )

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
        if self._busy:
            with suppress(OSError):
                self._pipe.send(None)

    def close(self) -> None:
        """End the process for good."""
        self._closed = True
        if self._process is not None:
            self._end(self._process)

    def _begun(self) -> BaseProcess:
        process = self._process
        if process is None or not process.is_alive():
            context = multiprocessing.get_context("spawn")
            self._pipe, theirs = context.Pipe()
            process = context.Process(target=_serve, args=(theirs, *self._case), daemon=True)
            process.start()
            theirs.close()
            self._process = process
        return process

    def _end(self, process: BaseProcess) -> None:
        process.kill()
        process.join()
        self._pipe.close()


def _serve(pipe: Connection, case_text: str, folder: Path, spring_model: str, warm: bool) -> None:
    """The worker process: threads and files are bounded before anything is imported that computes."""
    os.environ[SIDE_FILES_VARIABLE] = "1"
    os.environ |= dict.fromkeys(
        ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"
    )
    if hasattr(os, "setsid"):  # Ctrl-C is for the server
        os.setsid()
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    bound_memory(MEMORY)
    from valvetrain.workbench.live_worker import LiveCase, serve

    serve(pipe, LiveCase(case_text, folder, spring_model), warm)
