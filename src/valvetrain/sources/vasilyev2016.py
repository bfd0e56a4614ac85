"""Vasilyev, Bakhracheva and Storojakov (2016): a valve gear with nested springs as single masses,
chains of six masses and rods.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from valvetrain.solution.comparison import Finding
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study
from valvetrain.sources.contract import SourceStudy

#: Lash of the source's two sets of curves.
LASHES = ("0 mm", "0.1 mm")
#: Force of the lever on the valve, which the findings compare.
FORCE = "valve_tip_contact_force"
#: A model is markedly further off than another by this factor.
MARKED = 2.0
#: Viscous friction of the source (1/s), the middle of its 20 to 30.
FRICTION = 25.0

Runs = Mapping[str, Solution]


def findings(study: Study) -> tuple[Finding, ...]:
    """The findings that can be compared with these runs."""
    runs = {label: study.runs(label)[0] for label in study.labels}
    runs = {
        label: run
        for label, run in runs.items()
        if run.quantities and run.has(FORCE, "rigid_valve_lift")
    }
    found = [build(runs, lash) for lash in LASHES for build in (_second_half, _split, _sections)]
    return tuple(one for one in found if one is not None)


def _pair(runs: Runs, lash: str) -> tuple[Solution, Solution] | None:
    masses, rod = runs.get(f"six masses, lash {lash}"), runs.get(f"rod, lash {lash}")
    return None if masses is None or rod is None else (masses, rod)


def _second_half(runs: Runs, lash: str) -> Finding | None:
    pair = _pair(runs, lash)
    if pair is None:
        return None
    lift = pair[0].channel("rigid_valve_lift")
    late = np.arange(len(lift)) > int(np.argmax(lift))
    first, second = _rms(*pair, (lift > 0) & ~late), _rms(*pair, (lift > 0) & late)
    computed = (
        f"root mean square difference of the lever's force on the valve {first:.1f} N while opening, {second:.1f} N while closing "
        f"(lash {lash})"
    )
    verdict = (
        "agrees"
        if second > first
        else "not seen with these assumed parts: the two models differ more while opening"
    )
    return Finding(
        "section 4",
        "six masses and rods differ most in the second half, towards the seat",
        computed,
        verdict,
    )


def _split(runs: Runs, lash: str) -> Finding | None:
    pair, single = _pair(runs, lash), runs.get(f"single mass, lash {lash}")
    if pair is None or single is None:
        return None
    masses, rod = pair
    far = _rms(single, rod, single.channel("rigid_valve_lift") > 0)
    near = _rms(masses, rod, masses.channel("rigid_valve_lift") > 0)
    computed = f"against the rods: single mass {far:.1f} N, six masses {near:.1f} N root mean square over the open valve (lash {lash})"
    if far > MARKED * near:
        verdict = "agrees"
    else:
        verdict = (
            "weaker here" if far > near else "not seen: the single mass is as near to the rods"
        )
    return Finding(
        "section 4",
        "how a spring is split into masses changes the result markedly",
        computed,
        verdict,
    )


def _sections(runs: Runs, lash: str) -> Finding | None:
    pair, finite = _pair(runs, lash), runs.get(f"finite elements, lash {lash}")
    if pair is None or finite is None:
        return None
    peaks = [
        1e3 * run.quantities.get("outer_mean_peak_section_displacement", math.nan)
        for run in (*pair, finite)
    ]
    if not np.all(np.isfinite(peaks)):
        return None
    computed = f"{peaks[0]:.2f} mm (six masses), {peaks[1]:.2f} mm (rod), {peaks[2]:.2f} mm (finite elements) at lash {lash}"
    return Finding(
        "figure 3",
        "mean peak displacement of the outer spring's sections",
        computed,
        "no printed value to compare with",
    )


def _rms(one: Solution, other: Solution, window: NDArray[np.bool_]) -> float:
    """Root mean square difference (N) of the force on the valve over samples of ``one``."""
    mine, theirs = one.channel(FORCE), other.channel(FORCE)
    if len(theirs) != len(mine):
        theirs = np.interp(one.cam_angle, other.cam_angle, theirs, period=2 * np.pi)
    return float(np.sqrt(np.mean((mine - theirs)[window] ** 2)))


def notes(study: Study) -> tuple[str, ...]:
    """What cannot be compared, and the friction of the source as damping of the springs of these
    runs.
    """
    found = []
    if not study.record.published:
        found.append(
            "The source prints no mass, spring datum, lift or curve value: its figures 3 and 4 cannot be compared number by number. "
            "Springs follow a service manual as recalled, masses and geometry are assumed (see the case file)."
        )
    surges = (run.quantities.get("surge_frequency") for run in study.solutions)
    surge = next((value for value in surges if value is not None), None)
    if surge is not None:
        found.append(
            f"The source's term 2 mu / omega dU/dphi is a mass-proportional damping of {2 * FRICTION:.0f} 1/s at mu = {FRICTION:.0f} 1/s: "
            f"surge at {surge:.0f} Hz has the damping ratio mu / (2 pi f) = {FRICTION / (2 * math.pi * surge):.2%}."
        )
    return tuple(found)


SPEC = SourceStudy("vasilyev2016", findings=findings, notes=notes)
