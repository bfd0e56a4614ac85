"""What an identified damping of a spring is of critical damping, at the frequency of its ratio or at the
spring's first surge mode.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from valvetrain.explore.identification_file import Request
from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.summary import share_text
from valvetrain.runs.prepared import FAILURES, surge_frequency
from valvetrain.solution.definition import NESTED
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.finite_element_statics import spring_modes
from valvetrain.springs.spec import spring_model

#: Ends of the keys of a damping whose size alone says little.
RATIO = "damping.ratio"
DAMPINGS = ("damping.stiffness_damping", "damping.mass_damping", RATIO)
#: Place of a spring in its set.
_PLACE = re.compile(r"springs?\.(?:[^.]+\.)?(\d+)\.")
#: Modes of a wire among which its first surge is.
MODES = 12


def damping_meanings(request: Request, case: Case) -> dict[str, str]:
    """Quantity -> ``1.5 % of critical at 401 Hz``, of each damping among those of a request, in the
    ``case`` with the likeliest values, of a pair with the spring; empty where its surge is unknown.
    """
    keys = {
        unknown.name: key
        for unknown, varied in zip(request.unknowns, request.varied, strict=True)
        if (key := next((one.key for one in varied if one.key.endswith(DAMPINGS)), ""))
    }
    try:
        found = {name: _meaning(case, key) for name, key in keys.items()}
    except FAILURES:  # what a number means must not cost the number
        return {}
    return {name: text for name, text in found.items() if text}


def _meaning(case: Case, key: str) -> str:
    """A share of critical, its frequency and, of a pair, the spring; empty for no known surge."""
    springs = _springs_of(case, key)
    place = int(found[1]) if (found := _PLACE.search(key)) else 0
    spring = springs[place]
    frequency = spring.damping.ratio_frequency if key.endswith(RATIO) else _first_surge(spring)
    if not frequency:
        return ""
    whose = f", {NESTED[place]} spring" if len(springs) > 1 else ""
    share = share_text(spring.damping.ratio_at(frequency))
    return f"{share} of critical at {frequency:.0f} Hz{whose}"


def _springs_of(case: Case, key: str) -> Sequence[InstalledSpring]:
    """The springs among which a key names one, outer first."""
    if case.train is None or not key.startswith("train."):
        return case.springs
    named = key.split(".")[2]
    return case.train.spring_parts(named if named in case.train.springs else None)


def _first_surge(spring: InstalledSpring) -> float | None:
    """First surge frequency (Hz) as installed, of a wire by its finite elements."""
    if spring.wire is not None:
        built = spring_model("finite-element").build(spring, None)
        assert isinstance(built, FiniteElementRod)
        found = spring_modes(built, MODES).surge_frequencies
        if len(found):
            return float(found[0])
    return surge_frequency(spring)
