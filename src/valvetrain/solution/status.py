"""How a run ended (a value, never an exception), what happened in it, what it rests on, and which part of a result failed."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import NamedTuple, ParamSpec, TypeVar

from valvetrain.errors import FrozenMapping, InputError

#: Every way a run can end (docs/architecture.md).
STATUS_CODES = (
    "completed",
    "not-converged",
    "diverged",
    "out-of-range",
    "coil-bind",
    "solid",
    "buckled",
    "refused",
    "interrupted",
    "worker-lost",
)


@dataclass(frozen=True, slots=True)
class Status:
    """The end of a run: ``code``, message, the time reached (s), the location and the remedy.

    Raises :class:`ValueError` for a code outside :data:`STATUS_CODES`.

    >>> Status("coil-bind", "the spring is solid at 11.2 mm of lift", remedy="take a longer spring").completed
    False
    """

    code: str = "completed"
    message: str = ""
    time: float = 0.0
    where: str = ""
    remedy: str = ""

    def __post_init__(self) -> None:
        if self.code not in STATUS_CODES:
            raise ValueError(
                f"status code '{self.code}' is unknown; use one of {', '.join(STATUS_CODES)}"
            )

    @property
    def completed(self) -> bool:
        """True when the run reached its end."""
        return self.code == "completed"

    def sentence(self) -> str:
        """One line of text: code, message, time, location and remedy, where known."""
        if self.completed and not self.message:
            return "completed"
        remedy = f"; {self.remedy}" if self.remedy else ""
        when = f", at time {self.time:.6g} s" + (f" at {self.where}" if self.where else "")
        if self.where and not self.time and self.code in ("not-converged", "diverged"):
            when = f", at {self.where}"  # of a spring at rest
        elif self.completed or self.code in ("refused", "buckled", "worker-lost"):
            when = ""
        elif self.code == "interrupted" and not self.time:
            when = ""
        return f"{self.code}: {self.message}{when}{remedy}"


COMPLETED = Status()


class Cause(StrEnum):
    """Why an event happened, as its detail ``cause``.

    Of a loss of contact or float: the inertia of rigid parts exceeds the spring force, surge lowers that
    force, or the parts vibrate. Of a clash: coils strike, or come to rest on each other as the spring closes. Of a
    seating: the closing flank or a bounce ends. Of a bounce: a rebound, or one with the spring force lowered by surge.
    """

    INERTIA = "inertia"
    SURGE = "surge"
    VIBRATION = "vibration"
    COILS_STRIKE = "coils-strike"
    COILS_REST = "coils-rest"
    FLANK_ENDS = "flank-ends"
    BOUNCE_ENDS = "bounce-ends"
    REBOUND = "rebound"
    REBOUND_IN_SURGE = "rebound-in-surge"


#: Types of the details of an event, all of which can be stored.
Detail = float | int | str | bool


@dataclass(frozen=True)
class Event:
    """One event: ``cam_angle`` (rad, unwrapped) and ``time`` (s) of its start, ``duration`` (s),
    ``size`` in ``unit``. ``where``: code of a contact (``valve_tip``), or the coils. ``counts``: False of
    a loss of contact near the seat, which loses no control of the valve.

    Kind ``clash``: size = peak contact force (N); details hold ``impulse`` (N s), ``energy`` (J),
    ``upper_coil``, ``lower_coil``.

    >>> event = Event("clash", cam_angle=4.2, time=0.012, duration=2e-4, size=310.0, unit="N", where="coils 1-2")
    >>> event.kind, event.size
    ('clash', 310.0)
    """

    kind: str
    cam_angle: float
    time: float
    duration: float
    size: float
    unit: str
    where: str = ""
    details: Mapping[str, Detail] = field(default_factory=dict)
    counts: bool = True

    def __post_init__(self) -> None:
        # a code is plain text, as it comes back from a file
        object.__setattr__(self, "details", FrozenMapping(
            {name: getattr(one, "value", one) for name, one in self.details.items()}
        ))  # fmt: skip


class Fact(NamedTuple):
    """A ``code``, such as ``card-alone``, with its ``fields``: SI numbers, names and words; NaN for an unknown number.

    >>> Fact("card-alone", {"spring": "outer"}).fields["spring"]
    'outer'
    """

    code: str
    fields: Mapping[str, Detail] = {}


P = ParamSpec("P")
Part = TypeVar("Part")
#: Environment variable that lets unexpected errors pass with their traceback.
TRACEBACK_VARIABLE = "VALVETRAIN_TRACEBACK"


@dataclass
class PartialFailures:
    """Collects a sentence per part that failed, and why, each once.

    >>> failures = PartialFailures()
    >>> failures.part("share of closed coils", {}, lambda: {"share": 1 / 0})
    {}
    >>> failures.sentences
    ('share of closed coils: ZeroDivisionError: division by zero',)
    """

    sentences: tuple[str, ...] = ()

    def add(self, sentence: str) -> None:
        """Add the sentence of a failure."""
        self.sentences = tuple(dict.fromkeys((*self.sentences, sentence)))

    def part(
        self, name: str, instead: Part, build: Callable[P, Part], /, *args: P.args, **more: P.kwargs
    ) -> Part:
        """The result of ``build(*args)``; where it fails, ``instead``, and the failure is added."""
        try:
            return build(*args, **more)
        except Exception as error:  # whatever it is, the other parts of the result are there
            if os.environ.get(TRACEBACK_VARIABLE):
                raise
            self.add(f"{name}: {reason(error)}")
            return instead


def reason(error: BaseException) -> str:
    """What happened in one line; an unexpected error with its kind."""
    message = " ".join(str(error).split())
    if isinstance(error, MemoryError):
        return "the memory was not enough"
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    return message if isinstance(error, InputError) else f"{type(error).__name__}: {message}"
