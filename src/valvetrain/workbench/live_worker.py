"""The process behind :class:`valvetrain.workbench.live.LiveChain`: it holds the case read and
built, and answers line by line.

A line on standard input is a JSON object with ``changes`` (key path -> text) and ``engine_speed``;
a line on standard output the answer.
It ends when its standard input does.
"""

from __future__ import annotations

import json
import os
import queue
import sys
import threading
import time
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.errors import InputError, ValvetrainError
from valvetrain.parameters.loading import parse_case
from valvetrain.parameters.overrides import read_assignment
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.runs.prepared import (
    Plan,
    PreparedRun,
    integrate_point,
    prepare,
    provenance_of,
)
from valvetrain.runs.train_runs import member_statics
from valvetrain.solution.partial_failures import reason
from valvetrain.system.build import build
from valvetrain.system.problem import Problem
from valvetrain.units import si_speeds

#: The model of a spring alone: a curve in milliseconds.
CHAIN = "multi-mass"

#: Number of built cases in the cache, changed or not: a slider goes to and fro.
MAX_BUILT = 8


class LiveCase:
    """A case that is changed, built and run again and again.

    Parameters
    ----------
    case_text : the case (TOML)
    folder : where files that it names lie
    spring_model : name of the model that runs; empty: a chain of masses, of a train its own model
    """

    def __init__(self, case_text: str, folder: Path, spring_model: str) -> None:
        self.case_text, self.folder, self.spring_model = case_text, folder, spring_model
        self._built: dict[tuple[tuple[str, str], ...], tuple[Problem, PreparedRun]] = {}

    def answer(self, changes: Mapping[str, str], engine_speed: str) -> dict[str, Any]:
        """The curve of the case with ``changes`` at a crank speed (text; empty: the highest of the
        case), or a sentence.
        """
        begun = time.perf_counter()
        try:
            found = self._curve(changes, engine_speed)
        except ValvetrainError as error:
            found = {"sentence": str(error)}
        except Exception as error:  # whatever goes wrong in one curve, the next is still computed
            found = {"sentence": reason(error)}
        return found | {"seconds": time.perf_counter() - begun}

    def _curve(self, changes: Mapping[str, str], engine_speed: str) -> dict[str, Any]:
        problem, ready = self._ready(changes)
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
            return {"sentence": run.status.sentence()}
        cycle = reported_cycle(run)
        force, lift = (
            np.asarray(cycle.channel(name), dtype=float)
            for name in ("retainer_force", "valve_lift")
        )
        peak = int(np.argmax(force))
        degrees = np.degrees(cycle.cam_angle)
        return {
            "model": run.model,
            "angle_deg": np.round(degrees, 4).tolist(),
            "force_N": np.round(force, 4).tolist(),
            "lift_mm": np.round(lift * 1e3, 6).tolist(),
            "engine_speed": speed * 30 / np.pi,
            "sentence": "" if run.status.code == "completed" else run.status.sentence(),
            "quantities": {
                "largest force": (float(force[peak]), "N"),
                "at": (float(degrees[peak]), "deg"),
                "smallest force": (float(force.min()), "N"),
                "largest lift": (float(lift.max()) * 1e3, "mm"),
            },
        }

    def _ready(self, changes: Mapping[str, str]) -> tuple[Problem, PreparedRun]:
        key = tuple(sorted(changes.items()))
        if key not in self._built:
            given = dict(read_assignment(f"{path}={text}", path) for path, text in changes.items())
            case = parse_case(self.case_text, "case", self.folder, "case", given or None)
            own = CHAIN if case.train is None else case.train.model_of()
            problem = build(case, spring_models=(self.spring_model or own,))
            member = problem.members[0]
            rest = member_statics(problem, member) if member.gear is not None else {}
            self._built[key] = (problem, prepare(problem, member, rest, ""))
            while len(self._built) > MAX_BUILT:
                del self._built[next(iter(self._built))]
        return self._built[key]


def main() -> None:
    """Read the case from the first line, then answer each line that follows."""
    lines: queue.SimpleQueue[str] = queue.SimpleQueue()
    first = json.loads(sys.stdin.readline())
    _bound(float(first["memory"]))
    threading.Thread(target=_listen, args=(lines,), daemon=True).start()
    case = LiveCase(first["case_text"], Path(first["folder"]), first["spring_model"])
    if first["warm"]:
        case.answer({}, "")
    while True:
        request = json.loads(lines.get())
        answer = case.answer(request["changes"], request["engine_speed"])
        sys.stdout.write(json.dumps(answer, allow_nan=False) + "\n")
        sys.stdout.flush()


def _listen(lines: queue.SimpleQueue[str]) -> None:
    """Pass requests on; end the process, whatever it computes, once there are no more."""
    for line in sys.stdin:
        lines.put(line)
    os._exit(0)


def _bound(memory: float) -> None:
    """No more address space than that, and no core dumps."""
    with suppress(ImportError, ValueError, OSError):
        import resource

        for kind, most in ((resource.RLIMIT_AS, int(memory)), (resource.RLIMIT_CORE, 0)):
            hard = resource.getrlimit(kind)[1]
            least = most if hard == resource.RLIM_INFINITY else min(most, hard)
            resource.setrlimit(kind, (least, least))


if __name__ == "__main__":
    main()
