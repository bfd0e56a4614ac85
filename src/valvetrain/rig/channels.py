"""Which channel is what, in which unit, on which times; every question that stays open in one
sentence.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.rig.recording import Recording, RigChannel, evenly
from valvetrain.solution.definition import BY_LAST_WORD
from valvetrain.units import DIMENSIONS, Given, dimension_of, parse_quantity, si, unit_factor

#: Question -> how it reads in a refusal.
QUESTIONS = {
    "channels": "which channels are measured quantities, such as spring_force=NAME",
    "shaft": "which channel gives the angle (encoder, pulses or once)",
    "angle_of": "whether the shaft of the angle is the cam or the crank",
    "teeth": "how many teeth the pulses come from",
    "sampling_rate": "the sampling rate",
    "unit": "the unit of {}",
    "calibration": "the calibration of {}",
    "dwell": "the dwell in which the zero is taken, such as '-30, 30 deg'",
}  # fmt: skip
_NOTHING: Mapping[str, str] = MappingProxyType({})
#: Bounds of whole numbers.
_BOUNDS = {"teeth": (1, 100_000), "missing": (0, 10), "angle_count": (8, 28_800)}


@dataclass(frozen=True, kw_only=True)
class RigAnswers:
    """Answers to what a recording leaves open; what is empty is left to the file.

    Parameters
    ----------
    channels : quantity -> name of its channel, such as ``{"spring_force": "Force 1"}``; by names
        that tell, where empty
    encoder : name of the channel of an encoder's angle
    pulses : name of the channel of a toothed wheel or encoder track
    index : name of the channel that marks a place of that wheel
    once : name of a channel of one pulse a turn
    angle_of : ``cam`` or ``crank``: the shaft on which encoder, wheel or pulse sit
    teeth, missing : places on the wheel in one turn, and how many of them side by side are cut away
    units : quantity, or ``encoder``, -> unit, where the file does not say it or says it wrongly
    calibration : quantity -> what one unit of its channel stands for, such as
        ``{"spring_force": "2.5 N"}`` for a bridge in um/m
    shunt : quantity -> step of the channel with the shunt and the load it stands for, such as
        ``{"spring_force": "412, 1000 N"}``
    zero : quantity -> what it is in the dwell, such as ``{"spring_force": "240 N"}``; a lift is
        zero there unless told otherwise
    dwell : first and last cam angle of the dwell; found from the lift, where there is one
    band : Hz, or text; the highest frequency that is kept of every channel, such as the bandwidth
        of the gauge
    angle_count : points of a cam turn; enough for the band, where None
    offset : cam angle of the case at the mark of the rig; found from the lift, where a case is
        given
    sampling_rate : 1/s, or text; where the file has no times
    span : first and last time that are used, s or text
    keep_outliers : keep cycles that differ from all others

    >>> RigAnswers(angle_of="crank", teeth=60, missing=2, band="20 kHz").band
    20000.0
    """

    channels: Mapping[str, str] = field(default_factory=lambda: _NOTHING)
    encoder: str = ""
    pulses: str = ""
    index: str = ""
    once: str = ""
    angle_of: str = ""
    teeth: int | None = None
    missing: int = 0
    units: Mapping[str, str] = field(default_factory=lambda: _NOTHING)
    calibration: Mapping[str, str] = field(default_factory=lambda: _NOTHING)
    shunt: Mapping[str, str] = field(default_factory=lambda: _NOTHING)
    zero: Mapping[str, str] = field(default_factory=lambda: _NOTHING)
    dwell: tuple[Given, Given] | None = None
    band: Given | None = None
    angle_count: int | None = None
    offset: Given | None = None
    sampling_rate: Given | None = None
    span: tuple[Given, Given] | None = None
    keep_outliers: bool = False

    def __post_init__(self) -> None:
        if self.angle_of not in ("", "cam", "crank"):
            raise InputError(
                f"angle_of is cam or crank, not '{str(self.angle_of)[:40]}'; give one of them",
                "angle_of",
            )
        for name, (low, high) in _BOUNDS.items():
            value = getattr(self, name)
            if value is not None and (
                isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high
            ):
                raise InputError(
                    f"{name} is a whole number from {low} to {high}, not {str(value)[:40]}; correct it",
                    name,
                )
        for name in ("band", "sampling_rate"):
            if (given := getattr(self, name)) is not None:
                value = si(given, "frequency", name)
                if not 0 < value < 1e9:
                    raise InputError(
                        f"{name} of {value:g} Hz is none of a rig; give it above zero", name
                    )
                object.__setattr__(self, name, value)
        if self.offset is not None:
            object.__setattr__(self, "offset", si(self.offset, "angle", "offset"))
        if self.dwell is not None:
            if len(self.dwell) != 2:
                raise InputError(
                    "the dwell has two angles, first and last, such as '-30 deg' and '30 deg'; give both",
                    "dwell",
                )
            object.__setattr__(
                self, "dwell", tuple(si(angle, "angle", "dwell") for angle in self.dwell)
            )
        if self.span is not None:
            if len(self.span) != 2:
                raise InputError(
                    "the span has two times, first and last, such as '2 s' and '5 s'; give both",
                    "span",
                )
            first, last = (si(time, "time", "span") for time in self.span)
            if not first < last:
                raise InputError("the span ends before it begins; give first and last time", "span")
            object.__setattr__(self, "span", (first, last))
        if self.teeth is not None and self.missing >= self.teeth:
            raise InputError(
                f"{self.missing} missing teeth of {self.teeth} leave none; teeth counts those that are missing too",
                "missing",
            )


Array = NDArray[np.float64]
#: Words of a channel's name -> quantity; the first that fits.
_MEANINGS = (
    (r"retainer.?force", "retainer_force"), (r"seat.?force", "seat_force"), (r"force|kraft|load", "spring_force"),
    (r"lift|hub\b|displacement", "valve_lift"), (r"accel|beschl", "valve_acceleration"), (r"veloc|geschw", "valve_velocity"),
    (r"strain|dehnung|\bdms\b", "strain"), (r"stress|spannung", "stress"),
)  # fmt: skip
#: Words of a channel's name -> what it tells of the shaft.
_SHAFT = (
    (r"once|trigger|cam.?pulse|tdc|\bot\b|index", "once"), (r"wheel|teeth|tooth|pulses|encoder.?track", "pulses"),
    (r"angle|encoder|winkel|°", "encoder"),
)  # fmt: skip
#: Units as rigs write them -> SI value and dimension, beside those of the package.
_UNITS = {
    "um/m": (1e-6, "ratio"), "µm/m": (1e-6, "ratio"), "μm/m": (1e-6, "ratio"), "ustrain": (1e-6, "ratio"), "µε": (1e-6, "ratio"),
    "uε": (1e-6, "ratio"), "microstrain": (1e-6, "ratio"), "m/m": (1.0, "ratio"), "1": (1.0, "ratio"), "mm/m": (1e-3, "ratio"),
    "m/s2": (1.0, "acceleration"), "°": (np.pi / 180, "angle"), "degrees": (np.pi / 180, "angle"), "grad": (np.pi / 180, "angle"),
    "°CA": (np.pi / 180, "angle"), "degCA": (np.pi / 180, "angle"), "Deg": (np.pi / 180, "angle"),
}  # fmt: skip
#: Times that leave even ones by less than this (steps) are even ones, rounded; a gap is longer than
#: this (steps).
ROUNDED, GAP = 0.75, 1.9
_STANDARD_GRAVITY = 9.80665
#: Samples of a channel of which cycles can be made.
FEWEST = 64


@dataclass(frozen=True, eq=False)
class RigQuantity:
    """A measured quantity in SI, sampled evenly: ``values`` (samples,), ``start`` and ``step`` (s)."""

    quantity: str
    unit: str
    values: Array
    start: float
    step: float
    channel: str


@dataclass(frozen=True, eq=False)
class Chosen:
    """Channels by their meaning: ``measured`` quantities, and what tells the shaft (``kind``:
    encoder, pulses or once; SI for an angle).
    """

    measured: tuple[RigQuantity, ...]
    kind: str
    shaft: RigChannel
    index: RigChannel | None
    notes: tuple[str, ...]


def chosen_channels(recording: Recording, answers: RigAnswers, name: str) -> Chosen:
    """The channels that matter, even in time and in SI.

    Raises :class:`InputError` for a channel that is not there, and one sentence with all questions
    that are open.
    """
    notes: list[str] = list(recording.notes)
    measured = _measured(recording, answers, name)
    kind, shaft = _shaft(recording, answers, name)
    index = _named(recording, answers.index, "index", name) if answers.index else None
    missing = _open_questions(recording, answers, measured, kind, shaft)
    if missing:
        raise InputError(
            f"{name[:80]} does not say {'; '.join(words for _, words in missing)}; answer it",
            missing[0][0],
        )
    assert shaft is not None
    factors = {
        quantity: _factor(quantity, channel, answers) for quantity, channel in measured.items()
    }
    even = {
        id(one): _cut(_even(one, recording, answers, notes), answers.span)  # type: ignore[arg-type]
        for one in (*measured.values(), shaft, *([index] if index else []))
    }
    found = tuple(
        RigQuantity(
            quantity,
            factors[quantity][1],
            at.values * factors[quantity][0],
            at.start,
            at.step,
            one.name,
        )
        for quantity, one, at in (
            (quantity, one, even[id(one)]) for quantity, one in measured.items()
        )
    )
    turned = even[id(shaft)]
    if kind == "encoder":
        told = answers.units.get("encoder") or shaft.unit
        factor, dimension = _known_unit(told or "deg")
        if dimension != "angle":
            raise InputError(
                f"the encoder '{shaft.name[:40]}' is in {told[:20]}, which is no angle; give its unit, or another channel",
                "unit",
            )
        turned = replace(turned, values=turned.values * factor)
        if not told:
            notes.append(f"the angle of '{shaft.name}' is taken to be in degrees")
    return Chosen(found, kind, turned, even[id(index)] if index else None, tuple(notes))


def _cut(channel: RigChannel, span: tuple[float, float] | None) -> RigChannel:
    """The samples within the span (s)."""
    if span is None:
        return channel
    first, last = (
        int(np.clip(np.ceil((time - channel.start) / channel.step), 0, len(channel.values)))
        for time in span
    )
    if last - first < FEWEST:
        raise InputError(
            f"channel '{channel.name[:40]}' holds {last - first} samples in the span, too few for cycles; give another",
            "span",
        )
    return replace(
        channel, values=channel.values[first:last], start=channel.start + first * channel.step
    )


def _measured(recording: Recording, answers: RigAnswers, name: str) -> dict[str, RigChannel]:
    if answers.channels:
        return {
            quantity: _named(recording, channel, "channels", name)
            for quantity, channel in answers.channels.items()
        }
    found: dict[str, RigChannel] = {}
    shaft = {answers.encoder, answers.pulses, answers.index, answers.once}
    for channel in recording.channels:
        word = _meaning(channel.name, _MEANINGS)
        if (
            word
            and channel.name not in shaft
            and not (_meaning(channel.name, _SHAFT) == "encoder" and word == "valve_lift")
        ):
            if word in found:
                raise InputError(
                    f"{name[:80]} has two channels that may be {word}, '{found[word].name[:40]}' and '{channel.name[:40]}'; name one",
                    "channels",
                )
            found[word] = channel
    return found


def _meaning(name: str, table: tuple[tuple[str, str], ...]) -> str:
    return next(
        (word for pattern, word in table if re.search(pattern, name.lower().replace("_", " "))), ""
    )


def _shaft(recording: Recording, answers: RigAnswers, name: str) -> tuple[str, RigChannel | None]:
    """What tells the angle: the channel that was named, else by names; teeth are asked for pulses,
    so a smooth angle goes first.
    """
    for kind in ("pulses", "encoder", "once"):
        if word := getattr(answers, kind):
            return kind, _named(recording, word, kind, name)
    known = {_meaning(channel.name, _SHAFT): channel for channel in reversed(recording.channels)}
    order = ("pulses", "encoder", "once") if answers.teeth else ("encoder", "once", "pulses")
    return next(((kind, known[kind]) for kind in order if kind in known), ("", None))


def _named(recording: Recording, word: str, where: str, name: str) -> RigChannel:
    for channel in recording.channels:
        if channel.name == word:
            return channel
    near = [
        channel
        for channel in recording.channels
        if channel.name.lower().replace("_", " ") == word.lower().replace("_", " ")
    ]
    if len(near) == 1:
        return near[0]
    listed = ", ".join(f"'{channel.name[:30]}'" for channel in recording.channels[:12])
    raise InputError(f"{name[:80]} has no channel '{str(word)[:40]}'; it has {listed}", where)


def _open_questions(
    recording: Recording,
    answers: RigAnswers,
    measured: dict[str, RigChannel],
    kind: str,
    shaft: RigChannel | None,
) -> list[tuple[str, str]]:
    """Question and words of all that neither the file nor the user says."""
    listed = ", ".join(f"'{channel.name[:30]}'" for channel in recording.channels[:12])
    found = []
    if not measured:
        found.append(("channels", f"{QUESTIONS['channels']} (it has {listed})"))
    if shaft is None:
        found.append(
            ("encoder", f"{QUESTIONS['shaft']}{'' if not measured else f' (it has {listed})'}")
        )
    if not answers.angle_of:
        found.append(("angle_of", QUESTIONS["angle_of"]))
    if kind == "pulses" and answers.teeth is None:
        found.append(("teeth", QUESTIONS["teeth"]))
    if (
        any(one.times is None and one.step <= 0 for one in measured.values())
        and _rate(recording, answers) <= 0
    ):
        found.append(("sampling_rate", QUESTIONS["sampling_rate"]))
    for quantity, channel in measured.items():
        told, due = answers.units.get(quantity) or channel.unit, dimension_due(quantity)
        if quantity in answers.calibration or quantity in answers.shunt:
            continue
        if not told and due != "ratio":
            found.append(("unit", QUESTIONS["unit"].format(f"{quantity} ('{channel.name[:40]}')")))
        elif told and _dimension(told, due) != due:
            found.append(
                (
                    "calibration",
                    QUESTIONS["calibration"].format(
                        f"{quantity} ('{channel.name[:40]}' is in {told[:20]})"
                    ),
                )
            )
    return found


def dimension_due(quantity: str) -> str:
    """Dimension that a quantity has by its last word."""
    return BY_LAST_WORD.get(quantity.rsplit("_", 1)[-1], ("ratio", ""))[0]


def _dimension(unit: str, due: str) -> str | None:
    if unit in ("g", "gn") and due == "acceleration":
        return due
    try:
        return _known_unit(unit)[1]
    except InputError:
        return None


def _known_unit(unit: str) -> tuple[float, str | None]:
    """SI value and dimension of a unit as rigs write it."""
    word = unit.strip()
    return _UNITS[word] if word in _UNITS else (unit_factor(word), dimension_of(word))


def _factor(quantity: str, channel: RigChannel, answers: RigAnswers) -> tuple[float, str]:
    """SI value of one of the channel's units, and the SI unit."""
    due = dimension_due(quantity)
    unit = DIMENSIONS[due].si_unit or "1"
    if quantity in answers.calibration:
        return parse_quantity(
            answers.calibration[quantity], due, f"calibration of {quantity}"
        ), unit
    if quantity in answers.shunt:
        step, _, load = answers.shunt[quantity].partition(",")
        try:
            told = float(step)
        except ValueError:
            told = 0.0
        if not np.isfinite(told) or told == 0 or not load:
            raise InputError(
                f"the shunt of {quantity} is the step of its channel and the load, such as '412, 1000 N', not "
                f"'{answers.shunt[quantity][:40]}'",
                "shunt",
            )
        return parse_quantity(load.strip(), due, f"shunt of {quantity}") / told, unit
    told_unit = answers.units.get(quantity) or channel.unit
    if told_unit in ("g", "gn") and due == "acceleration":
        return _STANDARD_GRAVITY, unit
    return (_known_unit(told_unit)[0] if told_unit else 1.0), unit


def _rate(recording: Recording, answers: RigAnswers) -> float:
    if isinstance(answers.sampling_rate, float):
        return answers.sampling_rate
    return next(
        (
            value
            for name, value in recording.scalars.items()
            if name.lower() in ("fs", "sampling_rate", "sample_rate") and value > 0
        ),
        0.0,
    )


def _even(
    channel: RigChannel, recording: Recording, answers: RigAnswers, notes: list[str]
) -> RigChannel:
    """The channel on even times; uneven ones are interpolated, gaps are left open."""
    if len(channel.values) < FEWEST:
        raise InputError(
            f"channel '{channel.name[:40]}' holds {len(channel.values)} samples, too few for cycles; give a longer recording"
        )
    if channel.times is None:
        step = (
            channel.step
            if channel.step > 0 and not answers.sampling_rate
            else 1 / max(_rate(recording, answers), 1e-9)
        )
        return replace(channel, step=step)
    start, step, away = evenly(channel.times, channel.name)
    if away <= ROUNDED:
        return replace(channel, start=start, step=step, times=None)
    usual = float(np.median(np.diff(channel.times)))
    if not usual > 0 or (channel.times[-1] - channel.times[0]) / usual > 4 * len(channel.times):
        raise InputError(
            f"the times of '{channel.name[:40]}' leap; cut the recording to what was recorded in one go"
        )
    grid = np.arange(channel.times[0], channel.times[-1], usual)
    values = np.interp(grid, channel.times, channel.values)
    gaps = np.flatnonzero(np.diff(channel.times) > GAP * usual)
    for gap in gaps[:10_000]:
        values[(grid > channel.times[gap]) & (grid < channel.times[gap + 1])] = np.nan
    words = f", with {len(gaps)} gaps that are left open" if len(gaps) else ""
    notes.append(
        f"the times of '{channel.name}' are uneven{words}; they were interpolated to {1 / usual:.6g} Hz by straight lines"
    )
    return replace(channel, values=values, start=float(grid[0]), step=usual, times=None)
