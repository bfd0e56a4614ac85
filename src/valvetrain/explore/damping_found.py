"""What an identified damping of a spring is of critical damping at the spring's first surge mode."""

from __future__ import annotations

from collections.abc import Mapping

from valvetrain.explore.case_paths import vary
from valvetrain.explore.identification_file import Request
from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.summary import share_text
from valvetrain.runs.prepared import FAILURES, surge_frequency
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.finite_element_statics import spring_modes
from valvetrain.springs.spec import spring_model

#: Ends of the keys of a damping whose size alone says little.
COEFFICIENTS = ("damping.stiffness_damping", "damping.mass_damping")
#: Modes of a wire among which its first surge is.
MODES = 12


def damping_meanings(request: Request, best: Mapping[str, float]) -> dict[str, str]:
    """Quantity -> ``1.5 % of critical at 401 Hz``, of each damping coefficient among the ``best`` values
    (SI), with all of them in the case; empty where the case or its surge is unknown.
    """
    names = [
        unknown.name
        for unknown, varied in zip(request.unknowns, request.varied, strict=True)
        if any(one.key.endswith(COEFFICIENTS) for one in varied)
    ]
    if not names or request.evaluator:
        return {}
    values = {
        one: best[unknown.name]
        for unknown, varied in zip(request.unknowns, request.varied, strict=True)
        for one in varied
    }
    try:
        spring = _spring_of(vary(request.case, values))
        frequency = _first_surge(spring)
    except FAILURES:  # what a number means must not cost the number
        return {}
    if not frequency:
        return {}
    text = f"{share_text(spring.damping.ratio_at(frequency))} of critical at {frequency:.0f} Hz"
    return dict.fromkeys(names, text)


def _spring_of(case: Case) -> InstalledSpring:
    """The spring of a case, of a pair the outer one."""
    return (case.springs or (case.train.spring_parts() if case.train is not None else ()))[0]


def _first_surge(spring: InstalledSpring) -> float | None:
    """First surge frequency (Hz) as installed, of a wire by its finite elements."""
    if spring.wire is not None:
        built = spring_model("finite-element").build(spring, None)
        assert isinstance(built, FiniteElementRod)
        found = spring_modes(built, MODES).surge_frequencies
        if len(found):
            return float(found[0])
    return surge_frequency(spring)
