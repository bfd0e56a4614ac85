"""The result of a search: trials, the best designs, their gain over the case, and how far that can
be trusted.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from valvetrain.errors import InputError
from valvetrain.explore.case_paths import vary
from valvetrain.explore.objective import OptimumPlan
from valvetrain.explore.search import Trial, best_of, front_of
from valvetrain.parameters.case import Case
from valvetrain.parameters.case_changes import tables_of
from valvetrain.parameters.toml_text import toml_text
from valvetrain.solution.critical import RPM
from valvetrain.solution.display import Reported, frame_of, verdict_first
from valvetrain.solution.uncertainty import Uncertainty

if TYPE_CHECKING:
    import pandas
    import xarray


#: A varied quantity is at an end of its range, and a bound is active, within these shares of them.
AT_END, ACTIVE = 0.01, 0.01


@dataclass(frozen=True, eq=False)
class Confirmed:
    """A design by another model: what was measured of the case and of the design, against that
    model's own bounds.
    """

    label: str
    case: Trial
    design: Trial


@dataclass(frozen=True, eq=False)
class Design:
    """One of the chosen designs: its ``trial``, and why it was ``chosen``."""

    trial: Trial
    chosen: str


@dataclass(frozen=True, eq=False)
class Optimum(Reported):
    """``trials`` in order, the case itself first.

    ``computed``: points that this call
    computed, the others were in its store; ``seconds``: wall time of this call; ``finished``:
    whether it was not stopped before its end. ``confirmed``: what other models say of the
    best design. ``error_bars``: of the numbers of the best design that are searched for, or
    of the one that comes nearest. ``doubt``: what is unusual about the values of the best design. A search that was
    stopped has none of these.

    >>> import valvetrain as vt
    >>> found = vt.optimise('''
    ... case = "job-c"
    ... vary = [{ key = "spring.precompression", low = "5 mm", high = "9 mm" }]
    ... objective = [{ quantity = "solid_force", direction = "minimise" }]
    ... search = { trials = 4, per_round = 2 }
    ... ''', workers=1)
    >>> isinstance(found, Optimum), len(found.trials)
    (True, 5)
    >>> float(found.case_of(found.best).springs[0].precompression) == float(found.best.trial.values[0])
    True
    """

    plan: OptimumPlan
    trials: tuple[Trial, ...]
    computed: int = 0
    seconds: float = 0.0
    finished: bool = True
    confirmed: tuple[Confirmed, ...] = ()
    error_bars: tuple[Uncertainty, ...] = ()
    doubt: str = ""

    @property
    def case(self) -> Trial:
        """The case itself, by which bounds may be set."""
        return self.trials[0]

    @cached_property
    def designs(self) -> tuple[Design, ...]:
        """The chosen designs, the best first: of several objectives the balanced one of the front, then the best one by each."""
        front, goals = self.front, self.plan.objectives
        if len(goals) == 1:
            best = best_of(self.trials)
            return () if best is None else (Design(best, "the best"),)
        if not front:
            return ()
        costs = np.array([one.costs for one in front])
        width = np.ptp(costs, axis=0)
        away = np.sum(((costs - costs.min(axis=0)) / np.where(width > 0, width, 1.0)) ** 2, axis=1)
        words = "balanced: nearest to the best of every objective, each over its span on the front"
        designs = {int(np.argmin(away)): words}
        for place, goal in zip(np.argmin(costs, axis=0).tolist(), goals, strict=True):
            designs.setdefault(place, f"best {goal.measure.label}")
        return tuple(Design(front[place], text) for place, text in designs.items())

    @property
    def best(self) -> Design | None:
        """The best design, of several objectives the balanced one; None where no trial meets every
        bound.
        """
        return self.designs[0] if self.designs else None

    @cached_property
    def front(self) -> tuple[Trial, ...]:
        """Feasible trials that no other beats in all objectives, by the first of these; for one
        objective the best alone.
        """
        return tuple(front_of(self.trials))

    @property
    def feasible(self) -> int:
        """Trials that meet every bound."""
        return sum(one.feasible for one in self.trials)

    def to_xarray(self) -> xarray.Dataset:
        """A Dataset over trial: varied quantities, objectives and constraints in SI, feasibility
        and state.
        """
        import xarray

        plan, trials = self.plan, self.trials
        data: dict[str, Any] = {
            one.name: ("trial", [each.values[k] for each in trials], {"units": one.si_unit or "1"})
            for k, one in enumerate(plan.varied)
        }
        for kind in ("objective", "constraint"):
            for k, one in enumerate(getattr(plan, f"{kind}s")):
                about = {"units": one.measure.si_unit, "long_name": one.measure.label}
                values = [getattr(each, f"{kind}s")[k] for each in trials]
                data[f"{kind}_{k + 1}"] = ("trial", values, about)
        for k in range(len(plan.constraints)):
            data[f"missed_{k + 1}"] = ("trial", [each.missed[k] for each in trials], {"units": "1"})
        for name in ("feasible", "state", "failure"):
            data[name] = ("trial", [getattr(each, name) for each in trials])
        numbers = [each.number for each in trials]
        return xarray.Dataset(data, {"trial": numbers}, {"title": plan.title})

    def to_pandas(self) -> pandas.DataFrame:
        """A frame with a row for each trial, SI, the units in its ``attrs``."""
        return frame_of(self.to_xarray())

    def case_of(self, design: Design) -> Case:
        """The case with the values of a design."""
        assert self.plan.case is not None
        if design.trial is self.case:
            return self.plan.case
        return vary(
            self.plan.case,
            dict(zip(self.plan.varied, map(float, design.trial.values), strict=True)),
        )

    def at_ends(self, trial: Trial) -> list[int]:
        """Places of varied quantities at an end of their range in a design."""
        low, high = np.array([one.ends for one in self.plan.varied]).T
        reach = AT_END * (high - low)
        there = (trial.values <= low + reach) | (trial.values >= high - reach)
        return [int(place) for place in np.flatnonzero(there)]

    def active(self, trial: Trial) -> tuple[int, ...]:
        """Places of the constraints that a design meets with less than a hundredth of the bound to
        spare.
        """
        missed = np.abs(trial.missed[: len(self.plan.constraints)])
        return tuple(np.flatnonzero(missed <= ACTIVE).tolist())

    @property
    def nearest(self) -> Trial | None:
        """The best design, or where none meets every bound the one that misses them by least; None where none could be
        computed.
        """
        if self.best is not None:
            return self.best.trial
        first = min(self.trials, key=lambda one: one.rank)
        return None if first.failure else first

    def __repr__(self) -> str:
        cut = "" if self.finished else ", stopped before its end"
        done = f"{len(self.trials)} trials, {self.feasible} feasible{cut}"
        return verdict_first(self, [f"search '{self.plan.title}': {done}"])


def case_text(found: Optimum, design: Design) -> str:
    """A case file with the values of a design, ready to run by the speeds, spring set and spring model of
    the search; without the published values of the case, which are not this design's.

    Raises :class:`InputError` for a design of a function.
    """
    case = found.plan.case
    if case is None:
        raise InputError(
            f"'{found.plan.case_name}' is a function, so no file of the design can be written"
        )
    tree = copy.deepcopy(tables_of(found.case_of(design)).bare)
    for key in ("study", "published"):
        tree.pop(key, None)
    _as_searched(tree, found.plan)
    tree["title"] = f"{found.plan.title}, {design.chosen.partition(':')[0]}"
    tree["description"] = f"Trial {design.trial.number} of a search from the case {case.name}."
    return toml_text(tree)


def _as_searched(tree: dict[str, Any], plan: OptimumPlan) -> None:
    """Engine speeds and, of a train, the one spring set and model that every number of a search had, without its variants."""
    runs = [run for measure in plan.measures for run in measure.runs]
    speeds = sorted({speed for speed, _, _ in runs if speed is not None})
    if speeds:
        tree.setdefault("operation", {}).pop("cam_speeds", None)
        tree["operation"]["engine_speeds"] = (
            ", ".join(f"{speed / RPM:.9g}" for speed in speeds) + " rpm"
        )
    for place, key in enumerate(("spring_model", "spring_set"), start=1):
        chosen = {run[place] for run in runs}
        if "train" in tree and len(chosen) == 1:
            if key == "spring_set":  # variants would run other springs too
                tree["train"].pop("variants", None)
            if "" not in chosen:
                tree["train"][key] = chosen.pop()
