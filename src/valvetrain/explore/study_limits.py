"""Limit speeds as outputs of a study: what they cost, what cannot be had, and their columns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.explore.engine import Engine, Evaluation
from valvetrain.explore.limit_speed import BELOW, BEYOND, CLOSER, LimitEvaluation, limit_of
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
        self.searches = [
            LimitEvaluation(experiment, limit) for limit in experiment.outputs.limit_speeds
        ]
        for search in self.searches:
            engine.include(search)

    def probe(self) -> None:
        """Raise :class:`InputError` where the middle of the space runs at the lowest speed and has not
        the quantity.
        """
        middle = tuple(one.distribution.middle for one in self.experiment.space)
        kinds = dict.fromkeys(run[1:] for run in self.experiment.runs)
        for search in self.searches:
            limit = search.limit
            jobs = [(search, middle, (limit.engine_speeds[0], *kind)) for kind in kinds]
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
        for column, search in enumerate(self.searches):
            ends: list[str] = []
            for kind in kinds:
                jobs = [(search, tuple(row), (None, *kind)) for row in draws.tolist()]
                outcomes = self.engine.outcomes(jobs)
                for place in (k for k, run in enumerate(runs) if run[1:] == kind):
                    values[:, place, column] = [
                        one.values.get(search.limit.name, np.nan) for one in outcomes
                    ]
                    failures |= {
                        (draw, place): one.status
                        for draw, one in enumerate(outcomes)
                        if not one.status.completed
                    }
                ends += [limit_of(one).kind for one in outcomes if one.values]
            met += _ends(search.limit, ends, len(draws) * len(kinds))
        return LimitColumns(values, failures, tuple(met))


def _ends(limit: LimitSearch, kinds: list[str], searches: int) -> list[LimitEnd]:
    """How many searches end at an end of the speeds, which then replaces the limit."""
    ends = ((BEYOND, limit.engine_speeds[-1]), (BELOW, limit.engine_speeds[0]))
    return [
        LimitEnd(limit.name, word == BEYOND, kinds.count(word), searches, speed)
        for word, speed in ends
        if word in kinds
    ]


def limit_runs(experiment: Evaluation) -> int:
    """Runs of one draw for all its limit speeds, at most."""
    kinds = len(dict.fromkeys(run[1:] for run in experiment.runs))
    return kinds * sum(len(one.engine_speeds) + CLOSER for one in experiment.outputs.limit_speeds)
