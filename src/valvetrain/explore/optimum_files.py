"""A search as others read it: the case file of a design, and an Optuna study in a SQLite file."""

from __future__ import annotations

import copy
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.errors import InputError
from valvetrain.explore.optimum import Design, Optimum, bound_words
from valvetrain.explore.paths import set_in_tree, tree_of
from valvetrain.explore.searchers import Trial, quiet_optuna, shares_of
from valvetrain.explore.space import Uniform, Values, Varied
from valvetrain.parameters.toml_text import toml_text
from valvetrain.solution.atomic import write_bytes


def case_text(found: Optimum, design: Design) -> str:
    """A case file with the values of a design, ready to run; without the published values of the
    case, which are not this design's.

    Raises :class:`InputError` where the text of the case does not tell it.
    """
    bare = tree_of(found.plan.case)
    if bare is None:
        raise InputError(
            f"the text of case '{found.plan.case.name}' does not tell it, so no file of the design can be written"
        )
    tree = copy.deepcopy(bare)
    if design.trial is not found.case:
        for varied, value in zip(found.plan.varied, design.trial.values, strict=True):
            set_in_tree(tree, varied, float(value))
    for key in ("study", "published"):
        tree.pop(key, None)
    tree["title"] = f"{found.plan.title}, {design.chosen.partition(':')[0]}"
    tree["description"] = (
        f"Trial {design.trial.number} of a search from the case {found.plan.case.name}."
    )
    return toml_text(tree)


def write_optuna(found: Optimum, path: Path) -> Path:
    """The trials as an Optuna study in a SQLite file, whole or not at all, as Optuna's own tools
    open it.

    Bounds that are missed are positive constraints; a trial that could not be computed has failed,
    one that misses a bound before its limit
    speed was searched is pruned.
    """
    plan = found.plan
    with quiet_optuna() as optuna, tempfile.TemporaryDirectory(prefix="valvetrain.") as folder:
        place = Path(folder) / "study.db"
        storage = optuna.storages.RDBStorage(f"sqlite:///{place}")
        directions = ["maximize" if one.maximise else "minimize" for one in plan.objectives]
        study = optuna.create_study(storage=storage, study_name=plan.title, directions=directions)
        study.set_metric_names(
            [_with_unit(one.measure.label, one.measure.unit) for one in plan.objectives]
        )
        study.set_user_attr("case", plan.case.name)
        study.set_user_attr(
            "constraints", [bound_words(plan, one) for one in range(len(plan.constraints))]
        )
        axes = {_axis(one): _distribution(optuna, one) for one in plan.varied}
        for trial in found.trials:
            if trial.number == 0 and shares_of(plan, trial.values) is None:
                continue  # the case lies outside the ranges
            study.add_trial(_frozen(optuna, found, trial, axes))
        storage.remove_session()
        storage.engine.dispose()
        return write_bytes(path, place.read_bytes())


def _axis(one: Varied) -> str:
    return _with_unit(one.words, one.unit)


def _with_unit(words: str, unit: str) -> str:
    return f"{words} [{unit}]" if unit else words


def _distribution(optuna: Any, one: Varied) -> Any:
    levels = one.distribution
    if isinstance(levels, Values):
        return optuna.distributions.CategoricalDistribution(
            [one.shown(value) for value in sorted(set(levels.values))]
        )
    assert isinstance(levels, Uniform)
    return optuna.distributions.FloatDistribution(one.shown(levels.low), one.shown(levels.high))


def _frozen(optuna: Any, found: Optimum, trial: Trial, axes: dict[str, Any]) -> Any:
    states = optuna.trial.TrialState
    values = None
    if trial.failure:
        state = states.FAIL
    elif np.all(np.isfinite(trial.objectives)):
        state = states.COMPLETE
        values = [
            one.measure.shown(float(value))
            for one, value in zip(found.plan.objectives, trial.objectives, strict=True)
        ]
    else:
        state = states.PRUNED
    params = {}
    for one, value in zip(found.plan.varied, trial.values, strict=True):
        axis = axes[_axis(one)]
        shown = one.shown(float(value))
        params[_axis(one)] = (
            shown if hasattr(axis, "choices") else min(max(shown, axis.low), axis.high)
        )
    told: dict[str, Any] = {"number": trial.number, "seed": trial.seed}
    told |= {
        bound_words(found.plan, place): float(one)
        for place, one in enumerate(trial.constraints)
        if np.isfinite(one)
    }
    if trial.failure:
        told["failure"] = trial.failure
    return optuna.trial.create_trial(
        state=state,
        values=values,
        params=params,
        distributions=axes,
        user_attrs=told,
        system_attrs={"constraints": trial.told_missed},
    )
