"""From what a case says to a law that can be evaluated. A new law is one file and one line here."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from valvetrain.cam.contract import LiftLaw
from valvetrain.cam.cycloidal import Cycloidal
from valvetrain.cam.harmonic import Harmonic
from valvetrain.cam.modified_sine import ModifiedSine
from valvetrain.cam.polydyne import Polydyne
from valvetrain.cam.polynomial import Polynomial
from valvetrain.cam.ramped import ramped
from valvetrain.cam.shaped import Shaped
from valvetrain.cam.sine_power import SinePower
from valvetrain.cam.spline import Spline
from valvetrain.cam.stations import Stations
from valvetrain.cam.zero import Zero
from valvetrain.errors import InputError
from valvetrain.parameters.lift_law import LiftLawParameters

LAWS: dict[str, Callable[..., LiftLaw]] = {
    "zero": Zero,
    "spline": Spline,
    "stations": Stations,
    "polynomial": Polynomial,
    "polydyne": Polydyne,
    "cycloidal": Cycloidal,
    "modified-sine": ModifiedSine,
    "harmonic": Harmonic,
    "sine-power": SinePower,
    "ramped": ramped,
    "shaped": Shaped,
}


def build_lift_law(parameters: LiftLawParameters | None) -> LiftLaw:
    """The law of ``parameters`` (no lift for None). Raises :class:`InputError` for an unknown kind or numbers that make no law."""
    if parameters is None:
        return Zero()
    maker: Any = LAWS.get(parameters.kind)
    if maker is None:
        raise InputError(f"kind '{parameters.kind}' of a lift law is unknown; use one of {', '.join(LAWS)}")
    try:
        law: LiftLaw = maker(**parameters.values)
    except TypeError as error:
        raise InputError(f"the values of a {parameters.kind} law do not fit it ({error}); see valvetrain.cam") from error
    return law
