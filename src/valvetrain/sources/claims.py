"""What a published study claims of two numbers, and whether the runs of a study bear it out."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from pydantic.dataclasses import dataclass as table

from valvetrain.parameters.schema_types import AngularSpeed
from valvetrain.solution.comparison import Finding
from valvetrain.solution.display import value_text
from valvetrain.solution.quantity import same_speed, unit_of
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study
from valvetrain.sources.readings import KNOWN_KEYS

#: Parts of the open valve over which two runs are compared.
Part = Literal["", "opening", "closing"]


@table(frozen=True, config=KNOWN_KEYS)
class Term:
    """One side of a claim: a ``value`` (SI), or ``times`` a ``quantity`` of the ``run`` of that label.

    With ``beside``, the label of another run, ``quantity`` is a channel: the root mean square of the
    difference of both runs while the rigid valve is open, or over a ``part`` of that.
    """

    run: str = ""
    quantity: str = ""
    value: float = math.nan
    times: float = 1.0
    beside: str = ""
    part: Part = ""

    def number(self, study: Study, engine_speed: float | None) -> float | None:
        """The SI value; None without such a run, NaN where the run has no such number."""
        if not self.run:
            return self.value
        pair = [run_of(study, label, engine_speed) for label in (self.run, self.beside) if label]
        if pair[0] is None or pair[-1] is None:
            return None
        if self.beside:
            return self.times * departure(pair[0], pair[-1], self.quantity, self.part)
        return self.times * pair[0].quantities.get(self.quantity, math.nan)

    def text(self, number: float, like: str = "") -> str:
        """A number of this side with its unit and its runs; a plain value in the unit of a quantity ``like`` it."""
        unit = "N" if self.beside else unit_of(self.quantity or like)
        if not self.run:
            return value_text(number, unit, 4)
        times = f"{self.times:g} times " if self.times != 1 else ""
        runs = f"{self.run} less {self.beside}" if self.beside else self.run
        return f"{value_text(number, unit, 4)} ({times}{runs})"


@table(frozen=True, config=KNOWN_KEYS)
class Claim:
    """A ``statement`` of a study at a ``place`` in it: ``left`` is greater than ``right``, or equal to it
    within a share.

    ``engine_speed`` in rad/s of the crank; None for the only one of each label.
    """

    place: str
    statement: str
    left: Term
    right: Term
    relation: Literal["greater", "equal"] = "greater"
    within: float = 0.0
    engine_speed: AngularSpeed | None = None

    def finding(self, study: Study) -> Finding | None:
        """The claim with the computed numbers; None where the study lacks one of the runs.

        A run without the number does not show what is claimed.
        """
        left, right = (one.number(study, self.engine_speed) for one in (self.left, self.right))
        if left is None or right is None:
            return None
        if math.isnan(left) or math.isnan(right):
            return Finding(self.place, self.statement, "no such number", "not seen")
        greater = self.relation == "greater"
        holds = left > right if greater else abs(left - right) <= self.within * abs(right)
        computed = f"{self.left.text(left)}, against {self.right.text(right, self.left.quantity)}"
        return Finding(self.place, self.statement, computed, "agrees" if holds else "not seen")


def run_of(study: Study, label: str, engine_speed: float | None) -> Solution | None:
    """The run of a label at an engine speed (rad/s; None: its first) that has numbers."""
    return next(
        (
            run
            for run in study.runs(label)
            if run.quantities
            and (engine_speed is None or same_speed(run.engine_speed, engine_speed))
        ),
        None,
    )


def departure(run: Solution, other: Solution, channel: str, part: Part = "") -> float:
    """Root mean square (SI) of a channel less that of another run over the open valve or a part of it;
    NaN where a run has no such channel.
    """
    if not (run.has(channel, "rigid_valve_lift") and other.has(channel)):
        return math.nan
    lift, mine, theirs = (
        run.channel("rigid_valve_lift"),
        run.channel(channel),
        other.channel(channel),
    )
    if len(theirs) != len(mine):
        theirs = np.interp(run.cam_angle, other.cam_angle, theirs, period=2 * np.pi)
    late = np.arange(len(lift)) > int(np.argmax(lift))
    parts = {"": lift > 0, "opening": (lift > 0) & ~late, "closing": (lift > 0) & late}
    return float(np.sqrt(np.mean((mine - theirs)[parts[part]] ** 2)))
