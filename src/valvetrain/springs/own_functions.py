"""What a spring given in Python does: its functions in one form, checked, compiled where numba takes
them, and what follows from them (rest, eigenvalues, energy).
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from numbers import Number
from typing import Any

import numpy as np

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.parameters.own_parts import argument_count, for_numba

#: Compressions (m) at which a spring is tried before it runs.
TRIED = (0.0, 1e-3, 5e-3)
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)
Function = Callable[..., Any]
#: Entries live as long as the process: loops hold nothing but their addresses.
_ENTRIES: list[Any] = []
#: What a function takes, by whether the spring has states.
_FORMS = (
    "the compression (m), or of it and the velocity (m/s)",
    "state, compression (m) and velocity (m/s)",
)


@dataclass(frozen=True, eq=False)
class Behaviour:
    """``forces(state, compression, velocity)`` on retainer and seat (N) and ``rates`` of the state,
    which begins at ``guess`` and has ``count`` numbers; ``mass`` (kg) moves with the retainer.
    ``given``: force and derivatives as they were given, how many arguments force takes and whether
    it gives both forces.
    """

    forces: Function
    rates: Function
    guess: Array
    mass: float
    given: tuple[Any, Any, int, bool] = field(repr=False)

    @property
    def count(self) -> int:
        """Numbers of the state."""
        return len(self.guess)

    @cached_property
    def entry(self) -> Any:
        """The functions as compiled loops call them."""
        from valvetrain.springs.own_kernels import compiled_entry, plain_entry

        force, rates, arguments, both = self.given
        try:
            import numba

            ends = _ends(for_numba(force), arguments, both, numba.njit)
            made = compiled_entry(ends, for_numba(rates or _no_rates))
        except Exception:  # whatever numba does not know: Python runs it
            made = plain_entry(self.forces, self.rates)
        _ENTRIES.append(made)
        return made

    @property
    def address(self) -> int:
        """Address of the entry in this process."""
        from valvetrain.springs.own_kernels import address_of

        return address_of(self.entry)

    def rest(self, compression: float) -> Array:
        """The state in which nothing changes at a ``compression`` (m)."""
        if not self.count:
            return self.guess
        from scipy.optimize import root

        found = root(lambda own: np.asarray(self.rates(own, compression, 0.0), float), self.guess)
        left = float(np.max(np.abs(self.rates(found.x, compression, 0.0))))
        start = float(np.max(np.abs(self.rates(self.guess, compression, 0.0))))
        if not (found.success or left <= 1e-9 * start):
            raise InputError(
                f"derivatives has no state of rest at a compression of {1e3 * compression:.3g} mm; correct it or initial_state"
            )
        rest: Array = np.asarray(found.x, dtype=float)
        return rest

    def eigenvalues(self, compression: float) -> Array:
        """Eigenvalues (1/s) of the derivatives by the state, at rest."""
        if not self.count:
            return np.zeros(0, dtype=complex)
        rest = self.rest(compression)
        columns = []
        for i in range(self.count):
            step = 1e-6 * max(abs(rest[i]), 1e-6)
            way = step * np.eye(self.count)[i]
            ends = (
                np.asarray(self.rates(rest + s * way, compression, 0.0), float) for s in (1, -1)
            )
            columns.append(np.subtract(*ends) / (2 * step))
        found: Array = np.linalg.eigvals(np.array(columns).T).astype(complex)
        return found

    def energy(self, compression: float) -> float:
        """Work (J) of a force that the compression alone decides; of any other not a number."""
        if self.given[2] > 1:
            return math.nan
        places = compression * 0.5 * (1 + _NODES)
        work = [self.forces(self.guess, float(x), 0.0)[0] for x in places]
        return float(0.5 * compression * np.dot(_WEIGHTS, work))


def takes_spring(part: Any) -> bool:
    """Whether a class is made from the installed spring, by its only argument without a default."""
    if not isinstance(part, type):
        return False
    try:
        needed = [
            one
            for one in inspect.signature(part).parameters.values()
            if one.default is one.empty
            and one.kind in (one.POSITIONAL_ONLY, one.POSITIONAL_OR_KEYWORD)
        ]
    except ValueError:
        return False
    if len(needed) > 1:
        raise InputError(
            f"class {part.__name__} needs {len(needed)} arguments; give an instance, or a class that takes the installed spring alone",
            "models",
        )
    return len(needed) == 1


def behaviour_of(part: Any, where: str = "models") -> Behaviour:
    """What a function, class or instance does as a spring. Raises :class:`InputError` where it is
    none: its arguments, or what it gives at some compressions.
    """
    try:
        item = part() if isinstance(part, type) else part
    except Exception as error:
        raise InputError(f"class {part.__name__} cannot be made ({error})", where) from error
    name = getattr(part, "__name__", type(part).__name__)
    force, rates = getattr(item, "force", item), getattr(item, "derivatives", None)
    if not callable(force):
        raise InputError(f"force of {name} is no function; write force(compression)", where)
    guess, mass = _guess(item, rates, name, where), getattr(item, "mass", 0.0)
    if isinstance(mass, bool) or not isinstance(mass, Number) or not 0 <= float(mass) < math.inf:  # type: ignore[arg-type]
        raise InputError(f"mass of {name} is {mass!r}; give zero or a positive number (kg)", where)
    count = argument_count(
        force, (3,) if rates else (1, 2), f"force of {name}", _FORMS[rates is not None]
    )
    if rates is not None:
        argument_count(rates, (3,), f"derivatives of {name}", _FORMS[True])
    both = np.ndim(_tried(force, (guess, 0.0, 0.0), count, f"force of {name}", where)) == 1
    made = Behaviour(
        _ends(force, count, both, lambda function: function),
        rates or _no_rates,
        guess,
        float(mass),  # type: ignore[arg-type]
        (force, rates, count, both),
    )
    for compression in TRIED:
        at, place = (guess, compression, 0.0), f" at a compression of {1e3 * compression:g} mm"
        found = _tried(force, at, count, f"force of {name}", where)
        _check(found, (2,) if both else (), f"force of {name}", place, where)
        if rates is not None:
            found = _tried(rates, at, 3, f"derivatives of {name}", where)
            _check(found, (len(guess),), f"derivatives of {name}", place, where)
    return made


def _guess(item: Any, rates: Any, name: str, where: str) -> Array:
    if rates is None:
        return np.zeros(0)
    given = getattr(item, "initial_state", None)
    try:
        guess = np.array(given, dtype=float)
    except (TypeError, ValueError):
        guess = np.zeros(0)
    if guess.ndim != 1 or not len(guess) or not np.all(np.isfinite(guess)):
        raise InputError(
            f"{name} has derivatives and so states; give initial_state, a list of one number per state at rest or near it",
            where,
        )
    return guess


def _tried(function: Any, arguments: tuple[Any, ...], count: int, name: str, where: str) -> Any:
    try:
        return function(*(arguments if count == 3 else arguments[1 : 1 + count]))
    except Exception as error:
        raise InputError(
            f"{name} fails ({type(error).__name__}: {error}); correct it", where
        ) from error


def _check(given: Any, shape: tuple[int, ...], name: str, place: str, where: str) -> None:
    try:
        values = np.asarray(given, dtype=float)
    except (TypeError, ValueError):
        raise InputError(
            f"{name} gives {given!r:.40}{place}, which is no number (N)", where
        ) from None
    if values.shape != shape:
        due = f"{shape[0]} numbers" if shape else "a number, or the forces on retainer and seat"
        raise InputError(
            f"{name} gives an array of shape {values.shape}{place}; it should give {due}", where
        )
    if not np.all(np.isfinite(values)):
        raise InputError(f"{name} gives {given}{place}; it should be finite", where)


def _no_rates(state, compression, velocity):  # type: ignore[no-untyped-def]
    return state


def _ends(force: Any, arguments: int, both: bool, wrap: Function) -> Any:
    """``force`` as a function of state, compression and velocity that gives both end forces."""
    if arguments == 1:
        whole = wrap(lambda state, compression, velocity: force(compression))
    elif arguments == 2:
        whole = wrap(lambda state, compression, velocity: force(compression, velocity))
    else:
        whole = force

    def twice(state, compression, velocity):  # type: ignore[no-untyped-def]
        found = whole(state, compression, velocity)
        return found, found

    def pair(state, compression, velocity):  # type: ignore[no-untyped-def]
        found = whole(state, compression, velocity)
        return found[0], found[1]

    return wrap(pair if both else twice)
