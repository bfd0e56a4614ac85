"""Limit speeds as outputs of a study: what they cost, what cannot be had, and their columns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.explore.engine import Engine, Evaluation
from valvetrain.explore.measure import (
    BELOW,
    BEYOND,
    CLOSER,
    LIMIT,
    Measure,
    Measured,
    measure_designs,
)
from valvetrain.explore.outputs import LimitSearch
from valvetrain.explore.space import ENGINE_SPEED
from valvetrain.explore.table import LimitEnd
from valvetrain.quantities.request import is_at_rest
from valvetrain.solution.definition import (
    definition_of,
    is_defined,
    no_quantity,
    not_given,
)
from valvetrain.solution.status import Status

Array = NDArray[np.float64]


def refuse_limits(experiment: Evaluation) -> None:
    """Raise :class:`InputError` for a limit speed that no point of the experiment can have."""
    for limit in experiment.outputs.limit_speeds:
        if experiment.case is None:
            raise InputError("a function has no limit speed; give a case")
        if limit.share is not None:
            raise InputError("a bound as a share of the case belongs to a search; give a number")
        if not is_defined(limit.quantity):
            raise InputError(no_quantity(limit.quantity))
        if any(one.key == ENGINE_SPEED for one in experiment.space):
            raise InputError(
                "the engine speed is varied, and a limit speed is one; remove one of them"
            )
        row = definition_of(limit.quantity)
        if is_at_rest(limit.quantity):
            raise InputError(
                f"the {row.label} belongs to springs at rest, so it has no limit speed"
            )
        kind = "spring" if experiment.case.train is None else "train"
        if row.systems and kind not in row.systems:
            raise InputError(
                f"a {kind} has no {row.label} ({limit.quantity}), so its limit speed cannot be had; choose another",
            )


@dataclass(frozen=True)
class LimitColumns:
    """Limit speeds ``values`` (draws, runs, limits) in rad/s, nan where there is none; ``failures``:
    status by (draw, run) of those that could not be searched; ``ends`` of the search that were met.
    """

    values: Array
    failures: dict[tuple[int, int], Status]
    ends: tuple[LimitEnd, ...]


class LimitColumnsSearch:
    """The searches of an experiment's limit speeds through an engine."""

    def __init__(self, engine: Engine, experiment: Evaluation) -> None:
        self.engine, self.experiment = engine, experiment
        self.searches: list[tuple[LimitSearch, Evaluation]] = []
        for limit in experiment.outputs.limit_speeds:
            outputs = experiment.outputs.of(limit.quantity)
            own = Evaluation(experiment.case, experiment.space, outputs, experiment.runs)
            engine.include(own)
            self.searches.append((limit, own))

    def probe(self) -> None:
        """Raise :class:`InputError` where the middle of the space runs at the lowest speed and has not
        the quantity.
        """
        middle = tuple(one.distribution.middle for one in self.experiment.space)
        kinds = dict.fromkeys(run[1:] for run in self.experiment.runs)
        for limit, own in self.searches:
            jobs = [(own, middle, (limit.engine_speeds[0], *kind)) for kind in kinds]
            for kind, one in zip(kinds, self.engine.outcomes(jobs), strict=True):
                if one.status.completed and limit.quantity not in one.values:
                    by = f" by {kind[0]}" if kind[0] else ""
                    raise InputError(f"{not_given(limit.quantity, one.values)}{by}", "limit_speed")

    def columns(self, draws: Array) -> LimitColumns:
        """All limit speeds of the ``draws`` (n, d)."""
        runs = self.experiment.runs
        kinds = list(dict.fromkeys(run[1:] for run in runs))
        values = np.full((len(draws), len(runs), len(self.searches)), np.nan)
        failures: dict[tuple[int, int], Status] = {}
        met: list[LimitEnd] = []
        for column, (limit, own) in enumerate(self.searches):
            ends: list[str] = []
            for kind in kinds:
                measure = Measure(LIMIT, limit.quantity, ((None, *kind),), "", True, "worst", limit)
                subjects = [({LIMIT: own}, tuple(row)) for row in draws.tolist()]
                found = measure_designs(self.engine, subjects, [measure])
                for place in (k for k, run in enumerate(runs) if run[1:] == kind):
                    values[:, place, column] = [one.values.get(measure, np.nan) for one in found]
                    failures |= {
                        (draw, place): Status(one.code, one.failure)
                        for draw, one in enumerate(found)
                        if one.failure
                    }
                ends += [_end(one, measure) for one in found]
            met += _ends(limit, ends)
        return LimitColumns(values, failures, tuple(met))


def _end(one: Measured, measure: Measure) -> str:
    return one.limits[measure][0].kind if measure in one.limits else ""


def _ends(limit: LimitSearch, kinds: list[str]) -> list[LimitEnd]:
    """How many searches end at an end of the speeds, which then replaces the limit."""
    ends = ((BEYOND, limit.engine_speeds[-1]), (BELOW, limit.engine_speeds[0]))
    return [
        LimitEnd(limit.name, word == BEYOND, kinds.count(word), len(kinds), speed)
        for word, speed in ends
        if word in kinds
    ]


def limit_runs(experiment: Evaluation) -> int:
    """Runs of one draw for all its limit speeds, at most."""
    kinds = len(dict.fromkeys(run[1:] for run in experiment.runs))
    return kinds * sum(len(one.engine_speeds) + CLOSER for one in experiment.outputs.limit_speeds)
