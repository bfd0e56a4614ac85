"""A number, list or curve in the tree of a case file: set, multiplied or shifted in place, in the
form the file has it in.
"""

from __future__ import annotations

import re
from typing import Any

from valvetrain.errors import InputError
from valvetrain.parameters.changes import nearest
from valvetrain.studies.points.varied import Varied
from valvetrain.units import DIMENSIONS, dimension_of, parse_quantities

#: Keys of a curve over the coils that hold its values; the first that is there is meant.
CURVE_KEYS = ("values", "clearances", "level")
_UNIT = re.compile(r"[^\d\s.,+\-eE][^,]*\Z")


def set_in_tree(tree: dict[str, Any], varied: Varied, value: float) -> None:
    """Set, multiply or shift the ``varied`` quantity of a case file's bare ``tree`` in place;
    ``value`` in SI.

    Raises :class:`InputError` for a key that leads nowhere, a factor or an offset on what is no
    number, and an offset of another unit.
    """
    *heads, last = varied.key.split(".")
    holder: Any = tree
    for head in heads:
        if isinstance(holder, dict) and head not in holder and varied.operation == "value":
            holder[head] = {}
        holder = _unpacked(holder, head, varied)
    if varied.operation == "value" and isinstance(holder, dict):
        holder[last] = in_words(value, varied.si_unit)
        return
    before = _unpacked(holder, last, varied)
    after = (
        in_words(value, varied.si_unit)
        if varied.operation == "value"
        else _changed(before, varied, value)
    )
    holder[int(last) if isinstance(holder, list) else last] = after


def in_words(value: float, unit: str) -> Any:
    """A value (SI) as a case file holds it: text with its unit, a plain number where it has none, a
    whole one where it is whole.
    """
    if unit:
        return f"{float(value)!r} {unit}"
    return int(value) if float(value).is_integer() and abs(value) < 2**53 else float(value)


def _unpacked(holder: Any, key: str, varied: Varied) -> Any:
    """The part of ``holder`` under ``key``; numbers written as one text become a list where a place
    in it is asked for.
    """
    if isinstance(holder, dict):
        if key not in holder:
            raise InputError(
                f"the case has no '{key[:60]}' there; {nearest(key, tuple(holder))}", varied.key
            )
        found = holder[key]
        if (
            isinstance(found, str)
            and "," in found
            and varied.key.split(".")[-1].isdecimal()
            and key == varied.key.split(".")[-2]
        ):
            values, unit = numbers_of(found, varied)
            holder[key] = found = [in_words(one, unit) for one in values]
        return found
    if isinstance(holder, list):
        if not key.isdecimal() or int(key) >= len(holder):
            raise InputError(
                f"'{key[:20]}' is no place in a list of {len(holder)}; name one by its number from 0",
                varied.key,
            )
        return holder[int(key)]
    raise InputError(
        f"'{key[:60]}' is below a plain value, which has no parts; vary that value", varied.key
    )


def _changed(before: Any, varied: Varied, value: float) -> Any:
    """What stands in the case, multiplied by or shifted by ``value``."""
    if isinstance(before, bool):
        raise InputError(
            f"stands as {str(before).lower()} in the case, which has no {varied.operation}; vary its value",
            varied.key,
        )
    if isinstance(before, (int, float)):
        if varied.unit:
            raise InputError(
                "is a plain number in the case, so an offset of it has no unit; leave the unit out",
                varied.key,
            )
        return _moved(float(before), varied, value)
    if isinstance(before, list):
        return [_changed(one, varied, value) for one in before]
    if isinstance(before, dict):
        key = next((name for name in CURVE_KEYS if name in before), "")
        if not key:
            raise InputError(
                f"is a table without values; name one of its parts: {', '.join(before)[:120]}",
                varied.key,
            )
        return {**before, key: _changed(before[key], varied, value)}
    if not isinstance(before, str):
        raise InputError(
            f"is no number in the case, so it has no {varied.operation}; vary its value", varied.key
        )
    values, unit = numbers_of(before, varied)
    if varied.operation == "offset" and varied.si_unit != unit:
        raise InputError(
            f"stands in the case as '{before[:40]}', and an offset of it has a unit of the same kind; give one",
            varied.key,
        )
    moved = [in_words(_moved(one, varied, value), unit) for one in values]
    return moved if "," in before else moved[0]


def _moved(number: float, varied: Varied, value: float) -> float:
    return number * value if varied.operation == "factor" else number + value


def numbers_of(text: str, varied: Varied) -> tuple[tuple[float, ...], str]:
    """Numbers (SI) of a text such as ``"0, 1.5 mm"`` and their SI unit."""
    unit = _UNIT.search(text.strip())
    numeric = re.match(r"\s*[-+.]?\d", text)
    dimension = None if not numeric else dimension_of(unit[0].strip()) if unit else "ratio"
    if dimension is None:
        raise InputError(
            f"stands in the case as '{text[:40]}', which is no number with a unit; vary its value",
            varied.key,
        )
    return parse_quantities(text, dimension, varied.key), DIMENSIONS[dimension].si_unit
