"""The questions that every table of lifts raises, and the answers that a user gives."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from valvetrain.errors import InputError
from valvetrain.measurements.lift_formats.contract import COLUMN_WORDS
from valvetrain.units import dimension_of

#: Question -> its possible answers; angles and lengths are told in ``lift_unit`` and the like.
CHOICES = {
    "angle_of": ("cam", "crank"), "lift_of": ("valve", "tappet"), "angle_unit": ("deg", "rad"), "zero": ("file", "nose"),
    "direction": ("forward", "reversed"),
}  # fmt: skip
#: What is assumed where nobody answers, and said to be.
ASSUMED = {"angle_unit": "deg", "zero": "file", "direction": "forward"}
#: Question -> how it reads in a refusal.
QUESTIONS = {
    "angle_of": "whether its angles are of the cam or the crank", "lift_of": "whose lift it is, the valve's or the tappet's",
    "lift_unit": "the unit of its lifts, such as mm or inch", "peak_lift": "the largest lift that its fractions mean",
    "duration": "the angle from the first to the last of its fractions", "opening": "the angle at which it begins",
}  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class LiftAnswers:
    """Answers to what a table of lifts leaves open; empty ones are left to the file.

    Parameters
    ----------
    angle_of : ``cam`` or ``crank``; two crank revolutions are one of the cam
    lift_of : ``valve`` or ``tappet``
    angle_unit : ``deg`` (assumed) or ``rad``
    lift_unit : any unit of length, such as ``mm``, ``inch``, ``thou``
    zero : ``file`` (assumed) keeps the angles of the table, ``nose`` puts zero at the place of largest lift
    direction : ``forward`` (assumed): the cam turns with rising angle; ``reversed``: against it, so the table is mirrored
    columns : what each column is, of angle, lift, intake, exhaust, velocity, acceleration and ignore; needed beyond two columns
        that the headings do not name
    peak_lift, duration, opening : of a table of fractions: m; rad of the angle meant by ``angle_of``, length of the event and its begin

    >>> LiftAnswers(angle_of="cam", lift_of="tappet", lift_unit="inch").given("lift_unit")
    'inch'
    """

    angle_of: str = ""
    lift_of: str = ""
    angle_unit: str = ""
    lift_unit: str = ""
    zero: str = ""
    direction: str = ""
    columns: tuple[str, ...] = field(default=())
    peak_lift: float | None = None
    duration: float | None = None
    opening: float | None = None

    def __post_init__(self) -> None:
        for question, choices in CHOICES.items():
            given = getattr(self, question)
            if given and given not in choices:
                raise InputError(f"{question} is {' or '.join(choices)}, not '{given[:40]}'; give one of them", question)
        if self.lift_unit and dimension_of(self.lift_unit) != "length":
            raise InputError(f"lift_unit '{self.lift_unit[:40]}' is no length; use one such as mm or inch", "lift_unit")
        for word in self.columns:
            if word not in COLUMN_WORDS:
                raise InputError(f"a column is one of {', '.join(COLUMN_WORDS)}, not '{word[:40]}'; correct the list", "columns")

    def given(self, question: str) -> Any:
        """The answer to one question, None or empty where it is open."""
        return getattr(self, question)
