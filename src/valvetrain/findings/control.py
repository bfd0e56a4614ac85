"""Up to which engine speed a train is controlled, and what is lost from where: the loss that stays, and the short
ranges of lost contact below it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from valvetrain.solution.critical import CriticalSpeed, SpeedBracket
from valvetrain.solution.study import Study


@dataclass(frozen=True)
class Loss:
    """One kind of lost control: its critical speed, and the ranges of engine speed (rad/s) that hold it, from 0 where
    it is lost from the first speed searched on.
    """

    row: CriticalSpeed
    ranges: tuple[SpeedBracket, ...]

    @property
    def begin(self) -> float:
        """Engine speed (rad/s) from which control is lost."""
        return self.ranges[0].lower_engine_speed

    @property
    def at_onset(self) -> bool:
        """Whether it begins at the onset that the search looked at, whose cause is known."""
        return self.begin in (0.0, self.row.engine_speed)


@dataclass(frozen=True)
class Control:
    """What a search found of a label: ``losses`` by their begin, and ``islands``, short ranges of lost contact below all
    of them in which the valve neither floats nor bounces; ``contact`` is the row of those. ``unknown``: ranges of which
    the runs say nothing, and ``silent``: the engine speed (rad/s) below the losses from which control is not known to be kept.
    """

    losses: tuple[Loss, ...] = ()
    islands: tuple[SpeedBracket, ...] = ()
    contact: CriticalSpeed | None = None
    unknown: tuple[SpeedBracket, ...] = ()
    silent: float = math.inf

    @property
    def limit(self) -> float:
        """Engine speed (rad/s) up to which the train is known to be controlled but for the islands; infinite for never lost."""
        return min((self.silent, *(one.begin for one in self.losses)))

    def spans(self, kind: str) -> tuple[SpeedBracket, ...]:
        """All ranges of engine speed (rad/s) that hold one kind of loss, islands among them."""
        short = self.islands if kind == "contact-loss" else ()
        return (
            *short,
            *(span for one in self.losses if one.row.kind == kind for span in one.ranges),
        )


def control_of(study: Study, label: str) -> Control:
    """The control of a label by the critical speeds of a study.

    Parameters
    ----------
    study : a sweep; of any other study nothing is lost
    label : of its runs

    Returns
    -------
    Control, whose ``limit`` is infinite where nothing is lost

    Examples
    --------
    >>> from valvetrain.solution.provenance import CaseRecord
    >>> control_of(Study(CaseRecord("own")), "stock").limit
    inf
    """
    found = study.critical_speeds
    losses = [Loss(row, ranges) for row, ranges in found.limiting(label) if ranges]
    ordered = tuple(sorted(losses, key=lambda one: one.begin))
    contact = found.of("contact-loss", label)
    if contact is None:
        return Control(ordered)
    silent = min((one.lower_engine_speed for one in contact.silent), default=math.inf)
    if ordered and silent > ordered[0].begin:
        silent = math.inf
    if not contact.found:
        return Control(ordered, unknown=contact.pulled, silent=silent)
    return Control(ordered, contact.ranges[: contact.short_count], contact, contact.pulled, silent)
