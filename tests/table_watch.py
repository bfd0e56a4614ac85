"""Every terminal table that any test prints: columns of numbers stand at the right, columns of
words do not.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import Any

from valvetrain.cli import outcome as tables

#: A number as tables print it: signs, shares, ranges of error bars, angles and counts in brackets.
NUMBER = re.compile(r"[-+−±~]?[\d.,]+(?:e[-+]?\d+)?(?: ?[%°])?(?: ?±.*)?")
#: Heads under which anything may stand: inputs of two runs, lists of speeds, digests, and the one
#: column of a list of facts.
ANYTHING = ("A", "B", "rpm", "digest", "")
usual = tables.plain_table


def watched(
    headers: Sequence[str],
    rows: Iterable[Sequence[str]],
    title: str = "",
    right: Sequence[int] = (),
) -> Any:
    """``plain_table``, with its columns looked at."""
    told = [tuple(row) for row in rows]
    assert all(0 <= place < len(headers) for place in right) and len(set(right)) == len(
        tuple(right)
    ), (headers, right)
    for place, head in enumerate(headers):
        cells = [row[place] for row in told if place < len(row) and row[place] not in ("", "–")]
        numbers = [bool(NUMBER.fullmatch(cell)) for cell in cells]
        assert not cells or not all(numbers) or place in right or head in ANYTHING, (
            f"numbers under '{head}' stand at the left: {cells[:3]}"
        )
        digits = any(char.isdigit() for cell in cells for char in cell)
        assert digits or not cells or place not in right, (
            f"words under '{head}' stand at the right: {cells[:3]}"
        )
    return usual(headers, told, title, right)


tables.plain_table = watched
