"""Which part of a train gains how much engine speed: each is changed alone, and its critical speeds are searched."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from valvetrain.errors import UnusualValueWarning, ValvetrainError
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.material import Material
from valvetrain.parameters.train import TrainParameters
from valvetrain.parameters.train_parts import PushrodParameters
from valvetrain.runs.requests import Parts, Watch
from valvetrain.runs.run import sweep_study
from valvetrain.runs.workers import map_points
from valvetrain.solution.critical import RPM
from valvetrain.solution.part_ranking import PartChange, PartRanking
from valvetrain.solution.status import reason
from valvetrain.solution.study import Study
from valvetrain.springs.equivalent import EquivalentSpring

TENTH = 0.1
#: Titanium over steel by density, and the share of a steel retainer in what moves with the valve, which is assumed.
TITANIUM, RETAINER = 4.43 / 7.85, 0.16
#: Names of common steel pushrods, stiffer and stiffer -> outer diameter and wall (in); so many of them are tried, each
#: with a section larger by this factor at least.
TUBES = {
    "5/16 × 0.080 in": (0.3125, 0.08), "3/8 × 0.080 in": (0.375, 0.08), "3/8 × 0.120 in": (0.375, 0.12),
    "7/16 × 0.125 in": (0.4375, 0.125), "7/16 × 0.165 in": (0.4375, 0.165), "1/2 × 0.188 in": (0.5, 0.188),
}  # fmt: skip
TRIED, STIFFER = 2, 1.05
INCH, POUND_FORCE, LASH = 0.0254, 4.4482216, 50e-6
#: Speeds searched, over the range of the train as it is: below its least and above its largest critical speed.
BELOW, ABOVE, STEP = 0.94, 1.2, 100 * RPM
#: Share of the train as it is in the time of all.
OF_BASE = 0.2
STRESS = "open_nominal_shear_stress"
#: Key of the limit of a train as it is.
NOMINAL = ("", "")
#: Cause and change, as those of a range of critical speeds, -> least and largest limit (rad/s).
Limits = Mapping[tuple[str, str], tuple[float, float]]


@dataclass(frozen=True)
class Part:
    """A train in which one part is changed: what, what that costs, and the train."""

    name: str
    price: str
    train: TrainParameters


def parts_of(train: TrainParameters, spring_set: str) -> Iterator[Part]:
    """The trains in which a part that the ``train`` has is changed.

    Parameters
    ----------
    train : as it is
    spring_set : name of the set in use

    Examples
    --------
    >>> import valvetrain as vt
    >>> [one.name for one in parts_of(vt.load_case("tdi-pushrod").train, "stock")][:2]
    ['valve 10 % lighter', 'titanium retainer']
    """
    less, more = 1 - TENTH, 1 + TENTH
    valve, follower, lever = train.valve, train.follower, train.lever

    def lighter_valve(share: float) -> TrainParameters:
        return train.replace(valve=replace(valve, mass=(1 - share) * valve.mass))

    yield Part("valve 10 % lighter", "such as a hollow stem", lighter_valve(TENTH))
    yield Part("titanium retainer", "wears at the locks", lighter_valve(RETAINER * (1 - TITANIUM)))
    if follower.mass > 0:
        changed = train.replace(follower=replace(follower, mass=less * follower.mass))
        yield Part("follower 10 % lighter", "", changed)
    if lever is not None:
        turned = replace(lever, inertia=less * lever.inertia, mass=less * lever.mass)
        yield Part("rocker 10 % lighter", "may bend more", train.replace(lever=turned))
        if lever.stiffness is not None:
            stiff = replace(lever, stiffness=more * lever.stiffness)
            yield Part("rocker 10 % stiffer", "often heavier", train.replace(lever=stiff))
    for name, pushrod in stiffer_pushrods(train.pushrod):
        yield Part(name, "needs room in the head", train.replace(pushrod=pushrod))
    yield from _springs(train, spring_set)
    for sign, word in ((1, "more"), (-1, "less")):
        if 0 < train.lash > -sign * LASH:
            changed = train.replace(lash=train.lash + sign * LASH)
            price = "louder, lands faster" if sign > 0 else "may hang open when hot"
            yield Part(f"lash 0.05 mm {word}", price, changed)


def _springs(train: TrainParameters, spring_set: str) -> Iterator[Part]:
    """The changes of the springs in use."""
    springs = train.spring_parts(spring_set)

    def part(name: str, price: str, *changed: InstalledSpring) -> Part:
        return Part(name, price, train.replace(springs={**train.springs, spring_set: changed}))

    rate = sum(map(_rate, springs))
    for pounds in (5, 10):
        shim = pounds * POUND_FORCE / rate
        price = f"cam wear and torque, {shim * 1e3:.1f} mm nearer coil bind"
        yield part(f"seat load +{pounds} lbf", price, *(_shimmed(one, shim) for one in springs))
    for factor, word, price in (
        (1 + TENTH, "stiffer", "cam wear and torque over the nose"),
        (1 - TENTH, "softer", ""),
    ):
        yield part(f"rate 10 % {word}", price, *(_scaled(one, rate=factor) for one in springs))
    if any(one.card is None or one.card.mass is not None for one in springs):
        lighter = (_scaled(one, mass=1 - TENTH) for one in springs)
        yield part("spring 10 % lighter", "such as a beehive", *lighter)


def _rate(spring: InstalledSpring) -> float:
    """Rate (N/m) with the valve closed."""
    return spring.card.rate if spring.card else EquivalentSpring.from_installed(spring).rate


def _shimmed(spring: InstalledSpring, shim: float) -> InstalledSpring:
    """The spring installed shorter by ``shim`` (m)."""
    card = spring.card
    if card is None:
        return replace(spring, precompression=spring.precompression + shim)
    height = None if card.installed_height is None else card.installed_height - shim
    changed = replace(card, preload=card.preload + card.rate * shim, installed_height=height)
    return replace(spring, card=changed)


def _scaled(spring: InstalledSpring, rate: float = 1.0, mass: float = 1.0) -> InstalledSpring:
    """The spring with its rate, about the same preload, and its mass multiplied: of a wire by its moduli, for then, as with
    other turns, a force has the same stress, and by its density.
    """
    if card := spring.card:
        heavy = None if card.mass is None else mass * card.mass
        return replace(spring, card=replace(card, rate=rate * card.rate, mass=heavy))
    assert spring.wire is not None
    steel = spring.wire.material
    moduli = rate * steel.youngs_modulus, rate * steel.shear_modulus
    wire = replace(spring.wire, material=Material(steel.name, *moduli, mass * steel.density))
    return replace(spring, wire=wire, precompression=spring.precompression / rate)


def stiffer_pushrods(pushrod: PushrodParameters | None) -> Iterator[tuple[str, PushrodParameters]]:
    """Names of the next stiffer steel tubes, with the pushrod made of each; none of a rigid one.

    Its length, where the case does not give it, is that of a plain tube of its mass and stiffness.
    """
    if pushrod is None or pushrod.stiffness is None:
        return
    modulus, density = pushrod.youngs_modulus, pushrod.density
    length = pushrod.length or math.sqrt(modulus * pushrod.mass / (density * pushrod.stiffness))
    section = pushrod.stiffness * length / modulus
    areas = {name: math.pi * wall * (outer - wall) * INCH**2 for name, (outer, wall) in TUBES.items()}  # fmt: skip
    stiffer = [(name, area) for name, area in areas.items() if area > STIFFER * section]
    for name, area in stiffer[:TRIED]:
        mass = pushrod.mass + density * length * (area - section)
        changed = replace(pushrod, mass=mass, stiffness=pushrod.stiffness * area / section)
        yield f"pushrod {name}", changed


def rank_parts(request: Parts, watch: Watch = Watch()) -> PartRanking:
    """The parts of a train by the engine speed of control that each gains.

    Parameters
    ----------
    request : case with a train, and the speeds at which it is searched as it is
    watch : who watches

    Returns
    -------
    PartRanking; without changes where the train is controlled at all speeds searched, or at none

    Raises
    ------
    InputError : a case without a train, several spring sets or models
    """
    train, tell = request.case.train, watch.progress or (lambda share, text: None)
    assert train is not None
    request = request.with_speeds()
    count = request.worker_count
    base = sweep_study(request, Watch(lambda share, text: tell(OF_BASE * share, text)))
    limits = limits_of(base)
    limit = limits[NOMINAL][0]
    ranking = PartRanking(
        base.record.name, base.labels[0], limit, base.engine_speeds[0], base.engine_speeds[-1], seat_load=_seat_load(base),
        red_line=base.record.red_line, text=base.record.text,
    )  # fmt: skip
    if not 0 < limit < math.inf:
        return ranking
    ends = [one for pair in limits.values() for one in pair if 0 < one < math.inf]
    first, last = math.floor(BELOW * min(ends) / STEP), math.ceil(ABOVE * max(ends) / STEP)
    around = tuple(STEP * place for place in range(max(first, 1), last + 1))
    ranking = replace(ranking, first_engine_speed=around[0], last_engine_speed=around[-1])
    parts = tuple(parts_of(train, request.spring_sets[0]))

    def done(finished: int, total: int) -> None:
        tell(OF_BASE + (1 - OF_BASE) * finished / total, "parts")

    shared = replace(request, engine_speeds=around, workers=1), ranking, limits, _stress(base)
    changes = map_points(_changed, shared, parts, count, processes=True, tell=done)
    unknown = (
        _change(Part(f"damping {change}", "not known", train), ranking, limits, {NOMINAL: pair})
        for (cause, change), pair in limits.items()
        if cause == "damping"
    )
    unknowns = tuple(replace(one, chosen=False) for one in unknown)
    ordered = sorted(changes, key=lambda one: (bool(one.refusal), -one.gain))
    return replace(ranking, changes=(*ordered, *unknowns))


def _changed(shared: tuple[Parts, PartRanking, Limits, float], part: Part) -> PartChange:
    """The gain of one changed train; what it refuses is its ``refusal``."""
    request, ranking, limits, stress = shared
    try:
        # what is unusual of a changed part is no slip of its user
        with warnings.catch_warnings(action="ignore", category=UnusualValueWarning):
            study = sweep_study(replace(request, case=request.case.replace(train=part.train)))
    except ValvetrainError as error:
        return PartChange(part.name, part.price, refusal=reason(error))
    change = _change(part, ranking, limits, limits_of(study))
    seat, wire = _seat_load(study) - ranking.seat_load, _stress(study) - stress
    return replace(change, seat_load_change=seat, stress_change=wire)


def _change(part: Part, ranking: PartRanking, before: Limits, after: Limits) -> PartChange:
    """The gain of a part by the limits of both trains, each pair of them with the same thing changed."""

    def within(engine_speed: float) -> float:
        return min(max(engine_speed, ranking.first_engine_speed), ranking.last_engine_speed)

    gains = []
    for key in {**before, **after} if len(after) > 1 else (NOMINAL,):
        low, high = map(within, before.get(key, before[NOMINAL]))
        least, largest = map(within, after.get(key, after[NOMINAL]))
        gains += [least - high, largest - low]
    limit = after[NOMINAL][0]
    gain = within(limit) - ranking.engine_speed
    return PartChange(part.name, part.price, limit, gain, min(gains), max(gains))


def limits_of(study: Study) -> Limits:
    """Up to which engine speed (rad/s) the first train of a study is controlled, and with each thing changed of which a
    range of critical speeds is made: least and largest, 0 where it is not at the first speed, infinite where it always is.
    """
    # short ranges of lost contact alone limit nothing
    rows = [
        one
        for one in study.critical_speeds
        if one.label == study.labels[0] and not 0 < len(one.ranges) <= one.short_count
    ]
    own = [one.ranges[one.short_count].lower_engine_speed if one.ranges else math.inf for one in rows]  # fmt: skip
    limits = {NOMINAL: (min(own, default=math.inf),) * 2}
    keys = {(each.cause, each.change): None for one in rows for each in one.members if not each.refusal}  # fmt: skip
    for key in keys:
        pairs = []
        for row, speed in zip(rows, own, strict=True):
            members = (each for each in row.members if (each.cause, each.change) == key)
            roots = [each.engine_speed for each in members] or [speed]
            pairs.append((min(roots), max(roots)))
        limits[key] = min(low for low, _ in pairs), min(high for _, high in pairs)
    return limits


def _seat_load(study: Study) -> float:
    """Force (N) of all springs in use with the valve closed; NaN where no model gives it."""
    return next((one["preload"] for one in study.still.values() if "preload" in one), math.nan)


def _stress(study: Study) -> float:
    """Largest stress (Pa) of a wire at full lift; NaN of springs without a wire."""
    values = [run.quantities[STRESS] for run in study.solutions if STRESS in run.quantities]
    return max(values, default=math.nan)
