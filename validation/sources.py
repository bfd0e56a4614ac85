"""Every number that the three sources publish, by the runs of their cases: misses are shown, never
tuned away.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from validation.explained import Explained, explained_miss
from validation.row import Row, book_case
from valvetrain.parameters.loading import load_case
from valvetrain.runs.api import simulate
from valvetrain.solution.uncertainty import Comparison
from valvetrain.units import to_unit

#: Agreement required of a published value whose source or case states no tolerance: 3 degrees of an
#: angle, this share of anything else.
ANGLE, SHARE = 3.0, 0.03
#: Numbers that the course report prints for its formulas: contact (N/mm^1.5, N s/mm, mm), masses of valve,
#: rocker and pushrod (kg), two loads of each spring (N), the lift between them (m), cam speed (rpm).
CONTACT_STIFFNESS, CONTACT_DAMPING, CONTACT_DEPTH = 1e5, 49.92, 0.02
MASS = 0.03049 + 0.10634 + 0.17362
STOCK_RATE, RATE = ((high - low) / 8.5e-3 for low, high in ((195.81, 378.27), (342.66, 605.18)))
CAM_SPEED = 2000.0


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
        "published",
        miss.band,
        miss.why,
    )


@book_case(slow=True)
def beehive_spring() -> list[Row]:
    """Gu et al.: static curve, modes and transients of the beehive spring."""
    return rows_of(
        "beehive spring", "gu2021", simulate(load_case("gu2021-beehive-blind")).comparisons
    )


@book_case(slow=True)
def pushrod_train() -> list[Row]:
    """The course report on a cam, pushrod and rocker train."""
    study = simulate(load_case("tdi-pushrod"), spring_sets=("as printed",), workers=1)
    return rows_of("pushrod train", "multibody4b17", study.comparisons)


@book_case()
def pushrod_formulas() -> list[Row]:
    """The formulas of that report, evaluated as printed: arithmetic of its own numbers."""
    formula = (CONTACT_STIFFNESS + CONTACT_DAMPING) * CONTACT_DEPTH**1.5
    natural = math.sqrt(RATE / MASS)
    return [
        _formula("stock spring rate", "table 2", 21.47, STOCK_RATE / 1e3, "N/mm", 0.005),
        _formula("performance spring rate", "table 2", 30.88, RATE / 1e3, "N/mm", 0.005),
        _formula("lumped mass", "equation 8", 0.31045, MASS, "kg", 5e-6),
        _formula("contact formula force", "equation 5", 283.0, formula, "N", 0.2),
        _formula("lumped angular speed", "equation 8", 315.0, natural, "rad/s", 0.6),
        _formula(
            "lumped natural frequency", "equation 8", 50.0, natural / (2 * math.pi), "Hz", 0.5
        ),
        _formula("cam turn frequency", "equation 9", 33.33, CAM_SPEED / 60, "Hz", 0.005),
        # printed as N/m; its other form, 0.196 N s/mm, tells the unit
        _formula(
            "critical damping", "equation 10", 195.8, 2 * math.sqrt(RATE * MASS), "N s/m", 0.1
        ),
    ]


def _formula(
    name: str, place: str, printed: float, computed: float, unit: str, tolerance: float
) -> Row:
    name, reason = f"{name} (closed form of the source)", "digits as printed"
    row = (
        "pushrod train",
        name,
        "multibody4b17",
        place,
        printed,
        computed,
        unit,
        tolerance,
        reason,
    )
    return Row(*row, "consistency")
