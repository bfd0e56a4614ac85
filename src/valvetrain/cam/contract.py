"""What a lift law answers, how laws are evaluated on the circle, and a law from what a case says of it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from valvetrain import registry
from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.parameters.lift_law import LiftLawParameters, LiftModel

TURN = 2 * math.pi
#: Highest derivative of a lift law: the jerk.
HIGHEST_DERIVATIVE = 3


@runtime_checkable
class LiftLaw(Protocol):
    """Lift over the cam angle (rad), periodic in one cam revolution.

    ``continuity``: the number of continuous derivatives (2: the acceleration is continuous).
    ``joints``: cam angles (rad) at which the law changes its formula; a higher derivative may jump
    there and takes the value of the piece above.

    >>> import valvetrain as vt
    >>> law = vt.cam.build_lift_law(vt.load_case("job-t").lift_law)
    >>> isinstance(law, LiftLaw), law.continuity
    (True, 3)
    """

    @property
    def continuity(self) -> int: ...

    @property
    def joints(self) -> tuple[float, ...]: ...

    def lift(self, cam_angle: ArrayLike, derivative: int = 0) -> Array:
        """Lift (m) or its ``derivative``-th derivative, 0 to 3 (m per rad**derivative); the shape
        of ``cam_angle``.
        """
        ...


@dataclass(frozen=True, slots=True)
class LiftSpec:
    """What the registry holds of a lift law: ``make`` takes SI keyword arguments, ``table`` is the
    [lift_law] table that gives them.
    """

    make: Callable[..., LiftLaw]
    table: type[LiftModel]


def after(start: float, cam_angle: ArrayLike) -> Array:
    """Angle (rad) since ``start``, in [0, 2 pi)."""
    since = np.mod(np.asarray(cam_angle, dtype=float) - start, TURN)
    return np.where(since >= TURN, 0.0, since)


def check_derivative(derivative: int) -> None:
    """Raise :class:`InputError` unless ``derivative`` is 0, 1, 2 or 3."""
    if derivative not in range(HIGHEST_DERIVATIVE + 1):
        raise InputError(
            f"a lift law has derivatives 0 (lift) to {HIGHEST_DERIVATIVE} (jerk), not {derivative}; choose one of them"
        )


def build_lift_law(parameters: LiftLawParameters | None) -> LiftLaw:
    """The lift law of what a case says of it.

    Parameters
    ----------
    parameters : ``case.lift_law``: kind of the law and its numbers (SI: m, cam rad); None for no
        lift

    Returns
    -------
    LiftLaw whose ``lift(cam_angle, derivative=0)`` takes cam angles (rad) of any shape and gives
    m/rad**derivative of that shape

    Raises
    ------
    InputError : an unknown kind, numbers that make no law

    Examples
    --------
    >>> import numpy as np
    >>> import valvetrain as vt
    >>> law = vt.cam.build_lift_law(vt.load_case("job-t").lift_law)
    >>> round(1e3 * float(law.lift(np.linspace(0, 2 * np.pi, 721)).max()), 2)
    10.0
    """
    kind, values = ("zero", {}) if parameters is None else (parameters.kind, parameters.values)
    spec: LiftSpec = registry.find("lifts", kind)
    try:
        return spec.make(**values)
    except TypeError as error:
        raise InputError(
            f"the values of a {kind} law do not fit it ({error}); see valvetrain.cam"
        ) from error
