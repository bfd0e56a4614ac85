"""What springs at rest cost: time and memory of static curves and modes, before they are computed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from valvetrain.parameters.case import Case
from valvetrain.parameters.curves import Constant
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.runs.cost import Cost
from valvetrain.runs.planned import CARD_CHAIN, RunRequest, planned, unknowns_of
from valvetrain.runs.static_study import WIRE, default_name
from valvetrain.runs.statics import APPROACH, BEYOND
from valvetrain.springs.spec import spring_model

#: Steps to which a request is counted; so many lie beyond every bound.
MAX_COUNTED = 10**12


#: Points of the path behind every curve, and solutions that the search for a load takes.
PATH, SEARCH = APPROACH + BEYOND + 1, 12


#: Seconds per point and finite element where coils lie apart, and where they close one by one;
#: bytes kept of both.
APART, CLOSING, POINT_BYTES = 22e-6, 65e-6, 130.0


#: Modes of a rod: seconds per unknown and square of the vectors of the search, of which there are
#: two per mode.
MODE, VECTORS = 2.5e-9, 2.0


#: Seconds per finite element that the modes of a train take to find its two states at rest.
TRAIN_ROD = 0.03


#: Chain of masses: seconds per point and mass, seconds per cube and bytes per square of the masses
#: for all its frequencies.
CHAIN_POINT, CHAIN_CUBE, CHAIN_BYTES = 3e-6, 2.5e-10, 16.0


#: Seconds around a spring by one model; seconds and bytes of a point of any curve, as it is kept
#: and told.
AROUND, TOLD, TOLD_BYTES = 0.1, 1e-4, 2e3


def rest_cost(
    case: Case,
    spring_models: Sequence[str] = (),
    *,
    spring_sets: Sequence[str] = (),
    steps: int,
    modes: int = 0,
    heights: int = 0,
    loads: int = 0,
) -> Cost:
    """Estimated cost of :func:`valvetrain.runs.static_study.rest_study` with as many ``heights``
    and ``loads`` asked for.
    """
    parts = planned(RunRequest("static", case, None, (), tuple(spring_sets), 1))
    springs = dict.fromkeys(spring for _, springs in parts for spring in springs)
    points = heights + SEARCH * loads
    found = (
        spring_cost(spring, word, steps, modes, points)
        for spring in springs
        for word in spring_models or (default_name(spring),)
    )
    trains = (
        _train_modes(spring, word)
        for models, springs in parts
        for spring in springs
        for word in spring_models or models
    )
    return _sum(found) + (_sum(trains) if modes and case.train is not None else Cost())


def spring_cost(
    spring: InstalledSpring, word: str, steps: int, modes: int = 0, points: int = 0
) -> Cost:
    """Estimated cost of one spring by one model: a curve of ``steps``, ``modes`` and as many other
    ``points``.
    """
    spec = spring_model(word, "--spring")
    steps = min(steps, MAX_COUNTED)
    told = Cost(AROUND + TOLD * steps, TOLD_BYTES * steps)
    if spec.no_motion or spec.why_not(spring):
        return told
    unknowns = unknowns_of(spec, spring)[1]
    if word == WIRE:
        return told + _rod(spring, unknowns, PATH + steps + 1 + points, modes)
    if spec.needs_rest:
        told += _rod(spring, unknowns_of(spring_model(WIRE), spring)[1], PATH, max(modes, 8))
    if word == CARD_CHAIN:
        told += Cost(CHAIN_POINT * unknowns * (PATH + steps + 1 + points)) + _chain_modes(spring)
    return told


def _rod(spring: InstalledSpring, elements: float, points: float, modes: int) -> Cost:
    each = APART if spring.wire is None or isinstance(spring.wire.pitch, Constant) else CLOSING
    size = 6.0 * elements
    vectors = min(VECTORS * modes, size)
    statics = Cost(each * elements * points, POINT_BYTES * elements * points)
    return statics + Cost(MODE * size * vectors**2, 16.0 * size * vectors)


def _chain_modes(spring: InstalledSpring) -> Cost:
    masses = unknowns_of(spring_model(CARD_CHAIN), spring)[1]
    return Cost(CHAIN_CUBE * masses**3, CHAIN_BYTES * masses**2)


def _train_modes(spring: InstalledSpring, word: str) -> Cost:
    if word == CARD_CHAIN:
        return _chain_modes(spring)
    return Cost(TRAIN_ROD * unknowns_of(spring_model(WIRE), spring)[1]) if word == WIRE else Cost()


def _sum(costs: Iterable[Cost]) -> Cost:
    total = Cost()
    for cost in costs:
        total += cost
    return total
