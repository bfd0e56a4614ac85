"""The shaft behind the channel that tells it: angle, pulses or one pulse a turn, of cam or crank."""

from __future__ import annotations

import numpy as np

from valvetrain.errors import InputError
from valvetrain.measurements.pulses import Array, Teeth, numbered, rising_edges
from valvetrain.measurements.recording import RigChannel
from valvetrain.measurements.rig_answers import RigAnswers
from valvetrain.measurements.rig_channels import Chosen
from valvetrain.measurements.shaft_angle import TURN, ShaftAngle, shaft_through, told_by_counts, unwrapped

#: Crank turns per cam turn.
RATIO = 2
_HALF = "the mark comes once a crank turn: which of the two turns of a cycle comes first is not known, so angles may be half a cam turn off"


def shaft_of(chosen: Chosen, answers: RigAnswers) -> ShaftAngle:
    """Cam angle over time. Raises :class:`InputError` for pulses that do not fit their wheel and shafts that do not turn."""
    ratio = 1 if answers.angle_of == "cam" else RATIO
    channel = chosen.shaft
    if chosen.kind == "encoder":
        return _by_angle(channel, ratio)
    edges = rising_edges(channel.values, channel.start, channel.step, channel.name)
    if chosen.kind == "once":
        return _by_pulse_a_turn(edges, ratio, channel)
    assert answers.teeth is not None
    teeth = numbered(edges, answers.teeth, answers.missing, channel.name)
    return _by_teeth(teeth, answers.teeth, ratio, channel, chosen.index)


def _by_angle(channel: RigChannel, ratio: int) -> ShaftAngle:
    known = np.isfinite(channel.values)
    if not known.all():
        raise InputError(f"angle '{channel.name[:40]}' has gaps; cut the recording to what was recorded in one go")
    angles, period = unwrapped(channel.values, channel.name)
    times: Array = channel.start + channel.step * np.arange(len(angles), dtype=np.float64)
    notes = []
    if angles[-1] < angles[0]:
        angles = -angles
        notes.append(f"angle '{channel.name}' falls, so its sign is changed: the cam turns with rising angle")
    # how often the file's angle passes zero: a crank's that runs over two turns tells which turn of the cycle it is
    if ratio == RATIO and period == TURN:
        notes.append(_HALF)
    times, angles, least = told_by_counts(angles, times)
    if least:
        notes.append(
            f"angle '{channel.name}' counts in steps of {np.degrees(least):.4g} deg of its shaft; a count is taken as the edge just passed"
        )
    return shaft_through(times, angles / ratio, tuple(notes), channel.name)


def _by_pulse_a_turn(edges: Array, ratio: int, channel: RigChannel) -> ShaftAngle:
    if len(edges) < 4:
        raise InputError(f"channel '{channel.name[:40]}' holds {len(edges)} pulses; one pulse a turn needs four turns")
    intervals = np.diff(edges)
    odd = np.flatnonzero((intervals < 0.6 * np.median(intervals)) | (intervals > 1.6 * np.median(intervals)))
    if len(odd):
        raise InputError(
            f"the pulses of '{channel.name[:40]}' are not one a turn: {len(odd)} intervals leave the others by more than 60 %, the first "
            f"at {edges[odd[0]]:.6g} s; cut the recording, or give teeth if it is a wheel", "once",
        )  # fmt: skip
    notes = ["one pulse a turn shows how the speed changes from turn to turn, by a spline; a change within a turn is not seen"]
    if ratio == RATIO:
        notes.append(_HALF)
    return shaft_through(edges, TURN / ratio * np.arange(len(edges), dtype=np.float64), tuple(notes), channel.name)


def _by_teeth(teeth: Teeth, count: int, ratio: int, channel: RigChannel, index: RigChannel | None) -> ShaftAngle:
    notes = [*teeth.notes]
    zero, every = 0.0, 0
    if index is not None:
        marks = rising_edges(index.values, index.start, index.step, index.name)
        at = np.interp(marks, teeth.times, teeth.numbers.astype(float))
        inside = (marks >= teeth.times[0]) & (marks <= teeth.times[-1])
        if np.count_nonzero(inside) < 2:
            raise InputError(f"channel '{index.name[:40]}' marks fewer than two turns; name another channel, or leave it out", "index")
        zero, every = float(at[inside][0]), round(float(np.median(np.diff(at[inside]))) / count)
        if every not in (1, ratio):
            raise InputError(
                f"'{index.name[:40]}' comes every {np.median(np.diff(at[inside])):.4g} teeth, not once a turn of {count}; correct the "
                "number of teeth", "teeth",
            )  # fmt: skip
    elif len(teeth.marks):
        zero, every = float(teeth.marks[0]), 1
    else:
        notes.append(
            f"'{channel.name}' has no mark, so the angle begins at its first pulse; a case or an offset is needed to relate it to the cam"
        )
    if ratio == RATIO and every == 1:
        notes.append(_HALF)
    angles = np.asarray(TURN / ratio * (teeth.numbers - zero) / count, dtype=np.float64)
    return shaft_through(teeth.times, angles, tuple(notes), channel.name)
