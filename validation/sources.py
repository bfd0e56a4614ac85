"""Every number that the three sources publish, by the runs of their cases: misses are shown, never
tuned away.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from validation.explained import Explained, explained_miss
from validation.row import Kind, Row, book_case
from valvetrain.parameters.loading import load_case
from valvetrain.runs.run import run_study
from valvetrain.solution.comparison import Comparison
from valvetrain.units import to_unit

#: Agreement required of a published value whose source or case states no tolerance: 3 degrees of an
#: angle, this share of anything else.
ANGLE, SHARE = 3.0, 0.03


def rows_of(topic: str, key: str, comparisons: Iterable[Comparison]) -> list[Row]:
    """A row per comparison of one case: met within its tolerance, else within the band of an
    explained miss, else a failure.
    """
    return [_row(topic, key, item) for item in comparisons]


def _row(topic: str, key: str, item: Comparison) -> Row:
    published = float(to_unit(item.published, item.unit))
    computed = math.nan if item.computed is None else float(to_unit(item.computed, item.unit))
    if item.difference is not None:
        computed = published + float(to_unit(item.difference, item.unit))
    if item.tolerance is not None:
        tolerance, reason = (
            float(to_unit(item.tolerance, item.unit)),
            "stated by the source or the case",
        )
    elif item.unit == "deg":
        tolerance, reason = ANGLE, f"required of every angle: {ANGLE:g} degrees"
    else:
        tolerance, reason = SHARE * abs(published), f"required of every value: {SHARE:.0%}"
    speed = "" if item.engine_speed is None else f", {item.engine_speed * 30 / math.pi:.0f} rpm"
    origin = f" ({item.origin})" if item.origin else ""
    name = f"{item.quantity.replace('_', ' ')}{speed}{origin}"
    miss = explained_miss(name) or Explained("", None)
    kind: Kind = "consistency" if item.origin.startswith("closed form") else "published"
    return Row(
        topic,
        name,
        key,
        item.role,
        published,
        computed,
        item.unit,
        tolerance,
        reason,
        kind,
        miss.band,
        miss.why,
    )


@book_case(slow=True)
def beehive_spring() -> list[Row]:
    """Gu et al.: static curve, modes and transients of the beehive spring."""
    return rows_of(
        "beehive spring", "gu2021", run_study(load_case("gu2021-beehive-blind")).comparisons
    )


@book_case(slow=True)
def pushrod_train() -> list[Row]:
    """The course report on a cam, pushrod and rocker train."""
    return rows_of(
        "pushrod train",
        "multibody4b17",
        run_study(load_case("tdi-pushrod"), spring_sets=("as printed",), workers=1).comparisons,
    )
