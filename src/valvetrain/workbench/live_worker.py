"""The process behind :class:`valvetrain.workbench.live.LiveChain`: it holds the case read and
built, and answers one request after the other.
"""

from __future__ import annotations

import math
import multiprocessing
import os
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import wraps
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.errors import InputError, ValvetrainError
from valvetrain.parameters.loading import parse_case
from valvetrain.parameters.overrides import read_assignment
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.quantities.train_numbers import margin_quantities
from valvetrain.runs.critical_speeds import CriticalOptions, first_loss
from valvetrain.runs.prepared import (
    Plan,
    PreparedRun,
    integrate_point,
    prepare,
    provenance_of,
)
from valvetrain.runs.train_runs import member_statics, rigid_numbers
from valvetrain.solution.definition import label_of, shown
from valvetrain.solution.result import Solution
from valvetrain.solution.status import reason
from valvetrain.system.build import build
from valvetrain.system.problem import Problem
from valvetrain.units import si_speeds
from valvetrain.workbench.live_result import LiveResult

#: The model of a spring alone: a curve in milliseconds.
CHAIN = "multi-mass"

#: Number of built cases in the cache, changed or not: a slider goes to and fro.
MAX_BUILT = 8
#: Shares of the float speed of rigid parts at which the search for the float speed begins, one after
#: the other until the valve floats, and its resolution (rad/s).
FLOAT_SHARES, FLOAT_RESOLUTION = (0.6, 0.8, 0.9, 1.0, 1.1, 1.25, 1.5), 20 * np.pi / 30
RIGID = "rigid_contact_loss_engine_speed"


def timed(compute: Callable[..., LiveResult]) -> Callable[..., LiveResult]:
    """The same with its time; whatever goes wrong is a sentence, and the next curve is computed."""

    @wraps(compute)
    def answered(*given: Any) -> LiveResult:
        begun = time.perf_counter()
        try:
            result = compute(*given)
        except ValvetrainError as error:
            result = LiveResult(sentence=str(error))
        except Exception as error:
            result = LiveResult(sentence=reason(error))
        return replace(result, seconds=time.perf_counter() - begun)

    return answered


class LiveCase:
    """A case that is changed, built and run again and again.

    Parameters
    ----------
    case_text : the case (TOML)
    folder : of the files that it names
    spring_model : name of the model that runs; empty: a chain of masses, of a train its own model unless
        that is the reduced rod
    """

    def __init__(self, case_text: str, folder: Path, spring_model: str) -> None:
        self.case_text, self.folder, self.spring_model = case_text, folder, spring_model
        self.stopped: Callable[[], bool] = lambda: False
        self._built: dict[tuple[tuple[str, str], ...], tuple[Problem, PreparedRun, float]] = {}

    @timed
    def answer(self, changes: Mapping[str, str], engine_speed: str) -> LiveResult:
        """The curve of the case with ``changes`` at a crank speed (text; empty: the highest of the
        case), or a sentence.
        """
        problem, ready, rigid = self._ready(changes)
        if ready.refusal:
            raise InputError(ready.refusal)
        speeds = (
            si_speeds(engine_speed, "engine_speed", "engine speed")
            if engine_speed
            else problem.engine_speeds
        )
        if not speeds:
            raise InputError("the case names no engine speed; give one", "engine speed")
        speed = max(speeds)
        origin = provenance_of(problem, ready.member, speed, "")
        plan = Plan("ends", None, True, problem.cycles, problem.cycles_to_settle)
        run = integrate_point(ready, speed, plan, origin)
        if run.status.code not in ("completed", "not-converged"):
            return LiveResult(sentence=run.status.sentence())
        cycle = reported_cycle(run)
        force, lift = (
            np.asarray(cycle.channel(name), dtype=float)
            for name in ("retainer_force", "valve_lift")
        )
        peak = int(np.argmax(force))
        numbers = {} if ready.motion is None else train_numbers(ready, run, rigid)
        degrees = np.degrees(cycle.cam_angle)
        return LiveResult(
            angle_deg=tuple(np.round(degrees, 4).tolist()),
            force_N=tuple(np.round(force, 4).tolist()),
            sentence="" if run.status.code == "completed" else run.status.sentence(),
            quantities={
                **numbers,
                "largest force": (float(force[peak]), "N"),
                "at": (float(degrees[peak]), "deg"),
                "smallest force": (float(force.min()), "N"),
                "largest lift": (float(lift.max()) * 1e3, "mm"),
            },
            engine_speed=speed * 30 / np.pi,
            model=run.model,
        )

    @timed
    def float_speed(self, changes: Mapping[str, str]) -> LiveResult:
        """The float speed of a train with ``changes`` by a search of few runs, in ``quantities``;
        ``skipped`` once :attr:`stopped` says so, a sentence where it is refused.
        """
        problem, ready, rigid = self._ready(changes)
        if ready.refusal or ready.motion is None:
            raise InputError(ready.refusal or "a spring alone has no float speed")
        top = rigid if np.isfinite(rigid) else max(problem.engine_speeds, default=1000.0)
        speeds = [share * top for share in FLOAT_SHARES]
        options = CriticalOptions(resolution=FLOAT_RESOLUTION, ranges=False)
        found = first_loss("float", problem, ready, speeds, options, self.stopped)
        if found is None:
            return LiveResult(skipped=True)
        lost, kept = (value * 30 / np.pi for value in found)
        if np.isfinite(lost) and lost > 0:
            return LiveResult(quantities={"float speed": (lost, "rpm")})
        first = f"{speeds[0] * 30 / np.pi:.0f} rpm"
        if lost == 0:
            return LiveResult(sentence=f"below {first}")
        known = f"no float up to {kept:.0f} rpm" if kept else f"unknown from {first}"
        ends = ": the ends of the spring would lift above, of which its model knows nothing"
        return LiveResult(sentence=known + ends * bool(np.isnan(lost)))

    def _ready(self, changes: Mapping[str, str]) -> tuple[Problem, PreparedRun, float]:
        """The built case, its run, and the engine speed (rad/s) at which rigid parts lose contact,
        as a sweep reports it.
        """
        key = tuple(sorted(changes.items()))
        if key not in self._built:
            given = dict(read_assignment(f"{path}={text}", path) for path, text in changes.items())
            case = parse_case(self.case_text, "case", self.folder, "case", given or None)
            # tables of a reduced rod take a second or two for each place of a slider
            own = CHAIN if case.train is None else case.train.model_of()
            own = CHAIN if own == "reduced-rod" else own
            problem = build(case, spring_models=(self.spring_model or own,))
            member = problem.members[0]
            rest = member_statics(problem, member) if member.gear is not None else {}
            ready = prepare(problem, member, rest, "")
            rigid = rigid_numbers((ready,), ()).get(member.spring_set, {}).get(RIGID, math.inf)
            self._built[key] = (problem, ready, rigid)
            while len(self._built) > MAX_BUILT:
                del self._built[next(iter(self._built))]
        return self._built[key]


def train_numbers(ready: PreparedRun, run: Solution, rigid: float) -> dict[str, tuple[float, str]]:
    """What decides whether a train keeps control at the speed of a run: least cam force while the
    valve is open, least margin of the spring and float speed of ``rigid`` parts, by their labels.
    """
    assert ready.motion is not None
    margins = margin_quantities(ready.motion.table(run.engine_speed / 2))
    found = {
        "minimum_cam_contact_force": run.statistics.get("least_cam_contact_force"),
        "minimum_spring_margin_force": margins.get("minimum_spring_margin_force"),
        RIGID: rigid,
    }
    known = {name: float(value) for name, value in found.items() if value is not None}
    return {
        label_of(name): (float(shown(name, value)[0]), shown(name, value)[1])
        for name, value in known.items()
        if np.isfinite(value)
    }


def serve(pipe: Connection, case: LiveCase, warm: bool) -> None:
    """Answer each request that comes over the ``pipe``, and end with the process at its other end, whatever
    is computed; ``warm``: a first curve is computed before.
    """
    threading.Thread(target=_end_with_server, daemon=True).start()
    case.stopped = pipe.poll
    if warm:
        case.answer({}, "")
    with suppress(EOFError):
        while True:
            if (request := pipe.recv()) is not None:  # else its search has ended by itself
                method, given = request
                pipe.send(getattr(case, method)(*given))


def _end_with_server() -> None:
    server = multiprocessing.parent_process()
    if server is not None:
        server.join()
        os._exit(0)
