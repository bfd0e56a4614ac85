"""What every contact law answers, and the checks they share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.parameters.schema_contact import ContactTable

SLOWEST_IMPACT = 1e-3


@runtime_checkable
class ContactLaw(Protocol):
    """Penetration (m, positive when overlapping) and its rate (m/s, positive when closing) ->
    force. Vectorised.

    ``code`` and ``parameters()`` (shape (8,), see ``contact.kernels``) let the compiled
    ``contact_force`` evaluate the law.
    ``states``: how many numbers it remembers from step to step, zero at rest. ``impact_rate`` (m/s)
    is the approach velocity, needed by
    the restitution laws and ignored by all others.

    >>> import valvetrain as vt
    >>> law = vt.contact.build_contact_law("linear", contact_stiffness="60 kN/mm")
    >>> isinstance(law, ContactLaw), law.states
    (True, 0)
    """

    @property
    def name(self) -> str: ...

    @property
    def code(self) -> int: ...

    @property
    def states(self) -> int: ...

    def parameters(self) -> Array: ...

    def force(
        self,
        penetration: ArrayLike,
        penetration_rate: ArrayLike,
        impact_rate: float = SLOWEST_IMPACT,
    ) -> Array:
        """Normal force (N), zero without overlap, never adhesive."""
        ...

    def tangent(
        self,
        penetration: ArrayLike,
        penetration_rate: ArrayLike,
        impact_rate: float = SLOWEST_IMPACT,
    ) -> Array:
        """Derivative (N/m) of the force by the penetration."""
        ...

    def dissipated_power(
        self,
        penetration: ArrayLike,
        penetration_rate: ArrayLike,
        impact_rate: float = SLOWEST_IMPACT,
    ) -> Array:
        """Power (W) lost: (force - elastic force) * rate."""
        ...

    def stiffness(self, penetration: float) -> float:
        """Elastic stiffness (N/m) at a penetration, for the estimate of the stable step."""
        ...


LawKernel = Callable[[Array, Array, float, float, float, float], tuple[float, float]]
"""``kernel(parameters, memory, penetration, previous_penetration, penetration_rate, time_step) ->
(force, damping)``.
"""


@runtime_checkable
class OwnLaw(ContactLaw, Protocol):
    """A contact law with a compiled ``kernel`` of its own; its ``code`` is ``kernels.OWN_LAW``.

    The kernel (``numba.njit``) gets the row of ``parameters()``, its ``states`` numbers of memory,
    the penetration (m) now and one step
    before, the rate (m/s) and the step (s); it brings its memory to now in place and returns the
    force (N, never negative) that needs no
    rate and the damping coefficient (N s/m, not negative) of what does. It is called at every step,
    open gaps included; with
    ``time_step`` zero the memory must stay as it is.
    """

    @property
    def kernel(self) -> LawKernel: ...


def row(
    stiffness: float,
    exponent: float = 1.0,
    damping: float = 0.0,
    restitution: float = 1.0,
    depth: float = 1.0,
) -> Array:
    """Parameter row (8,) of ``contact.kernels``; the last two columns are free."""
    return np.array([stiffness, exponent, damping, restitution, depth, SLOWEST_IMPACT, 0.0, 0.0])


def overlap(penetration: ArrayLike) -> Array:
    """Penetration where positive, else zero."""
    found: Array = np.maximum(np.asarray(penetration, dtype=float), 0.0)
    return found


def require_positive(law: str, **values: float) -> None:
    """Raise :class:`InputError` unless every value is a positive finite number."""
    for key, value in values.items():
        if not (np.isfinite(value) and value > 0):
            raise InputError(f"{key} of contact law '{law}' is {value}; give a positive number")


def require_not_negative(law: str, **values: float) -> None:
    """Raise :class:`InputError` unless every value is zero or a positive finite number."""
    for key, value in values.items():
        if not (np.isfinite(value) and value >= 0):
            raise InputError(
                f"{key} of contact law '{law}' is {value}; give zero or a positive number"
            )


def require_restitution(law: str, restitution: float, lowest_open: bool = False) -> None:
    """Raise :class:`InputError` unless 0 <= restitution <= 1 (0 excluded where the law divides by
    it).
    """
    if not (np.isfinite(restitution) and 0 <= restitution <= 1) or (
        lowest_open and restitution == 0
    ):
        bounds = "above 0 and at most 1" if lowest_open else "between 0 and 1"
        raise InputError(
            f"restitution of contact law '{law}' is {restitution}; it must be {bounds}"
        )


def require_exponent(law: str, exponent: float) -> None:
    """Raise :class:`InputError` unless 1 <= exponent <= 3 (below 1 the stiffness at first touch is
    infinite).
    """
    if not (np.isfinite(exponent) and 1 <= exponent <= 3):
        raise InputError(
            f"exponent of contact law '{law}' is {exponent}; it must be between 1 and 3 (1.5 for a Hertz point contact)"
        )


@dataclass(frozen=True, slots=True)
class ContactSpec:
    """``law``: dataclass of the law, whose fields are its values. ``table``: its table in a case
    file.

    ``damping_unit``: whether its ``damping`` is c of c d' (N s/m) or q of 1 + q d' (s/m); empty for
    a law without one.
    """

    law: type[Any]
    table: type[ContactTable]
    damping_unit: Literal["N s/m", "s/m", ""] = ""
