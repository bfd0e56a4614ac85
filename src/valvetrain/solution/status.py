"""How a run ended: a value, never an exception."""

from __future__ import annotations

from dataclasses import dataclass

#: Every way a run can end (docs/architecture.md).
STATUS_CODES = (
    "completed",
    "not-converged",
    "diverged",
    "coil-bind",
    "solid",
    "buckled",
    "refused",
    "interrupted",
    "worker-lost",
)


@dataclass(frozen=True, slots=True)
class Status:
    """The end of a run: ``code``, what happened, the time reached (s), the place and the remedy.

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
        """One line for people: code, message, time, place and remedy, those that are known."""
        if self.completed and not self.message:
            return "completed"
        place = f" at {self.where}" if self.where else ""
        if (
            self.where and not self.time and self.code in ("not-converged", "diverged")
        ):  # of a spring at rest
            return f"{self.code}: {self.message}, at {self.where}{f'; {self.remedy}' if self.remedy else ''}"
        timeless = (
            self.completed
            or self.code in ("refused", "buckled", "worker-lost")
            or (self.code == "interrupted" and not self.time)
        )
        when = "" if timeless else f", at time {self.time:.6g} s{place}"
        remedy = f"; {self.remedy}" if self.remedy else ""
        return f"{self.code}: {self.message}{when}{remedy}"


COMPLETED = Status()
