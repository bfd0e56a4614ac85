"""The ``run.json`` of a kept run: written with a checksum, read back only where it is what was
written and has the shape of one.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from valvetrain.errors import InputError
from valvetrain.solution.atomic import digest

ANSWER = "run.json"
#: A longer file is no answer of a run.
MAX_BYTES = 200_000_000
_CHECKSUM = "checksum"


def answer_text(answer: Mapping[str, Any]) -> str:
    """The text of ``run.json``: the answer and its checksum."""
    plain = json.loads(json.dumps(answer, allow_nan=False, default=str))
    return _lines(plain | {_CHECKSUM: _sum(plain)}) + "\n"


def _lines(answer: Mapping[str, Any]) -> str:
    """JSON with a line for each entry, and for each part of an entry: every level on lines of its
    own takes ten times as long.
    """
    write = json.JSONEncoder(allow_nan=False).encode
    entries = []
    for key, value in answer.items():
        if isinstance(value, dict) and value:
            parts = (f"{write(name)}: {write(part)}" for name, part in value.items())
            text = "{\n    " + ",\n    ".join(parts) + "\n  }"
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            text = "[\n    " + ",\n    ".join(map(write, value)) + "\n  ]"
        else:
            text = write(value)
        entries.append(f"  {write(key)}: {text}")
    return "{\n" + ",\n".join(entries) + "\n}"


def read_answer(folder: Path) -> dict[str, Any]:
    """The ``run.json`` of a folder; empty where there is none, or another program's.

    Raises :class:`InputError` where one is there that is damaged: it cannot be read, was changed
    since, or lacks what every one has.
    """
    path = folder / ANSWER
    try:
        if not path.is_file():
            return {}
        if path.stat().st_size > MAX_BYTES:
            raise InputError("is too large for the answer of a run; repeat the run", str(path))
        found = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError, RecursionError, MemoryError) as error:
        raise InputError("is damaged: it is no JSON; repeat the run", str(path)) from error
    if not isinstance(found, dict) or "created_at" not in found:
        return {}
    told = found.pop(_CHECKSUM, None)
    try:
        same = told is None or told == _sum(found)
    except (ValueError, RecursionError):
        same = False
    if not same:
        raise InputError(
            "is damaged: its numbers are not those that were written (checksum); repeat the run",
            str(path),
        )
    if wrong := next(
        (name for name, fits in _SHAPE.items() if name in found and not fits(found[name])), ""
    ):
        raise InputError(
            f"is damaged: '{wrong}' is not what a run writes; repeat the run", str(path)
        )
    return found


def _sum(answer: Mapping[str, Any]) -> str:
    return digest(json.dumps(answer, sort_keys=True).encode())


def _is_number(item: Any) -> bool:
    return isinstance(item, (int, float)) and not isinstance(item, bool)


def _is_word(item: Any) -> bool:
    return isinstance(item, str)


def _are(fits: Callable[[Any], bool]) -> Callable[[Any], bool]:
    return lambda item: isinstance(item, list) and all(map(fits, item))


def _table_of(fits: Callable[[Any], bool]) -> Callable[[Any], bool]:
    return lambda item: isinstance(item, dict) and all(map(fits, item.values()))


def _is_measured(item: Any) -> bool:
    return (
        isinstance(item, dict)
        and (item.get("value") is None or _is_number(item["value"]))
        and _is_word(item.get("unit", ""))
    )


def _is_run(item: Any) -> bool:
    if not isinstance(item, dict) or not all(
        _is_word(item.get(name) or "") for name in ("label", "model")
    ):
        return False
    return (
        item.get("engine_speed") is None or _is_measured(item["engine_speed"])
    ) and _are_measured(item.get("quantities", {}))


def _are_choices(item: Any) -> bool:
    if not isinstance(item, dict):
        return False
    return _are(_is_number)(item.get("engine_speeds", [])) and _are(_is_word)(
        item.get("spring_models", [])
    )


_are_measured = _table_of(_is_measured)
_SHAPE: dict[str, Callable[[Any], bool]] = {
    **dict.fromkeys(("created_at", "digest", "case", "command"), _is_word), "files": _are(_is_word), "choices": _are_choices,
    "quantities": _are_measured, "quantities_by_label": _table_of(_are_measured), "runs": _are(_is_run),
}  # fmt: skip
