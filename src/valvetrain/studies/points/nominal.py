"""What stands in a case where a study varies it."""

from __future__ import annotations

from typing import Any

from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.studies.points.tree import numbers_of
from valvetrain.studies.points.varied import Varied
from valvetrain.studies.points.vary import part_of, tree_of


def nominal(case: Case, varied: Varied) -> float:
    """The value (SI) of the case, 1 for a factor, 0 for an offset.

    Raises :class:`InputError` for a key that is not there, or under which no single number stands.

    >>> import valvetrain as vt
    >>> nominal(vt.load_case("gu2021-beehive"), Varied("spring.precompression", "mm"))
    0.007
    """
    if varied.operation != "value":
        return 1.0 if varied.operation == "factor" else 0.0
    found, place = _stands(case, varied.key)
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
        "stands for several numbers in the case; vary it as = 'factor' or 'offset', or name one of its parts",
        varied.key,
    )


def unit_in_case(case: Case, key: str) -> str:
    """Unit in which the value of ``key`` is written in the case; empty for a plain number and where
    the case has no text.

    >>> import valvetrain as vt
    >>> unit_in_case(vt.load_case("gu2021-beehive"), "spring.precompression")
    'mm'
    """
    found, _ = _stands(case, key)
    return unit_of(found) if isinstance(found, str) else ""


def unit_of(text: str) -> str:
    """Unit of a text, of the last of several numbers.

    >>> unit_of("3.7, 3.8 mm"), unit_of("5 %"), unit_of("7")
    ('mm', '%', '')
    """
    words = text.split(",")[-1].strip()
    return words.lstrip("+-0123456789.eE ").strip() if words else ""


def _stands(case: Case, key: str) -> tuple[Any, int | None]:
    """What stands under ``key``, and the place in it where it is a text of several numbers of which
    one is meant.
    """
    tree = tree_of(case)
    if tree is None:
        return part_of(case, key), None
    found: Any = tree
    for part in key.split("."):
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
                "is not in the case, so it has no value to stand about; give low and high, or mean",
                key,
            )
    return found, None
