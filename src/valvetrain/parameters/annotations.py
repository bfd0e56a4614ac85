"""Takes the notes (status, source) out of a case file's tree, leaving the bare values."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, cast

from valvetrain.errors import InputError
from valvetrain.parameters.case import STATUSES, Note, ValueStatus
from valvetrain.parameters.changes import nearest
from valvetrain.parameters.schema_types import MAX_LINE_LENGTH, text_problem
from valvetrain.units.text import clipped

_VALUE_KEYS = {"value", "status", "source", "comment"}
#: Tables in which these keys are data of their own.
_OWN_MEANING = ("published", "train.published")


def split_notes(tree: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Note], dict[str, str]]:
    """Bare tree, notes by key path, and the reason of each bad note by key path.

    ``{ value = "4 mm", status = "published", source = "key" }`` becomes "4 mm" with a note;
    ``status`` and ``source`` in any other table are a note on the whole table.
    """
    notes: dict[str, Note] = {}
    bad: dict[str, str] = {}
    clean = {key: _walk(value, key, notes, bad) for key, value in tree.items()}
    return clean, notes, bad


def is_note(value: Any) -> bool:
    """Whether a value of a case file is one with a note: ``{ value = "4 mm", status = "measured" }``."""
    return isinstance(value, dict) and "value" in value and set(value) <= _VALUE_KEYS


def _walk(value: Any, path: str, notes: dict[str, Note], bad: dict[str, str]) -> Any:
    if path in _OWN_MEANING:
        return value
    if isinstance(value, list):
        return [_walk(item, f"{path}.{index}", notes, bad) for index, item in enumerate(value)]
    if not isinstance(value, dict):
        return value
    note = {key: value[key] for key in ("status", "source") if key in value}
    if note:
        try:
            notes[path] = _note(note)
        except InputError as error:
            bad[path] = error.reason
    if is_note(value):
        return _walk(value["value"], path, notes, bad)
    return {
        key: _walk(item, f"{path}.{key}", notes, bad)
        for key, item in value.items()
        if key not in note
    }


def _note(raw: dict[str, Any]) -> Note:
    status, source = raw.get("status"), raw.get("source", "")
    if not isinstance(source, str):
        raise InputError("source must be text, such as the key of a reference")
    if reason := text_problem(source, MAX_LINE_LENGTH):
        raise InputError(reason)
    if status is not None and (not isinstance(status, str) or status not in STATUSES):
        shown = clipped(str(status), 30)
        raise InputError(f"status '{shown}' is unknown; {nearest(shown, STATUSES)}")
    return Note(cast("ValueStatus | None", status), source)
