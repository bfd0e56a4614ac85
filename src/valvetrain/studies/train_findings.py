"""Published findings of the two train sources beside what was computed, contradictions said where they are."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from valvetrain.parameters.case import Case
from valvetrain.parameters.train import TrainParameters
from valvetrain.quantities.valvetrain_study import TrainRun
from valvetrain.solution.comparison import Finding
from valvetrain.solution.quantity import Quantity, named

Array = NDArray[np.float64]

PUSHROD_NOTES = (
    "The peak contact forces printed (283 and 400 N) fit springs without their seat load: rate x 8 mm x lever ratio 1.6 is 275 and 395 "
    "N; with the seat "
    "load of the same source's table 588 and 944 N are due. Both are computed: 'as printed' without, the others with the seat load.",
    "Equation 4 of the source lacks the penetration rate in its damping term and adds N s/mm to N; its check of 283 N is the elastic force "
    "at 0.02 mm and predicts nothing. The runs use F = k d^1.5 + c(d) d', the damping risen to its maximum at 0.02 mm.",
    "A damper of zeta = 1 (195.8 N s/m) on a valve that moves at 2 m/s adds some 390 N on the flanks, so a peak of 412 N can only be "
    "meant at the nose, where "
    "the valve stands still; there the damper changes next to nothing. On the closing flank the damped springs without seat load let "
    "the train go.",
    "384 deg/s of rocker rotation cannot be: 8 mm of lift in 90 cam degrees at 2000 rpm with an arm of 40 mm needs some 2900 deg/s.",
    "50 Hz is the lumped mass on the spring rate; the surge frequency of a spring of this rate and some 45 g lies near 400 Hz.",
)
VALVE_GEAR_NOTES = (
    "The source prints no mass, spring datum, lift or curve value: its figures 3 and 4 cannot be compared number by number. Springs "
    "follow a service manual "
    "as recalled, masses and geometry are assumed (see the case file).",
    "The source's term 2 mu / omega dU/dphi is a mass-proportional damping of 2 mu = 50 1/s at mu = 25 1/s; surge mode n then has the "
    "damping ratio mu / (2 pi f_n).",
)


def derived_quantities(case: Case, runs: Sequence[TrainRun]) -> dict[Quantity, float]:
    """Numbers that the case's published values ask for, by their published names (SI)."""
    by_label = {run.label: run for run in reversed(runs)}  # the first engine speed is the published one
    stock, performance = by_label.get("stock, as printed"), by_label.get("performance, as printed")
    if stock is None or performance is None:
        return {}
    values = {
        "stock_nose_cam_contact_force": _number(stock, "nose_cam_contact_force"),
        "performance_nose_cam_contact_force": _number(performance, "nose_cam_contact_force"),
        "contact_force_rise_ratio": _rise(_number(performance, "nose_cam_contact_force"), _number(stock, "nose_cam_contact_force")),
        "stock_peak_valve_lift": _number(stock, "peak_valve_lift"),
        "performance_lift_difference_displacement": _number(stock, "peak_valve_lift") - _number(performance, "peak_valve_lift"),
        "peak_lever_speed": _number(performance, "peak_lever_speed"),
        "peak_lever_speed_valve_lift": _number(performance, "peak_lever_speed_valve_lift"),
    }
    damped = by_label.get("performance, as printed, zeta 1")
    if damped is not None:
        values["performance_damped_nose_cam_contact_force"] = _number(damped, "nose_cam_contact_force")
    return named(values, stock.engine_speed, "") | named(_closed_forms(case.train), None, "")


def _rise(after: float, before: float) -> float:
    """Share by which a force rises; NaN where there was none (a train that floats carries nothing at the nose)."""
    return after / before - 1 if before > 0 else math.nan


def _number(run: TrainRun, name: str) -> float:
    return run.quantities.get(name, math.nan)


def _closed_forms(train: TrainParameters) -> dict[str, float]:
    """The source's own formulas, evaluated as printed: equations 5, 8 and 10."""
    values = train.contact("cam").values
    stiffness, damping = values["contact_stiffness"] / 1000**1.5, values["damping"] / 1000
    assert train.lever is not None and train.pushrod is not None
    mass = train.valve.mass + train.lever.mass + train.pushrod.mass
    rate = train.spring_parts("performance")[0].rate
    return {
        "contact_formula_force": (stiffness + damping) * 0.02**1.5, "lumped_natural_frequency": math.sqrt(rate / mass) / (2 * math.pi),
        "critical_damping_ratio": 2 * math.sqrt(rate * mass),
    }  # fmt: skip


def findings(case: Case, runs: Sequence[TrainRun]) -> tuple[tuple[str, ...], tuple[Finding, ...]]:
    """Notes that the report prints, and the findings in words that this set of runs can answer."""
    by_label = {run.label: run for run in reversed(runs) if run.quantities}
    if "vasilyev2016" in case.sources:
        return VALVE_GEAR_NOTES, tuple(_valve_gear_findings(by_label))
    if "multibody4b17" in case.sources:
        return PUSHROD_NOTES, tuple(_pushrod_findings(by_label))
    return (), ()


def _pushrod_findings(runs: dict[str, TrainRun]) -> list[Finding]:
    found = []
    # the source speaks of a nose that carries load, and so of no train that floats there
    runs = {label: run for label, run in runs.items() if _number(run, "nose_cam_contact_force") > 0}
    if {"stock", "performance"} <= set(runs):
        stock, performance = runs["stock"], runs["performance"]
        forces = [_number(run, "nose_cam_contact_force") for run in (stock, performance)]
        rise = _rise(forces[1], forces[0])
        words = f"with the seat load {forces[0]:.0f} N and {forces[1]:.0f} N, up {rise:.0%}"
        verdict = "the sign holds; with the seat load the rise is that of the whole spring force, not of the rate alone"
        found.append(Finding("section 7", "contact force up about 40 % with the stiffer spring, peak at the cam nose", words, verdict))
        loss = [1e3 * _number(run, "lift_loss_displacement") for run in (stock, performance)]
        words = f"lift lost to contact compliance {loss[0]:.3f} mm (stock) and {loss[1]:.3f} mm (performance)"
        verdict = "smaller than printed; the sign holds" if loss[1] - loss[0] < 0.15 else "agrees"
        found.append(Finding("section 5.2", "the performance spring gives about 0.2 mm less lift", words, verdict))
    zetas = [label for label in ("performance", "performance, zeta 0.5", "performance, zeta 1") if label in runs]
    if len(zetas) == 3:
        nose = [_number(runs[label], "nose_cam_contact_force") for label in zetas]
        peaks = [_number(runs[label], "peak_open_cam_contact_force") for label in zetas]
        words = (
            f"at the nose {nose[0]:.0f}, {nose[1]:.0f}, {nose[2]:.0f} N, on the opening flank up to {peaks[0]:.0f}, {peaks[1]:.0f}, "
            f"{peaks[2]:.0f} N at zeta 0, 0.5, 1"
        )
        verdict = (
            f"at the nose up {_rise(nose[2], nose[0]):.1%} (source 3 %), but the true peak moves to the opening flank and rises "
            f"{_rise(peaks[2], peaks[0]):.0%}"
        )
        found.append(Finding("section 6", "damping raises the peak contact force slightly (400 to 412 N)", words, verdict))
    return found


def _valve_gear_findings(runs: dict[str, TrainRun]) -> list[Finding]:
    found = []
    for lash in ("0 mm", "0.1 mm"):
        masses, rod = runs.get(f"six masses, lash {lash}"), runs.get(f"rod, lash {lash}")
        if masses is None or rod is None or masses.traces is None or rod.traces is None:
            continue
        first, second = _halves(masses, rod)
        words = (
            f"root mean square difference of the lever's force on the valve {first:.1f} N while opening, {second:.1f} N while "
            f"closing (lash {lash})"
        )
        verdict = "agrees" if second > first else "not seen with these assumed parts: the two models differ more while opening"
        found.append(Finding("section 4", "six masses and rods differ most in the second half, towards the seat", words, verdict))
        single = runs.get(f"single mass, lash {lash}")
        if single is not None and single.traces is not None:
            gap = _rms(single, rod, single.traces.rigid_lift > 0)
            other = _rms(masses, rod, masses.traces.rigid_lift > 0)
            words = (
                f"against the rods: single mass {gap:.1f} N, six masses {other:.1f} N root mean square over the open valve (lash {lash})"
            )
            found.append(
                Finding(
                    "section 4",
                    "how a spring is split into masses changes the result markedly",
                    words,
                    "agrees" if gap > 2 * other else "weaker here",
                )
            )
        finite = runs.get(f"finite elements, lash {lash}")
        if finite is not None and finite.traces is not None:
            peaks = [1e3 * _number(run, "outer_mean_peak_section_displacement") for run in (masses, rod, finite)]
            words = f"{peaks[0]:.2f} mm (six masses), {peaks[1]:.2f} mm (rod), {peaks[2]:.2f} mm (finite elements) at lash {lash}"
            found.append(
                Finding("figure 3", "mean peak displacement of the outer spring's sections", words, "no printed value to compare with")
            )
    return found


def _halves(one: TrainRun, other: TrainRun) -> tuple[float, float]:
    assert one.traces is not None
    lift = one.traces.rigid_lift
    nose = int(np.argmax(lift))
    place = np.arange(len(lift))
    return _rms(one, other, (lift > 0) & (place <= nose)), _rms(one, other, (lift > 0) & (place > nose))


def _rms(one: TrainRun, other: TrainRun, window: NDArray[np.bool_]) -> float:
    assert one.traces is not None and other.traces is not None
    difference = one.traces.forces["valve tip"] - other.traces.forces["valve tip"]
    return float(np.sqrt(np.mean(difference[window] ** 2)))
