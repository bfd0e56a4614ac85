"""From what a case says to a law that can be evaluated."""

from __future__ import annotations

from valvetrain import registry
from valvetrain.cam.contract import LiftLaw, LiftSpec
from valvetrain.errors import InputError
from valvetrain.parameters.lift_law import LiftLawParameters


def build_lift_law(parameters: LiftLawParameters | None) -> LiftLaw:
    """The law of ``parameters`` (no lift for None). Raises :class:`InputError` for an unknown kind or numbers that make no law."""
    kind, values = ("zero", {}) if parameters is None else (parameters.kind, parameters.values)
    spec: LiftSpec = registry.find("lifts", kind)
    try:
        return spec.make(**values)
    except TypeError as error:
        raise InputError(f"the values of a {kind} law do not fit it ({error}); see valvetrain.cam") from error
