"""Quantities of a case that a slider may move."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from valvetrain.findings.words import RPM
from valvetrain.parameters.case import Case
from valvetrain.workbench.form import Group

#: Key of the engine speed among the quantities of a slider.
ENGINE_SPEED = "engine_speed"


def sliding(groups: Sequence[Group]) -> list[dict[str, Any]]:
    """Quantities that a slider may move: place, words with the part, unit, value, ends and step."""
    return [
        {
            "key": field.key,
            "label": f"{group.title}: {field.label}",
            "unit": field.unit,
            "value": field.number,
            "low": field.slider[0],
            "high": field.slider[1],
            "step": field.slider[2],
        }
        for group in groups
        for field in group.fields
        if field.slider is not None and field.number is not None
    ]


def engine_speed(case: Case) -> list[dict[str, Any]]:
    """The engine speed as a quantity of the slider, about the highest speed of the case; nothing
    where it names none.
    """
    speeds = case.operation.engine_speeds
    if not speeds:
        return []
    value = round(max(speeds) / RPM)
    ends = {
        "low": 50.0 * round(value * 0.3 / 50),
        "high": 50.0 * round(value * 1.5 / 50),
        "step": 50.0,
    }
    return [
        {
            "key": ENGINE_SPEED,
            "label": "Engine speed",
            "unit": "rpm",
            "value": float(value),
            **ends,
        }
    ]
