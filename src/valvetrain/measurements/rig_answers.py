"""What a recording of a test rig leaves open, and the answers that a user gives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from valvetrain.errors import InputError
from valvetrain.units import Given, si

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
    channels : quantity -> name of its channel, such as ``{"spring_force": "Force 1"}``; by names that tell, where empty
    encoder : name of the channel of an encoder's angle
    pulses : name of the channel of a toothed wheel or encoder track
    index : name of the channel that marks a place of that wheel
    once : name of a channel of one pulse a turn
    angle_of : ``cam`` or ``crank``: the shaft on which encoder, wheel or pulse sit
    teeth, missing : places on the wheel in one turn, and how many of them side by side are cut away
    units : quantity, or ``encoder``, -> unit, where the file does not say it or says it wrongly
    calibration : quantity -> what one unit of its channel stands for, such as ``{"spring_force": "2.5 N"}`` for a bridge in um/m
    shunt : quantity -> step of the channel with the shunt and the load it stands for, such as ``{"spring_force": "412, 1000 N"}``
    zero : quantity -> what it is in the dwell, such as ``{"spring_force": "240 N"}``; a lift is zero there unless told otherwise
    dwell : first and last cam angle of the dwell; found from the lift, where there is one
    band : Hz, or text; the highest frequency that is kept of every channel, such as the bandwidth of the gauge
    angle_count : points of a cam turn; enough for the band, where None
    offset : cam angle of the case at the mark of the rig; found from the lift, where a case is given
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
            raise InputError(f"angle_of is cam or crank, not '{str(self.angle_of)[:40]}'; give one of them", "angle_of")
        for name, (low, high) in _BOUNDS.items():
            value = getattr(self, name)
            if value is not None and (isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high):
                raise InputError(f"{name} is a whole number from {low} to {high}, not {str(value)[:40]}; correct it", name)
        for name in ("band", "sampling_rate"):
            if (given := getattr(self, name)) is not None:
                value = si(given, "frequency", name)
                if not 0 < value < 1e9:
                    raise InputError(f"{name} of {value:g} Hz is none of a rig; give it above zero", name)
                object.__setattr__(self, name, value)
        if self.offset is not None:
            object.__setattr__(self, "offset", si(self.offset, "angle", "offset"))
        if self.dwell is not None:
            if len(self.dwell) != 2:
                raise InputError("the dwell has two angles, first and last, such as '-30 deg' and '30 deg'; give both", "dwell")
            object.__setattr__(self, "dwell", tuple(si(angle, "angle", "dwell") for angle in self.dwell))
        if self.span is not None:
            if len(self.span) != 2:
                raise InputError("the span has two times, first and last, such as '2 s' and '5 s'; give both", "span")
            first, last = (si(time, "time", "span") for time in self.span)
            if not first < last:
                raise InputError("the span ends before it begins; give first and last time", "span")
            object.__setattr__(self, "span", (first, last))
        if self.teeth is not None and self.missing >= self.teeth:
            raise InputError(f"{self.missing} missing teeth of {self.teeth} leave none; teeth counts those that are missing too", "missing")
