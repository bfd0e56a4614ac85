"""A study of points as its rules read it: the output it is judged by, its designs, the best of them, and what moves an output."""

from __future__ import annotations

import shlex
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.explore.case_paths import nominal, setting
from valvetrain.explore.outputs import Run
from valvetrain.explore.space import ENGINE_SPEED, Varied
from valvetrain.explore.table import StudyTable
from valvetrain.findings.engine import Subject
from valvetrain.findings.words import RPM, Amount
from valvetrain.quantities.request import BY_SIZE
from valvetrain.solution.definition import definition_of

#: Outputs by which springs are judged before all others, for by them they break.
STRESSES = ("largest_amplitude_shear_stress", "peak_shear_stress", "open_nominal_shear_stress")
#: What follows from the dimensions of a spring, its installing and the lift alone begins so.
PUT_IN = ("preload", "installed_", "coil_bind_clearance", *BY_SIZE)
#: What a spring has to press with anyway is asked of last: what goes wrong with it comes before.
FORCES = ("peak_spring_force", "minimum_spring_force")
#: Spread over the size of the mean below which nothing varies.
NO_SPREAD = 1e-9
PERCENTILES = (5.0, 50.0, 95.0)


def _bare(name: str) -> str:
    return name.removeprefix("outer_").removeprefix("inner_")


def put_in(name: str) -> bool:
    """Whether an output follows from dimensions, installing and lift alone, of one of a nested pair too."""
    return _bare(name).startswith(PUT_IN)


@dataclass(frozen=True)
class Effect:
    """The ``share`` of an output's variance that a varied quantity brings, its 95 % interval (``low``, ``high``), whether
    the output ``rises`` with it (1), falls (-1) or neither (0), and its ``change`` (SI) along a straight line over the range of
    the quantity.
    """

    varied: Varied
    share: float
    low: float
    high: float
    rises: int
    change: float


@dataclass(frozen=True)
class StudyFacts(Subject):
    """A study of points as rules read it. A design is a point, or all points that differ in engine speed alone."""

    table: StudyTable
    called: str = ""

    @property
    def case(self) -> str:
        """What a command takes for its case."""
        return self.called or self.table.plan.case_name

    @property
    def chosen(self) -> bool:
        """Whether every point was chosen, so that percentiles over them would be no real scatter."""
        return not self.table.plan.sampler.independent

    @property
    def listed(self) -> bool:
        """Whether the points are a list in which several quantities change."""
        return self.table.plan.sampler.word == "list" and len(self.changing) != 1

    @cached_property
    def draws(self) -> Array:
        """Values (points, d) of the varied quantities, SI."""
        return self.table.inputs[:: max(1, len(self.table.plan.runs))]

    @cached_property
    def changing(self) -> list[int]:
        """Varied quantities that are not the same at every point."""
        return [k for k, column in enumerate(self.draws.T) if np.any(column != column[:1])]

    @cached_property
    def along(self) -> list[int]:
        """Those of them that are a choice: the engine speed is a condition."""
        return [k for k in self.changing if self.table.plan.varied[k].key != ENGINE_SPEED]

    @cached_property
    def designs(self) -> list[NDArray[np.intp]]:
        """The points of every design; points with engine speeds of their own are a design each."""
        speeds = [k for k in self.changing if k not in self.along]
        chosen, place = np.unique(self.draws[:, self.along], axis=0, return_inverse=True)
        groups = [np.flatnonzero(place.ravel() == k) for k in range(len(chosen))]
        at = {tuple(np.sort(self.draws[one][:, speeds].ravel())) for one in groups}
        if not self.along or len(at) > 1 or not speeds:
            return [np.array([point]) for point in range(len(self.draws))]
        return sorted(groups, key=lambda one: int(one[0]))

    @property
    def order(self) -> NDArray[np.intp]:
        """Designs by the value of the first quantity that is a choice."""
        return np.argsort([self.draws[one[0], self.along[0]] for one in self.designs])

    @property
    def over_speed(self) -> bool:
        """Whether designs differ in engine speed, so that none can be preferred to another."""
        return len(self.along) < len(self.changing) and len(self.designs) == len(self.draws)

    def label(self, design: int) -> str:
        """What distinguishes a design: its name, else the values that change, of a list those that differ from the first."""
        point = int(self.designs[design][0])
        if names := getattr(self.table.plan.options, "names", ()):
            return str(names[point])
        changed = self.changing if self.over_speed else self.along
        if self.listed and point:
            changed = [k for k in changed if self.draws[point, k] != self.draws[0, k]]
        texts = (self.table.plan.varied[k].text(float(self.draws[point, k])) for k in changed)
        return ", ".join(texts) or f"point {point + 1}"

    # -- outputs -----------------------------------------------------------------------------------

    @cached_property
    def outputs(self) -> tuple[str, ...]:
        """Outputs that a point has, that of the verdict first: of chosen points a stress, else a limit speed, else what goes
        wrong in motion, such as surge, else a force of the spring; the best of what was put in is no finding.
        """
        there = [name for name in self.table.outputs if np.isfinite(self.column(name)).any()]

        def place(name: str) -> tuple[int, bool, bool, bool]:
            bare = _bare(name)
            stress = STRESSES.index(bare) if bare in STRESSES else len(STRESSES)
            return stress, put_in(name), name not in self.limits, bare in FORCES

        return tuple(sorted(there, key=place) if self.chosen else there)

    @property
    def limits(self) -> dict[str, tuple[float, ...]]:
        """Limit speed -> the engine speeds (rad/s) over which it was searched."""
        searches = self.table.plan.experiment.outputs.limit_speeds
        return {one.name: one.engine_speeds for one in searches}

    def sign(self, name: str) -> int:
        """1 where a larger value of an output is better, -1 where a smaller one is, 0 for neither."""
        return {"larger is better": 1, "smaller is better": -1}.get(definition_of(name).sense, 0)

    def column(self, name: str) -> Array:
        """Values (rows,) of an output, SI, nan where a point did not complete."""
        return np.where(self.table.completed, self.table.column(name), np.nan)

    def finite(self, name: str, run: Run) -> Array:
        """Values (SI) of an output that the points of a run have."""
        values = self.column(name)[self.table.rows_of(run)]
        return values[np.isfinite(values)]

    def worst(self, name: str) -> Array:
        """The worst value (SI) of every design over its engine speeds and runs; the mean of an output with no better side."""
        sign, values = self.sign(name), self.column(name).reshape(len(self.draws), -1)
        rows = [values[group] for group in self.designs]
        return np.array([sign * np.min(sign * one) if sign else np.mean(one) for one in rows])

    def judged(self, name: str) -> Array:
        """As :meth:`worst`, nan for designs without lash where others have some: a warm valve would stay open."""
        lash = [k for k in self.along if self.table.plan.varied[k].key.endswith(".lash")]
        none = np.array([bool(np.any(self.draws[one[0], lash] <= 0)) for one in self.designs])
        return np.where(none & ~none.all(), np.nan, self.worst(name))

    @cached_property
    def ends(self) -> dict[str, int]:
        """Designs by name: the ``best`` (``least`` of an output with no better side), the ``case`` or ``first`` that it is
        compared with, and the ``worst``; empty of draws, and where no design has the output at every run.
        """
        if not self.outputs or not self.chosen:
            return {}
        name, plan = self.outputs[0], self.table.plan
        values, sign = self.judged(name), self.sign(name)
        if not np.isfinite(values).any():
            return {}
        order = (sign or -1) * values
        found = {"best" if sign else "least": int(np.nanargmax(order))}
        if plan.sampler.word == "list":
            found["first"] = 0
        elif plan.sampler.word == "grid" and plan.case is not None and self.along:
            at = self.draws[[one[0] for one in self.designs]][:, self.along]
            with suppress(InputError):  # a list of numbers, which no single value is
                case = [nominal(plan.case, plan.varied[k]) for k in self.along]
                there = np.isclose(at, case, rtol=1e-9, atol=0).all(1) & np.isfinite(values)
                found |= {"case": int(there.argmax())} if there.any() else {}
        return found | {"worst" if sign else "largest": int(np.nanargmin(order))}

    def bar(self, name: str) -> float:
        """The error bar of an output as a share of its value: the largest of those that were computed, 0 where none was."""
        bars = vars(self.table).get("error_bars", {})  # nothing is computed here
        rows = [one[name] for one in bars.values() if name in one and one[name].value]
        return max((abs(one.numerical / one.value) for one in rows), default=0.0)

    @cached_property
    def within_bar(self) -> float:
        """The error bar (SI) of the first output where it is as large as the change between the chosen points; else 0."""
        if not self.ends:
            return 0.0
        values = self.judged(self.outputs[0])
        bar = self.bar(self.outputs[0]) * float(np.nanmax(np.abs(values)))
        return bar if 0 < np.nanmax(values) - np.nanmin(values) <= bar else 0.0

    def amount(self, name: str, value: float) -> Amount:
        """A value, with its error bar where that leaves it unresolved: points of one mesh are compared beyond their bars."""
        share, value = self.bar(name), float(value)
        made = Amount(name, value, share * abs(value))
        return Amount(name, value) if made.resolved else made

    # -- what moves an output ----------------------------------------------------------------------

    @cached_property
    def run(self) -> Run:
        """Of draws the run whose tail is worst, of an output with no better side the first."""
        name, sign = self.outputs[0], self.sign(self.outputs[0])
        runs = [run for run in self.table.plan.runs if len(self.finite(name, run))]
        return min(runs, key=lambda run: sign * np.percentile(self.finite(name, run), 50 - 45 * sign))  # fmt: skip

    def effects(self, name: str) -> list[Effect]:
        """What each varied quantity does to an output, the largest share first: by Sobol indices where there are some, else
        by the squared correlation of ranks with its interval by Fisher's transformation; none of a list.
        """
        from scipy.stats import pearsonr, rankdata

        table, rows, made = self.table, self.table.rows_of(self.run), list[Effect]()
        there = np.isfinite(self.column(name)[rows])
        y = self.column(name)[rows][there]
        still = not len(y) or np.ptp(y) <= NO_SPREAD * abs(float(y.mean()))
        if self.listed or len(y) < 4 or still:
            return []
        sobol = [one for one in table.sensitivities if (one.output, one.run) == (name, self.run)]
        for k in self.changing:
            x = table.inputs[rows][there, k]
            if not np.ptp(x) > 0:  # of a stopped study a quantity may not have moved yet
                continue
            ranks = pearsonr(rankdata(x, "dense"), rankdata(y, "dense"))
            r, ends = float(ranks.statistic), np.array(ranks.confidence_interval())
            change = float(np.polyfit(x - x.mean(), y, 1)[0] * np.ptp(x))
            rises = int(np.sign(r)) if ends[0] * ends[1] > 0 else 0
            low, high = np.sort(ends**2).tolist()
            one = Effect(table.plan.varied[k], r * r, low if rises else 0.0, high, rises, change)
            if sobol:
                low, high = sobol[0].total_interval[k].tolist()
                one = replace(one, share=float(sobol[0].total[k]), low=low, high=high)
            made.append(one)
        return sorted(made, key=lambda one: -one.share)

    def worst_row(self, design: int) -> int:
        """The row of a design at the worst of its engine speeds and runs, by the first output."""
        count, name = len(self.table.plan.runs), self.outputs[0]
        rows = [point * count + k for point in self.designs[design] for k in range(count)]
        return int(rows[np.argmin((self.sign(name) or 1) * self.column(name)[rows])])

    def speed_at(self, row: int) -> float | None:
        """Engine speed (rad/s) of a row, as varied or of its run; None at rest."""
        rows = zip(self.table.plan.varied, self.table.inputs[row].tolist(), strict=True)
        varied = (value for one, value in rows if one.key == ENGINE_SPEED)
        return next(varied, self.table.runs[row].engine_speed)

    def command(self, design: int, only: Varied | None = None) -> str:
        """The command that runs a design again, at the worst of its engine speeds and runs; empty where a value is a list.
        With ``only`` one of its quantities has the value of the design, the others those of the case.
        """
        table, plan, name = self.table, self.table.plan, self.outputs[0]
        if plan.case is None or (plan.case.changed and not self.called):
            return ""
        row = self.worst_row(design)
        speed, (_, model, spring_set) = self.speed_at(row), table.runs[row]
        words = list[str]()
        for one, value in zip(plan.varied, table.inputs[row].tolist(), strict=True):
            if one.key == ENGINE_SPEED or only not in (None, one):
                continue
            elif all(texts := [setting(plan.case, part, value) for part in one.parts]):
                words += [word for text in texts for word in ("--set", text)]
            else:
                return ""
        searched = self.limits.get(name, ())
        verb = "sweep" if searched else "static" if speed is None else "run"
        if searched or speed is not None:
            step = f":{(searched[1] - searched[0]) / RPM:.6g}" if searched else ""
            ends = (*searched[:1], *searched[-1:]) or (speed or 0.0,)
            words += ["--rpm", ":".join(f"{one / RPM:.8g}" for one in ends) + step]
        words += ["--model", model] * bool(model) + ["--spring-set", spring_set] * bool(spring_set)
        return f"valvetrain {verb} {self.case} {shlex.join(words)}"
