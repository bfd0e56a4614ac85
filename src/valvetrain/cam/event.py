"""The lift event of a cam: of a file, of a table, and where it begins and ends."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.arrays import Array
from valvetrain.cam.contract import LiftLaw
from valvetrain.errors import InputError
from valvetrain.measured.lift_file import LiftAnswers, MeasuredLift, chosen_lobe, read_lift
from valvetrain.measured.stations import turned
from valvetrain.parameters.bounded_file import named_file
from valvetrain.parameters.lift_law import LiftLawParameters
from valvetrain.parameters.schema_types import guarded
from valvetrain.solution.study import LiftEvent

#: Where a law does not say where its main event begins, it is where the lift passes this share of
#: its largest value.
EVENT_SHARE = 0.04
_TURN = 2 * math.pi


def find_lift_event(
    law: LiftLaw | None, parameters: LiftLawParameters | None = None
) -> LiftEvent | None:
    """Main lift event of a law; None without lift or where the event spans the zero of the cam
    angle.

    The event is the law's own (``event_start`` with ``event_end`` or mirrored about ``nose`` among
    the values of ``parameters``), else from where the lift first passes 4 % of its largest value to
    where it last does.
    """
    values = {} if parameters is None else parameters.values
    end = values.get("event_end")
    if "event_start" in values and (end is not None or "nose" in values):
        start = float(values["event_start"])
        found = start, 2 * float(values["nose"]) - start if end is None else float(end)
    elif law is None or (passed := _passed(law)) is None:
        return None
    else:
        found = passed
    first, length = found[0] % _TURN, found[1] - found[0]
    # Whole cam degrees stay whole through sums of radians.
    first, last = (math.radians(round(math.degrees(angle), 9)) for angle in (first, first + length))
    return LiftEvent(first, last) if last <= _TURN else None


def _passed(law: LiftLaw) -> tuple[float, float] | None:
    """Where the lift passes the share of its maximum, from the nose outward round the circle until
    it has gone under for good.
    """
    lift = law.lift(np.arange(7200) * _TURN / 7200)
    top, up = int(np.argmax(lift)), lift > EVENT_SHARE * float(np.max(lift))
    if not np.max(lift) > 0 or np.all(up):
        return None
    inside = np.flatnonzero(np.roll(up, len(up) // 2 - top)) - len(up) // 2 + top
    step = _TURN / len(up)
    return float(inside[0] * step), float((inside[-1] + 1) * step)


def lobe_of_file(model: Any, folder: Path, lift_of: str) -> MeasuredLift:
    """The lobe in the file of lifts that a table of a lift law names, ``model`` with its answers, one of which is ``lift_of``.

    Raises a located problem for a file that cannot be read, or that holds no such lobe.
    """
    said = {
        name: given
        for name in LiftAnswers.__dataclass_fields__
        if (given := getattr(model, name, None)) is not None
    }
    said["columns"] = tuple(word.strip() for word in model.columns.split(",") if word.strip())
    answers = guarded(lambda: LiftAnswers(**said | {"lift_of": lift_of}))
    path = guarded(named_file, folder, model.file, path=("file",))
    lobes = guarded(read_lift, path, answers, path=("file",))
    found: MeasuredLift = guarded(chosen_lobe, lobes, model.lobe, model.file, path=("lobe",))
    return found


def event_of_table(
    cam_angles: tuple[float, ...], lifts: tuple[float, ...], threshold: float = 0.0
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """The lifting part of a table, from the last station of zero lift before it to the first after
    it.

    Lifts up to ``threshold`` (m) count as zero. A table over a whole revolution may start within
    the event. Raises :class:`InputError` when the table has no base circle on both sides, or no
    lift.
    """
    angles, heights = np.array(cam_angles), np.array(lifts)
    if heights[0] > threshold or heights[-1] > threshold:
        angles, heights = turned(angles, heights)
    high = np.flatnonzero(heights > threshold)
    if not len(high):
        raise InputError(
            "the table holds no lift above its base circle; check the unit and the smoothing"
        )
    if high[0] == 0 or high[-1] == len(heights) - 1:
        raise InputError(
            "a lift table must begin and end on the base circle; add stations of zero lift on both sides"
        )
    event = slice(int(high[0]) - 1, int(high[-1]) + 2)
    return tuple(angles[event].tolist()), (0.0, *heights[event][1:-1].tolist(), 0.0)


#: A change of the acceleration within three steps is a jump where it is this share of the whole
#: range and the two steps on either side change by no more than this share of it.
JUMP_SHARE, CALM_SHARE = 0.2, 0.1


def with_base(cam_angles: Array, lifts: Array) -> tuple[Array, Array]:
    """A table (n,) with one more station of the base circle on either side (n + 2,)."""
    angles = np.concatenate(
        [[2 * cam_angles[0] - cam_angles[1]], cam_angles, [2 * cam_angles[-1] - cam_angles[-2]]]
    )
    return angles, np.concatenate([[0.0], lifts, [0.0]])


def second_differences(cam_angles: Array, lifts: Array) -> Array:
    """Divided second differences (m/rad2) of a table at its inner stations (n - 2,): means of the
    true second derivative over two steps, which never leave its range.
    """
    steps = np.diff(cam_angles)
    found: Array = 2 * np.diff(np.diff(lifts) / steps) / (steps[1:] + steps[:-1])
    return found


def has_jumps(cam_angles: Array, lifts: Array) -> bool:
    """Whether the acceleration of a table jumps: it changes much within three steps and hardly on
    either side of them.
    """
    bend = second_differences(*with_base(cam_angles, lifts))
    if len(bend) < 12:
        return False
    change, calm = np.abs(bend[3:] - bend[:-3]), np.abs(np.diff(bend))
    around = np.max([calm[start : start + len(change) - 4] for start in (0, 1, 5, 6)], axis=0)
    middle = change[2:-2]
    return bool(np.any((middle > JUMP_SHARE * np.ptp(bend)) & (around < CALM_SHARE * middle)))


def bounded_pieces(cam_angles: Array, lifts: Array) -> tuple[Array, Array]:
    """Breaks (n + 2,) and cubics (n + 1, 4; ascending powers) of straight accelerations through the
    second differences at the stations.

    Integrated twice from rest one station before the table to rest one station after it
    (Schoenberg's spline). The curve differs from the table by a sixth of the acceleration times
    the step squared: 1.2 um at steps of one degree and 0.024 m/rad2.
    """
    angles, heights = with_base(cam_angles, lifts)
    bend, steps = (
        np.concatenate([[0.0], second_differences(angles, heights), [0.0]]),
        np.diff(angles),
    )
    # rest at the end, which steps of unequal length miss by little: the smallest change that meets
    # it, in proportion to the acceleration
    left = angles[-1] - angles
    slope = (np.append(steps, 0.0) + np.append(0.0, steps)) / 2
    lift = np.append(steps * (left[:-1] / 2 - steps / 6), 0.0) + np.append(
        0.0, steps * (left[1:] / 2 + steps / 6)
    )
    ends, share = np.stack([lift, slope]), np.abs(bend)
    bend = bend - share * (np.linalg.pinv(ends * share) @ (ends @ bend))
    velocity = np.append(0.0, np.cumsum(steps * (bend[1:] + bend[:-1]) / 2))
    height = np.append(
        0.0, np.cumsum(steps * velocity[:-1] + steps**2 * (bend[:-1] / 3 + bend[1:] / 6))
    )
    return angles, np.column_stack(
        [height[:-1], velocity[:-1], bend[:-1] / 2, np.diff(bend) / steps / 6]
    )
