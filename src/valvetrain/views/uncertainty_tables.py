"""Files of a refinement: every error bar, and every number behind them."""

from __future__ import annotations

from collections.abc import Sequence

from numpy.typing import ArrayLike

from valvetrain.parameters.summary import rpm
from valvetrain.runs.error_bars import UncertaintyStudy
from valvetrain.solution.quantity import Quantity
from valvetrain.solution.uncertainty import Uncertainty
from valvetrain.views.study_files import by_columns


def uncertainty_table(rows: Sequence[Uncertainty]) -> str:
    """All rows in SI for ``uncertainty.csv``; speed in rpm of the crank, nan for statics and modes."""
    numbers = {
        "value": [row.value for row in rows], "numerical uncertainty": [row.numerical for row in rows],
        "observed order": [float("nan") if row.observed_order is None else row.observed_order for row in rows],
        "extrapolated": [row.extrapolated for row in rows], "part of the step": [row.step_part for row in rows],
        "least over contact stiffness": [row.contact_stiffness[0] for row in rows],
        "largest over contact stiffness": [row.contact_stiffness[1] for row in rows],
        "least over damping": [row.damping[0] for row in rows],
        "largest over damping": [row.damping[1] for row in rows],
    }  # fmt: skip
    speeds = [float("nan") if row.engine_speed is None else rpm(row.engine_speed) for row in rows]
    units = [Quantity(row.quantity).unit for row in rows]
    names: dict[str, ArrayLike] = {"quantity": [row.quantity for row in rows]}
    if any(row.label for row in rows):
        names["variant"] = [row.label for row in rows]
    return by_columns({**names, "engine speed [rpm]": speeds, "unit": units, **numbers})


def levels_table(study: UncertaintyStudy) -> str:
    """Every number (SI) of every run behind the error bars for ``levels.csv``, as
    :func:`uncertainty_table`.
    """
    found = [
        (level, speed, name, value)
        for level, by_speed in study.values.items()
        for speed, numbers in by_speed.items()
        for name, value in numbers.items()
    ]
    speeds = [float("nan") if speed is None else rpm(speed) for _, speed, _, _ in found]
    names = [name for _, _, name, _ in found]
    return by_columns({
        "level": [level for level, _, _, _ in found], "engine speed [rpm]": speeds, "quantity": names,
        "unit": [Quantity(name).unit for name in names], "value": [value for _, _, _, value in found],
    })  # fmt: skip
