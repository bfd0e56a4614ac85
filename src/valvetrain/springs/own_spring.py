"""A spring model given in Python: a function of the compression, or a class with ``force`` and, where
it has states of its own, ``derivatives``; the whole contract of ``springs.contract`` is made of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from typing import Any

import numpy as np

from valvetrain import registry
from valvetrain.arrays import Array, Ints
from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.own_parts import carrying, own_name
from valvetrain.parameters.spring_options import SpringOptions
from valvetrain.solution.static import SpringAtRest
from valvetrain.springs.contract import EndForces, SpringEnergy, SpringModel, SpringOutputs
from valvetrain.springs.own_functions import Behaviour, behaviour_of, takes_spring
from valvetrain.springs.spec import NoOptions, SpringModelSpec
from valvetrain.units.text import clipped

#: Step (s) times the fastest rate of the states; travel (m) of differences.
STEP_SHARE, TRAVEL = 0.5, 1e-6


def model_name(model: Any, where: str = "models") -> str:
    """The name of a spring model given by name, class or instance, or as a function of the
    compression. Raises :class:`InputError` for what is none of them.
    """
    if isinstance(model, str):
        return model
    built_in = getattr(model, "name", None)
    if (
        isinstance(model, type)
        and isinstance(built_in, str)
        and built_in in registry.names("springs")
    ):
        return built_in
    whole = isinstance(model, (SpringModelSpec, SpringModel)) and not isinstance(model, type)
    if not (whole or callable(model) or hasattr(model, "force")):
        raise InputError(
            f"{clipped(repr(model))} is no spring model; give a name, a function of the compression (m) that gives the force (N), or "
            "a class with force(compression)",
            where,
        )
    if not whole and not takes_spring(model):
        behaviour_of(model, where)  # what is wrong with it is found before it runs
    return own_name(model)


def model_names(given: Any) -> tuple[str, ...]:
    """Names of one spring model or several, each as :func:`model_name` takes it."""
    if isinstance(given, Sequence) and not isinstance(given, str):
        return tuple(model_name(one) for one in given)
    return () if given is None or (isinstance(given, str) and not given) else (model_name(given),)


def spec_of(word: str, part: Any) -> SpringModelSpec:
    """The entry of the registry for a model given in Python."""
    name = carrying(word)
    if isinstance(part, SpringModelSpec):
        return replace(part, word=name)
    return SpringModelSpec(
        name,
        registry.plain_name(word),
        "#8a5a9e",
        NoOptions,
        partial(_make, name),
        knows="what its Python says",
        leaves_out="what its Python leaves out",
        needs_mass=False,
        processor_time=0.2,
    )


def _make(
    name: str, spring: InstalledSpring, options: SpringOptions, rest: SpringAtRest | None
) -> SpringModel:
    part = registry.OWN[name]
    if takes_spring(part):
        part = part(spring)
    if isinstance(part, SpringModel) and not isinstance(part, type):
        return part
    behaviour_of(part)
    return OwnSpring(name, spring)


@cache
def _behaviour(name: str, spring: InstalledSpring) -> Behaviour:
    part = registry.OWN[name]
    return behaviour_of(part(spring) if takes_spring(part) else part)


@dataclass(frozen=True)
class OwnSpring:
    """The model given in Python under ``name``, for the installed ``spring``."""

    name: str
    spring: InstalledSpring
    unknowns = 0

    @property
    def behaviour(self) -> Behaviour:
        """What its Python does."""
        return _behaviour(self.name, self.spring)

    @property
    def kernel(self) -> Any:
        from valvetrain.springs.own_kernels import advance_own

        return advance_own

    def parameters(self) -> Array:
        return np.zeros(1)

    def integers(self) -> Ints:
        return np.array([self.behaviour.address, self.behaviour.count], dtype=np.int64)

    def with_time_step(self, time_step: float) -> OwnSpring:
        return self

    def initial_state(self, retainer_displacement: float) -> Array:
        from valvetrain.springs.own_kernels import state_size

        rest = self.behaviour.rest(float(retainer_displacement))
        state = np.zeros(state_size(len(rest)))
        state[: len(rest)] = rest
        return state

    @cached_property
    def _rates(self) -> Array:
        """Eigenvalues (1/s) of the states about rest as installed, the retainer fixed."""
        return self.behaviour.eigenvalues(0.0)

    @property
    def circular_frequencies(self) -> Array:
        """Frequencies (rad/s) at which the states oscillate, the retainer fixed."""
        found: Array = np.sort(self._rates.imag[self._rates.imag > 0])
        return found

    def stable_time_step(self) -> float:
        fastest = float(np.max(np.abs(self._rates), initial=0.0))
        return STEP_SHARE / fastest if fastest > 0 else float("inf")

    def energy(
        self,
        state: Array,
        retainer_displacement: float,
        retainer_velocity: float = 0.0,
        time_step: float = 0.0,
    ) -> SpringEnergy:
        """Work done from the installed position on, of a force that the compression alone decides; of
        any other not a number.
        """
        stored = self.behaviour.energy(float(retainer_displacement))
        return SpringEnergy(0.0 * stored, stored, 0.0 * stored, 0.0 * stored)

    def force(
        self, state: Array, retainer_displacement: float, retainer_velocity: float = 0.0
    ) -> EndForces:
        place, rate = float(retainer_displacement), float(retainer_velocity)
        copied = np.array(state, dtype=float)
        return EndForces(*self.kernel(self.parameters(), self.integers(), copied, place, rate, 0.0))

    def tangent(self, state: Array, retainer_displacement: float) -> float:
        upper = self.force(state, retainer_displacement + TRAVEL).retainer
        return (upper - self.force(state, retainer_displacement - TRAVEL).retainer) / (2 * TRAVEL)

    def outputs(
        self, state: Array, retainer_displacement: float, retainer_velocity: float = 0.0
    ) -> SpringOutputs:
        return SpringOutputs(*self.force(state, retainer_displacement, retainer_velocity))

    def retainer_mass(self) -> float:
        return self.behaviour.mass
