"""How the published values of a case compare, in one clause: by role, by kind of quantity, and the
worst by name.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence

from valvetrain.report.clauses import figure
from valvetrain.report.text import percent, speed_text
from valvetrain.solution.comparison import Comparison
from valvetrain.solution.definition import label_of
from valvetrain.solution.quantity import unit_of

ROLES = ("calibration", "check", "prediction")
#: Kind -> SI units of its quantities.
KINDS = {"forces": ("N",), "motion": ("m", "m/s", "m/s^2")}
#: Values that are named as the furthest from the published ones.
NAMED = 3


def published_clause(rows: Sequence[Comparison]) -> str:
    """How the published values of a case compare; empty without any.

    Roles and kinds are given apart, since a median over values that were fitted and values that were
    predicted describes neither. Values in doubt are left out; angles count in degrees.
    """
    given = [row for row in rows if row.difference is not None and not row.doubt]
    angles = [row for row in given if row.unit == "deg"]
    known = [row for row in given if row.unit != "deg" and row.relative_difference is not None]
    if not known:
        return ""
    if len(known) == 1:
        name, middle = label_of(known[0].quantity), _middle(known)
        return f"the published value of {name} differs by {middle}"
    roles = [(role, [row for row in known if row.role == role]) for role in ROLES]
    by_role = [f"{role} {_middle(mine)} ({len(mine)})" for role, mine in roles if mine]
    parts = [f"{len(known)} published values, median difference of {', '.join(by_role)}"]
    kinds = {
        kind: [r for r in known if unit_of(r.quantity) in units] for kind, units in KINDS.items()
    }
    by_kind = [f"{kind} {_middle(mine)}" for kind, mine in kinds.items() if mine]
    if angles:
        off = statistics.median(abs(math.degrees(row.difference or 0.0)) for row in angles)
        by_kind.append(f"angles {figure(off)} deg")
    if len(by_kind) > 1:
        parts.append(", ".join(by_kind))
    worst = sorted(known, key=lambda row: -abs(row.relative_difference or 0.0))
    named = [_named(row) for row in worst[: min(NAMED, len(known) - 1)]]
    return "; ".join([*parts, f"furthest {', '.join(named)}"])


def _middle(rows: Sequence[Comparison]) -> str:
    return share(statistics.median(abs(row.relative_difference or 0.0) for row in rows))


def _named(row: Comparison) -> str:
    where = "" if row.engine_speed is None else f" at {speed_text(row.engine_speed)}"
    return f"{label_of(row.quantity)}{where} {percent(row.relative_difference or 0.0)}"


def share(value: float) -> str:
    """A positive share in per cent."""
    return "less than 0.1 %" if 0 <= value < 5e-4 else percent(value).lstrip("+")
