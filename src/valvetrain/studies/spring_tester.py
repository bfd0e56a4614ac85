"""A spring definition behind a table of forces: active turns and a pitch law whose coils close where the table says, with intervals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from valvetrain.errors import InputError
from valvetrain.measurements.catalogue_card import POSSIBLE_INACTIVE, CatalogueCard, SpringLoad, Winding, first_winding
from valvetrain.measurements.force_height import FEWEST, ForceHeight
from valvetrain.parameters.curves import Constant, PiecewiseLinear
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.spring import EndCoil, SpringDefinition
from valvetrain.parameters.wire_ends import RAMP
from valvetrain.springs.chain_layout import chain_from_definition
from valvetrain.springs.chain_statics import static_curve
from valvetrain.springs.multi_mass import CONTACT_STIFFNESS
from valvetrain.studies.spring_card import forces_at

Array = NDArray[np.float64]
Closes = Literal["lower", "upper", "both"]
ENDS: tuple[Closes, ...] = ("lower", "upper", "both")
#: Heights that a fit looks at, elements per turn of its chain, most stations of the pitch law and turns to one of them.
HEIGHTS, MESH, STATIONS, TURNS_A_STATION = 36, 12, 7, 0.8
#: Scatter of a station before it is known, and the least that is believed, as shares of the largest force.
FIRST_SCATTER, LEAST_SCATTER = 3e-3, 2e-4
#: Standard deviation of the rise of the gap from station to station, in wire diameters: what is usual among progressive springs.
BEND = 0.5
#: What a height of a table is true to (m): where the force rises steeply, it decides how well a station is known.
HEIGHT_SCATTER = 20e-6
#: Slope of the table over its first slope from which the coils are taken to be bound.
BOUND = 5.0


@dataclass(frozen=True, eq=False)
class PitchStations:
    """The pitch law as it was found: ``coil`` turns from the lower tip, ``pitch`` and its standard deviation ``spread`` (m), each (k,)."""

    coil: Array
    pitch: Array
    spread: Array


@dataclass(frozen=True, eq=False)
class TesterFit:
    """A spring that meets a table of forces; SI.

    ``rate`` (N/m) and ``preload`` (N) at the installed height with standard deviations; ``coil_bind``: height (m), None where the table does
    not reach it. ``by_rod``: (n, 3) heights, forces of the table and of the finite-element rod. ``scatter`` (N): standard deviation of
    the table about the chain. ``curve``: (m, 3) height, force and rate of the spring by the chain. ``free``: what the table left open.
    """

    table: ForceHeight
    spring: InstalledSpring
    active_coils: tuple[float, float]
    free_length: tuple[float, float]
    rate: tuple[float, float]
    preload: tuple[float, float]
    coil_bind: float | None
    stations: PitchStations
    scatter: float
    by_rod: Array
    curve: Array
    free: tuple[str, ...]

    @property
    def definition(self) -> SpringDefinition:
        """The wire."""
        assert self.spring.wire is not None
        return self.spring.wire

    def __repr__(self) -> str:
        turns = f"{self.active_coils[0]:.3f} ± {2 * self.active_coils[1]:.3f} active turns"
        return f"TesterFit '{self.definition.name}': {turns}, scatter {self.scatter:.2g} N, rod within {self.worst_by_rod:.2g} N"

    @property
    def worst_by_rod(self) -> float:
        """Largest difference (N) between the finite-element rod and the table."""
        return float(np.max(np.abs(self.by_rod[:, 2] - self.by_rod[:, 1])))


@dataclass(frozen=True)
class _Law:
    """How numbers become a spring: active turns, the first gap and the steps to the next ones, from the end that closes first."""

    card: CatalogueCard
    total: float | None
    ground: float
    closes: Closes
    stations: int
    elements: int

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
        knots = np.concatenate([[0.0, inactive - RAMP / 2], self.places(numbers[0]), [total - inactive + RAMP / 2, total]])
        pitch = wire + np.concatenate([[0.0, 0.0], self.gaps(numbers[1:]), [0.0, 0.0]])
        keep = np.append(True, np.diff(knots) > 1e-9)
        end = EndCoil("closed-ground", inactive, self.ground)
        return SpringDefinition(
            Constant(wire), self.card.mean_diameter(total), PiecewiseLinear(tuple(knots[keep]), tuple(pitch[keep])), total, self.card.wire,
            end, end, name=self.card.name,
        )  # fmt: skip


def spring_from_tester(
    table: ForceHeight, card: CatalogueCard, closes: Closes = "lower", installed_height: float | None = None
) -> TesterFit:
    """The spring behind a table of a spring tester: active turns and a pitch law, fitted by the chain and checked by the rod.

    Parameters
    ----------
    table : of :func:`read_force_height`
    card : dimensions of the wire and the coils (:func:`card_of_table` makes one); its loads are not used
    closes : end whose coils close first; the table cannot tell it, seat and retainer exchanged give the same forces
    installed_height : at which preload and rate are told, m; the largest height of the table by default

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
    >>> spring_from_tester(table, card_of_table(table, wire_diameter=4.2e-3, outer_diameter=30.2e-3))
    TesterFit
    """
    read_end(closes)
    height = float(table.heights[0]) if installed_height is None else installed_height
    if not table.heights[-1] < height <= table.heights[0] * (1 + 1e-9):
        raise InputError(
            f"the table holds heights of {table.heights[-1] * 1e3:.4g} to {table.heights[0] * 1e3:.4g} mm, not the installed "
            f"{height * 1e3:.4g} mm; give one inside", "installed_height",
        )  # fmt: skip
    start = first_winding(card)
    told = card.total_coils is not None or card.mass is not None or card.solid_height is not None
    active = start.total_coils - 2 * start.inactive
    count = int(np.clip(round(active / TURNS_A_STATION), 3, STATIONS))
    law = _Law(card, start.total_coils if told else None, start.ground, closes, count, max(2, round(active * MESH)))
    chosen = _thinned(_open(table))
    numbers, covariance, scatter = _fit(law, start, active, *chosen)
    numbers = _met_by_rod(law, numbers, *chosen)
    return _result(table, law, numbers, covariance, scatter, height)


def read_end(word: str) -> Closes:
    """The end named by ``word``. Raises :class:`InputError` for another word."""
    for known in ENDS:
        if word == known:
            return known
    raise InputError(f"closes is lower, upper or both, not '{str(word)[:40]}'; say which end of the spring closes first", "closes")


def card_of_table(table: ForceHeight, **known: object) -> CatalogueCard:
    """A card with what is ``known`` of the spring (fields of :class:`CatalogueCard`) and two loads of the low part of the table."""
    forces = table.forces[0] + np.array([0.05, 0.35]) * (table.forces[-1] - table.forces[0])
    low = (table.forces >= forces[0]) & (table.forces <= forces[1])
    if np.count_nonzero(low) < 3:
        low = np.arange(len(table.forces)) < 3
    slope, offset = np.polyfit(table.heights[low], table.forces[low], 1)
    if not slope < 0:
        raise InputError("the force does not rise as the height falls at the beginning of the table; check it")
    loads = [SpringLoad(float(height), float(slope * height + offset)) for height in table.heights[low][[0, -1]]]
    return CatalogueCard(installed_load=loads[0], open_load=loads[1], **known)  # type: ignore[arg-type]


def _slopes(table: ForceHeight) -> tuple[Array, float]:
    """Slopes (N/m) between the stations, and the first of them."""
    slopes: Array = -np.diff(table.forces) / np.diff(table.heights)
    return slopes, float(np.median(slopes[: max(len(slopes) // 4, 2)]))


def _open(table: ForceHeight) -> ForceHeight:
    """The table without its stations in coil bind, whose force tells the tester rather than the spring."""
    slopes, first = _slopes(table)
    bound = np.flatnonzero(slopes > BOUND * first)
    last = int(bound[0]) if len(bound) and bound[0] >= FEWEST else len(slopes)
    return ForceHeight(table.heights[: last + 1], table.forces[: last + 1])


def _thinned(table: ForceHeight) -> tuple[Array, Array]:
    """Means of heights and forces over even pieces of the travel."""
    if len(table.heights) <= HEIGHTS:
        return table.heights, table.forces
    edges = np.linspace(table.heights[0], table.heights[-1], HEIGHTS + 1)
    piece = np.clip(np.searchsorted(-edges, -table.heights, side="right") - 1, 0, HEIGHTS - 1)
    held = np.bincount(piece, minlength=HEIGHTS)
    sums = [np.bincount(piece, values, HEIGHTS) for values in (table.heights, table.forces)]
    return sums[0][held > 0] / held[held > 0], sums[1][held > 0] / held[held > 0]


def _chain(law: _Law, numbers: Array, heights: Array) -> tuple[Array, Array]:
    """Forces (N) and rates (N/m) by the chain at heights (m)."""
    definition = law.definition(numbers)
    layout = chain_from_definition(definition, law.elements, CONTACT_STIFFNESS)  # a mesh that changed with the turns would leave steps
    return static_curve(layout, np.maximum(definition.free_length - heights, 0.0))


def _fit(law: _Law, start: Winding, active: float, heights: Array, forces: Array) -> tuple[Array, Array, float]:
    """Numbers of ``law``, their covariance and the scatter (N): least squares, weighed anew once the scatter is known."""
    wire, top = law.card.wire_diameter, float(np.max(forces))
    even = max((start.free_length - wire * (start.total_coils + 1 - 2 * start.ground)) / max(active - RAMP, 0.5), 0.05 * wire)
    numbers = np.append(active, np.where(np.arange(law.steps) == 0, even, 0.02 * wire))
    total = start.total_coils
    most = 40.0 if law.total is None else total - 2 * POSSIBLE_INACTIVE[0]
    least = 1.0 if law.total is None else max(total - 2 * POSSIBLE_INACTIVE[1], 0.6)
    low, high = np.append(least, np.full(law.steps, 1e-6 * wire)), np.append(most, np.full(law.steps, 20 * wire))
    numbers = np.clip(numbers, low * 1.001, high * 0.999)
    scatter, steep = FIRST_SCATTER * top, HEIGHT_SCATTER * np.gradient(-forces, heights)

    def misses(values: Array) -> Array:
        found, _ = _chain(law, values, heights)
        return np.concatenate([(found - forces) / np.hypot(scatter, steep), values[2:] / (BEND * wire)])

    for _ in range(2):
        found = least_squares(
            misses, numbers, bounds=(low, high), x_scale=np.append(1.0, np.full(law.steps, 0.2 * wire)), diff_step=1e-4, max_nfev=25
        )
        numbers = found.x
        spare = max(len(heights) - len(numbers), 1)
        left = found.fun[: len(heights)] * np.hypot(scatter, steep)
        scatter = max(float(np.sqrt(left @ left / spare)), LEAST_SCATTER * top)
    covariance = np.linalg.pinv(found.jac.T @ found.jac)
    return numbers, covariance, scatter


def _met_by_rod(law: _Law, numbers: Array, heights: Array, forces: Array) -> Array:
    """``numbers`` with the active turns and the gaps changed until the rod, not the chain, has the first slope and force of the table."""
    share = forces[0] + np.array([0.1, 0.5]) * (forces[-1] - forces[0])
    at = np.interp(share, forces, heights)
    for _ in range(3):
        definition = law.definition(numbers)
        low, high = forces_at(definition, at)
        slope, wanted = (high - low) / (at[0] - at[1]), (share[1] - share[0]) / (at[0] - at[1])
        longer = (share[0] - low) / wanted
        if abs(slope / wanted - 1) < 3e-4 and abs(longer) < 1e-6:
            break
        changed = np.append(numbers[0] * slope / wanted, numbers[1:])
        by_turns = law.definition(changed).free_length - definition.free_length
        rise = np.sum(law.gaps(changed[1:]))
        changed[1:] *= max(1 + (longer - by_turns) / (rise * (law.places(changed[0])[1] - law.places(changed[0])[0])), 0.1)
        numbers = changed
    return numbers


def _result(table: ForceHeight, law: _Law, numbers: Array, covariance: Array, scatter: float, height: float) -> TesterFit:
    definition = law.definition(numbers)
    fine = np.linspace(table.heights[0], table.heights[-1], 121)
    force, rate = _chain(law, numbers, fine)
    step = 1e-4 * numbers
    here = _told(law, numbers, height)
    moved = []
    for place in range(len(numbers)):
        other = _told(law, numbers + np.where(np.arange(len(numbers)) == place, step, 0.0), height)
        moved.append((other - here) / step[place])
    spread = np.sqrt(np.maximum(np.einsum("ia,ij,ja->a", np.array(moved), covariance, np.array(moved)), 0.0))
    weights = np.array([law.gaps(row) for row in np.eye(law.steps)])
    stations = PitchStations(
        law.places(numbers[0]), law.card.wire_diameter + law.gaps(numbers[1:]),
        np.sqrt(np.maximum(np.einsum("ia,ij,ja->a", weights, covariance[1:, 1:], weights), 0.0)),
    )  # fmt: skip
    lowest = max(float(_open(table).heights[-1]), definition.solid_height + 0.02 * definition.solid_compression)
    asked = np.linspace(table.heights[0], lowest, 9)
    measured = np.interp(-asked, -table.heights, table.forces)
    by_rod = np.column_stack([asked, measured, forces_at(definition, asked.tolist())])
    preload = float(np.interp(-height, -by_rod[:, 0], by_rod[:, 2]))
    bind = _bind(table)
    spring = InstalledSpring(wire=definition, precompression=max(definition.free_length - height, 0.0))
    return TesterFit(
        table, spring, (float(numbers[0]), float(np.sqrt(covariance[0, 0]))), (definition.free_length, float(spread[0])),
        (float(here[2]), float(spread[2])), (preload, float(spread[1])), bind, stations, scatter, by_rod,
        np.column_stack([fine, force, rate]), _left_free(law, bind),
    )  # fmt: skip


def _told(law: _Law, numbers: Array, height: float) -> Array:
    """Free length (m), force (N) and rate (N/m) at a height (m)."""
    return np.array([law.definition(numbers).free_length, *np.ravel(_chain(law, numbers, np.array([height])))])


def _bind(table: ForceHeight) -> float | None:
    """Height (m) at which the table stiffens as bound coils do: where the line of its last stations meets the force before them."""
    slopes, first = _slopes(table)
    steep = slopes > BOUND * first
    if not steep[-1]:
        return None
    begin = len(steep) - int(np.argmin(steep[::-1])) if not steep.all() else 0
    return float(table.heights[begin])


def _left_free(law: _Law, bind: float | None) -> tuple[str, ...]:
    free = [
        f"the order of the coils is not in a table of forces: the tight ones are taken to lie at "
        f"{'both ends' if law.closes == 'both' else 'the ' + law.closes + ' end'}"
    ]
    if law.card.material is None:
        free.append(
            f"no material is told: G = {law.card.wire.shear_modulus / 1e9:g} GPa of {law.card.wire.name}; 1 % of it is 1 % of the active turns"
        )
    if law.total is None:
        free.append("no turns, mass or solid height are told: one inactive turn at either end is assumed, so mass and bind are open")
    if bind is None:
        free.append("the table does not reach coil bind, so gaps that never close in it follow from the free length alone")
    return tuple(free)
