"""A chain of masses corrected by the rod of the same wire: its force at mid travel and its first
surge frequency are those of finite elements.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, NamedTuple, NoReturn

import numpy as np

from valvetrain.cosserat.modes import natural_modes
from valvetrain.cosserat.state import RodState
from valvetrain.cosserat.static import compress
from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import DampingParameters, InstalledSpring
from valvetrain.springs.chain_statics import static_curve
from valvetrain.springs.finite_element import SPEC as ROD
from valvetrain.springs.finite_element import FiniteElementRod, equilibrium_at

#: Elements per coil of the rod: force within 0.3 %, first frequency within 0.4 % of 24.
ELEMENTS_PER_COIL = 12
#: Places over the travel to solid at which chain and rod are compared; the correction is made at the
#: second, where few coils have closed.
PLACES = (0.0, 0.3, 0.5)
MID = 1
#: Modes searched for the first two of surge, and turns beyond which a rod costs too much here.
MODES, MAX_COILS = 16, 100
#: Factors on stiffness and mass outside of which rod and chain are no longer the same spring.
CREDIBLE = 0.6, 1.7
#: What a rod without equilibrium raises: of the data, of its matrices, of the search for modes.
FAILURES = (InputError, ArithmeticError, ValueError, RuntimeError)


class RodReference(NamedTuple):
    """The rod of a spring at rest: ``forces`` (N) at the first two :data:`PLACES`, ``surge_frequencies``
    (Hz) at the second, one or two; ``rod`` and its ``state`` there.
    """

    forces: tuple[float, ...]
    surge_frequencies: tuple[float, ...]
    rod: FiniteElementRod
    state: RodState


@dataclass(frozen=True)
class ChainMatch:
    """A ``chain`` (:class:`~valvetrain.springs.multi_mass.MultiMassSpring`) next to its rod, whose
    first ``surge_frequency`` (Hz) it shares.
    """

    chain: Any
    surge_frequency: float
    spring: InstalledSpring

    def errors(self) -> tuple[float, float | None]:
        """Largest error of the force at rest over the rod's at :data:`PLACES`, and error of the
        second surge frequency (None where the rod shows none).
        """
        found = rod_reference(self.spring)
        lifts, second = _lifts(self.spring), None
        last = compress(found.rod.statics, [self.spring.precompression + lifts[-1]], found.state)[
            -1
        ]
        forces = np.array([*found.forces, float(last.retainer_force)])
        own = np.array([_force(self.chain, lift) for lift in lifts])
        if not last.converged:
            forces, own = forces[:-1], own[:-1]
        if len(found.surge_frequencies) > 1 and self.chain.unknowns > 1:
            frequency = self.chain.frequencies(lifts[MID], 2)[1]
            second = float(frequency / found.surge_frequencies[1] - 1)
        return float(np.max(np.abs(own - forces))) / float(np.max(forces)), second


def rod_reference(spring: InstalledSpring) -> RodReference:
    """The rod of a wire at rest, computed once per spring. Raises :class:`InputError` where it has
    no credible solution, with the reason.
    """
    found = _reference(replace(spring, options={}, damping=DampingParameters()))
    return found if isinstance(found, RodReference) else _refuse(spring, found)


def _refuse(spring: InstalledSpring, reason: str) -> NoReturn:
    raise InputError(
        f"the chain of spring '{spring.name}' takes its rate and first frequency from the rod of its wire, which cannot be had: {reason}; "
        "correct the spring, or take both by formula, some per cent high, with from_rod = false in its options.multi-mass"
    )


@lru_cache(maxsize=32)  # each holds a rod
def _reference(spring: InstalledSpring) -> RodReference | str:
    assert spring.wire is not None
    if spring.wire.total_coils > MAX_COILS:
        return f"with more than {MAX_COILS} coils it costs too much"
    try:
        options = ROD.read_options({"elements_per_coil": ELEMENTS_PER_COIL})
        rod = ROD.make(spring, options, None)
        assert isinstance(rod, FiniteElementRod)
        path = [equilibrium_at(rod, spring.precompression + y) for y in _lifts(spring)[: MID + 1]]
        modes = natural_modes(rod.statics, path[MID].state, MODES)
        surge = modes.natural_frequency[modes.axial_modes(2)]
    except FAILURES as error:
        return str(error) or type(error).__name__
    forces = tuple(float(point.retainer_force) for point in path)
    if not len(surge) or not forces[MID] > 0:
        return "it shows no surge" if len(surge) else "it does not press at mid travel"
    return RodReference(forces, tuple(map(float, surge)), rod, path[MID].state)


def _lifts(spring: InstalledSpring) -> list[float]:
    assert spring.room is not None
    return [share * spring.room for share in PLACES]


def match(chain: Any, spring: InstalledSpring) -> ChainMatch:
    """The ``chain`` of a wire with its stiffness scaled to the force of the rod at mid travel and
    its masses to the rod's first surge frequency there. Raises :class:`InputError` where that cannot
    be had.
    """
    found = rod_reference(spring)
    middle, scale = _lifts(spring)[MID], 1.0
    layout, stiff = chain.layout, chain
    for _ in range(4):  # coils that have closed carry a part that is not scaled
        scale *= found.forces[MID] / _force(stiff, middle)
        stiff = replace(chain, layout=replace(layout, stiffness=layout.stiffness * scale))
    heavier = (stiff.frequencies(middle, 1)[0] / found.surge_frequencies[0]) ** 2
    if not all(CREDIBLE[0] < factor < CREDIBLE[1] for factor in (scale, heavier)):
        _refuse(
            spring, f"its stiffness is {scale:.3g} and its mass {heavier:.3g} times the chain's"
        )
    corrected = replace(stiff, layout=replace(stiff.layout, masses=layout.masses * heavier))
    return ChainMatch(corrected, found.surge_frequencies[0], spring)


def _force(chain: Any, lift: float) -> float:
    at = np.array([chain.precompression + lift])
    return float(static_curve(chain.layout, at)[0][0])
