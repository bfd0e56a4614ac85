"""Rules on springs: coil bind (B), coils that clash (K), ends that lift (E), stress (S), surge (G)."""

from __future__ import annotations

import math
from dataclasses import replace

from valvetrain.findings.engine import SPRINGS, Hit, Hits, Rule, above, below, per_run
from valvetrain.findings.facts import TURN, Facts
from valvetrain.findings.words import Amount
from valvetrain.solution.critical import NEAR_BIND
from valvetrain.solution.result import Solution

#: Surge is large above this share of what the spring has to spare, and none below this share of its peak force.
LARGE, NONE = 0.2, 0.01
#: A raw peak above that below 10 kHz by this share is a spike.
SPIKE = 0.05
#: Models that know the coils of a spring.
KNOWS_COILS = ("finite-element", "solid", "reduced-rod")
#: Code of :meth:`Facts.motion` -> words.
MOTIONS = {
    "closes": "as the valve closes", "opens": "as the valve opens", "shut": "with the valve shut", "": "",
}  # fmt: skip


def _pressed(facts: Facts, run: Solution) -> float:
    """Force (N) with which the spring presses at rest."""
    rest = facts.value(run, "preload")
    return rest if math.isfinite(rest) else run.quantities.get("minimum_spring_force", 0.0)


def _strike(facts: Facts, run: Solution) -> Hit | None:
    """Coils strike one another harder than the spring presses at rest."""
    events, rest = facts.strikes(run), _pressed(facts, run)
    if not events or events[0].size <= rest:
        return None
    hardest, known = events[0], facts.amount(run, "surge_clash_peak_force")
    size = Amount("surge_clash_peak_force", hardest.size)
    size = replace(size, bar=known.bar, rests_on=known.rests_on) if known else size
    angle = float(hardest.details.get("peak_cam_angle", hardest.cam_angle)) % TURN
    upper, lower = (f"{float(hardest.details.get(k, 0)):g}" for k in ("upper_coil", "lower_coil"))
    spring = hardest.where.partition("coils")[0].strip()
    return Hit(size, run, rest, {
        "upper": upper, "lower": lower, "spring": spring and f"{spring} spring, ",
        "angle": Amount("clash_cam_angle", angle), "motion": MOTIONS[facts.motion(run, angle)], "size": size,
        "rests": size.rests_on,
    })  # fmt: skip


strikes = per_run(_strike)


@per_run
def touches(facts: Facts, run: Solution) -> Hit | None:
    """Coils meet, but not harder than the spring presses at rest."""
    events = facts.strikes(run)
    if not events or _strike(facts, run):
        return None
    return Hit(Amount("surge_clash_peak_force", events[0].size), run, _pressed(facts, run))


@per_run
def quiet(facts: Facts, run: Solution) -> Hit | None:
    """The model knows the coils, and none of them strikes another."""
    peak = facts.amount(run, "peak_retainer_force") or facts.amount(run, "peak_spring_force")
    known = "clash_count" in run.quantities
    return Hit(peak, run) if known and peak and not _strike(facts, run) else None


@per_run
def unknown_coils(facts: Facts, run: Solution) -> Hit | None:
    """The run computes no clash of coils, by its model or by its case."""
    peak = facts.amount(run, "peak_spring_force")
    if peak is None or "clash_count" in run.quantities:
        return None
    better = "" if run.model in KNOWS_COILS else KNOWS_COILS[0]
    return Hit(peak, run, fields={"better": better})


@per_run
def spike(facts: Facts, run: Solution) -> Hit | None:
    """The raw peak force is above that below 10 kHz by a twentieth: it lasts so short that mesh and contact constants
    decide its height.
    """
    raw, smooth = (facts.amount(run, name) for name in ("raw_peak_spring_force", FORCE[0]))
    if raw is None or smooth is None or raw.value <= (1 + SPIKE) * smooth.value:
        return None
    return Hit(raw, run, fields={"smooth": smooth})


@per_run
def lifts(facts: Facts, run: Solution) -> Hit | None:
    """The least spring force is below zero by more than its error bar: the spring would leave its seat."""
    least = facts.amount(run, "minimum_spring_force")
    if least is None or least.value + least.bar >= 0:
        return None
    return Hit(least, run, 0.0, severity=-least.value)


def surge(facts: Facts) -> Hits:
    """Surge that is not lost in the force of the spring, and what the spring has to spare: in a train its margin over inertia,
    alone its preload.
    """
    for amount, run in facts.amounts("surge_amplitude_force"):
        spare = facts.amount(run, "minimum_spring_margin_force" if facts.train else "preload")
        peak = run.quantities.get("peak_spring_force", math.inf)
        if amount.resolved and amount.value >= NONE * peak:
            order = run.quantities.get("surge_amplitude_cam_order", 0)
            fields = {
                "order": f"{order:.0f}" if order else "",
                "left": spare if spare and spare.value > 0 else "",
            }
            yield Hit(amount, run, fields=fields)


def large_surge(facts: Facts) -> Hits:
    """Surge above a fifth of what the spring has to spare."""
    for hit in surge(facts):
        left = hit.fields["left"]
        if not isinstance(left, Amount) or (hit.amount and hit.amount.value > LARGE * left.value):
            yield hit


BIND = tuple(f"{prefix}coil_bind_clearance" for prefix in SPRINGS)
WOUND = ("wound_least_clearance", "wound_most_clearance")
#: By wire and turns of a card without a solid height.
SOLID = "wire and turns leave as little as {value} to coil bind[, {spring}][ {at}]"
MAY = "may be solid at full lift"
STATE = "state its solid_height"
CLASH = ("clash_count", "surge_clash_peak_force", "clash_energy")
STRESS = tuple(f"{prefix}peak_shear_stress" for prefix in SPRINGS)
FORCE = ("peak_spring_force", "minimum_spring_force")
SURGE = ("surge_amplitude_force",)
STRIKE = "coil {upper} strikes coil {lower}[ {motion}][, {where}]"
BLOW = "[{spring}]surge at {angle}[, {size}]"
STRIKES = "hardest: [{spring}]coil {upper} on {lower} at {angle}[; height by {rests}]"
SWEEP = "valvetrain sweep {case}"

ALONE = (
    Rule("K101", "decides", STRIKE, strikes, CLASH, BLOW, SWEEP, STRIKES,
         "how-to/16-force-spikes.md"),
    Rule("E101", "decides", "the spring would leave its seat: least force {value}[ {at}]", lifts,
         FORCE, guide="how-to/03-resonance.md"),
    Rule("K103", "decides", "no coil strikes another: at most {value} on the retainer[ {at}]", quiet,
         CLASH, step=SWEEP, mark="ok", unless=("K101", "E101")),
    Rule("K104", "decides", "{value} at most[ {at}]; clash of coils is not computed",
         unknown_coils, step="[valvetrain run {case} --model {better}]", mark="warn",
         unless=("K10", "E101")),
)  # fmt: skip
RULES = (
    Rule("S101", "warns", "{value} of shear, above the {limit} its wire may bear at rest[ {at}]",
         above("open_uncorrected_shear_stress", "permitted_shear_stress", springs=True),
         (*STRESS, "open_uncorrected_shear_stress"), remark="above its static limit", guide="how-to/17-life.md"),
    Rule("S102", "warns", "no wire bears {value}[ {at}]: above its tensile strength of {limit}",
         above("peak_shear_stress", "wire_tensile_strength", springs=True), STRESS, remark="no wire bears it"),
    Rule("B102", "warns", "only {value} left to coil bind[, {spring} spring][ {at}]",
         below("coil_bind_clearance", NEAR_BIND, springs=True), BIND, remark="close", guide="how-to/05-coil-bind.md"),
    Rule("B103", "warns", SOLID, below(WOUND[0], NEAR_BIND, springs=True), WOUND, step=STATE, remark=MAY, guide="how-to/05-coil-bind.md"),
    Rule("K110", "warns", "the peak on the seat is a spike[ {at}][, {value} high]; below 10 kHz it is {smooth}", spike, FORCE[:1],
         remark="below 10 kHz; a spike above", guide="how-to/16-force-spikes.md"),
    Rule("G101", "warns", "surge of {value}[ {at}][ of the {left} that the spring has to spare]", large_surge, SURGE,
         "[cam order {order}]", "valvetrain modes {case}", "[of {left} to spare][, order {order}]", "how-to/03-resonance.md"),
    Rule("G102", "notes", "surge of {value}[ {at}][, cam order {order}]", surge, SURGE, remark="[of {left} to spare][, order {order}]",
         guide="how-to/20-orders.md", mark="ok", unless=("G101",)),
    Rule("K121", "notes", "coils meet lightly[, at most {value}][ {at}]", touches, CLASH, remark="light, below the {limit} at rest",
         mark="ok", unless=("K101", "K102")),
)  # fmt: skip
OF_TRAIN = (
    Rule("K102", "warns", STRIKE, strikes, CLASH, BLOW, remark=STRIKES, guide="how-to/16-force-spikes.md"),
    Rule("K105", "notes", "no coil strikes another harder than the spring presses at rest[ {where}]", quiet, CLASH,
         remark="no blow above the load at rest", mark="ok",
         guide="how-to/16-force-spikes.md", unless=("K102", "K121")),
)  # fmt: skip
