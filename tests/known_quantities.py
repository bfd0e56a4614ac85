"""Simple systems whose every number is known from a formula, one function each: what is found, and what it has to be.

A value is a number (met to 1 part in 10^6) or a pair (number, largest difference) where samples stand in the way.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from scipy import signal

from known_events import rigid_valve_events, valve_events
from known_rest import REST_GROUPS
from synthetic_spring import ENGINE_SPEED, EVENT, bump, clashing_run, run
from synthetic_train import ANGLE, CAM_SPEED, COUNT, TIME, degrees, lift_of, rigid, train
from train_parts import LAW, direct, system
from valvetrain.parameters.card import SpringCard
from valvetrain.parameters.constructors import conical, cylindrical
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.spring import OPEN_END
from valvetrain.quantities.design import design_quantities
from valvetrain.quantities.evaluate import evaluate
from valvetrain.quantities.frame import Frame
from valvetrain.quantities.kinematics import rigid_motion, rigid_quantities
from valvetrain.quantities.statics import rest_quantities
from valvetrain.solution.event import Event
from valvetrain.solution.modal import ModalResult
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.record import CaseRecord, PublishedValue
from valvetrain.solution.result import Solution, empty_channels
from valvetrain.solution.static import SpringAtRest, StaticCurve, StaticStress
from valvetrain.solution.study import Study
from valvetrain.sources.multibody4b17 import study_quantities
from valvetrain.studies.sweep import control_quantities

Known = tuple[Mapping[str, float], dict[str, float | tuple[float, float]]]
DEG, CAM_RATE = np.pi / 180, ENGINE_SPEED / 2
CARD = SpringCard(30e3, 270.0, 0.06, 36e-3, 510.0, 8e-3, 24.5e-3)


def level(value: float):
    return lambda degrees: value + 0 * degrees


def forces() -> Known:
    """Bumps on a level force at the seat, others at the retainer; lift and room of a card."""
    channels = {
        "seat_force": lambda degrees: 300 + 500 * bump(degrees, 170, 100) - 45 * bump(degrees, 60, 20),
        "retainer_force": lambda degrees: 310 + 620 * bump(degrees, 180, 100) - 70 * bump(degrees, 300, 20),
        "valve_lift": lambda degrees: 9.25e-3 * bump(degrees, 180, 106),
    }
    found = evaluate(run(channels), Frame((InstalledSpring(card=CARD), InstalledSpring(card=replace(CARD, solid_height=26e-3))))).quantities
    return found, {
        "peak_spring_force": 800.0, "peak_spring_force_cam_angle": 170 * DEG, "minimum_spring_force": 255.0,
        "minimum_spring_force_cam_angle": 60 * DEG, "peak_retainer_force": 930.0, "minimum_retainer_force": 240.0,
        "peak_valve_lift": 9.25e-3, "coil_bind_clearance": 10e-3 - 9.25e-3,
    }  # fmt: skip


def bandwidth() -> Known:
    """200 waves of 10 kHz in a closed turn: 6 dB down at 10 kHz, 1 / (1 + ratio^8) of a warped 20 kHz."""
    speed = 2 * 2 * np.pi * 10e3 / 200
    made = run({"seat_force": lambda degrees: 300 + 100 * np.cos(200 * degrees * DEG)}, per_turn=4000, turns=1, engine_speed=speed,
               system="train")  # fmt: skip
    return evaluate(made).quantities, {
        "below_10_khz_peak_spring_force": 350.0,
        "below_20_khz_peak_spring_force": 300 + 100 / (1 + (np.tan(np.pi / 20) / np.tan(np.pi / 10)) ** 8),
    }


def curve(rate: float) -> StaticCurve:
    x, none = np.linspace(0, 20e-3, 21), np.zeros((21, 0))
    return StaticCurve(x, rate * x, np.full(21, rate), none, none, np.zeros(0), none, np.zeros(0))


def surge() -> Known:
    """9 N at order 13, 25 N at order 18 and 40 N at order 3 on a static force; surge at order 13.2 sees half to one and a half of it."""

    def lift(angle):
        return 4e-3 * (1 - np.cos(angle)) + 2e-5 * np.cos(13 * angle) + 7e-6 * np.cos(14 * angle)

    def force(degrees):
        angle = degrees * DEG
        waves = 9 * np.cos(13 * angle + 1) + 25 * np.cos(18 * angle) + 40 * np.sin(3 * angle) + 60 * np.sin(21 * angle)
        return 30e3 * (9e-3 + lift(angle)) + waves

    spring = InstalledSpring(card=CARD)
    frequency = 13.2 * CAM_RATE / (2 * np.pi)
    frame = Frame((spring,), (SpringAtRest(spring.name, "multi-mass", 9e-3, curve(30e3)),), (frequency,), EVENT, lift)
    found = evaluate(run({"seat_force": force, "valve_lift": lambda degrees: lift(degrees * DEG)}), frame).quantities
    return found, {
        "surge_frequency": frequency, "surge_cam_order": 13.2, "nearest_lift_harmonic_order": 13.0, "nearest_lift_harmonic_lift": 2e-5,
        "surge_amplitude_force": 25.0, "surge_order_3_force": 40.0, "surge_order_13_force": 9.0, "surge_order_18_force": 25.0,
    }  # fmt: skip


def stress() -> Known:
    """Three wire points with 300 +- 100, 350 +- 20 and 200 +- 130 MPa: the peak stands at the first, the largest amplitude at the third."""

    def shear(degrees):
        wave = np.cos((degrees - 40) * DEG)
        return 1e6 * np.stack([300 + 100 * wave, 350 + 20 * wave, 200 + 130 * wave], axis=1)

    wire = cylindrical(4e-3, 24e-3, 7e-3, 6.0, closed_coils=0.0, lower_end=OPEN_END, upper_end=OPEN_END)
    spring = InstalledSpring(wire=wire, precompression=5e-3)
    extra = {name: (("wire_point",), "Pa", "made up") for name in ("inner_fibre_shear_stress", "inner_fibre_equivalent_stress")}
    values = {
        "inner_fibre_shear_stress": shear, "inner_fibre_equivalent_stress": lambda degrees: 1.8 * shear(degrees),
        "valve_lift": lambda degrees: 9e-3 * bump(degrees, 180, 106),
        "seat_force": lambda degrees: 300 + 200 * bump(degrees, 180, 100) - 25 * bump(degrees, 20, 10),
    }  # fmt: skip
    at = np.array([0.0, 20e-3])
    slow = StaticStress(at, np.array([1.0, 2.0, 3.5]), 1e6 * np.array([[0, 0, 100], [400, 320, 420.0]]), np.zeros((2, 3)))
    frame = Frame((spring,), (SpringAtRest(spring.name, "finite-element", 5e-3, stress=slow),))
    found = evaluate(run(values, extra=extra, coil_number=[1.0, 2.0, 3.5]), frame).quantities
    per_force = (6 + 0.5) / (6 - 0.75) * 8 * 24e-3 / (np.pi * 4e-3**3)  # EN 13906-1 with w = D / d = 6
    top = 100e6 + 320e6 * 14 / 20  # the third point at 14 mm; the first reaches 280 MPa
    return found, {
        "peak_shear_stress": 400e6, "peak_shear_stress_cam_angle": 40 * DEG, "peak_shear_stress_coil_number": 1.0,
        "minimum_shear_stress": 200e6, "peak_equivalent_stress": 720e6, "largest_amplitude_shear_stress": 130e6,
        "largest_amplitude_mean_shear_stress": 200e6, "largest_amplitude_coil_number": 3.5,
        "nominal_peak_shear_stress": 500 * per_force, "nominal_minimum_shear_stress": 275 * per_force,
        "quasi_static_peak_shear_stress": top, "quasi_static_amplitude_shear_stress": 400e6 * 9 / 20 / 2,
        "dynamic_to_static_stress_ratio": 400e6 / top,
    }  # fmt: skip


def clashes() -> Known:
    """Three clashes that an integrator logged, in the second of two turns; one in the first does not count."""
    logged = [(3.0, 999.0, 9.0, 9.0), (2 * np.pi + 1, 345.0, 17e-3, 31e-3), (2 * np.pi + 2, 120.0, 23e-3, 11e-3),
              (2 * np.pi + 4, 80.0, 2e-3, 5e-3)]  # fmt: skip
    events = tuple(
        Event("clash", angle, angle / CAM_RATE, 1e-5, size, "N", "", {"upper_coil": 2.0, "energy": energy, "impulse": impulse})
        for angle, size, energy, impulse in logged
    )
    made = run({"seat_force": level(300.0)})
    counted = {"contact_record_interval_duration": 2e-6, "time_step_duration": 4e-6, "steps_per_cycle_count": 5357}
    made = Solution(made.channels, events, provenance=made.provenance, statistics=counted)
    return evaluate(made, Frame((InstalledSpring(card=CARD),))).quantities, {
        "clash_count": 3.0, "peak_clash_force": 345.0, "clash_energy": 42e-3, "largest_clash_energy": 23e-3,
        "largest_clash_impulse": 31e-3, "time_step_duration": 4e-6, "steps_per_cycle_count": 5357.0,
    }  # fmt: skip


def energies() -> Known:
    """Half of the heat is not booked: that half is what is missing, over the span of the work."""
    angle = np.arange(1440) * 2 * np.pi / 720
    stored, heat = 10 * (1 - np.cos(angle)), 0.1 * angle
    made = run({"kinetic_energy": 0.25 * stored + 1, "elastic_energy": 0.7 * stored + 3, "contact_energy": 0.05 * stored,
                "energy_dissipated": 0.5 * heat + 7, "work_done": stored + heat + 2})  # fmt: skip
    return evaluate(made).quantities, {
        "dissipated_energy": 0.5 * heat[-1], "energy_imbalance_ratio": 0.5 * heat[-1] / np.ptp(stored + heat),
    }  # fmt: skip


def at_rest() -> Known:
    """A bilinear curve with its knee at 5 mm, two gaps that shut, three modes of which two are axial."""
    x = np.linspace(0, 10e-3, 101)
    force = 40e3 * x + 4e3 * np.maximum(x - 5e-3, 0)
    gap = np.maximum(np.array([7.5e-3, 8.5e-3, 7.2e-3]) - x[:, None], 0)
    bent = StaticCurve(x, force, 40e3 + 4e3 * (x > 5e-3), gap, 0 * gap, np.array([1.5, 1.9, 2.5]), np.zeros((101, 0)), np.zeros(0))
    modes = ModalResult(7e-3, np.array([500.0, 630.0, 1120.0]), np.zeros((3, 2, 3)), np.arange(2.0), np.ones(3), (1, 2))
    found = rest_quantities(SpringAtRest("spring", "finite-element", 7e-3, bent, modes), ["natural_1_frequency"])
    return found, {
        "preload": 288.0, "installed_rate": 44e3, "stiffness_change_compression": (5e-3, 3e-5), "coil_1_2_installed_gap": 0.5e-3,
        "mode_2_frequency": 1120.0, "natural_1_frequency": 500.0,
    }  # fmt: skip


def design() -> Known:
    """A plain helix of six turns with open ends, pressed by 5 mm."""
    d, mean, pitch, turns = 4e-3, 24e-3, 7e-3, 6.0
    wire = cylindrical(d, mean, pitch, turns, closed_coils=0.0, lower_end=OPEN_END, upper_end=OPEN_END)
    length = turns * np.hypot(np.pi * mean, pitch)
    mass = np.pi / 4 * d**2 * length * wire.material.density
    rate = wire.material.shear_modulus * d**4 / (8 * mean**3 * turns)
    free, solid = turns * pitch + d, (turns + 1) * d
    return design_quantities(InstalledSpring(wire=wire, precompression=5e-3)), {
        "total_coil_count": turns, "active_coil_count": turns, "free_length": free, "solid_height": solid,
        "solid_compression": free - solid, "wire_length": length, "wire_mass": mass, "largest_outer_diameter": mean + d,
        "smallest_inner_diameter": mean - d, "estimated_rate": rate, "estimated_surge_frequency": 0.5 * np.sqrt(rate / mass),
        "installed_compression": 5e-3, "installed_height": free - 5e-3, "coil_bind_lift": free - 5e-3 - solid,
    }  # fmt: skip


def cone() -> Known:
    """A cone of 3 mm wire, 30 to 18 mm: its index runs from 10 to 6."""
    wire = conical(3e-3, 30e-3, 18e-3, 8e-3, 6.0, closed_coils=0.0, lower_end=OPEN_END, upper_end=OPEN_END)
    return design_quantities(InstalledSpring(wire=wire, precompression=5e-3)), {
        "smallest_index_ratio": 6.0, "largest_index_ratio": 10.0, "largest_outer_diameter": 33e-3, "smallest_inner_diameter": 15e-3,
    }  # fmt: skip


def card() -> Known:
    """A card says what it says; 0.5 sqrt(k / m) and the room to solid follow."""
    return design_quantities(InstalledSpring(card=CARD)), {
        "card_rate": 30e3, "card_preload": 270.0, "card_mass": 0.06, "card_installed_height": 36e-3, "card_open_force": 510.0,
        "card_open_lift": 8e-3, "card_solid_height": 24.5e-3, "card_surge_frequency": 0.5 * np.sqrt(30e3 / 0.06), "coil_bind_lift": 11.5e-3,
    }  # fmt: skip


def rigid_train() -> Known:
    """A direct train: contact is lost where spring less weight equals mass times deceleration, first at the least of their quotients."""
    mass, weight = 0.05 + 0.09 + 0.04 / 3, (0.05 + 0.09) * 9.80665
    angle = np.linspace(0, 2 * np.pi, 2_000_001)
    lift, bend = LAW.lift(angle), LAW.lift(angle, 2)
    risky = (bend < 0) & (lift > 0)
    squares = (300.0 + 30e3 * lift[risky] - weight) / (-mass * bend[risky])
    found = rigid_quantities(rigid_motion(system(direct())))
    return found, {
        "rigid_contact_loss_engine_speed": 2 * np.sqrt(squares.min()), "rigid_maximum_valve_lift": 5e-3,
        "rigid_contact_loss_cam_angle": (angle[risky][np.argmin(squares)], 1e-4),
    }  # fmt: skip


def moving_train() -> Known:
    """One cycle whose channels, gaps, touches and statistics are made up, each with a number of its own."""
    lift = np.where(degrees(90, 270), 0.9 * lift_of(ANGLE), -1e-6)
    open_part = degrees(105, 255)
    flying = lift + np.where(degrees(160, 200), 1e-3, 0.0)
    acceleration = np.zeros(COUNT)
    acceleration[[10, 20]] = 300.0, -450.0
    cam = np.where(open_part, 350.0, 700.0) + np.where(degrees(178, 182), 33.0, 0.0) - np.where(degrees(200, 202), 90.0, 0.0)
    tip = np.where(open_part, 210.0, 5.0) + np.where(degrees(150, 151), 44.0, 0.0) - np.where(degrees(140, 141), 33.0, 0.0)
    speed = np.where(degrees(100, 101), -12.0, np.where(degrees(240, 241), 9.0, 1.0))
    values = {
        "valve_lift": flying, "valve_acceleration": acceleration, "cam_contact_force": cam, "valve_tip_contact_force": tip,
        "cam_torque": 2.0 + 8 * np.sin(ANGLE), "lever_speed": speed, "piston_clearance": 3e-3 - 0.2 * lift_of(ANGLE),
        "cam_gap": np.where(degrees(158, 170), 2e-4, np.where(degrees(175, 202), 3e-4, -1e-5)),
        "valve_tip_gap": np.where(degrees(168, 175), 1e-4, -1e-5),
    }  # fmt: skip
    touches = [(271.0, 0.321, 8e-3, 90.0), (276.0, 0.11, 2e-4, 272.0), (279.0, 0.06, 5e-5, 277.0)]
    logged = tuple(
        Event("touch", place * DEG, place * DEG / CAM_SPEED, 0.0, velocity, "m/s", "seat",
              {"largest_gap": gap, "release_cam_angle": begin * DEG})
        for place, velocity, gap, begin in touches
    )  # fmt: skip
    counted = {
        "cycle_work_energy": 1.7, "cycle_dissipated_energy": 1.1, "spring_dissipated_energy": 0.6,
        "contact_friction_dissipated_energy": 0.4, "steady_cycles_count": 7, "steady_residual_ratio": 3e-5,
        "steady_tolerance_ratio": 1e-4, "motion_period_count": 2,
        "peak_cam_contact_force": 1234.0, "peak_support_force": 411.0, "peak_stem_force": 412.0, "peak_pushrod_bar_force": 413.0,
        "peak_lever_bending_force": 414.0, "wall_time_per_cycle_duration": 9.0,
    }  # fmt: skip
    made = train(logged, statistics=counted, **values)
    moved = -4e-3 * bump(np.degrees(ANGLE), 180, 90)[:, None] * np.array([0.0, 1.0, 2.0])
    with_coils = made.channels.assign(axial_displacement=(("sample", "wire_point"), moved, {"units": "m", "long_name": "moved"}))
    made = replace(made, channels=with_coils)
    found = evaluate(made, Frame(rigid=rigid())).quantities
    step, second = TIME[1] - TIME[0], DEG / CAM_SPEED
    opened = 180 - 2 * np.degrees(np.arcsin(np.sqrt(2e-6 / 7.2e-3)))  # 2 um off the seat count as open
    return found, {
        "peak_rigid_valve_lift": 8e-3, "lift_loss_displacement": 8e-3 - 8.2e-3, "peak_valve_acceleration": 450.0,
        "valve_open_duration": (opened * second, 2 * step), "loss_of_contact_duration": (44 * second, 2 * step),
        "peak_cam_torque": 10.0, "minimum_cam_torque": -6.0, "mean_cam_power": 1.7 / (2 * np.pi / CAM_SPEED),
        "minimum_cam_contact_force": 260.0, "peak_open_cam_contact_force": 383.0, "nose_cam_contact_force": 383.0,
        "minimum_valve_tip_contact_force": 177.0, "peak_open_valve_tip_contact_force": 254.0, "peak_lever_speed": 12.0,
        "peak_lever_speed_valve_lift": (0.9 * 8e-3 * np.sin(10 * DEG) ** 2, 3e-5), "minimum_piston_clearance_gap": 1.4e-3,
        "seating_velocity": 0.321, "seating_cam_angle": 271 * DEG, "bounce_count": 2.0, "bounce_height": 2e-4, "loft_gap": 3e-4,
        "loft_count": 2.0, "loft_duration": (39 * second, 2 * step), "float_excess_lift": 1e-3 - 0.8e-3 * np.sin(70 * DEG) ** 2,
        "float_duration": (40 * second, 2 * step), "cycle_work_energy": 1.7, "cycle_dissipated_energy": 1.1,
        "spring_dissipated_energy": 0.6, "contact_friction_dissipated_energy": 0.4, "steady_cycles_count": 7.0,
        "steady_residual_ratio": 3e-5, "steady_tolerance_ratio": 1e-4, "motion_period_count": 2.0, "peak_cam_contact_force": 1234.0,
        "peak_support_force": 411.0, "peak_stem_force": 412.0, "peak_pushrod_bar_force": 413.0, "peak_lever_bending_force": 414.0,
        "spring_mean_peak_section_displacement": (0.0 + 4e-3 + 8e-3) / 3,
    }  # fmt: skip


def sweep() -> Known:
    """Speeds 1 to 6 rad/s: the cam lets go at 2, one resonance floats at 3 and is passed over, the train floats from 5 on."""
    runs = []
    for place, (excess, least) in enumerate(zip((0, 0, 200, 0, 80, 90), (50, 0, 20, 30, 0, 0), strict=True)):
        origin = Provenance("own-train", "modal-uniform", 1.0 + place, label="stock", system="train")
        numbers = {"float_excess_lift": 1e-6 * excess, "minimum_cam_contact_force": float(least)}
        runs.append(Solution(empty_channels(), provenance=origin, quantities=numbers))
    return control_quantities(Study(CaseRecord("own-train"), "sweep", tuple(runs)), "stock"), {
        "contact_loss_engine_speed": 2.0, "float_engine_speed": 5.0,
    }  # fmt: skip


def stages() -> Known:
    """A force drawn of bumps: each stage of the beehive's study has its peaks where they were drawn."""

    def force(degrees):
        first = 30 * bump(degrees, 12, 20) + 31 * bump(degrees, 42, 20) + 40 * bump(degrees, 84.5, 20) - 15 * bump(degrees, 65, 12)
        event = 640 * bump(degrees, 160, 24) + 900 * bump(degrees, 190, 28) + 77 * bump(degrees, 234, 20) - 50 * bump(degrees, 174, 3)
        return 280 + first + event + 500 * bump(degrees, 254.5, 4) + 200 * bump(degrees, 297, 4)

    def fine(degrees):
        return force(degrees)[:, None] + np.array([0.0, 1.0, 3.0, 2.0])

    made = run({"seat_force": force, "seat_force_fine": fine}, extra={"seat_force_fine": (("subsample",), "N", "made up")})
    found = evaluate(made, Frame(source="gu2021", lift_event=EVENT)).quantities
    end = 280 + 77 * np.cos(np.pi / 20) ** 2
    return found, {
        "stage_1_minimum_force": 265.0, "stage_1_maximum_force": 320.0, "stage_1_peak_1_cam_angle": 12 * DEG,
        "stage_1_peak_2_cam_angle": 42 * DEG, "stage_2_peak_force": 1180.0, "stage_2_peak_cam_angle": 190 * DEG,
        "stage_2_first_peak_force": 920.0, "stage_2_first_peak_cam_angle": 160 * DEG, "stage_2_valley_force": 230.0,
        "stage_2_valley_cam_angle": 174 * DEG, "stage_2_second_peak_force": 1180.0, "stage_2_second_peak_cam_angle": 190 * DEG,
        "stage_2_end_force": end, "stage_3_peak_force": 780.0, "stage_3_peak_cam_angle": 254.5 * DEG,
        "stage_3_every_instant_peak_force": 783.0, "stage_3_second_peak_cam_angle": 297 * DEG,
    }  # fmt: skip


def node() -> Known:
    """Motion of the end of coil 2 drawn of bumps, at a wire point of its own; coil 1 moves by other numbers."""

    def both(one, two):
        return lambda degrees: np.stack([one(degrees), two(degrees)], axis=1)

    def velocity(degrees):
        slow = 0.5 * bump(degrees, 60, 30) - 0.7 * bump(degrees, 90, 30) + 1.1 * bump(degrees, 150, 20) - 1.2 * bump(degrees, 200, 20)
        fast = 1.0 * bump(degrees, 236, 4) - 1.35 * bump(degrees, 241.5, 4) + 0.6 * bump(degrees, 245, 3)
        return slow + fast - 0.9 * bump(degrees, 280, 4) + 0.8 * bump(degrees, 300, 10)

    def lift_off(degrees):
        return 2e-6 + 2e-4 * bump(degrees, 50, 40) + 7e-4 * bump(degrees, 243, 10)

    def spikes(degrees, scale):
        return scale * (1e4 * bump(degrees, 245.5, 3) - 8e3 * bump(degrees, 60, 3) + 6e3 * bump(degrees, 150, 3))

    values = {
        "seat_force": level(300.0), "axial_velocity": both(level(0.0), velocity), "coil_gap": both(level(1e-3), lift_off),
        "axial_displacement": both(level(-9e-3), lambda degrees: -3e-3 * bump(degrees, 180, 106)),
        "coil_contact_force": both(level(0.0), lambda degrees: 55.0 * (np.abs(degrees - 180) < 20.2)),
        "axial_acceleration": both(lambda degrees: spikes(degrees, 0.5), lambda degrees: spikes(degrees, 1.0)),
    }  # fmt: skip
    made = run(values, coil_number=[1.0, 2.0], upper_coil=[1.0, 2.0])
    found = evaluate(made, Frame(source="gu2021", lift_event=EVENT)).quantities
    return found, {
        "node_2_contact_displacement": 3e-3 * np.cos(np.pi * 20 / 106) ** 2, "node_2_maximum_displacement": 7.02e-4,
        "node_2_maximum_displacement_cam_angle": 243 * DEG, "node_2_stage_1_maximum_displacement": 2.02e-4,
        "node_2_stage_1_displacement_range": 2e-4, "node_2_stage_1_minimum_velocity": -0.7,
        "node_2_stage_1_minimum_velocity_cam_angle": 90 * DEG, "node_2_stage_1_maximum_velocity": 0.5,
        "node_2_stage_2_maximum_velocity_cam_angle": 150 * DEG, "node_2_stage_2_maximum_velocity": 1.1,
        "node_2_stage_2_minimum_velocity": -1.2, "node_2_stage_1_velocity_range": 1.2, "node_2_stage_3_minimum_velocity": -1.35,
        "node_2_stage_3_maximum_velocity": 1.0, "node_2_late_stage_3_minimum_velocity": -0.9,
        "node_2_late_stage_3_maximum_velocity": 0.8, "node_2_rebound_velocity": 0.6, "node_2_rebound_velocity_cam_angle": 245 * DEG,
        "node_2_rebound_duration": 3.5 * DEG / CAM_RATE, "node_2_peak_acceleration": 1e4,
        "node_2_peak_acceleration_cam_angle": 245.5 * DEG, "node_1_peak_acceleration": 5e3, "node_2_second_peak_acceleration": -8e3,
        "node_2_second_peak_acceleration_cam_angle": 60 * DEG, "node_2_third_peak_acceleration": 6e3,
        "node_2_third_peak_acceleration_cam_angle": 150 * DEG,
    }  # fmt: skip


def collisions() -> Known:
    """Coil 2 meets coil 1 at 20, 46, 72, 245.5 and 272 degrees, 25 % off one period; after 245.5 it leaves for 3 degrees."""
    touched = [(20, 22), (46, 48), (72, 74), (245.5, 246.5), (249.5, 251), (272, 274)]

    def gap(degrees):
        shut = np.any([(degrees >= first) & (degrees < last) for first, last in touched], axis=0)
        return np.where(shut, -1e-7, 1e-5)[:, None]

    made = run({"seat_force": level(300.0), "coil_gap": gap}, upper_coil=[2.0])
    mean = (26 + 26 + 26.5) / 3
    surge_frequency = 1.25 * CAM_RATE / (mean * DEG)
    found = evaluate(made, Frame(source="gu2021", lift_event=EVENT, surge_frequencies=(surge_frequency,))).quantities
    return found, {
        "clash_1_cam_angle": 20 * DEG, "clash_4_cam_angle": 245.5 * DEG, "clash_interval_cam_angle": mean * DEG,
        "clash_interval_to_mode_1_period_ratio": 1.25, "coil_1_2_bounce_start_cam_angle": 246.5 * DEG,
        "coil_1_2_bounce_end_cam_angle": 249.5 * DEG, "coil_1_2_bounce_duration": 3 * DEG / CAM_RATE,
    }  # fmt: skip


def main_clash() -> Known:
    """A bump of 400 N over 3 degrees at 250 on 300 N: height, angle and the area A w / 2 of the cosine squared within 0.1 ms."""
    closed = 360 - 106 * (1 - 2 / np.pi * np.arcsin(np.sqrt(1e-3)))  # degrees with less than a thousandth of the lift
    above = 400 * 1.5 / closed  # by which the spike itself raises the mean that it is counted from
    held = 400 * 1.5 * DEG / CAM_RATE - above * 2e-4
    made = clashing_run(2880)
    found = evaluate(made, Frame(source="gu2021", lift_event=EVENT, surge_frequencies=(600.0,))).quantities
    series, step = made.channel("seat_force_fine").ravel(), made.time[1] / 4
    last = slice(4 * 2880 * 601 // 360, 4 * 2880 * 659 // 360)  # 241 to 299 degrees of the second turn
    filters = (signal.butter(4, 2 * cutoff * step, output="sos") for cutoff in (10e3, 20e3))
    heights = [float(np.max(signal.sosfiltfilt(one, series)[last])) for one in filters]
    return found, {
        "main_clash_peak_force": 700.0, "main_clash_cam_angle": (250 * DEG, 2e-4), "main_clash_impulse": (held, 0.002 * held),
        "main_clash_below_10_khz_peak_force": (heights[0], 0.5), "main_clash_below_20_khz_peak_force": (heights[1], 0.5),
        "stage_3_below_10_khz_peak_force": (heights[0], 0.5), "stage_3_below_20_khz_peak_force": (heights[1], 0.5),
    }  # fmt: skip


def pushrod_study() -> Known:
    """Stock and performance springs side by side, each with numbers of its own; equations 5, 8 and 10 of the source by hand."""
    numbers = {
        "stock, as printed": (283.0, 9.1e-3, 1.0, 0.0), "performance, as printed": (400.0, 8.9e-3, 6.7, 4.4e-3),
        "performance, as printed, zeta 1": (412.0, 8.8e-3, 2.0, 0.0), "stock": (574.0, 9.0e-3, 3.0, 0.0),
    }  # fmt: skip
    names = ("nose_cam_contact_force", "peak_valve_lift", "peak_lever_speed", "peak_lever_speed_valve_lift")
    runs = tuple(
        Solution(empty_channels(), quantities=dict(zip(names, values, strict=True)),
                 provenance=Provenance("pushrod", "massless", 100.0, label=label, system="train"))
        for label, values in numbers.items()
    )  # fmt: skip
    printed = (PublishedValue("contact_force_rise_ratio", 0.4, "", engine_speed=100.0, model="as printed"),)
    study = Study(CaseRecord("pushrod", study="multibody4b17", published=printed), solutions=runs)
    rate, mass = (605.18 - 342.66) / 8.5e-3, 0.03049 + 0.10634 + 0.17362
    return {key.name: value for key, value in study_quantities(study).items()}, {
        "stock_nose_cam_contact_force": 283.0, "performance_nose_cam_contact_force": 400.0,
        "performance_damped_nose_cam_contact_force": 412.0, "contact_force_rise_ratio": 400 / 283 - 1, "stock_peak_valve_lift": 9.1e-3,
        "performance_lift_difference_displacement": 0.2e-3, "peak_lever_speed": 6.7, "peak_lever_speed_valve_lift": 4.4e-3,
        "contact_formula_force": (1e5 + 49.92) * 0.02**1.5, "lumped_natural_frequency": np.sqrt(rate / mass) / (2 * np.pi),
        "critical_damping_ratio": 2 * np.sqrt(rate * mass),
    }  # fmt: skip


GROUPS = (
    forces, bandwidth, surge, stress, clashes, energies, at_rest, design, cone, card, rigid_train, moving_train, sweep, stages, node,
    collisions, main_clash, pushrod_study, valve_events, rigid_valve_events, *REST_GROUPS,
)  # fmt: skip
