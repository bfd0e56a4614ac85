"""Options of spring models in a case file: one table per model, validated by the model's own class."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from valvetrain import registry
from valvetrain.parameters.changes import nearest
from valvetrain.parameters.schema_types import StrictModel


class SpringOptions(StrictModel):
    """Base of the tables. ``wire_only`` and ``card_only``: keys that have no effect on a spring
    known the other way.
    """

    wire_only: ClassVar[tuple[str, ...]] = ()
    card_only: ClassVar[tuple[str, ...]] = ()


def options_problem(
    options: Mapping[str, Mapping[str, Any]], by_card: bool
) -> tuple[str, str, str] | None:
    """Model word, key and reason of the first option that is unknown or has no effect on such a
    spring; None when all fit.
    """
    for word, values in options.items():
        table: type[SpringOptions] = registry.find("springs", word).options
        useless = table.wire_only if by_card else table.card_only
        for key in values:
            if key not in table.model_fields:
                return (
                    word,
                    key,
                    f"option '{key[:40]}' of spring model '{word}' is unknown; {nearest(key, tuple(table.model_fields))}",
                )
            if key in useless:
                known_by, other = ("card", "wire") if by_card else ("wire", "card")
                return (
                    word,
                    key,
                    f"{key} has no effect on a spring known by its {known_by} (it is for a {other}); remove it",
                )
    return None
