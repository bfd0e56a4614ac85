"""Verdict of springs at rest: loads, rate, first mode, and what is left to coil bind."""

from __future__ import annotations

import math

from valvetrain.report.clauses import (
    ENDED,
    amount_text,
    figure,
    joined,
    quantity_text,
    sentence,
)
from valvetrain.report.run_summary import share
from valvetrain.report.sections.at_rest import MODE_ORDERS, marked_compressions
from valvetrain.solution.definition import NESTED
from valvetrain.solution.static import SpringAtRest
from valvetrain.solution.study import Study
from valvetrain.units.reader import reader_factor

#: What is said of a spring that closes before full lift, and travel (m) to coil bind below which it is close.
SOLID, NEAR = "solid", 1e-3
#: Further springs whose loads are named, and share by which a rate differs from that as installed.
MAX_SPRINGS, SAME_RATE = 2, 0.02
#: Share within which a spring has the rate of the torsion of its wire.
OF_TORSION = 0.03


def study_verdict(study: Study) -> str:
    """The sentence of a study of springs at rest."""
    return sentence([*rest_failures(study), *rest_clauses(study)])


def rest_failures(study: Study) -> list[str]:
    """Springs whose static curve or modes did not complete."""
    return [
        f"{one.spring} {ENDED.get(part.status.code, part.status.code)} by {one.model}, {name}"
        for one in study.rest
        for name, part in (("at rest", one.curve), ("in its modes", one.modes))
        if part is not None and not part.status.completed
    ]


def rest_clauses(study: Study) -> list[str]:
    """Loads, rate and first axial mode of the first spring at rest, how far other models are, and what
    is left to coil bind; where loads or modes were requested, those of other springs too.
    """
    if not study.rest:
        return []
    first = study.rest[0]
    several = len({one.spring for one in study.rest}) > 1
    parts = _loads(study, first)
    modes = [] if first.modes is None else [float(one) for one in first.modes.axial_frequencies]
    if modes:
        place = 0 if study.command == "modes" else len(parts)
        parts.insert(place, f"first axial mode {figure(modes[0])} Hz{_orders(study, modes[0])}")
    if not parts:
        return []
    others = [
        float(one.modes.axial_frequencies[0]) / modes[0] - 1
        for one in study.rest[1:]
        if modes and one.spring == first.spring and one.model != first.model
        if one.modes is not None and len(one.modes.axial_frequencies)
    ]
    whose = f"{first.spring}: " if several else ""
    text = f"{whose}{joined(parts)} by {first.model}"
    if others:
        apart = share(max(map(abs, others)))
        text += f", other models {apart if apart.startswith('less') else f'at most {apart}'} off in that mode"
    if modes:
        text += _less_than_torsion(study, modes[0])
    texts = [*pair_clause(study), f"{text}{_to_solid(study, first)}"]
    named = {one.spring: one for one in reversed(study.rest) if one.spring != first.spring}
    for name, one in list(reversed(named.items()))[:MAX_SPRINGS]:
        if study.command == "static" and (loads := _loads(study, one)):
            texts.append(f"{name}: {joined(loads)}{_to_solid(study, one)}")
        elif (
            study.command == "modes" and one.modes is not None and len(one.modes.axial_frequencies)
        ):
            frequency = float(one.modes.axial_frequencies[0])
            texts.append(f"{name}: {figure(frequency)} Hz{_orders(study, frequency)}")
    return texts


def _loads(study: Study, one: SpringAtRest) -> list[str]:
    """Preload, load at full lift and rate of a spring, as far as its curve reaches."""
    curve, parts = one.curve, list[str]()
    if curve is None or not curve.compression[0] <= one.precompression <= curve.compression[-1]:
        return parts
    if one.precompression > 0:
        parts.append(f"preload {amount_text(curve.force_at(one.precompression), 'N')}")
    rate = float(curve.stiffness_at(one.precompression))
    rates = f"rate {amount_text(rate * 1e-3, 'N/mm')}"
    full = marked_compressions(study, one).get("full lift", math.inf)
    if study.command == "static" and full <= curve.compression[-1]:
        lift = quantity_text("maximum_lift", full - one.precompression)
        parts.append(f"{amount_text(curve.force_at(full), 'N')} at the full lift of {lift}")
        there = float(curve.stiffness_at(full))
        if abs(there / rate - 1) > SAME_RATE:
            rates += f" ({figure(there * 1e-3 * reader_factor('N/mm'))} at full lift)"
    return [*parts, rates]


def _to_solid(study: Study, one: SpringAtRest) -> str:
    """``, clear of coil bind by 3.6 mm at full lift`` where loads were requested; else empty."""
    alike = (other for other in study.rest if other.spring == one.spring)
    known = [found for other in alike if "solid" in (found := marked_compressions(study, other))]
    if study.command != "static" or not known or "full lift" not in known[0]:
        return ""
    marks = known[0]
    left = marks["solid"] - marks["full lift"]
    room = quantity_text("coil_bind_clearance", abs(left))
    if left < 0:
        return f", {SOLID} {room} before the full lift"
    only = "only " if left < NEAR else ""
    return f", {only}{room} from coil bind at full lift"


def _orders(study: Study, frequency: float) -> str:
    """Crank speeds at which cam orders meet a frequency (Hz), where modes were requested."""
    if study.command != "modes":
        return ""
    ends = (f"{order} at {120 * frequency / order:.0f} rpm" for order in MODE_ORDERS)
    return f" (cam order {' to '.join(ends)})"


def _less_than_torsion(study: Study, frequency: float) -> str:
    """``; torsion of the wire alone, by which cards go, gives 681 Hz, ...`` of a wire whose rate is that of
    its torsion; empty for any other, and with a mass or a free end.
    """
    first = study.rest[0]
    sizes = study.still.get("") or study.still.get(f"{first.spring}, {first.model}") or {}
    alone, torsion = sizes.get("estimated_surge_frequency"), sizes.get("estimated_rate")
    curve, modes = first.curve, first.modes
    if study.command != "modes" or not alone or not torsion or curve is None or modes is None:
        return ""
    rate = float(curve.stiffness_at(first.precompression))
    below = 1 - frequency / alone
    sideways = len(modes.coil_number) > 0 and modes.attached_mass is None
    if not sideways or abs(rate / torsion - 1) > OF_TORSION or not 0.005 < below < 0.06:
        return ""
    return (
        f"; torsion of the wire alone, by which cards go, gives {figure(alone)} Hz, {share(alone / frequency - 1)} more: "
        "few coils also tilt and move sideways"
    )


def pair_clause(study: Study) -> list[str]:
    """Preload and rate of both springs of a nested pair together; empty for other springs."""
    pair = [one for one in study.rest if one.model == study.rest[0].model and one.spring in NESTED]
    curves = [one.curve for one in pair if one.curve is not None]
    if len(curves) != len(NESTED):
        return []
    at = [(curve, one.precompression) for curve, one in zip(curves, pair, strict=True)]
    force = sum(float(curve.force_at(compression)) for curve, compression in at)
    rate = sum(float(curve.stiffness_at(compression)) for curve, compression in at)
    parts, rated = [f"preload {amount_text(force, 'N')}"], amount_text(rate * 1e-3, "N/mm")
    lifts = [
        marked_compressions(study, one).get("full lift", math.inf) - one.precompression
        for one in pair
    ]
    lift = max(lifts)
    if study.command == "static" and all(c + lift <= curve.compression[-1] for curve, c in at):
        full = sum(float(curve.force_at(compression + lift)) for curve, compression in at)
        parts.append(
            f"{amount_text(full, 'N')} at the full lift of {quantity_text('maximum_lift', lift)}"
        )
    return [f"together {joined([*parts, f'rate {rated}'])}"]
