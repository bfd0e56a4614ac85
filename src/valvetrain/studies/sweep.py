"""Speed sweeps of a train up to loss of control, per spring set and spring model; order map of the surge."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.integrate.train_run import TrainOptions
from valvetrain.parameters.case import Case
from valvetrain.parameters.train import TrainVariant
from valvetrain.quantities.kinematics import contact_loss_cam_speed
from valvetrain.quantities.valvetrain_quantities import ORDERS
from valvetrain.quantities.valvetrain_study import TrainRun
from valvetrain.solution.status import Status
from valvetrain.studies.batch import map_cases
from valvetrain.studies.train_study import RunJob, run_job, train_of
from valvetrain.system.build_train import build_train

Array = NDArray[np.float64]

#: Columns of a sweep's table, in order.
COLUMNS = (
    "peak_open_cam_contact_force", "minimum_cam_contact_force", "peak_open_valve_tip_contact_force", "minimum_valve_tip_contact_force",
    "peak_seat_contact_force", "lift_loss_displacement", "seating_velocity", "bounce_height", "bounce_count", "loft_gap",
    "float_excess_lift",
    "peak_retainer_force", "minimum_retainer_force", "motion_period_count", "steady_cycles_count",
)  # fmt: skip

CONTROL_LOST_GAP = 50e-6
"""A gap (m) in the drive, or a lift above the rigid one, beyond which control over the valve counts as lost."""

SWEEP_OPTIONS = TrainOptions(samples=720)


@dataclass(frozen=True)
class SweepSeries:
    """One spring set and model over ``engine_speeds`` (rad/s of the crank).

    ``columns``: name -> (speeds,), NaN where a run failed; ``orders`` (speeds, orders + 1): surge amplitude (N, 0 to peak) by cam order;
    ``statuses`` per speed. ``contact_loss_engine_speed``: lowest speed at which the cam contact is open for a moment while the valve is;
    ``rigid_engine_speed`` the same by rigid theory; ``float_engine_speed``: from where control is lost. NaN: not within the sweep.
    """

    spring_set: str
    spring_model: str
    engine_speeds: Array
    columns: dict[str, Array]
    orders: Array
    statuses: tuple[Status, ...]
    float_engine_speed: float
    rigid_engine_speed: float

    @property
    def contact_loss_engine_speed(self) -> float:
        """Lowest speed (rad/s) at which the cam contact opens while the valve is more than a tenth open; NaN when it never does."""
        lost = np.flatnonzero(self.columns["minimum_cam_contact_force"] <= 0)
        return float(self.engine_speeds[lost[0]]) if len(lost) else float("nan")

    @property
    def lone_float_engine_speeds(self) -> Array:
        """Speeds (rad/s) below ``float_engine_speed`` at which the train floats at that speed of the sweep only: resonances that let go."""
        lost = _floats(self.columns)
        below = self.engine_speeds < self.float_engine_speed if np.isfinite(self.float_engine_speed) else np.ones(len(lost), dtype=bool)
        return np.asarray(self.engine_speeds[lost & below])

    @property
    def label(self) -> str:
        """``set, model``."""
        return f"{self.spring_set}, {self.spring_model}" if self.spring_set else self.spring_model


@dataclass(frozen=True)
class TrainSweep:
    """All series of one sweep."""

    case: Case
    series: tuple[SweepSeries, ...]
    wall_time: float = field(default=0.0, compare=False)

    @property
    def failures(self) -> tuple[str, ...]:
        """One sentence per point that diverged; unsettled motion beyond float is a finding, not a failure."""
        return tuple(
            f"{item.label} at {speed * 30 / np.pi:.0f} rpm: {status.sentence()}"
            for item in self.series
            for speed, status in zip(item.engine_speeds, item.statuses, strict=True)
            if status.code not in ("completed", "not-converged")
        )


def run_sweep(
    case: Case, engine_speeds: Sequence[float], *, spring_models: Sequence[str] = (), spring_sets: Sequence[str] = (),
    workers: int | None = None,
    cycles: int = 30, progress: Callable[[float, str], None] | None = None,
) -> TrainSweep:  # fmt: skip
    """Steady states over ``engine_speeds`` (rad/s) for every spring set and model (the case's own by default).

    Raises :class:`InputError` for no speed at all.
    """
    import time

    train, begun = train_of(case), time.perf_counter()
    speeds = np.array(sorted(engine_speeds), dtype=float)
    if not len(speeds):
        raise InputError("a sweep needs at least one engine speed; write such as '1000:9000:100 rpm'")
    sets = tuple(spring_sets) or tuple(train.springs)
    models = tuple(spring_models) or (train.spring_model,)
    pairs = [(chosen, model) for chosen in sets for model in models]
    jobs = [
        RunJob(case, float(speed), TrainVariant(f"{chosen}, {model}", chosen, model), SWEEP_OPTIONS, cycles=cycles, keep_traces=False)
        for chosen, model in pairs
        for speed in speeds
    ]
    for chosen, model in pairs:  # refuse what cannot be built before the work starts
        build_train(case, spring_model=model, spring_set=chosen)

    def report(done: int, total: int) -> None:
        if progress is not None:
            progress(done / total, f"{jobs[done - 1].variant.label} {jobs[done - 1].engine_speed * 30 / np.pi:.0f} rpm")

    runs = map_cases(guarded_job, jobs, workers, report)
    series = [
        _series(case, chosen, model, speeds, runs[place * len(speeds) : (place + 1) * len(speeds)])
        for place, (chosen, model) in enumerate(pairs)
    ]
    return TrainSweep(case, tuple(series), time.perf_counter() - begun)


def guarded_job(job: RunJob) -> TrainRun:
    """:func:`run_job`, a failure of which becomes the status of its point, so that a sweep survives one bad speed and names it."""
    try:
        return run_job(job)
    except (InputError, ArithmeticError, np.linalg.LinAlgError, ValueError) as error:
        status = Status("diverged", " ".join(str(error).split()), 0.0, "start", "look at this speed alone with 'valvetrain run'")
        return TrainRun(job.variant.label, job.variant.spring_model, job.variant.spring_set, job.engine_speed, {}, (), status)


def _series(case: Case, spring_set: str, model: str, speeds: Array, runs: Sequence[TrainRun]) -> SweepSeries:
    columns = {name: np.array([run.quantities.get(name, np.nan) for run in runs]) for name in COLUMNS}
    orders = np.array([[run.quantities.get(f"surge_order_{order}_force", np.nan) for order in range(ORDERS + 1)] for run in runs])
    orders[:, 0] = 0.0
    rigid = 2 * contact_loss_cam_speed(build_train(case, spring_model="massless", spring_set=spring_set))[0]
    statuses = tuple(run.status for run in runs)
    return SweepSeries(spring_set, model, speeds, columns, orders, statuses, float_engine_speed(speeds, columns), rigid)


def float_engine_speed(engine_speeds: Array, columns: dict[str, Array]) -> float:
    """Lowest speed (rad/s) from which the train floats: gap in the drive or lift above the rigid one beyond :data:`CONTROL_LOST_GAP`, at
    that speed and the next.

    A single resonance that lets go and catches again does not count (:attr:`SweepSeries.lone_float_engine_speeds` names it); the last
    point of a sweep may stand alone.
    """
    lost = _floats(columns)
    for place in np.flatnonzero(lost):
        if place + 1 == len(engine_speeds) or lost[place + 1]:
            return float(engine_speeds[place])
    return float("nan")


def _floats(columns: dict[str, Array]) -> NDArray[np.bool_]:
    return np.asarray((columns["float_excess_lift"] > CONTROL_LOST_GAP) | np.isnan(columns["float_excess_lift"]))
