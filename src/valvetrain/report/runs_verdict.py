"""Verdict on two saved runs: which headline quantities are better and which are worse in the second."""

from __future__ import annotations

import math
from collections.abc import Sequence

from valvetrain.report.clauses import figure
from valvetrain.report.text import percent, unit_text
from valvetrain.runs.headline_changes import LEAST, HeadlineChange
from valvetrain.solution.definition import definition_of, label_of, shown

#: Changes that are named, of the better and of the worse ones.
MAX_NAMED = 4


def runs_verdict(changes: Sequence[HeadlineChange], failed: Sequence[str] = ()) -> str:
    """The sentence; ``failed``: which of A and B did not complete.

    >>> runs_verdict([HeadlineChange("lift_loss_displacement", 1.16e-4, 9.8e-5)])
    'From A to B better: lift lost 0.116 -> 0.098 mm (−15.5 %).'
    >>> runs_verdict([HeadlineChange("seating_velocity", 0.5, 0.501, bar=0.01)])
    'No headline quantity changes by more than its error bar or 0.5 %.'
    """
    lead = f"{' and '.join(failed)} did not complete; " if failed else ""
    if not changes:
        text = "the two runs have no headline quantity at one speed and model in common"
        return _whole(lead, text)
    moved = [one for one in changes if one.counts]
    alike = f"by more than its error bar or {100 * LEAST:g} %"
    if not moved:
        return _whole(lead, f"no headline quantity changes {alike}")
    parts = []
    for word, better in (("better", True), ("worse", False)):
        some = [one for one in moved if one.better is better]
        if some:
            more = f" and {len(some) - MAX_NAMED} more" if len(some) > MAX_NAMED else ""
            parts.append(f"{word}: {', '.join(map(_change, some[:MAX_NAMED]))}{more}")
    if len(changes) > len(moved):
        still = len(changes) - len(moved)
        parts.append(
            f"{still} other{'s' if still > 1 else ''} alike (within error bar or {100 * LEAST:g} %)"
        )
    return _whole(lead, f"from A to B {'; '.join(parts)}")


def _whole(lead: str, text: str) -> str:
    text = f"{lead}{text}."
    return f"{text[:1].upper()}{text[1:]}"


def _change(one: HeadlineChange) -> str:
    """``lift lost 0.116 -> 0.098 mm (−15.5 %)``."""
    unit = unit_text(definition_of(one.quantity).unit_word)
    texts = [
        "never reached" if math.isinf(value) else figure(float(shown(one.quantity, value)[0]), 4)
        for value in (one.a, one.b)
    ]
    if math.isinf(one.b):
        texts[0] = f"{texts[0]} {unit}".strip()
    else:
        texts[1] = f"{texts[1]} {unit}".strip()
    known = one.a and math.isfinite(one.a) and math.isfinite(one.b)
    share = f" ({percent((one.b - one.a) / abs(one.a))})" if known else ""
    name, comma, rest = label_of(one.quantity).partition(", ")
    label = f"{name} ({rest})" if comma else name  # of a list whose commas part the quantities
    return f"{label} {texts[0]} -> {texts[1]}{share}"
