"""The form of a case as the page shows it, and the quantities a slider may move."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

from valvetrain.findings.words import RPM
from valvetrain.parameters.case import Case
from valvetrain.parameters.summary import number
from valvetrain.workbench.form import FieldGroup
from valvetrain.workbench.form_fields import Field

#: Key of the engine speed among the quantities of a slider.
ENGINE_SPEED = "engine_speed"


def shown_groups(
    groups: Sequence[FieldGroup], files: Sequence[str] = (), removed: Collection[str] = ()
) -> list[dict[str, Any]]:
    """Groups of fields with words, for the script of the form.

    ``files``: names that a field for a file suggests; ``removed``: keys of the tables that may be
    taken away.
    """
    return [
        {
            "key": group.key,
            "title": group.title,
            "fields": [_shown(field, files) for field in group.fields],
            "goes": group.key in removed,
        }
        for group in groups
        if group.fields
    ]


def _shown(field: Field, files: Sequence[str]) -> dict[str, Any]:
    choices = files if field.key.endswith(".file") else field.choices
    return {
        "key": field.key,
        "label": _capitalized(field.label),
        "kind": field.kind,
        "text": field.value_text,
        "unit": field.unit,
        "limits": limit_text(field),
        "help": field.help,
        "source": field.source,
        "required": field.required,
        "usual": field.default_text,
        "choices": list(choices),
    }


def _capitalized(label: str) -> str:
    return label[:1].upper() + label[1:]


def limit_text(field: Field) -> str:
    """Limits of a field in words: "0.1 to 20 mm", "at least 0"; empty without any."""
    low, high = field.limits
    unit = f" {field.unit}" if field.unit else ""
    if low is None and high is None:
        return ""
    if low is None or high is None:
        return (
            f"{number(low)}{unit if low else ''} or more"
            if low is not None
            else f"at most {number(high)}{unit}"
        )
    return f"{number(low)} to {number(high)}{unit}"


def sliding(groups: Sequence[FieldGroup]) -> list[dict[str, Any]]:
    """Quantities that a slider may move: place, words, unit, value, ends and step."""
    return [
        {
            "key": field.key,
            "label": _capitalized(field.label),
            "group": group.title,
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
            "group": "Operation",
            "unit": "rpm",
            "value": float(value),
            **ends,
        }
    ]
