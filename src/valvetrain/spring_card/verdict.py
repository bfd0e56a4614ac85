"""The verdict on a spring from a card or from a table of forces: what is met, and what is not."""

from __future__ import annotations

from valvetrain.report.text import number, percent
from valvetrain.spring_card.fit import SpringFit
from valvetrain.spring_card.page import ROWS
from valvetrain.spring_card.tester import TesterFit

#: Share from which a number of the card counts as missed.
MISSED = 0.01


def card_verdict(fit: SpringFit) -> str:
    """Whether a spring of these turns meets every number of its card, else which it misses."""
    wire = fit.definition
    made = (
        f"{number(wire.total_coils, 4)} turns of {number(1e3 * wire.free_length, 4)} mm free length"
    )
    requested = [one for one in fit.held if one.requested]
    missed = [
        f"{ROWS[one.quantity][0]} by {percent(one.found / one.requested - 1)}"
        for one in requested
        if one.requested and abs(one.found / one.requested - 1) > MISSED
    ]
    if missed:
        said = f"{made} miss {' and '.join(missed)} of the card, {_others(len(requested) - len(missed))}"
    else:
        worst = max(
            (abs(one.found / one.requested - 1) for one in requested if one.requested), default=0.0
        )
        said = f"{made} meet all {len(requested)} numbers of the card within {max(100 * worst, 0.1):.1f} %"
    left = len(fit.free)
    return f"{said}; the card left {left} point{'s' * (left != 1)} open."


def _others(count: int) -> str:
    return (
        "the other number is met within 1 %"
        if count == 1
        else f"the other {count} are met within 1 %"
    )


def tester_verdict(fit: TesterFit) -> str:
    """Rate, load and coil bind of the spring behind a table, and how far the rod is off it."""
    largest = float(fit.table.forces.max())
    bind = (
        f"coil bind from {number(1e3 * fit.coil_bind, 4)} mm"
        if fit.coil_bind is not None
        else "the table ends above coil bind"
    )
    return (
        f"{number(fit.preload[0], 4)} N and {number(1e-3 * fit.rate[0], 4)} N/mm at the installed height, {bind}; the rod meets the table "
        f"within {number(fit.worst_by_rod, 2)} N, {100 * fit.worst_by_rod / largest:.1f} % of its largest force."
    )
