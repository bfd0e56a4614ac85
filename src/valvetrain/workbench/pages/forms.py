"""The form of a case as the page shows it, and the quantities a slider may move."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from valvetrain.parameters.words import number
from valvetrain.workbench.form import Field, FieldGroup

#: Share of a value by which a slider goes down and up, where its limits allow.
REACH = 0.3
#: Places of a slider between its ends.
PLACES = 200


def shown_groups(groups: Sequence[FieldGroup]) -> list[dict[str, Any]]:
    """Groups of fields with words, for the script of the form."""
    return [
        {"key": group.key, "title": group.title, "fields": [_shown(field) for field in group.fields]} for group in groups if group.fields
    ]


def _shown(field: Field) -> dict[str, Any]:
    return {
        "key": field.key, "label": field.label, "kind": field.kind, "text": field.value_text, "unit": field.unit,
        "limits": limit_words(field), "help": field.help, "source": field.source, "required": field.required,
        "usual": field.default_text, "choices": list(field.choices),
    }  # fmt: skip


def limit_words(field: Field) -> str:
    """Limits of a field in words: "0.1 to 20 mm", "at least 0"; empty without any."""
    low, high = field.limits
    unit = f" {field.unit}" if field.unit else ""
    if low is None and high is None:
        return ""
    if low is None or high is None:
        return f"at least {number(low)}{unit}" if low is not None else f"at most {number(high)}{unit}"
    return f"{number(low)} to {number(high)}{unit}"


def sliding(groups: Sequence[FieldGroup]) -> list[dict[str, Any]]:
    """Quantities that a slider may move: place, words, unit, value, ends and step."""
    return [
        {"key": field.key, "label": field.label, "group": group.title, "unit": field.unit, "value": field.number, **_reach(field)}
        for group in groups for field in group.fields if field.slides and field.number is not None and math.isfinite(field.number)
    ]  # fmt: skip


def _reach(field: Field) -> dict[str, float]:
    value = field.number or 0.0
    span = REACH * abs(value) or 1.0
    low, high = field.limits
    first = value - span if low is None else max(low, value - span)
    last = value + span if high is None else min(high, value + span)
    if not last > first:
        first, last = (value - span, value) if high is not None and value >= high else (value, value + span)
    return {"low": first, "high": last, "step": (last - first) / PLACES}
