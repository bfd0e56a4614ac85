"""Every number that the three sources publish, by the runs of their cases: misses are shown, never tuned away."""

from __future__ import annotations

import math
from collections.abc import Iterable

from valvetrain.parameters.loading import load_case
from valvetrain.solution.comparison import Comparison
from valvetrain.studies.run import run_study
from valvetrain.units import to_unit
from valvetrain.validation.row import Row, book_case


def rows_of(topic: str, key: str, comparisons: Iterable[Comparison]) -> list[Row]:
    """Rows of the comparisons of one case; only a calibrated value that leaves its stated tolerance fails."""
    rows = []
    for item in comparisons:
        tolerance = math.inf if item.tolerance is None else float(to_unit(item.tolerance, item.unit))
        computed = math.nan if item.computed is None else float(to_unit(item.computed, item.unit))
        published = float(to_unit(item.published, item.unit))
        if item.difference is not None:
            computed = published + float(to_unit(item.difference, item.unit))
        speed = "" if item.engine_speed is None else f", {item.engine_speed * 30 / math.pi:.0f} rpm"
        origin = f" ({item.origin})" if item.origin else ""
        rows.append(
            Row(
                topic,
                f"{item.quantity.replace('_', ' ')}{speed}{origin}",
                key,
                item.role,
                published,
                computed,
                item.unit,
                tolerance,
                "none stated by the source" if item.tolerance is None else "stated by the source or asked for",
                "published",
                "" if item.role == "calibration" and item.computed is not None else item.verdict,
            )
        )
    return rows


@book_case(slow=True)
def beehive_spring() -> list[Row]:
    """Gu et al.: static curve, modes and transients of the beehive spring."""
    return rows_of("beehive spring", "gu2021", run_study(load_case("gu2021-beehive")).comparisons)


@book_case(slow=True)
def pushrod_train() -> list[Row]:
    """The course report on a cam, pushrod and rocker train."""
    return rows_of("pushrod train", "multibody4b17", run_study(load_case("tdi-pushrod"), workers=1).comparisons)
