"""Outputs and limit speeds that no run of an experiment can give, refused before the first point: by what the spring models
show, and whether a spring is given by wire or card. What depends on the values of a point is not refused.
"""

from __future__ import annotations

from collections.abc import Sequence

from valvetrain.errors import InputError
from valvetrain.explore.engine import Engine, Evaluation
from valvetrain.explore.limit_speed import LimitEvaluation
from valvetrain.explore.outputs import Run
from valvetrain.explore.space import ENGINE_SPEED
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.registry import OWN, find, names
from valvetrain.runs.cost import planned
from valvetrain.solution.definition import NESTED, definition_of, label_of, not_given, of_pair

#: What a spring model shows -> beginnings of the names of quantities that need it.
NEEDS = {
    "clash": (
        "clash_", "peak_clash_", "surge_clash_", "largest_clash_", "main_clash_",
    ),
    "stress": (
        "peak_shear_stress", "minimum_shear_stress", "peak_equivalent_stress", "largest_amplitude_",
    ),
}  # fmt: skip
#: Stresses of the force by the dimensions of a wire, which every model gives.
BY_WIRE = ("open_nominal_shear", "closed_nominal_shear", "open_uncorrected_shear")
WHAT = {"clash": "coils that meet", "stress": "stress along the wire"}


def refuse_outputs(experiment: Evaluation) -> None:
    """Raise :class:`InputError` for an output that no run of the experiment can give.

    >>> import valvetrain as vt
    >>> space = vt.Space({"spring.precompression": vt.Uniform("6 mm", "8 mm")})
    >>> outputs = vt.Outputs("clash_count", engine_speeds="4000 rpm", spring_models="massless")
    >>> refuse_outputs(Evaluation("job-c", space, outputs))  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    ...
    valvetrain.errors.InputError: the coil contacts (clash_count) cannot be had by massless, which has no coils that meet; ...
    """
    case = experiment.case
    if case is None:
        return
    kind = "spring" if case.train is None else "train"
    for name in experiment.outputs.quantities:
        row = definition_of(name)
        if row.systems and kind not in row.systems:
            raise InputError(f"a {kind} has no {row.label} ({name}); choose another")
    runs = [_chosen(experiment, run) for run in experiment.runs]
    for name in experiment.outputs.quantities:
        reasons = [_reason(name, model, springs) for model, springs in runs]
        if reasons and all(reasons):
            raise InputError(reasons[0])


def _chosen(experiment: Evaluation, run: Run) -> tuple[str, Sequence[InstalledSpring]]:
    """Spring model and springs of a run, as its point is built."""
    assert experiment.case is not None
    chosen, springs = planned(run.request(experiment.case))[0]
    return chosen[0], springs


def _reason(name: str, model: str, springs: Sequence[InstalledSpring]) -> str:
    """Why a run does not give a quantity; empty where it may."""
    first, _, rest = name.partition("_")
    own = rest if first in NESTED and len(springs) > 1 else name
    need = next((one for one, starts in NEEDS.items() if own.startswith(starts)), "")
    if not need and not own.startswith(BY_WIRE):
        return ""
    text = f"the {label_of(name)} ({name}) cannot be had"
    cards = [f"'{one.name}'" for one in springs if one.wire is None]
    if len(cards) == len(springs):
        known = "springs {} are" if len(cards) > 1 else "spring {} is"
        return (
            f"{text}: {known.format(' and '.join(cards))} known by card alone, and it needs the wire, "
            "which 'valvetrain spring-card' makes; leave it out"
        )
    # a model given in Python may show coils without saying so
    if need and model not in OWN and need not in find("springs", model).shows:
        able = ", ".join(one for one in names("springs") if need in find("springs", one).shows)
        return f"{text} by {model}, which has no {WHAT[need]}; choose {able}, or leave it out"
    if need == "stress" and own == name and len(springs) > 1:
        return not_given(name, of_pair(name))
    return ""


def refuse_limits(experiment: Evaluation) -> None:
    """Raise :class:`InputError` for a limit speed that no point of the experiment can have."""
    for limit in experiment.outputs.limit_speeds:
        if experiment.case is None:
            raise InputError("a function has no limit speed; give a case")
        if limit.share is not None:
            raise InputError("a bound as a share of the case belongs to a search; give a number")
        if any(one.key == ENGINE_SPEED for one in experiment.space):
            raise InputError(
                "the engine speed is varied, and a limit speed is one; remove one of them"
            )
        row = definition_of(limit.quantity)
        kind = "spring" if experiment.case.train is None else "train"
        if row.systems and kind not in row.systems:
            raise InputError(
                f"a {kind} has no {row.label} ({limit.quantity}), so its limit speed cannot be had; choose another",
            )


def refuse_missing(engine: Engine, searches: Sequence[LimitEvaluation]) -> None:
    """Raise :class:`InputError` where the middle of the space runs at the lowest speed and has not
    the quantity of a limit.
    """
    for search in searches:
        limit, middle = search.limit, tuple(one.distribution.middle for one in search.space)
        kinds = dict.fromkeys(run[1:] for run in search.runs)
        jobs = [(search, middle, Run(limit.engine_speeds[0], *kind)) for kind in kinds]
        for kind, outcome in zip(kinds, engine.outcomes(jobs), strict=True):
            if outcome.status.completed and limit.quantity not in outcome.values:
                by = f" by {kind[0]}" if kind[0] else ""
                raise InputError(f"{not_given(limit.quantity, outcome.values)}{by}", "limit_speed")
