"""The page of defaults, from the typed tables of the case file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from valvetrain import registry
from valvetrain.parameters.case import Operation
from valvetrain.parameters.installed_spring import CoilContact, DampingParameters, Guide, Rubbing
from valvetrain.parameters.lift_law import LiftModel
from valvetrain.parameters.schema_contact import ContactTable
from valvetrain.parameters.schema_types import Table
from valvetrain.parameters.spring_blocks import fields_of
from valvetrain.parameters.summary import number
from valvetrain.parameters.train import PARTS, TrainParameters
from valvetrain.parameters.winding import EndCoil
from valvetrain.workbench.form_fields import usual_text

_HEAD = """# Defaults

What a case file that leaves a key out gets. The tables that read the case file write this page. A key without a default here is required
or has no effect when left out.

Units are the ones shown; any other of the same dimension may be written ([case-files.md](case-files.md)).
"""


def defaults_page() -> str:
    """Every default of the case file with its unit and meaning."""
    parts = [_HEAD, *(_section(title, rows) for title, rows in _sections() if rows)]
    return "\n".join(parts)


def _sections() -> Iterator[tuple[str, list[str]]]:
    kinds = ((kind, EndCoil(kind)) for kind in ("closed-ground", "closed", "open", "open-ground"))
    yield (
        "A spring: `[spring]`, `[[train.springs.SET]]`",
        [*_rows(fields_of({})), *(_end_row(kind, end) for kind, end in kinds)],
    )
    yield "`damping` of a spring", _rows(DampingParameters)
    yield "`contact` of a spring's coils", _rows(CoilContact)
    yield "`guide` of a wire", _rows(Guide)
    for word in registry.BUILT_IN["springs"]:
        yield f"`options.{word}` of a spring", _rows(registry.find("springs", word).options)
    yield "`[rubbing]`, `[train.rubbing]`", _rows(Rubbing)
    yield "`[operation]`", _rows(Operation)
    yield "`[lift_law]`, every kind", _rows(LiftModel)
    for kind in registry.BUILT_IN["lifts"]:
        yield f"`[lift_law]` of kind `{kind}`", _rows(registry.find("lifts", kind).table, LiftModel)
    yield "`[train]`", _rows(TrainParameters)
    for name, model in PARTS.items():
        yield f"`[train.{name}]`" if name != "variants" else "`[[train.variants]]`", _rows(model)
    yield "`[train.contacts.PLACE]`, every law", _rows(ContactTable)
    for law in registry.BUILT_IN["contacts"]:
        yield (
            f"`[train.contacts.PLACE]` of law `{law}`",
            _rows(registry.find("contacts", law).table, ContactTable),
        )


def _section(title: str, rows: list[str]) -> str:
    return "\n".join([f"## {title}", "", "| key | default | meaning |", "|---|---|---|", *rows, ""])


def _rows(model: Any, base: type[BaseModel] | None = None) -> list[str]:
    """Rows of the fields of ``model`` that have a default and differ from those of
    ``base``.
    """
    known = base.model_fields if base is not None else {}
    fields = {
        name: field
        for name, field in getattr(model, "model_fields", model).items()
        if name not in known or field.default != known[name].default
    }
    return [
        f"| `{name}` | {_default(field)} | {field.description or ''} |"
        for name, field in fields.items()
        if _is_documented(field)
    ]


def _default(field: FieldInfo) -> str:
    text = usual_text(field) or "not given"
    return f"`{text}`" if isinstance(field.default, str) and field.default else text


def _is_documented(field: FieldInfo) -> bool:
    """Whether leaving the key out means something: a plain value, or none with a word on what
    follows.
    """
    if (
        field.is_required()
        or field.default_factory is not None
        or isinstance(field.default, (BaseModel, Table, Mapping, list))
        or field.default == ()
    ):
        return False
    return bool(field.description) if field.default is None or field.default == "" else True


def _end_row(kind: str, end: EndCoil) -> str:
    turns = f"{number(end.inactive_coils)} and {number(end.ground_coils)}"
    return f"| `inactive_coils`, `ground_coils` | {turns} | turns of an end of kind `{kind}` inactive and ground |"
