"""Sweeps over engine speed of any system by any spring model: numbers per speed, where a train loses control, order map."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.solution.study import Study
from valvetrain.studies.engine import Progress
from valvetrain.studies.run import run_problem
from valvetrain.system.build import build
from valvetrain.system.contract import TRAIN

Array = NDArray[np.float64]

CONTROL_LOST_GAP = 50e-6
"""A lift (m) above the rigid one beyond which control over the valve counts as lost."""


def sweep_study(
    case: Case, engine_speeds: Sequence[float], *, spring_models: Sequence[str] = (), spring_sets: Sequence[str] = (),
    whole: bool = False, workers: int | None = None, progress: Progress | None = None, created_at: str = "",
) -> Study:  # fmt: skip
    """A case over ``engine_speeds`` (rad/s of the crank): solutions, reduced unless ``whole``, and per label where a
    train first loses contact and floats.

    By default every spring set of a train by its own model, a spring alone by its usual models. Raises :class:`InputError` for no speed
    at all and for what cannot be built.
    """
    speeds = tuple(sorted(float(speed) for speed in engine_speeds))
    if not speeds:
        raise InputError("a sweep needs at least one engine speed; write such as '1000:9000:100 rpm'", "--engine-speed")
    sets = tuple(spring_sets) or (tuple(case.train.springs) if case.train is not None else ())
    problem = build(case, spring_models=spring_models, spring_sets=sets)
    study = run_problem(problem, speeds, workers=workers, progress=progress, created_at=created_at, command="sweep", whole=whole)
    if problem.kind != TRAIN:
        return study
    still = {**study.still}
    for label in study.labels:
        still[label] = {**still.get(label, {}), **control_quantities(study, label)}
    return replace(study, still=still)


def control_quantities(study: Study, label: str) -> dict[str, float]:
    """Engine speeds (rad/s) at which one series lets the cam go for a moment while the valve is open, and from which it floats.

    Absent where no speed of the sweep does so.
    """
    speeds, least = study.series(label, "minimum_cam_contact_force")
    _, excess = study.series(label, "float_excess_lift")
    found, lost = {}, np.flatnonzero(least <= 0)
    if len(lost):
        found["contact_loss_engine_speed"] = float(speeds[lost[0]])
    floats = float_engine_speed(speeds, excess)
    return found | ({"float_engine_speed": floats} if np.isfinite(floats) else {})


def float_engine_speed(engine_speeds: Array, float_excess_lift: Array) -> float:
    """Lowest speed (rad/s) from which a train floats: at that speed and the next its lift stands above the rigid one by more than
    :data:`CONTROL_LOST_GAP` (m), or it gave none. NaN where it never does.

    A single resonance that loses contact and regains it does not count (:func:`lone_float_engine_speeds`); the last point may stand alone.
    """
    lost = _floats(float_excess_lift)
    for place in np.flatnonzero(lost):
        if place + 1 == len(engine_speeds) or lost[place + 1]:
            return float(engine_speeds[place])
    return float("nan")


def lone_float_engine_speeds(study: Study, label: str) -> Array:
    """Speeds (rad/s) below the float speed at which a series floats at that speed of the sweep only: resonances that lose contact."""
    speeds, excess = study.series(label, "float_excess_lift")
    first = float_engine_speed(speeds, excess)
    below = speeds < first if np.isfinite(first) else np.ones(len(speeds), dtype=bool)
    return np.asarray(speeds[_floats(excess) & below])


def _floats(float_excess_lift: Array) -> NDArray[np.bool_]:
    return np.asarray((float_excess_lift > CONTROL_LOST_GAP) | np.isnan(float_excess_lift))
