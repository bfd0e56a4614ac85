"""Speed run-ups: the cam accelerates through the cycles instead of turning at one speed."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

from valvetrain.integrate.contract import RunUp
from valvetrain.integrate.train_record import CycleRecord, TrainOptions, TrainState
from valvetrain.integrate.train_run import TrainRunner, runner
from valvetrain.system.train_rest import TrainRest
from valvetrain.system.train_system import TrainSystem


def run_up(
    system: TrainSystem,
    first_cam_speed: float,
    last_cam_speed: float,
    cam_acceleration: float,
    options: TrainOptions | None = None,
    start: TrainState | None = None,
    rest: TrainRest | None = None,
) -> tuple[CycleRecord, ...]:
    """Records of consecutive stretches, each one nominal cam period long at its own first speed,
    until ``last_cam_speed`` (rad/s) is reached.

    The cam angle of a record is the true one (rad, unwrapped). ``cam_acceleration`` in rad/s2, of
    the sign of the change. The step is that of the first speed throughout, so that wave rods keep
    their grid. Raises :class:`InputError` for an acceleration that does not lead there.
    """
    RunUp(last_cam_speed, cam_acceleration).duration(first_cam_speed)
    ready = runner(system, first_cam_speed, options, cam_acceleration, rest)
    step, state, records = ready.time_step, start or ready.initial_state(), []
    cam_speed = first_cam_speed
    while (last_cam_speed - cam_speed) * cam_acceleration > 0:
        # one stretch always takes the same time: only the speed at its start is new
        stretch = replace(ready, cam_speed=cam_speed, fixed_step=step)
        state, record = stretch.cycle(state)
        records.append(record)
        cam_speed += cam_acceleration * step * ready.steps
        if not record.status.completed:
            break
    return tuple(records)


def turns_of_run_up(
    ready: TrainRunner, last_cam_speed: float, start: TrainState | None = None
) -> Iterator[CycleRecord]:
    """Records of a run-up turn by turn: every one a cam revolution to the nearest sample, from ``start``
    (none: at rest), until its speed at the start reaches ``last_cam_speed`` (rad/s).

    ``ready``: runner at the first speed with the cam acceleration. Its step and the interval of its
    samples are stored, so that a turn of a higher speed has fewer samples. Ends after a record that
    did not complete. Raises :class:`InputError` for an acceleration that does not lead there.
    """
    first_cam_speed, cam_acceleration = ready.cam_speed, ready.cam_acceleration
    RunUp(last_cam_speed, cam_acceleration).duration(first_cam_speed)
    step, state, each = (
        ready.time_step,
        start or ready.initial_state(),
        ready.steps // ready.options.samples,
    )
    begun, count, cam_speed = 0, 0, first_cam_speed
    while (last_cam_speed - cam_speed) * cam_acceleration > 0:
        count += 1
        ends = _turn_time(first_cam_speed, cam_acceleration, count)
        if ends is None:  # the cam would stop before this turn is done
            return
        samples = max(1, round(ends / (step * each)) - begun)
        turn = replace(
            ready,
            cam_speed=cam_speed,
            fixed_step=step,
            steps=samples * each,
            options=replace(ready.options, samples=samples),
        )
        state, record = turn.cycle(state)
        yield record
        if not record.status.completed:
            return
        begun += samples
        cam_speed = first_cam_speed + cam_acceleration * step * each * begun


def _turn_time(first_cam_speed: float, cam_acceleration: float, turns: int) -> float | None:
    """Time (s) at which that many turns are done: w t + a t^2 / 2 = 2 pi n; None where the cam
    is before.
    """
    root = first_cam_speed**2 + 4 * math.pi * cam_acceleration * turns
    return None if root < 0 else (math.sqrt(root) - first_cam_speed) / cam_acceleration
