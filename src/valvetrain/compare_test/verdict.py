"""The verdict on a model against a test: how near the nearest run is, what it misses most, and
whether the test refutes it.
"""

from __future__ import annotations

import math

import numpy as np

from valvetrain.compare_test.compare import ModelAgainstTest
from valvetrain.compare_test.comparison import RunAgainstTest, ValueRow
from valvetrain.compare_test.summary import unit_of_test
from valvetrain.compare_test.tables import value_label
from valvetrain.measured.cycles import MeasuredCycles
from valvetrain.report.text import number, speed_text, unit_text
from valvetrain.solution.definition import label_of
from valvetrain.units import unit_factor

#: Share up to which a value counts as met.
NEAR = 0.05


def test_verdict(found: ModelAgainstTest) -> str:
    """The sentence; runs that did not complete come first."""
    count = len(found.failures)
    lead = f"{count} run{'s' * (count != 1)} did not complete; " if count else ""
    if not found.runs:
        return f"{lead}nothing can be compared."
    best = found.best
    if isinstance(found.test, MeasuredCycles):
        said = _of_cycles(found, found.test, best)
    else:
        said = _of_values(best)
    return f"{lead}{said}{_refuted(found, best)}."


def _of_cycles(found: ModelAgainstTest, test: MeasuredCycles, best: RunAgainstTest) -> str:
    assert best.agreement is not None and best.curve is not None
    unit, factor = unit_of_test(found)
    mean, curve = test.values.mean(axis=0) * factor, best.curve * factor
    rms, reach = best.agreement.rms * factor, float(np.ptp(mean))
    share = f", {100 * rms / reach:.2g} % of its range" if reach > 0 else ""
    return (
        f"{best.label} is {number(rms, 3)} {unit} off the {label_of(test.quantity)} of the test (root mean square{share}); "
        f"its largest is {number(float(curve.max()), 4)} {unit}, test {number(float(mean.max()), 4)} {unit}"
    )


def _of_values(best: RunAgainstTest) -> str:
    known = [one for one in best.values if math.isfinite(one.model)]
    values = [one for one in known if one.unit != "deg"]
    angles = [abs(math.degrees(one.difference)) for one in known if one.unit == "deg"]
    if not known:
        return f"{best.label} has none of the measured values"
    parts = []
    off = [abs(one.difference / one.test) for one in values if one.test]
    near = sum(one <= NEAR for one in off)
    if off:
        all_near = f"all {near}" if len(off) > 1 else "the one"
        counted = all_near if near == len(off) else f"{near} of {len(off)}"
        parts.append(f"{counted} value{'s' * (len(off) != 1)} within {_share(off)}")
    if angles:
        worst_angle = f"{max(angles):.2g}"
        parts.append(f"angles within {worst_angle} cam degree{'s' * (worst_angle != '1')}")
    said = f"{best.label}: {', '.join(parts)}"
    worst = max(
        (one for one in values if one.test),
        key=lambda one: abs(one.difference / one.test),
        default=None,
    )
    if worst is None or abs(worst.difference / worst.test) <= NEAR:
        return said
    both = f"{_shown(worst, worst.model)}, test {_shown(worst, worst.test)}"
    return f"{said}; the {_lower(value_label(worst))} at {speed_text(worst.engine_speed)} is {both}"


def _lower(label: str) -> str:
    """A label amid a sentence; "Stage III" and the like stay."""
    return label if label.startswith("Stage ") else f"{label[:1].lower()}{label[1:]}"


def _share(off: list[float]) -> str:
    """The largest of the shares that count as met."""
    near = [one for one in off if one <= NEAR]
    return f"{100 * max(near):.1f} %" if near else f"{100 * NEAR:.0f} %"


def _shown(one: ValueRow, value: float) -> str:
    return f"{number(value / unit_factor(one.unit), 4)} {unit_text(one.unit)}".strip()


def _refuted(found: ModelAgainstTest, best: RunAgainstTest) -> str:
    if best.adequacy is None:
        return ""
    reason = "refuted" if not best.adequacy.adequate else "not refuted"
    by = (
        f"{best.adequacy.repeats} repeats" if best.adequacy.repeats else "the scatters of the table"
    )
    return f"; {reason} by {by}"
