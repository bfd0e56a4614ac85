"""Outputs and limit speeds that no run of an experiment can give, refused before the first point: by what the spring models
show, and whether a spring is given by wire or card. What depends on the values of a point is not refused.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from valvetrain.errors import InputError
from valvetrain.explore.engine import Engine, Evaluation
from valvetrain.explore.outputs import Task
from valvetrain.explore.space import ENGINE_SPEED
from valvetrain.parameters.case import Case
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


def refuse_outputs(case: Case | None, tasks: Iterable[Task]) -> None:
    """Raise :class:`InputError` for an output that no task of a case can give.

    >>> import valvetrain as vt
    >>> space = vt.Space({"spring.precompression": vt.Uniform("6 mm", "8 mm")})
    >>> outputs = vt.Outputs("clash_count", engine_speeds="4000 rpm", spring_models="massless")
    >>> refuse_outputs(vt.load_case("job-c"), vt.Experiment("job-c", space, outputs).tasks)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    ...
    valvetrain.errors.InputError: the coil contacts (clash_count) cannot be had by massless, which has no coils that meet; ...
    """
    if case is None:
        return
    kind, reasons = "spring" if case.train is None else "train", dict[str, list[str]]()
    for task in tasks:
        (model, *_), springs = planned(task.run.request(case))[0]
        for name in task.request.outputs:
            row = definition_of(name)
            if row.systems and kind not in row.systems:
                raise InputError(f"a {kind} has no {row.label} ({name}); choose another")
            reasons.setdefault(name, []).append(_reason(name, model, springs))
    if refused := next((every for every in reasons.values() if all(every)), None):
        raise InputError(refused[0])


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


def refuse_missing(engine: Engine, experiment: Evaluation) -> None:
    """Raise :class:`InputError` where the middle of the space runs at the lowest speed and has not
    the quantity of a limit.
    """
    middle = tuple(one.distribution.middle for one in experiment.space)
    for task in experiment.tasks:
        if task.limit is not None:
            lowest = task.run._replace(engine_speed=task.limit.engine_speeds[0])
            (outcome,) = engine.outcomes([(experiment, middle, Task(lowest, task.request))])
            if outcome.status.completed and task.limit.quantity not in outcome.values:
                by = f" by {lowest.spring_model}" if lowest.spring_model else ""
                raise InputError(
                    f"{not_given(task.limit.quantity, outcome.values)}{by}", "limit_speed"
                )
