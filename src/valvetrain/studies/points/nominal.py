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
    tree = tree_of(case)
    found: Any = part_of(case, varied.key) if tree is None else tree
    if tree is not None:
        for key in varied.key.split("."):
            if isinstance(found, dict) and key in found:
                found = found[key]
            elif isinstance(found, list) and key.isdecimal() and int(key) < len(found):
                found = found[int(key)]
            elif isinstance(found, str) and "," in found and key.isdecimal() and int(key) < len(found.split(",")):
                return numbers_of(found, varied)[0][int(key)]
            else:
                raise InputError("is not in the case, so it has no value to stand about; give low and high, or mean", varied.key)
    if isinstance(found, str) and "," not in found:
        return numbers_of(found, varied)[0][0]
    if isinstance(found, (int, float)) and not isinstance(found, bool):
        return float(found)
    level = getattr(found, "level", None)
    if isinstance(level, float):
        return level
    raise InputError("stands for several numbers in the case; vary it as = 'factor' or 'offset', or name one of its parts", varied.key)
