"""Key paths into a case: the case with varied quantities changed, checked as its file would be, and
the values under its keys.

Keys of a case file (``spring.wire_diameter``) and key paths of :meth:`Case.replace`
(``springs.0.wire.wire_diameter``) name the same value, of any case.
"""

from __future__ import annotations

import copy
import re
import tomllib
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from pydantic import ValidationError
from pydantic_core import PydanticCustomError

from valvetrain.errors import InputError
from valvetrain.explore.space import ENGINE_SPEED, Varied
from valvetrain.parameters.annotations import split_notes
from valvetrain.parameters.case import Case, Note
from valvetrain.parameters.changes import nearest
from valvetrain.parameters.curves import (
    Constant,
    FunctionCurve,
    PiecewiseLinear,
    Table,
    WeightedSum,
    add_curves,
)
from valvetrain.parameters.schema_case import CaseModel
from valvetrain.parameters.schema_types import first_problem
from valvetrain.units import (
    DIMENSIONS,
    PlainInteger,
    PlainNumber,
    dimension_of,
    parse_quantities,
)

#: Keys of a curve over the coils that hold its values; the first that is there is meant.
CURVE_KEYS = ("values", "clearances", "level")
_UNIT = re.compile(r"[^\d\s.,+\-eE][^,]*\Z")


_IN_OBJECT = re.compile(
    r"(?:springs\.0|(?P<train>train\.springs\.[^.]+\.\d+))(?:\.(?:wire|card))?\."
)
_IN_FILE = re.compile(r"(?:spring|train\.springs\.(?P<set>[^.]+)\.(?P<index>\d+))\.(?P<rest>.+)")


def file_key(key: str) -> str:
    """A key as case files have it.

    >>> file_key("springs.0.wire.wire_diameter"), file_key("train.springs.nested.1.wire.pitch")
    ('spring.wire_diameter', 'train.springs.nested.1.pitch')
    """
    found = _IN_OBJECT.match(key)
    return key if found is None else f"{found['train'] or 'spring'}.{key[found.end() :]}"


def object_key(case: Case, key: str) -> str:
    """A key as :meth:`Case.replace` has it.

    >>> import valvetrain as vt
    >>> object_key(vt.load_case("job-t"), "spring.wire_diameter")
    'springs.0.wire.wire_diameter'
    """
    found = _IN_FILE.fullmatch(key)
    if found is None:
        return key
    name, index = found["set"], int(found["index"] or 0)
    springs = (
        case.springs if name is None else case.train.springs.get(name, ()) if case.train else ()
    )
    if index >= len(springs):
        return key
    head = "springs.0" if name is None else f"train.springs.{name}.{index}"
    first, spring = found["rest"].partition(".")[0], springs[index]
    if first in spring.__dataclass_fields__:
        return f"{head}.{found['rest']}"
    return f"{head}.{'card' if spring.wire is None else 'wire'}.{found['rest']}"


def set_in_tree(tree: dict[str, Any], varied: Varied, value: float) -> None:
    """Set, multiply or shift the ``varied`` quantity of a case file's bare ``tree`` in place;
    ``value`` in SI.

    Raises :class:`InputError` for a key that leads nowhere, a factor or an offset on what is no
    number, and an offset of another unit.
    """
    *heads, last = file_key(varied.key).split(".")
    holder: Any = tree
    for head in heads:
        if isinstance(holder, dict) and head not in holder and varied.operation == "value":
            holder[head] = {}
        holder = _unpacked(holder, head, varied)
    if varied.operation == "value" and isinstance(holder, dict):
        holder[last] = as_written(value, varied.si_unit)
        return
    before = _unpacked(holder, last, varied)
    after = (
        as_written(value, varied.si_unit)
        if varied.operation == "value"
        else _changed(before, varied, value)
    )
    holder[int(last) if isinstance(holder, list) else last] = after


def as_written(value: float, unit: str) -> Any:
    """A value (SI) as a case file holds it: text with its unit, else a plain number, whole where it
    is whole, in the SI unit that its key has.
    """
    if unit:
        return f"{float(value)!r} {unit}"
    whole = float(value).is_integer() and abs(value) < 2**53
    return PlainInteger(value) if whole else PlainNumber(value)


def _unpacked(holder: Any, key: str, varied: Varied) -> Any:
    """The part of ``holder`` under ``key``; numbers written as one text become a list where a place
    in it is requested.
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
            and varied.key.rpartition(".")[2].isdecimal()
            and key == varied.key.split(".")[-2]
        ):
            values, unit = numbers_of(found, varied)
            holder[key] = found = [as_written(one, unit) for one in values]
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
    unit = _UNIT.search(text.strip())
    numeric = re.match(r"\s*[-+.]?\d", text)
    dimension = None if not numeric else dimension_of(unit[0].strip()) if unit else "ratio"
    if dimension is None:
        raise InputError(
            f"is in the case '{text[:40]}', which is no number with a unit; vary its value",
            varied.key,
        )
    return parse_quantities(text, dimension, varied.key), DIMENSIONS[dimension].si_unit


_CURVES = (Constant, PiecewiseLinear, Table, FunctionCurve, WeightedSum)


@dataclass(frozen=True, eq=False)
class _Template:
    """A case file read, without its published values: ``bare`` tree, notes, and the ``warnings`` that
    reading gives.
    """

    bare: dict[str, Any]
    notes: dict[str, Note]
    warnings: tuple[str, ...] = ()


def vary(case: Case, values: Mapping[Varied, float]) -> Case:
    """The case with the varied quantities at ``values`` (SI), as its file with those values would
    give it.

    A case that a program made or changed, so that its text no longer describes it, is changed part
    by part. Raises :class:`InputError`, one sentence, for a key that is not there and for a case
    that cannot exist.

    >>> import valvetrain as vt
    >>> thinner = vary(vt.load_case("gu2021-beehive"), {Varied("spring.wire_diameter", "mm"): 3.7e-3})
    >>> thinner == vt.load_case("gu2021-beehive", {"spring.wire_diameter": "0.0037 m"})
    False
    >>> thinner.springs == vt.load_case("gu2021-beehive", {"spring.wire_diameter": "0.0037 m"}).springs
    True
    """
    own = {varied: float(value) for varied, value in values.items() if varied.key != ENGINE_SPEED}
    if not own:
        return case
    remarks = "".join(
        f"# changed: {varied.name} = {value!r} {varied.si_unit}".rstrip() + "\n"
        for varied, value in own.items()
    )
    names = tuple(dict.fromkeys((*case.changed, *(varied.name for varied in own))))
    template = _template(case)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        changed = _changed_case(case, own) if template is None else _from_tree(case, template, own)
    where = ", ".join(
        f"{one.shown_name} = {one.shown(value):.5g} {one.unit}".rstrip()
        for one, value in own.items()
    )
    for one in caught:
        text = str(one.message)
        of_case = template is not None and text in template.warnings
        warnings.warn(text if of_case else f"at {where}: {text}", one.category, stacklevel=2)
    return replace(
        changed, published=case.published, notes=case.notes, text=case.text + remarks, changed=names
    )


def _from_tree(case: Case, template: _Template, values: Mapping[Varied, float]) -> Case:
    tree = copy.deepcopy(template.bare)
    for varied, value in values.items():
        if file_key(varied.key).partition(".")[0] not in (
            "spring",
            "lift_law",
            "operation",
            "train",
            "rubbing",
            "points",
        ):
            raise InputError(
                "is no quantity that moves anything; vary one of spring, lift_law, operation, train, rubbing or points",
                varied.key,
            )
        set_in_tree(tree, varied, value)
    return _read(case, tree, template.notes)


def _read(case: Case, tree: dict[str, Any], notes: dict[str, Note]) -> Case:
    try:
        return CaseModel.model_validate(tree).build(
            case.name, Path(), notes, case.text, case.changed
        )
    except ValidationError as error:
        path, reason = first_problem(error)
        raise InputError(reason, ".".join(map(str, path))) from None
    except PydanticCustomError as error:
        context = error.context or {}
        raise InputError(
            str(context.get("reason", error)), ".".join(map(str, context.get("path", ())))
        ) from None
    except ArithmeticError as error:
        raise InputError(
            f"the numbers of the case are too large or too small to compute with ({error}); check them"
        ) from error


@lru_cache(maxsize=16)
def _template(case: Case) -> _Template | None:
    """The case's text read once; None where the text does not describe the case."""
    try:
        bare, notes, bad = split_notes(tomllib.loads(case.text))
        bare.pop("published", None)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            again = None if bad else _read(case, bare, notes)
    except (ValueError, InputError):
        return None
    if again is None or replace(again, published=case.published, name=case.name) != case:
        return None
    return _Template(bare, notes, tuple(str(one.message) for one in caught))


def _changed_case(case: Case, values: Mapping[Varied, float]) -> Case:
    """A case changed by key paths of its parts."""
    changes: dict[str, Any] = {}
    for varied, value in values.items():
        key = object_key(case, varied.key)
        if varied.operation != "value":
            before = case.replace(changes) if changes else case
            changes[key] = _moved_vary(part_of(before, key), varied, value)
        else:
            changes[key] = value
    return case.replace(changes)


def part_of(item: Any, path: str) -> Any:
    """The part of a case under a key path of :meth:`Case.replace`. Raises :class:`InputError` where
    there is none.
    """
    for key in path.split("."):
        found = item.get(key) if isinstance(item, Mapping) else None
        if isinstance(item, tuple) and key.isdecimal() and int(key) < len(item):
            found = item[int(key)]
        elif found is None:
            values = getattr(item, "values", None)
            found = getattr(item, key, values.get(key) if isinstance(values, Mapping) else None)
        if found is None:
            raise InputError(
                f"the case has no '{key[:60]}' there; its text does not describe it, so keys are those of Case.replace",
                path,
            )
        item = found
    return item


def _moved_vary(before: Any, varied: Varied, value: float) -> Any:
    """A number, a row of numbers or a curve multiplied by or shifted by ``value``."""
    if isinstance(before, bool):
        raise InputError(
            f"is no number, so it has no {varied.operation}; vary its value", varied.key
        )
    if isinstance(before, (int, float)):
        return before * value if varied.operation == "factor" else before + value
    if isinstance(before, tuple):
        return tuple(_moved_vary(one, varied, value) for one in before)
    if isinstance(before, _CURVES):
        if varied.operation == "factor":
            return add_curves(Constant(0.0), before, value)
        return add_curves(before, Constant(value))
    raise InputError(
        f"is no number and no curve, so it has no {varied.operation}; vary its value", varied.key
    )


def tree_of(case: Case) -> dict[str, Any] | None:
    """The bare tree of the case's text, not to be changed; None where the text does not
    describe the case.
    """
    template = _template(case)
    return None if template is None else template.bare


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
    if place is not None:
        return numbers_of(found, varied)[0][place]
    if isinstance(found, str) and "," not in found:
        return numbers_of(found, varied)[0][0]
    if isinstance(found, (int, float)) and not isinstance(found, bool):
        return float(found)
    level = getattr(found, "level", None)
    if isinstance(level, float):
        return level
    raise InputError(
        "has several numbers in the case; vary it as = 'factor' or 'offset', or name one of its parts",
        varied.key,
    )


def unit_in_case(case: Case, key: str) -> str:
    """Unit in which the value of ``key`` is written in the case; empty for a plain number and where
    the case has no text.

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
    tree = tree_of(case)
    if tree is None:
        return part_of(case, object_key(case, key)), None
    found: Any = tree
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
