"""From what a case says to a law that can be evaluated."""

from __future__ import annotations

from valvetrain import registry
from valvetrain.cam.contract import LiftLaw, LiftSpec
from valvetrain.errors import InputError
from valvetrain.parameters.lift_law import LiftLawParameters


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
