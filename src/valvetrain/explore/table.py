"""The result of a study: a row per draw and run with its inputs, its outputs and how it ended."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.explore.plan import Run, StudyPlan
from valvetrain.solution.definition import definition_of, label_of, not_given
from valvetrain.solution.display import frame
from valvetrain.solution.status import Status

if TYPE_CHECKING:
    import pandas

    from valvetrain.explore.sensitivity import Sensitivity, Surrogate

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class StudyTable:
    """``inputs`` (n, d) and ``values`` (n, m), both SI, nan for what a point does not have;
    ``runs`` and ``statuses`` (n).

    ``sensitivities``: Sobol indices of a study of tolerances, ``surrogates`` of one that asks for
    them; ``computed``: points that this
    call computed, the others were in its store; ``seconds``: wall time of this call.

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
    surrogates: tuple[Surrogate, ...] = ()
    computed: int = 0
    seconds: float = 0.0

    def __len__(self) -> int:
        return len(self.inputs)

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the outputs, in the order of the columns of ``values``."""
        return self.plan.wanted.outputs

    @cached_property
    def completed(self) -> NDArray[np.bool_]:
        """Which rows (n,) reached their end."""
        return np.array([one.completed for one in self.statuses], dtype=bool)

    @property
    def failures(self) -> tuple[str, ...]:
        """A sentence per row that did not complete: its varied values and its status."""
        return tuple(
            f"{self.row_words(row)}: {self.statuses[row].sentence()}"
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
        return tuple(f"{told[0].upper()}{told[1:]}." for told in map(not_given, gone))

    def row_words(self, row: int) -> str:
        """The inputs of a row in words."""
        pairs = zip(self.plan.varied, self.inputs[row], strict=True)
        told = [f"{one.words} {one.shown(value):.6g} {one.unit}".strip() for one, value in pairs]
        return ", ".join([*told, *filter(None, [run_words(self.runs[row])])])

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

    def rows_of(self, run: Run) -> NDArray[np.int64]:
        """Rows of one run, in the order of the draws."""
        return np.flatnonzero([one == run for one in self.runs])

    def to_pandas(self) -> pandas.DataFrame:
        """A frame with inputs, engine speed (rad/s), model, spring set, outputs (all SI) and
        status; needs pandas.
        """
        speeds, models, sets = zip(*self.runs, strict=True) if self.runs else ((), (), ())
        columns: dict[str, Any] = {
            one.name: self.inputs[:, place] for place, one in enumerate(self.plan.varied)
        }
        columns |= (
            {"engine_speed": np.array(speeds, dtype=float)} if "engine_speed" not in columns else {}
        )
        columns |= {"spring_model": list(models), "spring_set": list(sets)}
        columns |= {name: self.values[:, place] for place, name in enumerate(self.outputs)}
        units = {one.name: one.si_unit for one in self.plan.varied} | {
            name: definition_of(name).si_unit for name in self.outputs
        }
        return frame(
            columns | {"status": [one.code for one in self.statuses]},
            units={"engine_speed": "rad/s", **units},
        )

    def __repr__(self) -> str:
        done = int(np.count_nonzero(self.completed))
        lines = [f"study '{self.plan.title}': {done} of {len(self)} points completed"]
        lines += [f"  over {one.words} ({one.name})" for one in self.plan.varied]
        for name in self.outputs:
            found = self.column(name)[np.isfinite(self.column(name))]
            if len(found):
                low, middle, high = (
                    _shown(name, value) for value in np.percentile(found, [5, 50, 95])
                )
                lines.append(
                    f"  {label_of(name)}: {middle:.5g} {definition_of(name).shown_unit}, nine in ten {low:.5g} to {high:.5g}"
                )
        return "\n".join(
            [
                *lines,
                *(f"  {one.sentence}" for one in self.sensitivities),
                *(f"  {one.sentence}" for one in self.surrogates),
            ]
        )


def _shown(name: str, value: float) -> float:
    from valvetrain.solution.definition import shown

    return float(shown(name, float(value))[0])


def run_words(run: Run) -> str:
    """A run in words: speed, model, set, those that it has."""
    engine_speed, model, spring_set = run
    speed = "" if engine_speed is None else f"{engine_speed * 30 / np.pi:.6g} rpm"
    return ", ".join(filter(None, (speed, model, spring_set)))
