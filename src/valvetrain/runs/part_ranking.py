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
from valvetrain.runs.critical_speeds import CriticalOptions, speeds_near
from valvetrain.runs.prepared import Plan, PreparedRun, largest_lift
from valvetrain.runs.refusals import refuse_implausible
from valvetrain.runs.requests import Parts, Watch
from valvetrain.runs.run import sweep_study
from valvetrain.runs.train_runs import preloads, prepare_trains, train_point
from valvetrain.runs.workers import map_points
from valvetrain.solution.critical import CriticalSpeeds
from valvetrain.solution.part_ranking import PartChange, PartRanking
from valvetrain.solution.status import PartialFailures, reason
from valvetrain.springs.equivalent import EquivalentSpring
from valvetrain.system.build import build
from valvetrain.system.problem import Problem
from valvetrain.units import to_unit
from valvetrain.units.reader import system_of

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
#: What many run to coil bind at full lift (m), to calm the coils.
COIL_BIND = 1.4e-3
INCH, LASH = 0.0254, 50e-6
#: Units in which changes are named -> seat loads that are added (N).
LOADS = {("N", "mm"): (25.0, 50.0), ("lbf", "in"): (22.241108, 44.482216)}
#: Speeds searched, over the range of the train as it is: below its least and above its largest critical speed.
BELOW, ABOVE = 0.94, 1.2
#: Resolution of the search over the limit of the train as it is: changed trains are run every one and a half per
#: cent, with less damping and in another model as close as in a scan of all speeds.
RESOLUTION = 0.0015
#: Share of the train as it is in the time of all.
OF_BASE = 0.2
#: Lift and open time that flex takes, and the largest stress of a wire at full lift.
FLEX, STRESS, BIND = (
    ("lift_loss_displacement", "valve_50_thou_lost_crank_angle_range"),
    "open_nominal_shear_stress",
    "coil_bind_clearance",
)
#: Clearances to coil bind (m) closer than this are one, as lift differs a little from part to part.
SAME = 20e-6
#: Stiffness (N/m) and damping (N s/m) at the valve tip of a rocker that a case calls rigid, both assumed.
BENDS = 40e6, 100.0
#: Key of the limit of a train as it is.
NOMINAL = ("", "")
#: Cause and change, as those of a range of critical speeds, -> least and largest limit (rad/s).
Limits = Mapping[tuple[str, str], tuple[float, float]]


@dataclass(frozen=True)
class Part:
    """A train in which one part is changed: what, what that costs, the train, what sets it on a command line, and whether a
    shop can choose it.
    """

    name: str
    price: str
    train: TrainParameters
    setting: str = ""
    chosen: bool = True


def parts_of(
    train: TrainParameters, spring_set: str, valve_lift: float = math.inf, text: str = ""
) -> Iterator[Part]:
    """The trains in which a part that the ``train`` has is changed.

    Parameters
    ----------
    train : as it is
    spring_set : name of the set in use
    valve_lift : the largest (m), from which springs may be installed closer to coil bind
    text : of the case file, in whose units changes are named, pounds and inches or N and mm

    Examples
    --------
    >>> import valvetrain as vt
    >>> [one.name for one in parts_of(vt.load_case("tdi-pushrod").train, "stock")][:2]
    ['valve 10 % lighter', 'titanium retainer']
    """
    less, more = 1 - TENTH, 1 + TENTH
    units = ("lbf", "in") if system_of(text) == "imperial" else ("N", "mm")

    def part(name: str, price: str, table: str, **values: tuple[float, str]) -> Part:
        """The part with values (SI) of a table of the train in units of the case."""
        numbers = {key: value for key, (value, _) in values.items()}
        changed = replace(getattr(train, table), **numbers) if table else numbers.pop("lash")
        texts = (
            _setting(".".join(filter(None, ("train", table, key))), *one)
            for key, one in values.items()
        )
        return Part(name, price, train.replace(**{table or "lash": changed}), " ".join(texts))

    valve, follower, lever, pushrod = train.valve, train.follower, train.lever, train.pushrod
    for name, price, share in (
        ("valve 10 % lighter", "such as a hollow stem", TENTH),
        ("titanium retainer", "wears at the locks", RETAINER * (1 - TITANIUM)),
    ):
        yield part(name, price, "valve", mass=((1 - share) * valve.mass, "g"))
    if follower.mass > 0:
        yield part("follower 10 % lighter", "", "follower", mass=(less * follower.mass, "g"))
    if lever is not None:
        lighter = {"inertia": (less * lever.inertia, "kg mm^2"), "mass": (less * lever.mass, "g")}
        yield part("rocker 10 % lighter", "may bend more", "lever", **lighter)
        if lever.stiffness is not None:
            stiff = more * lever.stiffness, "kN/mm"
            yield part("rocker 10 % stiffer", "often heavier", "lever", stiffness=stiff)
        else:
            bends = {"stiffness": (BENDS[0], "kN/mm"), "damping": (BENDS[1], "N s/m")}
            bent = part(
                f"rocker of {BENDS[0] / 1e6:g} kN/mm", "rigid in this case", "lever", **bends
            )
            yield replace(bent, chosen=False)
    for name, mass, stiffness in stiffer_pushrods(pushrod):
        tube = {"mass": (mass, "g"), "stiffness": (stiffness, "kN/mm")}
        yield part(name, "needs room in the head", "pushrod", **tube)
    yield from _springs(train, spring_set, valve_lift, units)
    for sign, word in ((1, "more"), (-1, "less")):
        if 0 < train.lash > -sign * LASH:
            price = "louder, lands faster" if sign > 0 else "may hang open when hot"
            lash = train.lash + sign * LASH, units[1]
            yield part(f"lash {_length(LASH, units)} {word}", price, "", lash=lash)


def _length(metres: float, units: tuple[str, str]) -> str:
    return f"{to_unit(metres, units[1]):.2g} {units[1]}"


def _setting(key: str, value: float, unit: str) -> str:
    """The option of a command that gives a key of the case a value (SI)."""
    return f"""--set '{key}="{to_unit(value, unit):.5g} {unit}"'"""


def _springs(
    train: TrainParameters, spring_set: str, valve_lift: float, units: tuple[str, str]
) -> Iterator[Part]:
    """The changes of the springs in use."""
    springs = train.spring_parts(spring_set)

    def part(name: str, price: str, *changed: InstalledSpring) -> Part:
        return Part(name, price, train.replace(springs={**train.springs, spring_set: changed}))

    def shimmed(name: str, price: str, shim: float) -> Part:
        """Installed shorter by ``shim`` (m): springs by card by their preload and height, which a command takes."""
        changed = [_shimmed(one, shim) for one in springs]
        values = {
            f"train.springs.{spring_set}.{place}.{key}": (getattr(one.card, key), unit)
            for place, one in enumerate(changed)
            for key, unit in zip(("preload", "installed_height"), units, strict=True)
            if one.card is not None and getattr(one.card, key) is not None
        }
        by_card = all(one.card is not None for one in changed)
        texts = [_setting(key, *one) for key, one in values.items()] if by_card else ()
        return replace(part(name, price, *changed), setting=" ".join(texts))

    rate = sum(
        one.card.rate if one.card else EquivalentSpring.from_installed(one).rate for one in springs
    )
    for load in LOADS[units]:
        shim = load / rate
        price = f"cam wear and torque, {_length(shim, units)} nearer coil bind"
        name = f"seat load +{to_unit(load, units[0]):.0f} {units[0]}"
        yield shimmed(name, price, shim)
    left = min((one.room for one in springs if one.room is not None), default=0.0) - valve_lift
    if (shim := left - COIL_BIND) > 0:
        name = f"{_length(COIL_BIND, units)} to coil bind"
        price = f"cam wear and torque, a shim of {_length(shim, units)}"
        yield shimmed(name, price, shim)
    for factor, word, price in (
        (1 + TENTH, "stiffer", "cam wear and torque over the nose"),
        (1 - TENTH, "softer", ""),
    ):
        yield part(f"rate 10 % {word}", price, *(_scaled(one, rate=factor) for one in springs))
    if any(one.card is None or one.card.mass is not None for one in springs):
        lighter = (_scaled(one, mass=1 - TENTH) for one in springs)
        yield part("spring 10 % lighter", "such as a beehive", *lighter)


def _shimmed(spring: InstalledSpring, shim: float) -> InstalledSpring:
    """The spring installed shorter by ``shim`` (m)."""
    card = spring.card
    if card is None:
        return replace(spring, precompression=spring.precompression + shim)
    height = None if card.installed_height is None else card.installed_height - shim
    changed = card.replace(preload=card.preload + card.rate * shim, installed_height=height)
    return replace(spring, card=changed)


def _scaled(spring: InstalledSpring, rate: float = 1.0, mass: float = 1.0) -> InstalledSpring:
    """The spring with its rate, about the same preload, and its mass multiplied: of a wire by its moduli, for then, as with
    other turns, a force has the same stress, and by its density.
    """
    if card := spring.card:
        heavy = None if card.mass is None else mass * card.mass
        return replace(spring, card=card.replace(rate=rate * card.rate, mass=heavy))
    assert spring.wire is not None
    steel = spring.wire.material
    moduli = rate * steel.youngs_modulus, rate * steel.shear_modulus
    wire = replace(spring.wire, material=Material(steel.name, *moduli, mass * steel.density))
    return replace(spring, wire=wire, precompression=spring.precompression / rate)


def stiffer_pushrods(pushrod: PushrodParameters | None) -> Iterator[tuple[str, float, float]]:
    """Names of the next stiffer steel tubes, with mass (kg) and stiffness (N/m) of the pushrod made of each; none of a rigid one.

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
        yield f"pushrod {name}", mass, pushrod.stiffness * area / section


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
    limits = limits_of(base.critical_speeds)
    limit, first = limits[NOMINAL][0], base.engine_speeds[0]
    last = base.engine_speeds[-1]
    ends = [one for pair in limits.values() for one in pair if 0 < one < math.inf]
    if lost := 0 < limit < math.inf:
        first, last = BELOW * min(ends), ABOVE * max(ends)
    problem, _, numbers = _prepared(request, train, (base.engine_speeds[0], first))
    ranking = PartRanking(
        base.record.name, base.labels[0], limit, first, last, seat_load=numbers["preload"], red_line=base.record.red_line,
        text=base.record.text, lift_loss=numbers[FLEX[0]], time_lost=numbers[FLEX[1]],
        loss=first_loss(base.critical_speeds),
    )  # fmt: skip
    if not lost:
        return ranking
    kinds = tuple(
        one.kind
        for one in base.critical_speeds
        if any(speed <= max(ends) for speed in (one.deciding_speed, *(each.engine_speed for each in one.members)))
    )  # fmt: skip
    asked = request.critical_options or CriticalOptions()
    options = replace(asked, resolution=RESOLUTION * limit, ranges=True)
    search = Search(request, base.engine_speeds[0], (first, last), kinds, options)
    parts = tuple(parts_of(train, request.spring_sets[0], largest_lift(problem), ranking.text))

    def done(finished: int, total: int) -> None:
        tell(OF_BASE + (1 - OF_BASE) * finished / total, "parts")

    shared = search, ranking, limits, numbers
    changes = map_points(_changed, shared, parts, count, processes=True, tell=done)
    unknown = (
        _change(
            Part(f"damping {change}", "nobody knows it", train), ranking, limits, {NOMINAL: pair}
        )
        for (cause, change), pair in limits.items()
        if cause == "damping"
    )
    unknowns = tuple(replace(one, chosen=False) for one in unknown)
    ordered = sorted(changes, key=lambda one: (one.chosen, bool(one.refusal), -one.gain))
    return replace(ranking, changes=(*unknowns, *ordered))


@dataclass(frozen=True)
class Search:
    """How changed trains are searched: between ``ends`` (rad/s), with the range of each of ``kinds`` of loss; ``slow`` (rad/s):
    the speed at which their lift is compared.
    """

    request: Parts
    slow: float
    ends: tuple[float, float]
    kinds: tuple[str, ...]
    options: CriticalOptions


def _prepared(
    request: Parts, train: TrainParameters, engine_speeds: tuple[float, float]
) -> tuple[Problem, PreparedRun, Mapping[str, float]]:
    """A changed train ready to run, and numbers of it: seat load, the stress of a wire, the lift that flex takes at the lower
    of two ``engine_speeds`` (rad/s) and the open time at the higher; NaN for what it does not have.
    """
    case = request.case.replace(train=train)
    problem = build(case, spring_models=request.models, spring_set=request.spring_sets).settled()
    problem.must_run()
    if not request.implausible:
        refuse_implausible(problem, engine_speeds)
    (ready, *_), _ = prepare_trains(problem, engine_speeds, PartialFailures())
    seat = next((one["preload"] for one in preloads((ready,)).values()), math.nan)
    plan = problem, (ready,), Plan("ends", None, False)
    runs = [train_point(plan, (0, speed)).quantities for speed in engine_speeds]
    stresses = [one for name, one in runs[0].items() if name.endswith(STRESS)]
    lost = {name: run.get(name, math.nan) for name, run in zip(FLEX, runs, strict=True)}
    flex = {name: 0.0 if value < 0 else value for name, value in lost.items()}
    left = runs[0].get(BIND, math.nan)
    return (
        problem,
        ready,
        {"preload": seat, STRESS: max(stresses, default=math.nan), BIND: left, **flex},
    )


def _changed(
    shared: tuple[Search, PartRanking, Limits, Mapping[str, float]], part: Part
) -> PartChange:
    """The gain of one changed train; what it refuses is its ``refusal``."""
    search, ranking, limits, before = shared
    try:
        # what is unusual of a changed part is no slip of its user
        with warnings.catch_warnings(action="ignore", category=UnusualValueWarning):
            problem, ready, numbers = _prepared(
                search.request, part.train, (search.slow, search.ends[0])
            )
            found = speeds_near(problem, ready, search.options, search.ends, search.kinds)
    except ValvetrainError as error:
        return PartChange(
            part.name, part.price, refusal=reason(error), setting=part.setting, chosen=part.chosen
        )
    change, left = _change(part, ranking, limits, limits_of(found)), numbers[BIND]
    return replace(
        change, seat_load_change=numbers["preload"] - ranking.seat_load, stress_change=numbers[STRESS] - before[STRESS], chosen=part.chosen,
        lift_loss=numbers[FLEX[0]], time_lost=numbers[FLEX[1]], bind_clearance=left if left < before[BIND] - SAME else math.nan,
        loss=first_loss(found),
    )  # fmt: skip


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
    ends = min(gains), max(gains)
    return PartChange(part.name, part.price, limit, gain, *ends, setting=part.setting)


def first_loss(found: CriticalSpeeds) -> str:
    """Kind of the critical speed that ends control; empty for none."""
    lost = [(spans[0].lower_engine_speed, one.kind) for one, spans in found.limiting() if spans]
    return min(lost, default=(0.0, ""))[1]


def limits_of(found: CriticalSpeeds) -> Limits:
    """Up to which engine speed (rad/s) a train is controlled, and with each thing changed of which a range of critical speeds
    is made: least and largest, 0 where it is not at the first speed, infinite where it always is. The least one ends where
    runs say nothing of control.
    """
    rows = [one for one, _ in found.limiting()]
    own = [lost[0].lower_engine_speed if lost else math.inf for _, lost in found.limiting()]
    nominal = min(own, default=math.inf)
    silent = (each.lower_engine_speed for one in rows for each in one.silent)
    limits = {NOMINAL: (min((nominal, *silent)), nominal)}
    keys = {(each.cause, each.change): None for one in rows for each in one.members if not each.refusal}  # fmt: skip
    for key in keys:
        pairs = []
        for row, speed in zip(rows, own, strict=True):
            members = [each for each in row.members if (each.cause, each.change) == key]
            roots = [each.engine_speed for each in members] or [speed]
            known = [one.lower_engine_speed for each in members for one in each.silent]
            pairs.append((min((*roots, *known)), max(roots)))
        limits[key] = min(low for low, _ in pairs), min(high for _, high in pairs)
    return limits
