"""Identify the unpublished dimensions of the beehive case from its calibration data alone.

Only the published statics, modes and 4200 rpm results are used; 5600 and 8000 rpm are never computed here. Rewrites the
values marked "identified" in the case library when called with --write.

    python scripts/identify_beehive.py [--write] [--elements-per-coil 24] [--workers 4] [--samples 300] [--keep 6]
"""

from __future__ import annotations

import argparse
import hashlib
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from importlib import resources

import numpy as np

from valvetrain.cam.build import build_lift_law
from valvetrain.cam.shaped import Shaped
from valvetrain.cosserat.buffer import RodDynamics
from valvetrain.cosserat.modes import natural_modes
from valvetrain.cosserat.static import Equilibrium, compress
from valvetrain.cosserat.transient import RodTransient, simulate
from valvetrain.errors import InputError
from valvetrain.parameters.curves import Constant, PiecewiseLinear
from valvetrain.parameters.damping import DampingParameters
from valvetrain.parameters.lift_law import LiftLawParameters
from valvetrain.parameters.loading import load_case
from valvetrain.parameters.material import OTEVA_90_SC
from valvetrain.parameters.spring import EndCoil, SpringDefinition
from valvetrain.parameters.writing import write_case_values
from valvetrain.quantities.statics import slope_change
from valvetrain.solution.atomic import write_text
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.modal_varied import ModalVaried
from valvetrain.studies.identification import Identified, Target, Unknown, identify
from valvetrain.studies.run import run_study

PRECOMPRESSION = 7e-3
ENGINE_SPEED = 4200 * 2 * np.pi / 60

#: Unknown dimensions (SI): bounds, and the prior that spring and cam practice gives. The 4200 rpm run does not tell the flank of the
#: lift (it excites the first mode by the 18th cam harmonic, 5600 and 8000 rpm by the 9th to 14th), so its prior is what a cam of this size
#: looks like: a pulse of positive acceleration over some 20 cam degrees, then constant deceleration over the nose.
UNKNOWNS = (
    Unknown("wire_diameter", 3.6e-3, 4.1e-3, 3.87e-3, 0.08e-3),
    Unknown("mean_diameter", 20.5e-3, 24.0e-3, 22.3e-3, 0.6e-3),
    Unknown("top_mean_diameter", 15.5e-3, 20.0e-3, 17.5e-3, 0.8e-3),
    Unknown("clearance_at_coil_1", 0.2e-3, 2.2e-3, 1.1e-3, 0.3e-3),
    Unknown("clearance_at_coil_2", 1.0e-3, 3.6e-3, 2.1e-3, 0.4e-3),
    Unknown("clearance_at_coil_3", 4.0e-3, 6.5e-3, 5.2e-3, 0.5e-3),
    Unknown("clearance_at_coil_7", 0.3e-3, 3.5e-3, 1.5e-3, 0.5e-3),
    Unknown("lower_inactive_coils", 0.50, 0.98, 0.78, 0.08),
    Unknown("upper_inactive_coils", 0.50, 0.98, 0.78, 0.08),
    Unknown("stiffness_share", 0.40, 1.00, 0.80, 0.15),
    Unknown("maximum_lift", 8.6e-3, 9.8e-3, 9.2e-3, 0.2e-3),
    Unknown("ramp_lift", 0.15e-3, 0.60e-3, 0.35e-3, 0.08e-3),
    Unknown("flank_start", 0.3, 2.0, 1.0, 0.3),
    Unknown("flank_end", 0.0, 1.0, 0.3, 0.3),
    Unknown("nose_start", 0.4, 2.0, 1.0, 0.3),
    Unknown("nose_middle", 0.4, 2.0, 1.0, 0.3),
)

#: Calibration data with the weight of a miss; source numbers of the published study, statics, modes and 4200 rpm only.
TARGETS = (
    Target("preload", 289.0, 1.5),
    Target("stiffness_change_compression", 5.0e-3, 0.25e-3),
    # "The compressive displacement is 0.07 mm when coil 2 makes contact": a gap of 0.07 mm, or no gap and 0.07 mm of elastic give.
    Target("node_2_installed_gap", 0.035e-3, 0.035e-3),
    Target("mode_1_frequency", 630.0, 4.0),
    Target("mode_2_frequency", 1120.0, 20.0),
    Target("mode_3_frequency", 1639.0, 30.0),
    # Over 0 to 120 degrees, the free swing: the study's own Stage I goes to 127, where the ramp already adds a few newtons.
    Target("free_swing_force_range", 12.0, 3.0),
    Target("stage_2_peak_force", 818.0, 4.0),
    Target("stage_2_peak_cam_angle", 183.0, 1.0),
    Target("stage_3_peak_force", 315.0, 8.0),
    Target("modal_stage_2_peak_force", 814.0, 6.0),
    Target("node_2_maximum_displacement", 0.05e-3, 0.02e-3),
    Target("node_2_stage_3_peak_acceleration", 5490.0, 1500.0),
)

#: Target -> the published value behind it: what produced it and its quantity in the case, whose role is therefore "calibration".
PUBLISHED = {target.name: ("solid finite elements", target.name) for target in TARGETS} | {
    "node_2_installed_gap": ("solid finite elements", "coil_1_2_installed_gap"),
    "free_swing_force_range": ("solid finite elements", "stage_1_force_range"),
    "modal_stage_2_peak_force": ("analytical modal", "stage_2_peak_force"),
    "node_2_stage_3_peak_acceleration": ("solid finite elements", "node_2_peak_acceleration"),
}


def method_digest() -> str:
    """Fingerprint of unknowns and targets: what a spread depends on beside the case."""
    return hashlib.sha256(repr((UNKNOWNS, TARGETS)).encode()).hexdigest()[:16]


def spring_of(p: dict[str, float]) -> SpringDefinition:
    """The beehive of a parameter set; shapes as published (diameter constant to coil 4, pitch linear 1-3, level 3-6, falling to 7)."""
    c1, c2, c3, c7 = (p[f"clearance_at_coil_{n}"] for n in (1, 2, 3, 7))
    step = 0.125
    clearances = (0.0, 0.0, c1 + step * (c2 - c1), c2, c3, c3, c7)
    return SpringDefinition(
        wire_diameter=Constant(p["wire_diameter"]),
        mean_diameter=PiecewiseLinear((0.0, 4.0, 7.0), (p["mean_diameter"], p["mean_diameter"], p["top_mean_diameter"])),
        pitch=PiecewiseLinear((0.0, 1 - step, 1 + step, 2.0, 3.0, 6.0, 7.0), tuple(p["wire_diameter"] + c for c in clearances)),
        total_coils=7.0, material=OTEVA_90_SC, name="beehive",
        lower_end=EndCoil("closed-ground", p["lower_inactive_coils"], p["lower_inactive_coils"]),
        upper_end=EndCoil("closed-ground", p["upper_inactive_coils"], p["upper_inactive_coils"]),
    )  # fmt: skip


def law_of(p: dict[str, float]) -> Shaped:
    """The lift law: published stages, acceleration of the flank drawn by six control values."""
    shape = (p["flank_start"], 1.0, p["flank_end"], -p["nose_start"], -p["nose_middle"], -1.0)
    angles = np.radians((90.0, 127.0, 180.0))
    return Shaped(
        maximum_lift=p["maximum_lift"], ramp_lift=p["ramp_lift"],
        ramp_start=angles[0], event_start=angles[1], nose=angles[2], flank_shape=shape,
    )  # fmt: skip


def evaluate(elements_per_coil: int, vector: np.ndarray) -> dict[str, float] | None:
    """Calibration quantities of one parameter vector; None for an impossible spring or a failed solution."""
    p = {u.name: float(v) for u, v in zip(UNKNOWNS, vector, strict=True)}
    damping = DampingParameters(ratio=0.016, ratio_frequency=630.0, stiffness_share=p["stiffness_share"])
    dynamics = RodDynamics(mass_damping=damping.mass_damping, stiffness_damping=damping.stiffness_damping)
    try:
        law = law_of(p)
        model = FiniteElementRod(spring_of(p), PRECOMPRESSION, elements_per_coil, dynamics)
        to_seat, to_top = np.linspace(0.5e-3, PRECOMPRESSION, 14), np.linspace(9e-3, PRECOMPRESSION + p["maximum_lift"], 6)
        whole = compress(model.statics, [*to_seat, *to_top])
        if not whole[-1].converged:
            return None
        path = whole[:14]
        model.__dict__["installed"] = path[-1]
        modes = natural_modes(model.statics, path[-1].state, 24)
        axial = modes.natural_frequency[modes.axial_modes(3)]
        classical = ModalVaried(
            tuple(axial), 0.016, tuple(e.state.compression for e in whole), tuple(e.retainer_force for e in whole), PRECOMPRESSION
        ).solve(law.lift, ENGINE_SPEED / 2, 720)
        run = simulate(
            model.mesh, path[-1].state, lambda time: PRECOMPRESSION + law.lift(ENGINE_SPEED / 2 * np.asarray(time)),
            np.radians(0.5) / (ENGINE_SPEED / 2), 2 * 720, dynamics, model.stable_time_step(), discard=720,
        )  # fmt: skip
    except (InputError, ValueError, np.linalg.LinAlgError, RuntimeError):
        return None
    if not run.completed or len(axial) < 3:
        return None
    force = np.concatenate([[0.0], [e.retainer_force for e in path]])
    compression = np.concatenate([[0.0], [e.state.compression for e in path]])
    values = {"preload": float(force[-1]), "stiffness_change_compression": slope_change(compression, force) or 0.0}
    values |= {f"mode_{n + 1}_frequency": float(f) for n, f in enumerate(axial)}
    values["modal_stage_2_peak_force"] = float(np.max(classical.seat_force_as_printed))
    return values | _node_2(model, path[-1], run) | _forces(run)


def _node_2(model: FiniteElementRod, installed: Equilibrium, run: RodTransient) -> dict[str, float]:
    coil = model.mesh.coil_number
    gaps = model.statics.gaps(installed.state.position).min(axis=0)
    inside = np.isfinite(gaps)
    height = np.array([np.interp(2.0, coil, z) for z in run.position[:, :, 2]])
    velocity = np.array([np.interp(2.0, coil, v) for v in run.velocity[:, :, 2]])
    acceleration = np.diff(velocity) / np.diff(run.time)
    angle = np.degrees(ENGINE_SPEED / 2 * run.time[1:]) % 360.0
    gap = float(np.interp(2.0, coil[inside], gaps[inside]))
    rest = np.interp(2.0, coil, installed.state.position[:, 2]) - max(gap, 0.0)
    return {
        "node_2_installed_gap": gap,
        "node_2_maximum_displacement": float(np.max(height) - rest),
        "node_2_stage_3_peak_acceleration": float(np.max(np.abs(acceleration[angle > 236.0]))),
    }


def _forces(run: RodTransient) -> dict[str, float]:
    force = run.seat_force
    angle = np.degrees(ENGINE_SPEED / 2 * run.time) % 360.0
    free_swing, stage_2, stage_3 = angle < 120, (angle > 140) & (angle < 225), (angle > 236) & (angle < 359)
    top = np.flatnonzero(stage_2)[np.argmax(force[stage_2])]
    near = slice(top - 8, top + 9)
    fit = np.polyfit(angle[near] - angle[top], force[near], 2)
    return {
        "free_swing_force_range": float(np.ptp(force[free_swing])),
        "stage_2_peak_force": float(force[top]),
        "stage_2_peak_cam_angle": float(angle[top] - fit[1] / (2 * fit[0])) if fit[0] < 0 else float(angle[top]),
        "stage_3_peak_force": float(np.max(force[stage_3])),
    }


def samples_of(count: int) -> list[np.ndarray]:
    """The centre of the prior and a Latin hypercube over 1.5 spreads about it."""
    centre = np.array([u.start for u in UNKNOWNS])
    spread = np.array([u.spread for u in UNKNOWNS])
    random = np.random.default_rng(2021)
    strata = np.argsort(random.random((len(UNKNOWNS), max(count - 1, 1))), axis=1).T
    offsets = 2 * (strata + random.random(strata.shape)) / max(count - 1, 1) - 1
    low, high = np.array([u.low for u in UNKNOWNS]), np.array([u.high for u in UNKNOWNS])
    return [centre, *np.clip(centre + 1.5 * offsets * spread, low, high)][:count]


def misfit(values: dict[str, float] | None, vector: np.ndarray) -> float:
    """Sum of squared scaled misses and of squared distances from the prior; infinite for an impossible spring."""
    if values is None:
        return np.inf
    prior = sum(((v - u.start) / u.spread) ** 2 for u, v in zip(UNKNOWNS, vector, strict=True))
    return float(prior + sum(((values[t.name] - t.value) / t.scale) ** 2 for t in TARGETS))


def library_values() -> np.ndarray:
    """The parameter vector that the shipped case holds, so that a new search starts where the last one ended."""
    case = load_case("gu2021-beehive")
    spring, law = case.require_spring(), build_lift_law(case.lift_law)
    assert isinstance(law, Shaped) and isinstance(spring.pitch, PiecewiseLinear)
    wire = float(spring.wire_diameter.value(0.0))
    clearance = dict(zip(spring.pitch.coils, np.array(spring.pitch.values) - wire, strict=True))
    at_2, step = clearance[2.0], 0.125
    start, _, end, first, second, last = law.flank_shape
    found = {
        "wire_diameter": wire, "mean_diameter": float(spring.mean_diameter.value(0.0)),
        "top_mean_diameter": float(spring.mean_diameter.value(7.0)),
        "clearance_at_coil_1": (clearance[1 + step] - step * at_2) / (1 - step), "clearance_at_coil_2": at_2,
        "clearance_at_coil_3": clearance[3.0], "clearance_at_coil_7": clearance[7.0],
        "lower_inactive_coils": spring.lower_end.inactive_coils, "upper_inactive_coils": spring.upper_end.inactive_coils,
        "stiffness_share": case.springs[0].damping.stiffness_share, "maximum_lift": law.maximum_lift, "ramp_lift": law.ramp_lift,
        "flank_start": start, "flank_end": end, "nose_start": -first / -last, "nose_middle": -second / -last,
    }  # fmt: skip
    return np.array([found[u.name] for u in UNKNOWNS], dtype=float)


def search(elements: int, workers: int, samples: int, keep: int) -> Identified:
    """Sample the prior, refine the best ``keep`` samples on a coarse mesh, finish the best of them and the shipped values.

    The final mesh has ``elements`` per coil; the more probable of the two ends is the answer, so a new search never makes it worse.
    """
    ends = [library_values()]
    with ProcessPoolExecutor(workers) as pool:
        if keep > 0:
            points = samples_of(samples)
            coarse = partial(evaluate, 12)
            scores = [misfit(values, point) for values, point in zip(pool.map(coarse, points), points, strict=True)]
            order = np.argsort(scores)[:keep]
            print(f"{samples} samples, best misfits {[round(scores[n], 1) for n in order]}", flush=True)
            found = [identify(UNKNOWNS, TARGETS, coarse, pool, begin=points[n], iterations=10) for n in order]
            print(f"refined to {[round(f.misfit, 2) for f in found]}", flush=True)
            best = min(found, key=lambda f: f.misfit)
            ends.insert(0, np.array([best.parameters[u.name] for u in UNKNOWNS]))
        fine = partial(evaluate, elements)
        finished = []
        for begin in ends:
            found_here = identify(UNKNOWNS, TARGETS, fine, pool, begin=begin, iterations=10, report=partial(print, flush=True))
            finished.append(found_here)
            print(f"finished at {finished[-1].misfit:.3f}", flush=True)
        return min(finished, key=lambda f: f.misfit)


def case_values(p: dict[str, float]) -> dict[str, object]:
    """The identified values as the case file holds them."""
    spring, law = spring_of(p), law_of(p)
    pitch = spring.pitch
    assert isinstance(pitch, PiecewiseLinear)
    clearances = ", ".join(f"{1e3 * (value - p['wire_diameter']):.4f}" for value in pitch.values)
    diameters = [1e3 * p[name] for name in ("mean_diameter", "mean_diameter", "top_mean_diameter")]
    return {
        "spring.wire_diameter": f"{1e3 * p['wire_diameter']:.4f} mm",
        "spring.mean_diameter.values": ", ".join(f"{diameter:.4f}" for diameter in diameters) + " mm",
        "spring.pitch.coils": [float(coil) for coil in pitch.coils],
        "spring.pitch.clearances": f"{clearances} mm",
        "spring.lower_end.inactive_coils": round(p["lower_inactive_coils"], 4),
        "spring.lower_end.ground_coils": round(p["lower_inactive_coils"], 4),
        "spring.upper_end.inactive_coils": round(p["upper_inactive_coils"], 4),
        "spring.upper_end.ground_coils": round(p["upper_inactive_coils"], 4),
        "spring.damping.stiffness_share": round(p["stiffness_share"], 4),
        "lift_law.maximum_lift": f"{1e3 * p['maximum_lift']:.4f} mm",
        "lift_law.ramp_lift": f"{1e3 * p['ramp_lift']:.4f} mm",
        "lift_law.flank_shape": [round(float(value), 4) for value in law.flank_shape],
    }


#: Quantities whose spread over the posterior is worth telling, with the unit they are told in.
SPREADS = (
    "stage_1_minimum_force", "stage_1_maximum_force", "stage_2_peak_force", "stage_2_peak_cam_angle", "stage_2_first_peak_force",
    "stage_2_valley_force", "stage_2_second_peak_force", "stage_3_peak_force", "stage_3_peak_cam_angle", "node_2_maximum_displacement",
    "node_2_stage_3_minimum_velocity", "node_2_peak_acceleration", "clash_interval_cam_angle",
)  # fmt: skip


def predict(elements_per_coil: int, vector: np.ndarray) -> dict[str, float]:
    """All three speeds of one parameter vector: named quantities, keyed ``rpm quantity``; empty for an impossible spring."""
    p = {u.name: float(v) for u, v in zip(UNKNOWNS, vector, strict=True)}
    case = load_case("gu2021-beehive")
    try:
        law = law_of(p)
        values = {name: getattr(law, name) for name in ("maximum_lift", "ramp_lift", "ramp_start", "event_start", "nose", "flank_shape")}
        own = case.springs[0].with_options("finite-element", elements_per_coil=elements_per_coil)
        spring = replace(own, wire=spring_of(p), damping=replace(own.damping, stiffness_share=p["stiffness_share"]))
        case = case.replace(springs=(spring,), lift_law=LiftLawParameters("shaped", values), published=())
        study = run_study(case, spring_models=("finite-element",), workers=1)
    except (InputError, ValueError, np.linalg.LinAlgError, RuntimeError):
        return {}
    told = {q: value for q, value in study.quantities.items() if q.engine_speed and q.name in SPREADS}
    return {f"{round(q.engine_speed * 30 / np.pi)} {q.name}": value for q, value in told.items()}


def tell_spread(found: Identified, elements: int, workers: int, count: int) -> str:
    """TOML text: 5, 50 and 95 % of each quantity over ``count`` draws of the posterior (SI)."""
    with ProcessPoolExecutor(workers) as pool:
        outcomes = [o for o in pool.map(partial(predict, elements), found.sample(UNKNOWNS, count, seed=2021)) if o]
    lines = [
        "# Spread of the beehive's results over what its calibration data leave open; written by scripts/identify_beehive.py.",
        f"# Percentiles 5, 50, 95 over {len(outcomes)} draws of the linearised posterior, {elements} elements per coil, SI units.",
        "", "[case]", f'digest = "{load_case("gu2021-beehive").record().digest}"', f'identification = "{method_digest()}"',
    ]  # fmt: skip
    for rpm in (4200, 5600, 8000):
        lines += ["", f'["{rpm} rpm"]']
        for name in SPREADS:
            values = [o[f"{rpm} {name}"] for o in outcomes if np.isfinite(o.get(f"{rpm} {name}", np.nan))]
            if len(values) >= 0.5 * len(outcomes):
                lines.append(f"{name} = [{', '.join(f'{v:.6g}' for v in np.percentile(values, (5, 50, 95)))}]")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Identify, print the result and, with --write, rewrite the case library."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--elements-per-coil", type=int, default=24)
    parser.add_argument("--workers", type=int, default=4)
    parser.add_argument("--samples", type=int, default=300)
    parser.add_argument("--keep", type=int, default=6, help="samples to refine; 0 starts from the shipped values alone")
    parser.add_argument("--draws", type=int, default=48)
    options = parser.parse_args()
    found = search(options.elements_per_coil, options.workers, options.samples, options.keep)
    print(f"misfit {found.misfit:.3f} after {found.iterations} iterations")
    for name, value in found.parameters.items():
        print(f"  {name:24s} {value:.6g}  +- {found.standard_error[name]:.2g}")
    for target in TARGETS:
        print(f"  {target.name:32s} {found.computed[target.name]:.6g}   published {target.value:.6g}")
    if options.write:
        path = resources.files("valvetrain") / "parameters" / "library" / "gu2021-beehive.toml"
        write_case_values(str(path), case_values(dict(found.parameters)))
        print(f"rewrote the identified values of {path.name}")
        spread = tell_spread(found, 16, options.workers, options.draws)
        write_text(str(path).replace(".toml", ".spread"), spread)
        print(spread)


if __name__ == "__main__":
    main()
