"""A spring definition behind a table of forces: active turns and a pitch law whose coils close
where the table says, with intervals.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from scipy.optimize import least_squares

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.measured.force_curve import Estimate
from valvetrain.measured.force_height import ForceHeight
from valvetrain.parameters.card import SpringCard
from valvetrain.parameters.curves import RAMP, Constant, PiecewiseLinear
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.winding import EndCoil
from valvetrain.solution.display import Saveable
from valvetrain.spring_card.card import (
    POSSIBLE_INACTIVE,
    CatalogueCard,
    SpringLoad,
    Winding,
    first_winding,
    turns_of_mass,
)
from valvetrain.spring_card.fit import forces_at

Closes = Literal["lower", "upper", "both"]
#: Places along the wire and forces on which the closing of the coils is computed; stiffness of
#: closed coils (N/m).
PLACES, FORCES, CLOSED = 481, 400, 1e8
#: Corrections by the rod, and the change of its forces (of their largest) below which they end.
CORRECTIONS, SETTLED = 8, 3e-4
#: Scatter of a station before it is known, and the least that is believed, as shares of the largest
#: force.
FIRST_SCATTER, MIN_SCATTER = 3e-3, 2e-4
#: Standard deviations of the rise of the gap from station to station and of the change of that
#: rise, in wire diameters: the typical value
#: among progressive springs. They decide where the table does not.
RISE, BEND = 0.5, 0.15
#: What a height of a table is true to (m): where the force rises steeply, it decides how well a
#: station is known.
HEIGHT_SCATTER = 20e-6
#: Rates (N/m) of springs, from those of models to those of ship engines.
RATES = (10.0, 1e7)


@dataclass(frozen=True)
class PitchLaw:
    """How numbers become a spring: active turns, the first gap and the steps to the next ones, from
    the end that closes first.
    """

    card: CatalogueCard
    total: float | None
    ground: float
    closes: Closes
    stations: int

    def winding(self, active: float) -> tuple[float, float]:
        """All turns, and inactive turns at either end."""
        if self.total is None:
            return active + 2.0, 1.0
        return self.total, (self.total - active) / 2

    def gaps(self, steps: Array) -> Array:
        """Gap (m) at each station along the wire."""
        rising: Array = np.cumsum(steps)
        if self.closes == "lower":
            return rising
        if self.closes == "upper":
            return rising[::-1]
        half = rising[: (self.stations + 1) // 2]
        return np.concatenate([half, half[::-1][self.stations % 2 :]])

    @property
    def steps(self) -> int:
        """Numbers behind the gaps."""
        return (self.stations + 1) // 2 if self.closes == "both" else self.stations

    def places(self, active: float) -> Array:
        """Coil numbers (turns) of the stations."""
        total, inactive = self.winding(active)
        return np.linspace(inactive + RAMP / 2, total - inactive - RAMP / 2, self.stations)

    def definition(self, numbers: Array) -> SpringDefinition:
        """The spring of ``numbers``: active turns, then steps of the gaps (m)."""
        wire = self.card.wire_diameter
        total, inactive = self.winding(numbers[0])
        knots = np.concatenate(
            [
                [0.0, inactive - RAMP / 2],
                self.places(numbers[0]),
                [total - inactive + RAMP / 2, total],
            ]
        )
        pitch = wire + np.concatenate([[0.0, 0.0], self.gaps(numbers[1:]), [0.0, 0.0]])
        keep = np.append(True, np.diff(knots) > 1e-9)
        end = EndCoil("closed-ground", inactive, self.ground)
        return SpringDefinition(
            Constant(wire),
            self.card.mean_diameter(total),
            PiecewiseLinear(tuple(knots[keep]), tuple(pitch[keep])),
            total_coils=total,
            material=self.card.wire,
            lower_end=end,
            upper_end=end,
            name=self.card.name,
        )


def closing_forces(definition: SpringDefinition, heights: Array) -> Array:
    """Forces (N) at heights (m) of a wire in torsion whose turns close one after the other.

    Under F the wire gives 8 D^3 / (G d^4) F per turn until the turn about a place has used up its
    gap: x(F) = integral of
    min(F c(u), gap(u)) du, gap(u) = rise over the turn about u less the wire.
    """
    coil = np.linspace(*definition.free_coils, PLACES)
    low, high = np.maximum(coil - 0.5, 0.0), np.minimum(coil + 0.5, definition.total_coils)
    wire = definition.wire_diameter.value(coil)
    gap = np.maximum(
        definition.axial_position(high) - definition.axial_position(low) - wire * (high - low), 0.0
    )
    give = (
        8
        * definition.mean_diameter.value(coil) ** 3
        / (definition.material.shear_modulus * wire**4)
    )
    force = np.linspace(0.0, 3 * float(np.max(gap / give)) + 1.0, FORCES)
    shorter = np.trapezoid(np.minimum(force[:, None] * give, gap), coil, axis=1) + force / CLOSED
    return np.interp(definition.free_length - heights, shorter, force)


def fit_closing(
    law: PitchLaw, start: Winding, active: float, heights: Array, forces: Array
) -> tuple[Array, Array, float]:
    """Numbers of ``law``, their covariance and the scatter (N): least squares on closing coils,
    with the difference to the rod added.

    Closing coils have slopes everywhere and one best answer, which the rod, whose coils close node
    after node, has not.
    """
    wire, top = law.card.wire_diameter, float(np.max(forces))
    even = max(
        (start.free_length - wire * (start.total_coils + 1 - 2 * start.ground))
        / max(active - RAMP, 0.5),
        0.05 * wire,
    )
    numbers = np.append(active, np.where(np.arange(law.steps) == 0, even, 0.05 * wire))
    most = 40.0 if law.total is None else law.total - 2 * POSSIBLE_INACTIVE[0]
    least = 1.0 if law.total is None else max(law.total - 2 * POSSIBLE_INACTIVE[1], 0.6)
    low, high = (
        np.append(least, np.full(law.steps, 1e-6 * wire)),
        np.append(most, np.full(law.steps, 20 * wire)),
    )
    numbers = np.clip(numbers, low * 1.001, high * 0.999)
    scatter, apart = FIRST_SCATTER * top, np.zeros(len(heights))
    steps = np.append(1e-4, np.full(law.steps, 1e-4 * wire))

    def misses(values: Array) -> Array:
        rise = values[2:] / wire
        found = closing_forces(law.definition(values), heights) + apart
        return np.concatenate(
            [(found - forces) / np.hypot(scatter, steep), rise / RISE, np.diff(rise) / BEND]
        )

    def slopes(values: Array) -> Array:
        here, columns = misses(values), []
        for place, step in enumerate(steps):
            away = step if values[place] + step <= high[place] else -step
            columns.append(
                (misses(values + np.where(np.arange(len(values)) == place, away, 0.0)) - here)
                / away
            )
        return np.array(columns).T

    steep = HEIGHT_SCATTER * np.gradient(-forces, heights)
    for number in range(CORRECTIONS):
        found = least_squares(
            misses,
            numbers,
            jac=slopes,
            bounds=(low, high),
            x_scale=np.append(0.1, np.full(law.steps, 0.1 * wire)),
        )
        numbers, before = found.x, apart
        definition = law.definition(numbers)
        _refuse_misfit(closing_forces(definition, heights) + apart - forces, 3 * MISFIT * top)
        rod = forces_by_rod(definition, heights)
        left = rod - forces
        spare = max(len(heights) - len(numbers), 1)
        scatter = max(float(np.sqrt(left @ left / spare)), MIN_SCATTER * top)
        apart = rod - closing_forces(definition, heights)
        if float(np.max(np.abs(apart - before))) < SETTLED * top:
            break
        if number:  # the difference itself swings about its end
            apart = (apart + before) / 2
    covariance = np.linalg.pinv(found.jac.T @ found.jac)
    return numbers, covariance, scatter


def forces_by_rod(definition: SpringDefinition, heights: Array) -> Array:
    """Forces (N) of the rod at heights (m); 0 above the free length, and those of all but closed
    coils below.
    """
    lowest = definition.solid_height + 0.02 * definition.solid_compression
    clipped = np.clip(heights, lowest, definition.free_length)
    return np.array(forces_at(definition, clipped.tolist()))


#: Heights that a fit looks at, most stations of the pitch law and turns to one of them.
HEIGHTS, STATIONS, TURNS_A_STATION = 36, 7, 0.8
#: Points of the curve that is shown.
CURVE = 41
#: Scatter about the rod, as a share of the largest force, from which no spring was found; what may be wrong then.
MISFIT, CHECK = (
    0.03,
    "check wire, diameters, material and the units of the table, or give total_coils",
)
#: Turns of a spring over its active ones that its solid height takes, less what is ground away, and
#: the standard deviation: without any number of the ends, and where all turns are given.
STACKED, STACKED_TOTAL = (2.1, 0.5), (-0.25, 0.25)
#: Share of the travel at which numbers are reported where no installed height is given.
QUARTER = 0.25


@dataclass(frozen=True, eq=False)
class PitchStations:
    """The pitch law as it was found: ``coil`` turns from the lower tip, ``pitch`` and its standard
    deviation ``spread`` (m), each (k,).
    """

    coil: Array
    pitch: Array
    spread: Array


@dataclass(frozen=True, eq=False)
class WireFit:
    """The wire behind a table: ``active_coils`` with their standard deviation and the pitch law at
    ``stations``. ``by_rod``: (m, 3) heights (m), forces (N) of the table and of the finite-element rod;
    ``scatter`` (N): standard deviation of the table about the rod. ``free``: words for what the table
    left open.
    """

    definition: SpringDefinition
    active_coils: tuple[float, float]
    stations: PitchStations
    scatter: float
    by_rod: Array
    free: tuple[str, ...]

    @property
    def worst_by_rod(self) -> float:
        """Largest difference (N) between the finite-element rod and the table."""
        return float(np.max(np.abs(self.by_rod[:, 2] - self.by_rod[:, 1])))


@dataclass(frozen=True, eq=False)
class TesterFit(Saveable):
    """What a table of forces says of a spring; SI, each number with its standard deviation.

    ``rate`` (N/m) and ``preload`` (N) at the installed ``height`` (m); ``free_length`` and
    ``solid_height`` (m), None where nothing shows them. ``bound``: whether the table reaches coil bind.
    ``wire``: the wire that has these forces, None where no sizes were given. Made by
    :func:`spring_from_tester`.

    >>> [name for name in TesterFit.__dataclass_fields__ if name in ("rate", "preload", "wire")]
    ['rate', 'preload', 'wire']
    """

    table: ForceHeight
    spring: InstalledSpring
    height: float
    rate: tuple[float, float]
    preload: tuple[float, float]
    free_length: tuple[float, float] | None
    solid_height: tuple[float, float] | None
    bound: bool
    wire: WireFit | None = None

    def __repr__(self) -> str:
        rate = f"rate {self.rate[0] / 1e3:.4g} ± {2 * self.rate[1] / 1e3:.2g} N/mm"
        if self.wire is None:
            return f"TesterFit: {rate}"
        turns = (
            f"{self.wire.active_coils[0]:.3f} ± {2 * self.wire.active_coils[1]:.3f} active turns"
        )
        return f"TesterFit '{self.wire.definition.name}': {rate}, {turns}, rod within {self.wire.worst_by_rod:.2g} N"


def spring_from_tester(
    table: ForceHeight,
    card: CatalogueCard | None = None,
    closes: Closes = "lower",
    installed_height: float | None = None,
    name: str = "spring",
) -> TesterFit:
    """What a table of a spring tester says of its spring, and the wire behind it: active turns and a
    pitch law, fitted until the finite-element rod has its forces.

    Parameters
    ----------
    table : of :func:`read_force_height`
    card : dimensions of the wire and the coils (:func:`card_from_table` makes one); its loads are not
        used. Without it there is no wire
    closes : end whose coils close first; the table cannot show it, seat and retainer exchanged give
        the same forces
    installed_height : at which preload and rate are reported, m; without it the largest height of
        the table, or a quarter of its travel where the spring hardly presses there
    name : of a spring without a card

    Returns
    -------
    TesterFit

    Raises
    ------
    InputError : a table that no spring of this wire and these coils can make

    Examples
    --------
    >>> import numpy as np
    >>> heights = np.linspace(50e-3, 38e-3, 13)
    >>> table = ForceHeight(heights, 40e3 * (55e-3 - heights))
    >>> fit = spring_from_tester(table, card_from_table(table, wire_diameter=4.2e-3, outer_diameter=30.2e-3))
    >>> round(fit.wire.active_coils[0], 1), round(fit.rate[0] / 1e3)
    (4.4, 40)
    """
    if closes not in get_args(Closes):
        raise InputError(
            f"closes is lower, upper or both, not '{str(closes)[:40]}'; say which end of the spring closes first",
            "closes",
        )
    height = _reported_height(table) if installed_height is None else installed_height
    if not table.heights[-1] < height <= table.heights[0] * (1 + 1e-9):
        given = (
            "the table holds travels and no free length is given, so it has no heights; give the free length"
            if table.measured_from == "travel"
            else f"the table holds heights of {table.heights[0] * 1e3:.4g} to {table.heights[-1] * 1e3:.4g} mm, not the installed "
            f"{height * 1e3:.4g} mm; give one inside"
        )
        raise InputError(given, "installed_height")
    rate, preload = table.rate_at(height), table.force_at(height)
    if not RATES[0] <= rate.value <= RATES[1]:
        raise InputError(
            f"the table makes a rate of {rate.value / 1e3:.3g} N/mm, which no spring has; check its rows and units"
        )
    heights = table.measured_from != "travel"
    wire = None if card is None else _wire_fit(table, card, closes)
    solid, bound = table.bind(), table.curve.bind() is not None
    free_length = table.contact() if table.measured_from == "seat" else None
    if heights and free_length is None and table.free_length is not None:
        free_length = Estimate(table.free_length, 0.0)
    if wire is None or card is None:
        known = SpringCard(
            rate.value, preload.value, installed_height=height if heights else None,
            solid_height=solid.value if solid else None, name=name,
        )  # fmt: skip
        spring = InstalledSpring(card=known, precompression=preload.value / rate.value)
    else:
        solid = solid or _stacked_height(table, card, wire.active_coils[0])
        spring = InstalledSpring(
            wire=wire.definition, precompression=max(wire.definition.free_length - height, 0.0)
        )
    return TesterFit(table, spring, height, rate, preload, free_length, solid, bound, wire)


def _reported_height(table: ForceHeight) -> float:
    """The largest height (m) where the spring presses there, else that of a quarter of the travel."""
    pressed, _ = table.curve.elastic
    if table.force_at(float(table.heights[0])).value > 0.05 * float(np.max(table.forces)):
        return float(table.heights[0])
    return float(-pressed[0] - QUARTER * (pressed[-1] - pressed[0]))


def _stacked_height(table: ForceHeight, card: CatalogueCard, active: float) -> Estimate:
    """Solid height (m) of the wire's turns, below the last height of the table."""
    if card.solid_height is not None:
        return Estimate(card.solid_height, 0.0)
    total = card.total_coils
    if total is None and card.mass is not None:
        total = turns_of_mass(card, card.mass)
    more, spread = STACKED if total is None else STACKED_TOTAL
    middle = ((active if total is None else total) + more) * card.wire_diameter
    high = min(middle + 2 * spread * card.wire_diameter, float(table.heights[-1]))
    low = min(middle - 2 * spread * card.wire_diameter, high - card.wire_diameter / 2)
    return Estimate((low + high) / 2, (high - low) / 4)


def _wire_fit(table: ForceHeight, card: CatalogueCard, closes: Closes) -> WireFit:
    """The wire of ``card`` whose rod has the forces of the table."""
    if table.measured_from == "travel":
        raise InputError(
            "the table holds travels, so the free length is needed for the wire; give it",
            "free_length",
        )
    start = first_winding(card)
    turns_given = (
        card.total_coils is not None or card.mass is not None or card.solid_height is not None
    )
    active = start.total_coils - 2 * start.inactive
    _refuse_turns(table, card, active)
    count = int(np.clip(round(active / TURNS_A_STATION), 3, STATIONS))
    law = PitchLaw(card, start.total_coils if turns_given else None, start.ground, closes, count)
    chosen = _thinned(*table.curve.elastic)
    numbers, covariance, scatter = fit_closing(law, start, active, *chosen)
    _refuse_misfit(scatter, MISFIT * float(np.max(chosen[1])))
    definition = law.definition(numbers)
    weights = np.array([law.gaps(row) for row in np.eye(law.steps)])
    stations = PitchStations(
        law.places(numbers[0]),
        law.card.wire_diameter + law.gaps(numbers[1:]),
        np.sqrt(np.maximum(np.einsum("ia,ij,ja->a", weights, covariance[1:, 1:], weights), 0.0)),
    )
    travel, _ = table.curve.elastic
    lowest = max(-float(travel[-1]), definition.solid_height + 0.02 * definition.solid_compression)
    fine = np.linspace(-float(travel[0]), lowest, CURVE)
    measured = np.interp(-fine, -table.heights, table.forces)
    return WireFit(
        definition,
        (float(numbers[0]), float(np.sqrt(covariance[0, 0]))),
        stations,
        scatter,
        np.column_stack([fine, measured, forces_by_rod(definition, fine)]),
        _left_free(law, table.curve.bind() is not None),
    )


def _refuse_misfit(misfit: Array | float, most: float) -> None:
    """Raise :class:`InputError` where a fit is off by more than ``most`` (N, root mean square)."""
    if (off := float(np.sqrt(np.mean(np.square(misfit))))) > most:
        raise InputError(
            f"no spring of this wire and these sizes makes this table: the nearest is {off:.2g} N off; {CHECK}"
        )


def _refuse_turns(table: ForceHeight, card: CatalogueCard, active: float) -> None:
    """Raise :class:`InputError` where the turns that make the rate are less than one, or solid above the table."""
    solid, lowest = active * card.wire_diameter, float(table.heights[-1])
    if active >= 1 and (solid <= lowest or card.top_outer_diameter is not None):
        return
    made = f"{card.rate / 1e3:.3g} N/mm needs {active:.2g} active turns of {1e3 * card.wire_diameter:.4g} mm"
    why = (
        f", which are solid at {1e3 * solid:.3g} mm, above its {1e3 * lowest:.4g} mm"
        if active >= 1
        else ""
    )
    raise InputError(f"this wire and these sizes cannot make this table: {made}{why}; {CHECK}")


def card_from_table(table: ForceHeight, **known: object) -> CatalogueCard:
    """A card of the sizes that are known, with two loads from the low part of a table.

    Parameters
    ----------
    table : of :func:`read_force_height`
    known : what else :class:`CatalogueCard` takes, such as
        ``wire_diameter="4.2 mm", outer_diameter="30.2 mm"``

    Returns
    -------
    CatalogueCard

    Raises
    ------
    InputError : a table whose force does not rise, sizes that contradict each other

    Examples
    --------
    >>> import numpy as np
    >>> heights = np.linspace(50e-3, 38e-3, 13)
    >>> table = ForceHeight(heights, 40e3 * (55e-3 - heights))
    >>> round(card_from_table(table, wire_diameter="4.2 mm", outer_diameter="30.2 mm").rate)
    40000
    """
    travel, force = table.curve.elastic
    forces = force[0] + np.array([0.05, 0.35]) * (force[-1] - force[0])
    low = (force >= forces[0]) & (force <= forces[1])
    if np.count_nonzero(low) < 3:
        low = np.arange(len(force)) < 3
    slope, offset = np.polyfit(travel[low], force[low], 1)
    if not slope > 0:
        raise InputError(
            "the force does not rise as the height falls at the beginning of the table; check it"
        )
    loads = [
        SpringLoad(float(-place), float(slope * place + offset)) for place in travel[low][[0, -1]]
    ]
    return CatalogueCard(installed_load=loads[0], open_load=loads[1], **known)  # type: ignore[arg-type]


def _thinned(travel: Array, forces: Array) -> tuple[Array, Array]:
    """Means of heights and forces over even pieces of the travel."""
    if len(travel) <= HEIGHTS:
        return -travel, forces
    edges = np.linspace(travel[0], travel[-1], HEIGHTS + 1)
    piece = np.clip(np.searchsorted(edges, travel, side="right") - 1, 0, HEIGHTS - 1)
    count = np.bincount(piece, minlength=HEIGHTS)
    sums = [np.bincount(piece, values, HEIGHTS) for values in (-travel, forces)]
    return sums[0][count > 0] / count[count > 0], sums[1][count > 0] / count[count > 0]


def _left_free(law: PitchLaw, bound: bool) -> tuple[str, ...]:
    words = (
        "both ends" if law.closes == "both" else f"{law.closes} end", "material" * (law.card.material is None),
        "turns" * (law.total is None), "gaps" * (not bound),
    )  # fmt: skip
    return tuple(filter(None, words))
