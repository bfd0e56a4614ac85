"""Speed run-ups: the cam accelerates through the cycles instead of turning at one speed."""

from __future__ import annotations

from dataclasses import replace

from valvetrain.integrate.contract import RunUp
from valvetrain.integrate.train_run import CycleRecord, TrainOptions, TrainState, runner
from valvetrain.system.train_rest import TrainRest
from valvetrain.system.train_system import TrainSystem


def run_up(
    system: TrainSystem, first_cam_speed: float, last_cam_speed: float, cam_acceleration: float, options: TrainOptions | None = None,
    start: TrainState | None = None, rest: TrainRest | None = None,
) -> tuple[CycleRecord, ...]:  # fmt: skip
    """Records of consecutive stretches, each one nominal cam period long at its own first speed, until ``last_cam_speed`` (rad/s) is
    reached.

    The cam angle of a record is the true one (rad, unwrapped). ``cam_acceleration`` in rad/s2, of the sign of the change. The step is
    that of the first speed throughout, so that wave rods keep their grid. Raises :class:`InputError` for an acceleration that does not
    lead there.
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
