"""Chooses and converts the channels of a recording: which is what, in which unit, at which times.

All questions that the file and the user leave open are listed in one sentence.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.measured.door import refuse_beyond
from valvetrain.measured.tables import UNIT_NAMES
from valvetrain.rig.reader import Recording, RigChannel
from valvetrain.rig.request import RigAnswers
from valvetrain.solution.definition import BY_LAST_WORD
from valvetrain.units import (
    DIMENSIONS,
    dimension_of,
    parse_quantity,
    unit_factor,
)

#: How the question of the dwell reads in a refusal.
DWELL = "the dwell in which the zero is taken, such as '-30, 30 deg'"
#: Pattern of a channel's name -> quantity; the first that fits.
_MEANINGS = (
    (r"retainer.?force", "retainer_force"), (r"seat.?force", "seat_force"), (r"force|kraft|load", "spring_force"),
    (r"lift|hub\b|displacement", "valve_lift"), (r"accel|beschl", "valve_acceleration"), (r"veloc|geschw", "valve_velocity"),
    (r"strain|dehnung|\bdms\b", "strain"), (r"stress|spannung", "stress")
)  # fmt: skip
#: Pattern of a channel's name -> how it gives the angle of the shaft.
_SHAFT = (
    (r"once|trigger|cam.?pulse|tdc|\bot\b|index", "once"), (r"wheel|teeth|tooth|pulses|encoder.?track", "pulses"),
    (r"angle|encoder|winkel|°", "encoder")
)  # fmt: skip
#: Units as rigs write them -> units of the package.
_UNITS = {
    **UNIT_NAMES, "ustrain": "um/m", "µε": "um/m", "uε": "um/m", "με": "um/m", "microstrain": "um/m", "m/s2": "m/s^2"
}  # fmt: skip
_STANDARD_GRAVITY = 9.80665
#: Times that differ from even ones by less than this (steps) are even ones, rounded; a gap is
#: longer than this (steps).
ROUNDED, GAP = 0.75, 1.9
#: Samples of a channel of which cycles can be made, at least.
MIN_SAMPLES = 64


@dataclass(frozen=True, eq=False)
class RigQuantity:
    """A measured quantity in SI, sampled evenly: ``values`` (samples,), ``start`` and ``step`` (s)."""

    quantity: str
    unit: str
    values: Array
    start: float
    step: float
    channel: str


class ChosenChannels(NamedTuple):
    """Channels by their meaning: ``measured`` quantities, and the channel of the shaft (``kind``:
    encoder, pulses or once; SI for an angle).
    """

    measured: tuple[RigQuantity, ...]
    kind: str
    shaft: RigChannel
    index_channel: RigChannel | None
    notes: tuple[str, ...]


def choose_channels(recording: Recording, answers: RigAnswers, file_name: str) -> ChosenChannels:
    """The channels that matter, even in time and in SI.

    Raises :class:`InputError` for a channel that is not there, and one sentence with all questions
    that are open.
    """
    notes = list(recording.notes)
    channels = _measured_channels(recording, answers, file_name)
    kind, shaft = _shaft_channel(recording, answers, file_name)
    index = _by_name(recording, answers.index, "index", file_name) if answers.index else None
    questions = _open_questions(recording, answers, channels, kind, shaft)
    if questions:
        raise InputError(
            f"{file_name[:80]} does not say {'; '.join(text for _, text in questions)}; answer it",
            questions[0][0],
        )
    assert shaft is not None
    for channel in (*channels.values(), shaft):
        refuse_beyond(channel.values, "", f"channel '{channel.name[:80]}' of {file_name[:80]}")

    def sampled(channel: RigChannel) -> RigChannel:
        return _cut(_even(channel, recording, answers, notes), answers.span)  # type: ignore[arg-type]

    measured = []
    for quantity, channel in channels.items():
        (factor, unit), even = _scale(quantity, channel, answers), sampled(channel)
        measured.append(
            RigQuantity(quantity, unit, even.values * factor, even.start, even.step, channel.name)
        )
    angle = sampled(shaft)
    if kind == "encoder":
        unit = answers.unit.get("encoder") or shaft.unit
        factor, dimension = _unit_scale(unit or "deg", "angle")
        if dimension != "angle":
            raise InputError(
                f"the encoder '{shaft.name[:40]}' is in {unit[:20]}, which is no angle; give its unit, or another channel",
                "unit",
            )
        angle = replace(angle, values=angle.values * factor)
        if not unit:
            notes.append(f"the angle of '{shaft.name}' is taken to be in degrees")
    marks = sampled(index) if index else None
    return ChosenChannels(tuple(measured), kind, angle, marks, tuple(notes))


def _cut(channel: RigChannel, span: tuple[float, float] | None) -> RigChannel:
    """The samples within the span (s)."""
    if span is None:
        return channel
    first, last = (
        int(np.clip(np.ceil((time - channel.start) / channel.step), 0, len(channel.values)))
        for time in span
    )
    if last - first < MIN_SAMPLES:
        raise InputError(
            f"channel '{channel.name[:40]}' holds {last - first} samples in the span, too few for cycles; give another",
            "span",
        )
    return replace(
        channel, values=channel.values[first:last], start=channel.start + first * channel.step
    )


def _measured_channels(
    recording: Recording, answers: RigAnswers, file_name: str
) -> dict[str, RigChannel]:
    """Quantity -> its channel: those that were named, else by the channels' names."""
    if answers.channels:
        return {
            quantity: _by_name(recording, channel, "channels", file_name)
            for quantity, channel in answers.channels.items()
        }
    channels: dict[str, RigChannel] = {}
    shaft = {answers.encoder, answers.pulses, answers.index, answers.once}
    for channel in recording.channels:
        quantity = _first_match(channel.name, _MEANINGS)
        if not quantity or channel.name in shaft:
            continue
        if quantity == "valve_lift" and _first_match(channel.name, _SHAFT) == "encoder":
            continue
        if quantity in channels:
            raise InputError(
                f"{file_name[:80]} has two channels that may be {quantity}, '{channels[quantity].name[:40]}' and '{channel.name[:40]}'; "
                "name one",
                "channels",
            )
        channels[quantity] = channel
    return channels


def _plain_name(name: str) -> str:
    return name.lower().replace("_", " ")


def _first_match(name: str, patterns: tuple[tuple[str, str], ...]) -> str:
    return next((key for pattern, key in patterns if re.search(pattern, _plain_name(name))), "")


def _shaft_channel(
    recording: Recording, answers: RigAnswers, file_name: str
) -> tuple[str, RigChannel | None]:
    """Kind and channel of the angle: the one that was named, else by names; pulses need the number
    of teeth, so a smooth angle goes first.
    """
    for kind in ("pulses", "encoder", "once"):
        if name := getattr(answers, kind):
            return kind, _by_name(recording, name, kind, file_name)
    by_kind = {
        _first_match(channel.name, _SHAFT): channel for channel in reversed(recording.channels)
    }
    order = ("pulses", "encoder", "once") if answers.teeth else ("encoder", "once", "pulses")
    return next(((kind, by_kind[kind]) for kind in order if kind in by_kind), ("", None))


def _by_name(recording: Recording, name: str, question: str, file_name: str) -> RigChannel:
    """The channel of that name, or the only one that differs in case and underscores alone."""
    for channel in recording.channels:
        if channel.name == name:
            return channel
    near = [
        channel for channel in recording.channels if _plain_name(channel.name) == _plain_name(name)
    ]
    if len(near) == 1:
        return near[0]
    raise InputError(
        f"{file_name[:80]} has no channel '{str(name)[:40]}'; it has {_listed(recording)}", question
    )


def _listed(recording: Recording) -> str:
    return ", ".join(f"'{channel.name[:30]}'" for channel in recording.channels[:12])


def _open_questions(
    recording: Recording,
    answers: RigAnswers,
    measured: dict[str, RigChannel],
    kind: str,
    shaft: RigChannel | None,
) -> list[tuple[str, str]]:
    """Question, and its text in a refusal, of all that neither the file nor the user answers."""
    listed = f" (it has {_listed(recording)})"
    questions = []
    if not measured:
        questions.append(
            (
                "channels",
                f"which channels are measured quantities, such as spring_force=NAME{listed}",
            )
        )
    if shaft is None:
        questions.append(
            (
                "encoder",
                f"which channel gives the angle (encoder, pulses or once){listed if measured else ''}",
            )
        )
    if not answers.angle_of:
        questions.append(
            ("angle_of", "whether the shaft of the angle is the cam or the crank (angle_of)")
        )
    if kind == "pulses" and answers.teeth is None:
        questions.append(("teeth", "how many teeth the pulses come from (teeth)"))
    if (
        any(sampled.times is None and sampled.step <= 0 for sampled in measured.values())
        and _sampling_rate(recording, answers) <= 0
    ):
        questions.append(("sampling_rate", "the sampling rate (sampling_rate)"))
    for quantity, channel in measured.items():
        if quantity in answers.calibration:
            continue
        unit, due = answers.unit.get(quantity) or channel.unit, dimension_due(quantity)
        label = f"{quantity} ('{channel.name[:40]}'"
        if not unit and due != "ratio":
            questions.append(("unit", f"the unit of {label})"))
        elif unit and _unit_scale(unit, due)[1] != due:
            questions.append(("calibration", f"the calibration of {label} is in {unit[:20]})"))
    return questions


def dimension_due(quantity: str) -> str:
    """Dimension that a quantity has by its last word."""
    return BY_LAST_WORD.get(quantity.rsplit("_", 1)[-1], ("ratio", ""))[0]


def _unit_scale(unit: str, due: str) -> tuple[float, str | None]:
    """SI value and dimension of a unit as rigs write it, of a channel of dimension ``due``; none of an unknown one."""
    if due == "acceleration" and unit in ("g", "gn"):
        return _STANDARD_GRAVITY, due
    word = _UNITS.get(unit.strip().lower(), unit.strip())
    try:
        return unit_factor(word), dimension_of(word)
    except InputError:
        return np.nan, None


def _scale(quantity: str, channel: RigChannel, answers: RigAnswers) -> tuple[float, str]:
    """SI value of one of the channel's units, and the SI unit."""
    due = dimension_due(quantity)
    si_unit = DIMENSIONS[due].si_unit or "1"
    if quantity in answers.calibration:
        calibration = answers.calibration[quantity]
        return parse_quantity(calibration, due, f"calibration of {quantity}"), si_unit
    unit = answers.unit.get(quantity) or channel.unit
    return (_unit_scale(unit, due)[0] if unit else 1.0), si_unit


def _sampling_rate(recording: Recording, answers: RigAnswers) -> float:
    """Sampling rate (1/s) that the user or the file gives; 0 where neither does."""
    if answers.sampling_rate is not None:
        return answers.sampling_rate
    names = ("fs", "sampling_rate", "sample_rate")
    rates = (value for name, value in recording.scalars.items() if name.lower() in names)
    return next((rate for rate in rates if rate > 0), 0.0)


def _even(
    channel: RigChannel, recording: Recording, answers: RigAnswers, notes: list[str]
) -> RigChannel:
    """The channel on even times; uneven ones are interpolated, gaps are left open."""
    count, times = len(channel.values), channel.times
    if count < MIN_SAMPLES:
        raise InputError(
            f"channel '{channel.name[:40]}' holds {count} samples, too few for cycles; give a longer recording"
        )
    if times is None:
        if channel.step > 0 and not answers.sampling_rate:
            return channel
        return replace(channel, step=1 / max(_sampling_rate(recording, answers), 1e-9))
    steps = np.diff(times)
    if not np.isfinite(times).all() or not (steps >= 0).all() or times[-1] <= times[0]:
        raise InputError(
            f"the times of '{channel.name[:80]}' do not rise; correct them or leave them out and give the sampling rate"
        )
    samples = np.arange(len(times))
    step = float(times[-1] - times[0]) / (len(times) - 1)
    start = float(np.mean(times - step * samples))
    if float(np.max(np.abs(times - start - step * samples))) / step <= ROUNDED:
        return replace(channel, start=start, step=step, times=None)
    step = float(np.median(steps))
    if not step > 0 or (times[-1] - times[0]) / step > 4 * len(times):
        raise InputError(
            f"the times of '{channel.name[:40]}' leap; cut the recording to what was recorded in one go"
        )
    grid = np.arange(times[0], times[-1], step)
    values = np.interp(grid, times, channel.values)
    gaps = np.flatnonzero(steps > GAP * step)
    for gap in gaps[:10_000]:
        values[(grid > times[gap]) & (grid < times[gap + 1])] = np.nan
    left_open = f", with {len(gaps)} gaps that are left open" if len(gaps) else ""
    notes.append(
        f"the times of '{channel.name}' are uneven{left_open}; they were interpolated to {1 / step:.6g} Hz by straight lines"
    )
    return replace(channel, values=values, start=float(grid[0]), step=step, times=None)
