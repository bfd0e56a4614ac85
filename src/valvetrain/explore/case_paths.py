"""Key paths into a case: the case with varied quantities changed, checked as its file would be, and
the values under its keys.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any

from valvetrain.errors import InputError
from valvetrain.explore.space import ENGINE_SPEED, Varied
from valvetrain.parameters.case import Case
from valvetrain.parameters.case_changes import changed_case, tables_of
from valvetrain.parameters.overrides import file_key
from valvetrain.parameters.schema_types import DOUBTED
from valvetrain.units import (
    DIMENSIONS,
    PlainInteger,
    PlainNumber,
    dimension_of,
    doubt,
    parse_quantities,
)

#: Keys of a curve over the coils that hold its values; the first that is there is meant.
CURVE_KEYS = ("values", "clearances", "level")
#: Tables of a case whose values may be varied.
MOVING = ("spring", "lift_law", "operation", "train", "rubbing", "points")


def as_written(value: float, unit: str) -> Any:
    """A value (SI) as a case file holds it: text with its unit, else a plain number, whole where it
    is whole, in the SI unit that its key has.
    """
    if unit:
        return f"{float(value)!r} {unit}"
    whole = float(value).is_integer() and abs(value) < 2**53
    return PlainInteger(value) if whole else PlainNumber(value)


def _changed(before: Any, varied: Varied, value: float) -> Any:
    """The value of the case, multiplied by or shifted by ``value``."""
    if isinstance(before, bool):
        raise InputError(
            f"is {str(before).lower()} in the case, which has no {varied.operation}; vary its value",
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
            f"is in the case '{before[:40]}', and an offset of it has a unit of the same kind; give one",
            varied.key,
        )
    moved = [as_written(_moved(one, varied, value), unit) for one in values]
    return moved if "," in before else moved[0]


def _moved(number: float, varied: Varied, value: float) -> float:
    return number * value if varied.operation == "factor" else number + value


def numbers_of(text: str, varied: Varied) -> tuple[tuple[float, ...], str]:
    """Numbers (SI) of a text such as ``"0, 1.5 mm"`` and their SI unit."""
    unit = unit_of(text)
    numeric = re.match(r"\s*[-+.]?\d", text)
    dimension = None if not numeric else dimension_of(unit) if unit else "ratio"
    if dimension is None:
        raise InputError(
            f"is in the case '{text[:40]}', which is no number with a unit; vary its value",
            varied.key,
        )
    return parse_quantities(text, dimension, varied.key), DIMENSIONS[dimension].si_unit


def vary(case: Case, values: Mapping[Varied, float]) -> Case:
    """The case with the varied quantities at ``values`` (SI), as its file with those values would
    give it.

    Raises :class:`InputError`, one sentence, for a key that is not there, for a case that cannot exist
    and for one that a program changed part by part.

    >>> import valvetrain as vt
    >>> thinner = vary(vt.load_case("gu2021-beehive"), {Varied("spring.wire_diameter", "mm"): 3.7e-3})
    >>> thinner == vt.load_case("gu2021-beehive", {"spring.wire_diameter": "0.0037 m"})
    True
    """
    own = {
        part: float(value)
        for varied, value in values.items()
        for part in varied.parts
        if part.key != ENGINE_SPEED
    }
    if not own:
        return case
    changes: dict[str, Any] = {}
    for varied, value in own.items():
        key = file_key(varied.key)
        if key.partition(".")[0] not in MOVING:
            raise InputError(
                f"is no quantity that moves anything; vary one of {', '.join(MOVING[:-1])} or {MOVING[-1]}",
                varied.key,
            )
        if key in changes:
            raise InputError("is varied twice; give it once", varied.key)
        name = DOUBTED.get(key.rpartition(".")[2], "")
        if name and varied.operation == "value" and varied.distribution.dimension is None:
            doubt(value, name, f"{value:.6g} {varied.si_unit}", True, varied.key)
        changes[key] = (
            as_written(value, varied.si_unit)
            if varied.operation == "value"
            else partial(_changed, varied=varied, value=value)
        )
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        changed = changed_case(case, changes)
    where = ", ".join(
        f"{one.shown_name} = {one.shown(value):.5g} {one.unit}".rstrip()
        for one, value in own.items()
    )
    for one in caught:
        text = str(one.message)
        of_case = text in tables_of(case).warnings
        warnings.warn(text if of_case else f"at {where}: {text}", one.category, stacklevel=2)
    names = (one.name for one in own)
    return replace(changed, changed=tuple(dict.fromkeys((*case.changed, *names))))


def nominal(case: Case, varied: Varied) -> float:
    """The value (SI) of the case, 1 for a factor, 0 for an offset.

    Raises :class:`InputError` for a key that is not there, or that holds no single number.

    >>> import valvetrain as vt
    >>> nominal(vt.load_case("gu2021-beehive"), Varied("spring.precompression", "mm"))
    0.007
    """
    if varied.operation != "value":
        return 1.0 if varied.operation == "factor" else 0.0
    found, place = _entry(case, varied.key)
    if isinstance(found, str) and (place is not None or "," not in found):
        return numbers_of(found, varied)[0][place or 0]
    if isinstance(found, (int, float)) and not isinstance(found, bool):
        return float(found)
    raise InputError(
        "has several numbers in the case; vary it as = 'factor' or 'offset', or name one of its parts",
        varied.key,
    )


def setting(case: Case, varied: Varied, value: float) -> str:
    """What ``--set`` takes to give a case a varied ``value`` (SI); empty where the case has a list or a table there.

    >>> import valvetrain as vt
    >>> setting(vt.load_case("gu2021-beehive"), Varied("spring.precompression", "mm", "offset"), 5e-4)
    'spring.precompression=0.0075 m'
    """
    moved: Any = f"{varied.shown(value):.8g} {varied.unit}".strip()
    if varied.operation != "value":
        moved = _changed(_entry(case, varied.key)[0], varied, value)
    return "" if isinstance(moved, (list, dict)) else f"{file_key(varied.key)}={moved}"


def unit_in_case(case: Case, key: str) -> str:
    """Unit in which the value of ``key`` is written in the case; empty for a plain number.

    >>> import valvetrain as vt
    >>> unit_in_case(vt.load_case("gu2021-beehive"), "spring.precompression")
    'mm'
    """
    found, _ = _entry(case, key)
    if isinstance(found, dict):  # a curve
        found = next((found[name] for name in CURVE_KEYS if name in found), "")
    return unit_of(found) if isinstance(found, str) else ""


def unit_of(text: str) -> str:
    """Unit of a text, of the last of several numbers.

    >>> unit_of("3.7, 3.8 mm"), unit_of("5 %"), unit_of("7")
    ('mm', '%', '')
    """
    phrase = text.split(",")[-1].strip()
    return phrase.lstrip("+-0123456789.eE ").strip() if phrase else ""


def _entry(case: Case, key: str) -> tuple[Any, int | None]:
    """The value under ``key``, and the index in it where it is a text of several numbers of which
    one is meant.
    """
    found: Any = tables_of(case).bare
    for part in file_key(key).split("."):
        if isinstance(found, dict) and part in found:
            found = found[part]
        elif isinstance(found, list) and part.isdecimal() and int(part) < len(found):
            found = found[int(part)]
        elif (
            isinstance(found, str)
            and "," in found
            and part.isdecimal()
            and int(part) < len(found.split(","))
        ):
            return found, int(part)
        else:
            raise InputError(
                "is not in the case, so it has no value to vary about; give low and high, or mean",
                key,
            )
    return found, None
