"""Plan and result of a study: a row per draw and run with its inputs, outputs and status."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from valvetrain.arrays import Array, Flags, Ints
from valvetrain.errors import InputError
from valvetrain.explore.engine import Plan
from valvetrain.explore.evaluate import doubts
from valvetrain.explore.outputs import Run, missing_text
from valvetrain.explore.samplers import SamplerOptions, SamplerSpec, Sensitivity
from valvetrain.solution.definition import definition_of, label_of
from valvetrain.solution.display import Reported, frame_of, verdict_first
from valvetrain.solution.status import Status

if TYPE_CHECKING:
    import pandas
    import xarray

    from valvetrain.solution.uncertainty import Uncertainty

#: Rows of a study that get error bars.
MAX_BARRED = 4


@dataclass(frozen=True, eq=False, kw_only=True)
class StudyPlan(Plan):
    """Every draw of the ``sampler``."""

    sampler: SamplerSpec
    options: SamplerOptions

    @property
    def runs(self) -> tuple[Run, ...]:
        """Runs of every draw."""
        return self.experiment.runs

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the outputs: quantities of the runs, then limit speeds."""
        outputs = self.experiment.outputs
        return (*outputs.quantities, *(one.name for one in outputs.limit_speeds))

    def draws(self) -> Array:
        """The points (n, d). Raises :class:`InputError` where there is none."""
        draws = self.sampler.draw(self.varied, self.options)
        if not len(draws):
            raise InputError("the sampler gives no point; request more", "points")
        return draws


@dataclass(frozen=True, eq=False)
class StudyTable(Reported):
    """``inputs`` (n, d) and ``values`` (n, m), both SI, nan for what a point does not have;
    ``runs`` and ``statuses`` (n).

    ``sensitivities``: Sobol indices, where its kind asks for them; ``computed``: points that this call
    computed, the others were in the store; ``seconds``: wall time of this call. A limit speed is that
    of the point by the model and set of a row, at any speed of it.

    >>> import valvetrain as vt
    >>> table = vt.study('''
    ... case = "job-c"
    ... engine_speeds = "4000 rpm"
    ... spring_models = "massless"
    ... outputs = "peak_spring_force"
    ... points = { sampler = "grid", levels = 3 }
    ... vary = [{ key = "spring.precompression", low = "6 mm", high = "8 mm" }]
    ... ''')
    >>> isinstance(table, StudyTable), len(table)
    (True, 3)
    """

    plan: StudyPlan
    inputs: Array
    runs: tuple[Run, ...]
    values: Array
    statuses: tuple[Status, ...]
    sensitivities: tuple[Sensitivity, ...] = ()
    computed: int = 0
    seconds: float = 0.0

    def __len__(self) -> int:
        return len(self.inputs)

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the outputs, in the order of the columns of ``values``."""
        return self.plan.outputs

    @cached_property
    def completed(self) -> Flags:
        """Which rows (n,) reached their end."""
        return np.array([one.completed for one in self.statuses], dtype=bool)

    @cached_property
    def error_bars(self) -> Mapping[int, Mapping[str, Uncertainty]]:
        """Error bars of the outputs of the first row and of those where an output is least, by row and output; computed
        when first read.
        """
        shown = np.where(self.completed[:, None], self.values, np.nan)
        least = [int(np.nanargmin(one)) for one in shown.T if np.isfinite(one).any()]
        rows = [row for row in dict.fromkeys((0, *least)) if len(self) and self.completed[row]]
        found = {}
        for row in rows[:MAX_BARRED]:
            bars = self.plan.experiment.error_bars(self.inputs[row].tolist(), self.runs[row])
            found[row] = {one.quantity: one for one in bars if one.quantity in self.outputs}
        return found

    @cached_property
    def doubts(self) -> Mapping[int, str]:
        """Points (from 0) with doubtful values -> the first warning; their cases are made again when first read."""
        return doubts(self.plan.case, self.plan.varied, self.inputs[:: max(1, len(self.plan.runs))])

    @property
    def failures(self) -> tuple[str, ...]:
        """A sentence per row that did not complete: its varied values and its status."""
        return tuple(
            f"{self.row_label(row)}: {self.statuses[row].sentence()}"
            for row in np.flatnonzero(~self.completed).tolist()
        )

    @property
    def not_given(self) -> tuple[str, ...]:
        """A sentence per output that no completed row has."""
        if not self.completed.any():
            return ()
        gone = [
            name
            for name in self.outputs
            if not np.isfinite(self.column(name)[self.completed]).any()
        ]
        texts = [missing_text(name, self.plan.case, self.plan.runs) for name in gone]
        return tuple(f"{text[0].upper()}{text[1:]}." for text in texts)

    def row_label(self, row: int) -> str:
        """The inputs of a row in words."""
        pairs = zip(self.plan.varied, self.inputs[row], strict=True)
        inputs = [one.text(value, 6) for one, value in pairs]
        return ", ".join([*inputs, *filter(None, [self.runs[row].label])])

    def column(self, name: str) -> Array:
        """Values (n,) in SI of an output, or of a varied quantity by its name. Raises
        :class:`InputError` for a name of neither.
        """
        if name in self.outputs:
            return self.values[:, self.outputs.index(name)]
        names = [one.name for one in self.plan.varied]
        if name not in names:
            raise InputError(
                f"the study has no '{name[:60]}'; it has {', '.join((*names, *self.outputs))}"
            )
        return self.inputs[:, names.index(name)]

    def rows_of(self, run: Run) -> Ints:
        """Rows of one run, in the order of the draws."""
        return np.arange(self.plan.runs.index(run), len(self), len(self.plan.runs))

    def to_xarray(self) -> xarray.Dataset:
        """A Dataset over point, speed (rpm of the crank), model, and spring set where there are
        several: outputs in SI, the status of every run of every point, and the varied quantities as
        coordinates of the points.
        """
        import xarray

        axes = [list(dict.fromkeys(column)) for column in zip(*self.plan.runs, strict=True)]
        shape = (-1, *map(len, axes))
        dims, still = ("point", "speed", "model", "spring_set"), ("point", "model", "spring_set")
        limits = [one.name for one in self.plan.experiment.outputs.limit_speeds]
        data: dict[str, Any] = {}
        for name, column in zip(self.outputs, self.values.T, strict=True):
            numbers = column.reshape(shape)
            about = {"units": definition_of(name).si_unit or "1", "long_name": label_of(name)}
            data[name] = (still, numbers[:, 0], about) if name in limits else (dims, numbers, about)
        status = np.reshape([one.code for one in self.statuses], shape)
        coordinates: dict[str, Any] = {
            "speed": ("speed", np.round(np.array(axes[0], dtype=float) * 30 / np.pi, 6), {"units": "rpm"}), "model": axes[1], "spring_set": axes[2],
        } | {
            one.name: ("point", column, {"units": one.si_unit or "1", "long_name": one.shown_name})
            for one, column in zip(self.plan.varied, self.inputs[:: len(self.plan.runs)].T, strict=True)
        }  # fmt: skip
        dataset = xarray.Dataset({**data, "status": (dims, status)}, coordinates)
        dataset.attrs["title"] = self.plan.title
        dropped = {"spring_set": 0} if axes[2] == [""] else {}
        dropped |= {"speed": 0, "model": 0} if self.plan.case is None else {}
        return dataset.isel(dropped, drop=True)

    def to_pandas(self) -> pandas.DataFrame:
        """The same as a frame of rows, with the reason of those that did not complete."""
        data = self.to_xarray()
        made = frame_of(data, data["status"].dims)
        made["reason"] = ["" if one.completed else one.sentence() for one in self.statuses]
        return made

    def __repr__(self) -> str:
        done = int(np.count_nonzero(self.completed))
        told = f"study '{self.plan.title}': {done} of {len(self)} points completed"
        return verdict_first(self, [told])
