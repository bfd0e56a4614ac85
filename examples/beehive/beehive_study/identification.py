"""Points of the beehive for its identification: unpublished dimensions and lift in, calibration
numbers out, by one path of the rod.

The study's own readings of its results are taken, not those of a run: the free swing from 0 to 120
degrees, a parabola through the Stage II peak, coil 2 as its node 2.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from valvetrain.cam.contract import build_lift_law
from valvetrain.cam.shaped import Shaped
from valvetrain.cosserat.buffer import RodDynamics
from valvetrain.cosserat.modes import natural_modes
from valvetrain.cosserat.static import Equilibrium, compress
from valvetrain.cosserat.transient import RodTransient, simulate
from valvetrain.errors import InputError
from valvetrain.explore.identification_file import PointEvaluator
from valvetrain.parameters.curves import Constant, PiecewiseLinear
from valvetrain.parameters.installed_spring import DampingParameters
from valvetrain.parameters.loading import load_case
from valvetrain.parameters.material import OTEVA_90_SC
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.winding import EndCoil
from valvetrain.quantities.statics import slope_change
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.modal_varied import ModalVaried

PRECOMPRESSION = 7e-3
ENGINE_SPEED = 4200 * 2 * np.pi / 60
ELEMENTS_PER_COIL = 24
#: The unpublished quantities, by the names an identification file has them under.
NAMES = (
    "wire_diameter", "mean_diameter", "top_mean_diameter", "clearance_at_coil_1", "clearance_at_coil_2", "clearance_at_coil_3",
    "clearance_at_coil_7", "lower_inactive_coils", "upper_inactive_coils", "stiffness_share", "maximum_lift", "ramp_lift", "flank_start",
    "flank_end", "nose_start", "nose_middle",
)  # fmt: skip


@dataclass(frozen=True)
class BeehivePoint:
    """Result of :func:`evaluate` for values in the order of ``names``; those that are not among
    them are the shipped case's.
    """

    names: tuple[str, ...]
    elements_per_coil: int = ELEMENTS_PER_COIL

    def __call__(self, values: Sequence[float]) -> Mapping[str, float] | None:
        fixed = {} if set(self.names) == set(NAMES) else library_values()
        return evaluate(
            self.elements_per_coil, fixed | dict(zip(self.names, map(float, values), strict=True))
        )


def points(names: Sequence[str], options: Mapping[str, float]) -> BeehivePoint:
    """The computation for an identification of ``names``. Raises :class:`InputError` for a name or
    an option that is none.
    """
    unknown = next((name for name in names if name not in NAMES), None)
    if unknown is not None:
        raise InputError(
            f"the beehive has no unknown '{unknown[:60]}'; its unknowns are {', '.join(NAMES)}",
            "quantities",
        )
    elements = options.get("elements_per_coil", ELEMENTS_PER_COIL)
    if (
        set(options) - {"elements_per_coil"}
        or not 4 <= elements <= 1000
        or elements != int(elements)
    ):
        raise InputError(
            "the beehive takes elements_per_coil, a whole number from 4 to 1000; give that alone",
            "options",
        )
    return BeehivePoint(tuple(names), int(elements))


def spring_of(p: Mapping[str, float]) -> SpringDefinition:
    """The beehive of a parameter set; shapes as published (diameter constant to coil 4, pitch
    linear 1-3, level 3-6, falling to 7).
    """
    c1, c2, c3, c7 = (p[f"clearance_at_coil_{n}"] for n in (1, 2, 3, 7))
    step = 0.125
    clearances = (0.0, 0.0, c1 + step * (c2 - c1), c2, c3, c3, c7)
    return SpringDefinition(
        wire_diameter=Constant(p["wire_diameter"]),
        mean_diameter=PiecewiseLinear(
            (0.0, 4.0, 7.0), (p["mean_diameter"], p["mean_diameter"], p["top_mean_diameter"])
        ),
        pitch=PiecewiseLinear(
            (0.0, 1 - step, 1 + step, 2.0, 3.0, 6.0, 7.0),
            tuple(p["wire_diameter"] + c for c in clearances),
        ),
        total_coils=7.0,
        material=OTEVA_90_SC,
        name="beehive",
        lower_end=EndCoil("closed-ground", p["lower_inactive_coils"], p["lower_inactive_coils"]),
        upper_end=EndCoil("closed-ground", p["upper_inactive_coils"], p["upper_inactive_coils"]),
    )


def law_of(p: Mapping[str, float]) -> Shaped:
    """The lift law: published stages, acceleration of the flank drawn by six control values."""
    shape = (p["flank_start"], 1.0, p["flank_end"], -p["nose_start"], -p["nose_middle"], -1.0)
    angles = np.radians((90.0, 127.0, 180.0))
    return Shaped(
        maximum_lift=p["maximum_lift"],
        ramp_lift=p["ramp_lift"],
        ramp_start=angles[0],
        event_start=angles[1],
        nose=angles[2],
        flank_shape=shape,
    )


def evaluate(elements_per_coil: int, p: Mapping[str, float]) -> dict[str, float] | None:
    """Calibration quantities of one set of parameters; None for an impossible spring or a failed
    solution.
    """
    damping = DampingParameters(
        ratio=0.016, ratio_frequency=630.0, stiffness_share=p["stiffness_share"]
    )
    dynamics = RodDynamics(
        mass_damping=damping.mass_damping, stiffness_damping=damping.stiffness_damping
    )
    try:
        law = law_of(p)
        model = FiniteElementRod(spring_of(p), PRECOMPRESSION, elements_per_coil, dynamics)
        to_seat, to_top = (
            np.linspace(0.5e-3, PRECOMPRESSION, 14),
            np.linspace(9e-3, PRECOMPRESSION + p["maximum_lift"], 6),
        )
        whole = compress(model.statics, [*to_seat, *to_top])
        if not whole[-1].converged:
            return None
        path = whole[:14]
        model.__dict__["installed"] = path[-1]
        modes = natural_modes(model.statics, path[-1].state, 24)
        axial = modes.natural_frequency[modes.axial_modes(3)]
        classical = ModalVaried(
            tuple(axial),
            0.016,
            tuple(e.state.compression for e in whole),
            tuple(e.retainer_force for e in whole),
            PRECOMPRESSION,
        ).solve(law.lift, ENGINE_SPEED / 2, 720)
        run = simulate(
            model.mesh,
            path[-1].state,
            lambda time: PRECOMPRESSION + law.lift(ENGINE_SPEED / 2 * np.asarray(time)),
            np.radians(0.5) / (ENGINE_SPEED / 2),
            2 * 720,
            dynamics,
            model.stable_time_step(),
            discard=720,
        )
    except (InputError, ValueError, np.linalg.LinAlgError, RuntimeError):
        return None
    if not run.completed or len(axial) < 3:
        return None
    force = np.concatenate([[0.0], [e.retainer_force for e in path]])
    compression = np.concatenate([[0.0], [e.state.compression for e in path]])
    values = {
        "preload": float(force[-1]),
        "stiffness_change_compression": slope_change(compression, force) or 0.0,
    }
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
    free_swing, stage_2, stage_3 = (
        angle < 120,
        (angle > 140) & (angle < 225),
        (angle > 236) & (angle < 359),
    )
    top = np.flatnonzero(stage_2)[np.argmax(force[stage_2])]
    near = slice(top - 8, top + 9)
    fit = np.polyfit(angle[near] - angle[top], force[near], 2)
    return {
        "free_swing_force_range": float(np.ptp(force[free_swing])),
        "stage_2_peak_force": float(force[top]),
        "stage_2_peak_cam_angle": float(
            np.radians(angle[top] - fit[1] / (2 * fit[0]) if fit[0] < 0 else angle[top])
        ),
        "stage_3_peak_force": float(np.max(force[stage_3])),
    }


def library_values() -> dict[str, float]:
    """The values that the shipped case holds, so that a new search starts where the last one ended."""
    case = load_case("gu2021-beehive-blind")
    spring, law = case.require_spring(), build_lift_law(case.lift_law)
    assert isinstance(law, Shaped) and isinstance(spring.pitch, PiecewiseLinear)
    wire = float(spring.wire_diameter.value(0.0))
    clearance = dict(zip(spring.pitch.coils, np.array(spring.pitch.values) - wire, strict=True))
    at_2, step = clearance[2.0], 0.125
    start, _, end, first, second, last = law.flank_shape
    return {
        "wire_diameter": wire,
        "mean_diameter": float(spring.mean_diameter.value(0.0)),
        "top_mean_diameter": float(spring.mean_diameter.value(7.0)),
        "clearance_at_coil_1": (clearance[1 + step] - step * at_2) / (1 - step),
        "clearance_at_coil_2": at_2,
        "clearance_at_coil_3": clearance[3.0],
        "clearance_at_coil_7": clearance[7.0],
        "lower_inactive_coils": spring.lower_end.inactive_coils,
        "upper_inactive_coils": spring.upper_end.inactive_coils,
        "stiffness_share": case.springs[0].damping.stiffness_share,
        "maximum_lift": law.maximum_lift,
        "ramp_lift": law.ramp_lift,
        "flank_start": start,
        "flank_end": end,
        "nose_start": -first / -last,
        "nose_middle": -second / -last,
    }


def case_values(p: Mapping[str, float]) -> dict[str, object]:
    """The identified values as the case file holds them."""
    spring, law = spring_of(p), law_of(p)
    pitch = spring.pitch
    assert isinstance(pitch, PiecewiseLinear)
    clearances = ", ".join(f"{1e3 * (value - p['wire_diameter']):.4f}" for value in pitch.values)
    diameters = [1e3 * p[name] for name in ("mean_diameter", "mean_diameter", "top_mean_diameter")]
    return {
        "spring.wire_diameter": f"{1e3 * p['wire_diameter']:.4f} mm",
        "spring.mean_diameter.values": ", ".join(f"{diameter:.4f}" for diameter in diameters)
        + " mm",
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


SPEC = PointEvaluator(points, lambda names: tuple(float(library_values()[name]) for name in names))
