"""A student study of a diesel's cam, pushrod and rocker in a commercial multibody tool: stock
against performance valve springs.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from valvetrain.solution.comparison import Finding
from valvetrain.solution.quantity import Quantity, named, same_speed
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study
from valvetrain.sources.contract import Origin, SourceStudy

PRINTED, CLOSED_FORM = "as printed", "closed form of the source"
ORIGINS = {
    PRINTED: Origin("MB", "multibody study"),
    CLOSED_FORM: Origin("CF", "closed form of the source"),
}
#: Numbers that the source prints in its formulas: contact (N/mm^1.5, N s/mm, mm), masses of valve,
#: rocker and pushrod (kg), two loads of each spring (N) and the lift between them (m).
CONTACT_STIFFNESS, CONTACT_DAMPING, CONTACT_DEPTH = 1e5, 49.92, 0.02
MASSES = (0.03049, 0.10634, 0.17362)
STOCK_RATE, RATE = ((high - low) / 8.5e-3 for low, high in ((195.81, 378.27), (342.66, 605.18)))
#: Rockers of engines of this size have arms (m) well below this.
MAX_ARM_LENGTH = 0.06
#: Printed and computed lift losses agree within this share.
LOSS_FIT = 0.25
#: A printed force fits a computed one within this share, and a change below a third of it is next
#: to nothing.
FIT = 0.08

#: The peak force on the cam: over the open valve, without the impact of a follower that comes back.
PEAK = "peak_open_cam_contact_force"

Runs = Mapping[str, Solution]


def runs_of(study: Study) -> dict[str, Solution]:
    """The run of every label with results at the engine speed of the published values, else at its
    lowest.
    """
    speed = next(
        (value.engine_speed for value in study.record.published if value.engine_speed is not None),
        None,
    )
    chosen = {}
    for label in study.labels:
        series = [run for run in study.runs(label) if run.quantities]
        if series:
            chosen[label] = next(
                (run for run in series if same_speed(run.engine_speed, speed)), series[0]
            )
    return chosen


def number(run: Solution, name: str) -> float:
    """A quantity of a run; NaN where it has none of that name."""
    return run.quantities.get(name, math.nan)


def study_quantities(study: Study) -> dict[Quantity, float]:
    """Quantities by their published names (SI): from the runs without seat load, and closed forms."""
    runs = runs_of(study)
    stock, performance = runs.get("stock, as printed"), runs.get("performance, as printed")
    found = named(closed_forms(), None, "")
    if runs:
        found |= named(
            {"cam_turn_frequency": next(iter(runs.values())).engine_speed / 2 / (2 * math.pi)},
            None,
            "",
        )
    if stock is None or performance is None:
        return found
    nose, lift = "nose_cam_contact_force", "peak_valve_lift"
    values = {
        f"stock_{nose}": number(stock, nose), f"performance_{nose}": number(performance, nose),
        "contact_force_rise_ratio": _rise(number(performance, nose), number(stock, nose)),
        f"stock_{lift}": number(stock, lift),
        "performance_lift_difference_displacement": number(stock, lift) - number(performance, lift),
        "peak_lever_speed": number(performance, "peak_lever_speed"),
        "peak_lever_speed_valve_lift": number(performance, "peak_lever_speed_valve_lift"),
    }  # fmt: skip
    if "performance, as printed, zeta 1" in runs:
        damped = runs["performance, as printed, zeta 1"]
        values[f"performance_damped_{nose}"] = number(damped, nose)
        values["performance_damped_peak_cam_contact_force"] = number(damped, PEAK)
    return found | named(
        {name: value for name, value in values.items() if np.isfinite(value)},
        stock.engine_speed,
        "",
    )


def closed_forms() -> dict[str, float]:
    """The source's own formulas, evaluated as printed: table 2, equations 5, 8 and 10."""
    mass = sum(MASSES)
    lumped = math.sqrt(RATE / mass)
    return {
        "stock_spring_rate": STOCK_RATE,
        "performance_spring_rate": RATE,
        "lumped_mass": mass,
        "lumped_angular_speed": lumped,
        "contact_formula_force": (CONTACT_STIFFNESS + CONTACT_DAMPING) * CONTACT_DEPTH**1.5,
        "lumped_natural_frequency": lumped / (2 * math.pi),
        "critical_damping": 2 * math.sqrt(RATE * mass),
    }


def _rise(after: float, before: float) -> float:
    """Share by which a force rises; NaN where there was none, as at the nose of a floating train."""
    return after / before - 1 if before > 0 else math.nan


def findings(study: Study) -> tuple[Finding, ...]:
    """The findings that can be compared with these runs; none of a train without contact at the
    nose.
    """
    runs = {
        label: run
        for label, run in runs_of(study).items()
        if number(run, "nose_cam_contact_force") > 0
    }
    printed = {value.quantity: value.value for value in study.record.published}
    found = (build(runs, printed) for build in (_stiffer_spring, _lift_loss, _damping))
    return tuple(one for one in found if one is not None)


def _stiffer_spring(runs: Runs, printed: Mapping[str, float]) -> Finding | None:
    source_rise = printed.get("contact_force_rise_ratio")
    if not {"stock", "performance"} <= set(runs) or source_rise is None:
        return None
    forces = [number(runs[label], "nose_cam_contact_force") for label in ("stock", "performance")]
    rise = _rise(forces[1], forces[0])
    if rise <= 0:
        verdict = "not seen: the force does not rise"
    else:
        verdict = (
            "agrees"
            if abs(rise - source_rise) <= FIT
            else f"the sign holds, the rise is {rise:.0%}"
        )
    computed = f"with the seat load {forces[0]:.0f} N and {forces[1]:.0f} N, {'up' if rise > 0 else 'down'} {abs(rise):.0%}"
    return Finding(
        "section 7",
        f"contact force up about {source_rise:.0%} with the stiffer spring, peak at the cam nose",
        computed,
        verdict,
    )


def _lift_loss(runs: Runs, printed: Mapping[str, float]) -> Finding | None:
    source_loss = 1e3 * printed.get("performance_lift_difference_displacement", math.nan)
    if not {"stock", "performance"} <= set(runs) or not source_loss > 0:
        return None
    loss = [
        1e3 * number(runs[label], "lift_loss_displacement") for label in ("stock", "performance")
    ]
    more = loss[1] - loss[0]
    if not math.isfinite(more):
        return None
    computed = f"lift lost to contact compliance {loss[0]:.3f} mm (stock) and {loss[1]:.3f} mm (performance)"
    if more <= 0:
        verdict = "not seen: the performance spring loses no more"
    else:
        share = more / source_loss - 1
        computed += f", {more:.3f} mm more"
        verdict = (
            "agrees"
            if abs(share) <= LOSS_FIT
            else f"{'smaller' if share < 0 else 'larger'} than printed; the sign holds"
        )
    return Finding(
        "section 5.2",
        f"the performance spring gives about {source_loss:.1f} mm less lift",
        computed,
        verdict,
    )


def _damping(runs: Runs, printed: Mapping[str, float]) -> Finding | None:
    labels = ("performance", "performance, zeta 0.5", "performance, zeta 1")
    source_forces = [
        printed.get(f"performance_{force}_cam_contact_force", math.nan)
        for force in ("nose", "damped_peak")
    ]
    if not set(labels) <= set(runs) or not all(np.isfinite(source_forces)):
        return None
    nose = [number(runs[label], "nose_cam_contact_force") for label in labels]
    peaks = [number(runs[label], PEAK) for label in labels]
    at_nose, over_all = _rise(nose[2], nose[0]), _rise(peaks[2], peaks[0])
    computed = (
        f"with the seat load, peak over the open valve {peaks[0]:.0f}, {peaks[1]:.0f}, {peaks[2]:.0f} N, at the nose {nose[0]:.0f}, "
        f"{nose[1]:.0f}, {nose[2]:.0f} N at zeta 0, 0.5, 1"
    )
    source = _rise(source_forces[1], source_forces[0])
    verdict = f"peak {over_all:+.1%} (source {source:+.1%}), "
    if over_all > source + FIT:
        verdict += f"not reproduced: it is off the nose; there {at_nose:+.1%}"
    else:
        verdict += f"at the nose {at_nose:+.1%}"
    statement = f"damping {'raises' if source > 0 else 'lowers'} the peak contact force ({source_forces[0]:.0f} to {source_forces[1]:.0f} N)"
    return Finding("section 6", statement, computed, verdict)


def notes(study: Study) -> tuple[str, ...]:
    """Contradictions between the numbers of the source, with the computed results."""
    runs = runs_of(study)
    printed = {value.quantity: value.value for value in study.record.published}
    contacts = (_seat_load(runs, printed), _formula(printed), _damper(runs), _stability(runs))
    return tuple(filter(None, (*contacts, _rocker(runs, printed), _surge(runs))))


def _seat_load(runs: Runs, printed: Mapping[str, float]) -> str:
    forces = []
    for spring in ("stock", "performance"):
        force = printed.get(f"{spring}_nose_cam_contact_force")
        bare, whole = (runs.get(label) for label in (f"{spring}, as printed", spring))
        if force is None or bare is None or whole is None:
            return ""
        forces.append(
            (force, number(bare, "nose_cam_contact_force"), number(whole, "nose_cam_contact_force"))
        )
    fits = [sum(abs(row[column] / row[0] - 1) <= FIT for row in forces) for column in (1, 2)]
    fit = "fit neither springs with nor springs without their seat load"
    if fits in ([2, 0], [0, 2]):
        fit = f"fit springs {'without' if fits == [2, 0] else 'with'} their seat load"
    numbers = [" and ".join(f"{row[column]:.0f}" for row in forces) for column in range(3)]
    return f"The peak contact forces printed ({numbers[0]} N) {fit}: without it {numbers[1]} N came out, with it {numbers[2]} N."


def _formula(printed: Mapping[str, float]) -> str:
    if "contact_formula_force" not in printed:
        return ""
    elastic, whole = CONTACT_STIFFNESS * CONTACT_DEPTH**1.5, closed_forms()["contact_formula_force"]
    return (
        f"Equation 4 of the source lacks the penetration rate in its damping term and adds N s/mm to N; its check of "
        f"{printed['contact_formula_force']:.0f} N is all but the elastic force at {CONTACT_DEPTH} mm ({elastic:.1f} of {whole:.1f} N)."
    )


def _damper(runs: Runs) -> str:
    free, damped = (
        runs.get(label) for label in ("performance, as printed", "performance, as printed, zeta 1")
    )
    if free is None or damped is None or not damped.has("valve_velocity"):
        return ""
    damping, velocity = (
        closed_forms()["critical_damping"],
        float(np.max(np.abs(damped.channel("valve_velocity")))),
    )
    change = _rise(number(damped, "nose_cam_contact_force"), number(free, "nose_cam_contact_force"))
    if not math.isfinite(change):
        return ""
    word = "next to nothing" if abs(change) < FIT / 3 else "it clearly"
    lost = number(damped, "loft_count") > 0
    flank = "loses contact with the cam" if lost else "keeps contact"
    return (
        f"A damper of zeta = 1 ({damping:.1f} N s/m) on a valve moving at up to {velocity:.1f} m/s adds some {damping * velocity:.0f} N "
        f"on the flanks; at the nose, where the valve has zero velocity, it changes {word} ({change:+.1%}). "
        f"So damped and without seat load the train {flank}{_peaks(free, damped)}."
    )


def _peaks(free: Solution, damped: Solution) -> str:
    """The peak forces of both runs, and what they say of the force printed; empty without them."""
    peaks = [number(run, PEAK) for run in (free, damped)]
    whole = number(damped, "peak_cam_contact_force")
    if not (all(map(math.isfinite, peaks)) and peaks[1] > (1 + FIT) * peaks[0]):
        return ""
    impact = f" ({whole:.0f} N with impacts)" if whole > (1 + FIT) * peaks[1] else ""
    return (
        f", and its peak force over the open valve rises from {peaks[0]:.0f} to {peaks[1]:.0f} N{impact}: "
        "this damper cannot be the cause of the few per cent that the source prints"
    )


def _stability(runs: Runs) -> str:
    labels = ("performance", "performance, zeta 0.5")
    if not set(labels) <= set(runs):
        return ""
    before, after = (_departure(runs[label]) for label in labels)
    if not after > before:
        return ""
    return (
        "That zeta = 0.5 gives stability (section 6) is not reproduced: the acceleration of the valve departs from that of rigid parts "
        f"by {before:.3g} m/s2 (rms over the open valve) without damper and by {after:.3g} m/s2 with it."
    )


def _departure(run: Solution) -> float:
    """Root mean square (m/s2), over the valve open by more than a tenth of its lift, of the second
    derivative of lift less rigid lift; NaN where the run has none.
    """
    if not run.has("valve_lift", "rigid_valve_lift"):
        return math.nan
    lift, rigid = run.channel("valve_lift"), run.channel("rigid_valve_lift")
    step = 2 * math.pi / (len(lift) - 1) / (run.engine_speed / 2)
    # Twice over two samples: the rigid lift may be joined by straight lines between every second.
    bend = np.gradient(np.gradient(lift - rigid, step), step)
    open_valve = rigid > 0.1 * np.max(rigid)
    return float(np.sqrt(np.mean(bend[open_valve] ** 2))) if open_valve.any() else math.nan


def _rocker(runs: Runs, printed: Mapping[str, float]) -> str:
    run, rate = runs.get("performance, as printed"), printed.get("peak_lever_speed")
    lift = math.nan if run is None else number(run, "peak_valve_lift")
    if run is None or rate is None or not number(run, "peak_lever_speed") > 0 or not lift > 0:
        return ""
    ratio, cam_speed = number(run, "peak_lever_speed") / rate, run.engine_speed / 2
    rotation = f"{np.degrees(rate):.0f} deg/s of rocker rotation, as printed,"
    here = f"{np.degrees(number(run, 'peak_lever_speed')):.0f} deg/s came out"
    if 0.5 < ratio < 2:
        return f"{rotation} fits: {here}."
    # Twice the lift in one turn: no motion of the valve has a lower peak speed.
    arm = lift * cam_speed / math.pi / rate
    text = f"{rotation} does not fit: {here}, {ratio:.1f} times that. "
    if ratio < 1 or arm < MAX_ARM_LENGTH:
        return text + "Another profile or another arm would be needed."
    text += (
        f"To lift the valve {lift * 1e3:.1f} mm and set it down again within one cam revolution at {cam_speed * 30 / math.pi:.0f} rpm, "
        f"it would need a valve arm of at least {arm * 1e3:.0f} mm even if the valve never rested: no rocker has that."
    )
    as_rpm = number(run, "peak_lever_speed") / (np.degrees(rate) * math.pi / 30)
    return text + (
        f" Read as rpm it would be {6 * np.degrees(rate):.0f} deg/s." if 0.7 < as_rpm < 1.4 else ""
    )


def _surge(runs: Runs) -> str:
    lumped = closed_forms()["lumped_natural_frequency"]
    surge = runs["performance"].quantities.get("surge_frequency") if "performance" in runs else None
    if surge is None:
        return ""
    apart = abs(surge / lumped - 1) > 0.5
    meaning = "no surge frequency" if apart else "near the surge frequency by chance"
    return f"{lumped:.0f} Hz is the lumped mass on the spring rate, {meaning}: the spring's own is at {surge:.0f} Hz."


SPEC = SourceStudy(
    "multibody4b17",
    study_quantities=study_quantities,
    findings=findings,
    notes=notes,
    origins=ORIGINS,
)
