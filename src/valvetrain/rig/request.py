"""What is asked of a recording of a test rig, and what its file leaves open."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from valvetrain.errors import FrozenMapping, InputError
from valvetrain.runs.request_fields import (
    Answers,
    option,
    read_amounts,
    read_case,
    read_choice,
    read_count,
    read_pairs,
    read_path,
    read_switch,
    read_text,
    read_within,
)

if TYPE_CHECKING:
    from valvetrain.parameters.case import Case

FREQUENCY = partial(read_within, "frequency", 1e-9, 1e9)


@dataclass(frozen=True, kw_only=True)
class RigAnswers(Answers):
    """Answers to what a recording leaves open; what is empty is left to the file. Amounts are SI numbers, or text with a unit.

    >>> RigAnswers(angle_of="crank", teeth=60, missing=2, band="20 kHz").band
    20000.0
    """

    channels: Mapping[str, str] = option(
        read_pairs,
        "Channel of it: 'spring_force=Force 1'. Repeatable.",
        "--channel",
        "QUANTITY=NAME",
        default=FrozenMapping(),
        repeatable=True,
    )
    encoder: str = option(
        read_text, "Channel of an encoder's angle.", "--encoder", "NAME", default=""
    )
    pulses: str = option(
        read_text,
        "Channel of a toothed wheel or encoder track; needs --teeth.",
        "--pulses",
        "NAME",
        default="",
    )
    index: str = option(
        read_text, "Channel that marks one position of that wheel.", "--index", "NAME", default=""
    )
    once: str = option(
        read_text, "Channel of one pulse per revolution.", "--once", "NAME", default=""
    )
    angle_of: str = option(
        partial(read_choice, ("cam", "crank")),
        "Shaft on which encoder, wheel or pulse sit.",
        "--angle-of",
        "cam|crank",
        default="",
    )
    teeth: int | None = option(
        partial(read_count, 1, 100_000),
        "Teeth of the wheel, with those that are missing.",
        "--teeth",
        "N",
    )
    missing: int = option(
        partial(read_count, 0, 10),
        "Number of missing teeth at the reference mark.",
        "--missing",
        "N",
        default=0,
    )
    unit: Mapping[str, str] = option(
        read_pairs,
        "Unit of a channel: 'spring_force=kN'. Repeatable.",
        "--unit",
        "QUANTITY=UNIT",
        default=FrozenMapping(),
        repeatable=True,
    )
    calibration: Mapping[str, str] = option(
        read_pairs,
        "Value of one unit of a channel: 'spring_force=2.5 N'; of a shunt its load over the step that it makes.",
        "--calibration",
        "QUANTITY=VALUE",
        default=FrozenMapping(),
        repeatable=True,
    )
    zero: Mapping[str, str] = option(
        read_pairs,
        "Value of a quantity in the dwell: 'spring_force=240 N'.",
        "--zero",
        "QUANTITY=VALUE",
        default=FrozenMapping(),
        repeatable=True,
    )
    dwell: tuple[float, ...] | None = option(
        partial(read_amounts, "angle"),
        "First and last cam angle of the dwell: '-30, 30 deg'.",
        "--dwell",
        "ANGLES",
    )
    band: float | None = option(
        FREQUENCY, "Highest frequency to retain: '20 kHz'.", "--band", "FREQUENCY"
    )
    angle_count: int | None = option(
        partial(read_count, 8, 28_800),
        "Points per cam revolution (default: as the band needs).",
        "--angle-count",
        "N",
    )
    offset: float | None = option(
        partial(read_within, "angle", -1e6, 1e6),
        "Cam angle of the case at the mark, instead of by the lift.",
        "--offset",
        "ANGLE",
    )
    sampling_rate: float | None = option(
        FREQUENCY, "Where the file has no times: '100 kHz'.", "--sampling-rate", "FREQUENCY"
    )
    span: tuple[float, ...] | None = option(
        partial(read_amounts, "time"),
        "First and last time that are used: '2, 5 s'.",
        "--span",
        "TIMES",
    )
    keep_outliers: bool = option(
        read_switch, "Retain outlier cycles too.", "--keep-outliers", default=False
    )

    def __post_init__(self) -> None:
        """Raise :class:`InputError` for ends that are not two or out of order, and a wheel without a tooth."""
        super().__post_init__()
        for name, example in (("dwell", "-30, 30 deg"), ("span", "2, 5 s")):
            if (ends := getattr(self, name)) is not None and len(ends) != 2:
                raise InputError(f"the {name} has two ends, first and last: '{example}'", name)
        if self.span is not None and not self.span[0] < self.span[1]:
            raise InputError("the span ends before it begins; give first and last time", "span")
        if self.teeth is not None and self.missing >= self.teeth:
            raise InputError(
                f"{self.missing} missing teeth of {self.teeth} leave none; teeth counts those that are missing too",
                "teeth",
            )


@dataclass(frozen=True, kw_only=True)
class RigRequest(RigAnswers):
    """A recording as cycles over the cam angle."""

    command = "rig"

    file: Path = option(
        read_path,
        "Recording: text, MDF, TDMS, MAT, HDF5 or UFF58; read by content.",
        metavar="FILE",
    )
    case: Case | None = option(
        read_case, "Case whose lift gives the cam angle of the mark.", "--case", "CASE"
    )
