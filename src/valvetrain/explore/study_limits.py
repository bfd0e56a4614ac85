"""Limit speeds as outputs of a study: what cannot be had, their searches, and where these end."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from valvetrain.errors import InputError
from valvetrain.explore.engine import Engine, Evaluation
from valvetrain.explore.limit_speed import BELOW, BEYOND, LimitEvaluation
from valvetrain.explore.space import ENGINE_SPEED
from valvetrain.explore.table import LimitEnd
from valvetrain.quantities.request import is_at_rest
from valvetrain.solution.definition import (
    definition_of,
    is_defined,
    no_quantity,
    not_given,
)


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


def searches_of(experiment: Evaluation) -> tuple[LimitEvaluation, ...]:
    """The searches for the limit speeds of an experiment."""
    return tuple(LimitEvaluation(experiment, one) for one in experiment.outputs.limit_speeds)


def refuse_missing(engine: Engine, searches: Sequence[LimitEvaluation]) -> None:
    """Raise :class:`InputError` where the middle of the space runs at the lowest speed and has not
    the quantity of a limit.
    """
    for search in searches:
        limit, middle = search.limit, tuple(one.distribution.middle for one in search.space)
        kinds = dict.fromkeys(run[1:] for run in search.runs)
        jobs = [(search, middle, (limit.engine_speeds[0], *kind)) for kind in kinds]
        for kind, outcome in zip(kinds, engine.outcomes(jobs), strict=True):
            if outcome.status.completed and limit.quantity not in outcome.values:
                by = f" by {kind[0]}" if kind[0] else ""
                raise InputError(f"{not_given(limit.quantity, outcome.values)}{by}", "limit_speed")


def ends_of(kinds: Mapping[tuple[LimitEvaluation, bytes], str]) -> tuple[LimitEnd, ...]:
    """How many searches, by evaluation and point, end at an end of the speeds, which then replaces
    the limit.
    """
    ends = []
    for search in dict.fromkeys(search for search, _ in kinds):
        words = [word for (one, _), word in kinds.items() if one is search]
        speeds = search.limit.engine_speeds
        ends += [
            LimitEnd(search.limit.name, word == BEYOND, words.count(word), len(words), speed)
            for word, speed in ((BEYOND, speeds[-1]), (BELOW, speeds[0]))
            if word in words
        ]
    return tuple(ends)
