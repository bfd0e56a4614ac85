"""Rules on springs at rest: force over compression (F) and natural modes (N)."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

from valvetrain.findings.engine import Fields, Hit, Hits, Rule
from valvetrain.findings.facts import Facts
from valvetrain.findings.rules_spring import MAY, SOLID, STATE, WOUND
from valvetrain.findings.springs_at_rest import State, pair_of, states_of
from valvetrain.findings.words import RPM, Amount, about, digits_text, speed_text
from valvetrain.solution.critical import NEAR_BIND
from valvetrain.solution.modes import TrainModes

#: What bounds the speeds in use of a case with a red line, and without.
IN_USE = ("red line", "highest speed")
#: Cam orders that are named where a case states no engine speed.
ORDERS = (12, 6)
#: Highest cam order whose lift is compared.
HIGHEST = 40
#: Share by which the rate differs at full lift from that of the closed valve before both are named.
SAME_RATE = 0.01


# -- force over compression ------------------------------------------------------------------------


def near(facts: Facts) -> Hits:
    """Less than a millimetre is left to coil bind at the largest lift."""
    for one in states_of(facts.study):
        if one.left is not None and 0 <= one.left.value < NEAR_BIND:
            yield Hit(one.left, None, NEAR_BIND, {"spring": one.name}, -one.left.value)


def unknown_solid(facts: Facts) -> Hits:
    """A spring states no height at which it is solid, and not both wire and turns."""
    for one in states_of(facts.study):
        if math.isfinite(one.lift) and not math.isfinite(one.solid) and WOUND[0] not in one.values:
            yield Hit(fields={"spring": one.one.spring})


def wound(facts: Facts) -> Hits:
    """Wire and turns of a card without a solid height may leave less than a millimetre to coil bind."""
    for one in states_of(facts.study):
        least = one.amount(WOUND[0])
        if least is not None and least.value < NEAR_BIND:
            yield Hit(least, fields={"spring": one.name}, severity=-least.value)


def other_height(facts: Facts) -> Hits:
    """A stated solid height is more than 1 % off that of the wire."""
    for one in states_of(facts.study):
        if "computed_solid_height" in one.values:
            fields: Fields = {
                "stated": Amount("solid_height", one.values["solid_height"]),
                "spring": one.name,
            }
            yield Hit(Amount("solid_height", one.values["computed_solid_height"]), fields=fields)


def fails(facts: Facts) -> Hits:
    """A static curve ends before it should, or passes the compression at which the spring buckles."""
    for one in states_of(facts.study):
        curve = one.one.curve
        if curve is not None and not curve.status.completed:
            buckling = curve.buckling
            at = None if buckling is None else Amount("buckling_compression", buckling.compression)
            yield Hit(at, None, None, {
                "did": "" if at else curve.status.message, "remedy": curve.status.remedy, "spring": one.one.spring,
            })  # fmt: skip


def leans(facts: Facts) -> Hits:
    """A spring in a guide bows until it touches it."""
    for one in states_of(facts.study):
        leaning = None if one.one.curve is None else one.one.curve.leaning
        if leaning is not None:
            at = Amount("buckling_compression", leaning.compression)
            force = Amount("guide_force", leaning.force)
            yield Hit(at, None, None, {"spring": one.name, "force": force})


def loads(facts: Facts) -> Hits:
    """Loads with the valve closed and at full lift."""
    states = states_of(facts.study)
    pair = pair_of(states) if states else None
    if pair is not None:
        yield from _loads(pair.name, pair.force, pair.rate, 0.0, pair.lift)
    for one in states[:1] if pair is None else ():
        yield from _loads(one.name, one.force, one.rate, one.one.precompression, one.full_lift)


Read = Callable[[float], Amount | None]


def _loads(name: str, force: Read, rate: Read, closed: float, full: float) -> Hits:
    """Loads at two compressions (m), or lifts, of a spring that lifts."""
    first, last = force(closed), force(full) if math.isfinite(full) else None
    before, after = rate(closed), rate(full) if math.isfinite(full) else None
    if first is None or last is None or before is None or after is None:
        return
    same = abs(after.value / before.value - 1) < SAME_RATE
    yield Hit(last, None, None, {
        "spring": name, "closed": first, "lift": Amount("maximum_lift", full - closed), "rate": before,
        "rate_full": "" if same else after,
    }, 0.0)  # fmt: skip


def as_installed(facts: Facts) -> Hits:
    """Load and rate of a spring that nothing lifts."""
    for one in states_of(facts.study)[:1]:
        force, rate = (read(one.one.precompression) for read in (one.force, one.rate))
        if rate is not None and not math.isfinite(one.lift):
            closed = force if force is not None and force.value > 0 else ""
            yield Hit(rate, None, None, {"spring": one.name, "closed": closed})


# -- natural modes ---------------------------------------------------------------------------------


def orders_of(facts: Facts, natural_frequency: float) -> tuple[int, ...]:
    """Cam orders that are named with a ``natural_frequency`` (Hz): the lowest that meets it at a speed in use, or a range."""
    top = facts.study.record.top_speed
    return (math.ceil(120 * natural_frequency / (top / RPM)),) if top else ORDERS


def speed_of(order: int, natural_frequency: float) -> float:
    """Engine speed (rad/s) at which a cam order meets a ``natural_frequency`` (Hz)."""
    return 120 * natural_frequency / order * RPM


def lift_of(facts: Facts, order: int) -> Amount | None:
    """Amplitude of a cam order of the lift; None where nothing lifts the springs."""
    name = f"lift_harmonic_{order}_lift"
    return (
        Amount(name, facts.study.still[""][name]) if name in facts.study.still.get("", {}) else None
    )


def strongest(facts: Facts, natural_frequency: float, count: int = 1) -> tuple[int, ...]:
    """The ``count`` cam orders with the largest lift that meet a ``natural_frequency`` (Hz) at a speed in use, ascending;
    the lowest ones without a lift.
    """
    lowest = orders_of(facts, natural_frequency)[0]
    orders = range(lowest, max(lowest, HIGHEST) + 1)
    sizes = {order: one.value for order in orders if (one := lift_of(facts, order)) is not None}
    return tuple(sorted(sorted(sizes or orders, key=lambda one: -sizes.get(one, 0.0))[:count]))


def surges(facts: Facts) -> Hits:
    """The first axial natural frequency, both ends fixed, of the spring that the strongest cam order shakes most."""
    met = list[tuple[float, State, Amount, int]]()
    for one in {one.one.spring: one for one in reversed(states_of(facts.study))}.values():
        if one.surge is None or one.one.modes is None or one.one.modes.attached_mass is not None:
            continue
        (order,) = strongest(facts, one.surge.value)
        lift, rate = lift_of(facts, order), one.rate(one.one.precompression)
        met.insert(0, (lift.value * rate.value if lift and rate else 0.0, one, one.surge, order))
    met.sort(key=lambda one: -one[0])
    for _, one, surge, order in met[:1]:
        orders = orders_of(facts, surge.value)
        first, *more = (speed_text(speed_of(k, surge.value), "") for k in orders)
        fields: Fields = {"order": str(orders[0]), "last": str(orders[-1]), "speed": first, "top": f"{more[0]} rpm"} if more else {
            "strongest" if lift_of(facts, order) else "lowest": str(order), "speed": speed_text(speed_of(order, surge.value)),
        }  # fmt: skip
        if met[1:] and not more:
            _, other, its_surge, its_order = met[1]
            fields = {**fields, "other": other.name, "other_value": its_surge, "other_order": str(its_order),
                      "other_speed": speed_text(speed_of(its_order, its_surge.value))}  # fmt: skip
        step = "sweep" if math.isfinite(one.lift) else "static"
        yield Hit(surge, None, None, {**fields, "spring": one.name, "next": step})


def moving_end(facts: Facts) -> Hits:
    """The first axial natural frequency with a mass on the retainer, or with its end free."""
    for one in states_of(facts.study)[:1]:
        mass = None if one.one.modes is None else one.one.modes.attached_mass
        if one.surge is not None and mass is not None:
            grams = f"{digits_text(1e3 * mass)} g on the retainer" if mass else "the end free"
            yield Hit(one.surge, None, None, {"spring": one.name, "end": grams})


def still(facts: Facts) -> Hits:
    """No spring has modes by the models that were asked for."""
    some = states_of(facts.study)
    if some and not any(one.surge for one in some):
        yield Hit(fields={"model": some[0].one.model})


def failed_modes(facts: Facts) -> Hits:
    """Modes about a state that does not last, such as one beyond buckling."""
    for one in states_of(facts.study):
        modes = one.one.modes
        if modes is not None and not modes.status.completed:
            yield Hit(fields={"did": modes.status.message, "remedy": modes.status.remedy})


def _train(facts: Facts) -> Iterator[tuple[TrainModes, TrainModes]]:
    modes = facts.study.train_modes
    return zip(modes[::2], modes[1::2], strict=False)


def apart(facts: Facts) -> Hits:
    """By how much the surge of two nested springs differs, and the speed at which strong cam orders shake both: their
    resonances there are nearer than they are wide at half power.
    """
    pair = pair_of(states_of(facts.study))
    halves = [one.values.get(HALF, math.nan) for one in pair.pair] if pair else []
    surges = [one.surge.value for one in pair.pair if one.surge] if pair else []
    if len(surges) == 2 and all(map(math.isfinite, halves)):
        share = abs(surges[0] / surges[1] - 1)
        width = sum(
            math.log(2) / (math.tau * one * half) for one, half in zip(surges, halves, strict=True)
        )
        outer, inner = (
            [(speed_of(order, one), order) for order in strongest(facts, one, STRONG)]
            for one in surges
        )
        distance, near = min(
            (abs(one[0] / two[0] - 1), (one, two)) for one in outer for two in inner
        )
        fields = {"apart": f"{100 * share:.2g} %", "width": f"{100 * width:.2g} %"}
        if distance < width:
            (speed, order), (_, other) = near
            fields |= {"speed": f"{about(speed)} rpm", "order": str(order), "other": str(other)}
        yield Hit(fields=fields)


def whole_train(facts: Facts) -> Hits:
    """The lowest natural frequency of the train with its springs, valve closed and at full lift."""
    for closed, lifted in list(_train(facts))[:1]:
        one, other = (
            Amount("surge_frequency", float(t.natural_frequency[0])) for t in (closed, lifted)
        )
        yield Hit(
            other, fields={"closed": one, "first": closed.moving(0), "moving": lifted.moving(0)}
        )


HALF = "surge_half_duration"
#: How many of the strongest cam orders are compared between two nested springs.
STRONG = 6
LOADS = ("preload", "installed_rate")
SURGE = ("surge_frequency",)
BIND = ("coil_bind_clearance",)
STATIC = (
    Rule("F101", "decides", "[{spring} buckles at {value} of compression][{did}]", fails, LOADS, step="[{remedy}]"),
    Rule("F102", "decides", "{closed} closed, {value} at the full lift of {lift}[, {spring}]", loads, LOADS,
         "rate {rate..rate_full}", "valvetrain modes {case}", mark=""),
    Rule("F103", "decides", "[{closed} as installed, ]rate {value}[, {spring}]", as_installed, LOADS, "",
         "valvetrain modes {case}", mark=""),
    Rule("F110", "warns", "only {value} left to coil bind[, {spring}]", near, BIND, guide="how-to/05-coil-bind.md"),
    Rule("F113", "warns", "solid at {stated:4} is stated, and the wire binds at {value:4}[, {spring}]", other_height, BIND,
         "the stated height counts", guide="how-to/05-coil-bind.md"),
    Rule("F111", "notes", "[{spring} ]leans on its guide from {value} of compression, in the end with {force}",
         leans, guide="how-to/05-coil-bind.md"),
    Rule("F112", "notes", "coil bind of {spring} is not checked: no solid height is known", unknown_solid, BIND,
         remark="not known"),
    Rule("F114", "warns", SOLID, wound, WOUND, step=STATE, remark=MAY, guide="how-to/05-coil-bind.md"),
)  # fmt: skip
MODES = (
    Rule("N101", "decides", "{did}", failed_modes, SURGE, step="[{remedy}]"),
    Rule("N102", "decides", "surge at {value}[, {spring}]", surges, SURGE,
         "[met by cam orders {order} to {last} at {speed} to {top}][met by cam order {lowest} at {speed}]"
         "[strongest in use with cam order {strongest} at {speed}]"
         "[; {other} {other_value}: order {other_order} at {other_speed}]",
         "valvetrain {next} {case}", mark="", guide="models.md"),
    Rule("N103", "decides", "{value} with {end}[, {spring}]", moving_end, SURGE, mark=""),
    Rule("N104", "decides", "no modes: the {model} model has no inner motion", still, SURGE, mark="warn",
         step="valvetrain modes {case} --model modal-uniform"),
    Rule("N112", "notes", "outer and inner surge {apart} apart, resonances are {width} wide"
         "[: near {speed} cam order {order} shakes the outer and order {other} the inner at once]",
         apart, guide="how-to/06-nested-springs.md"),
    Rule("N111", "notes", "train and springs as one: {closed} closed ({first}), {value} at full lift ({moving})", whole_train),
)  # fmt: skip
