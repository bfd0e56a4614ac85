"""Simple systems whose every number is known from a formula, one function each: what is found, and
what it has to be.

A value is a number (met to 1 part in 10^6) or a pair (number, largest difference) where samples
stand in the way.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from known_events import rigid_valve_events, surge_speeds, valve_events
from known_rest import REST_GROUPS
from spring_shapes import conical, cylindrical
from synthetic_spring import ENGINE_SPEED, EVENT, bump, run
from synthetic_train import ANGLE, CAM_SPEED, COUNT, TIME, degrees, lift_of, rigid, train
from train_parts import LAW, direct, system
from valvetrain.integrate.train_channels import Scatter
from valvetrain.parameters.card import SpringCard
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.material import material_by_name
from valvetrain.quantities.cycle import Frame
from valvetrain.quantities.evaluate import evaluate
from valvetrain.quantities.kinematics import rigid_motion, rigid_quantities
from valvetrain.quantities.statics import design_quantities, rest_quantities
from valvetrain.quantities.valve_events import nose_ends
from valvetrain.runs.critical_scan import Scan, SpeedSample
from valvetrain.runs.critical_speeds import CriticalOptions, critical_speed
from valvetrain.solution.critical import KINDS
from valvetrain.solution.modes import ModalResult
from valvetrain.solution.result import Solution
from valvetrain.solution.static import SpringAtRest, StaticCurve, StaticStress
from valvetrain.solution.status import Cause, Event

Known = tuple[Mapping[str, float], dict[str, float | tuple[float, float]]]
DEG, CAM_RATE = np.pi / 180, ENGINE_SPEED / 2
CARD = SpringCard(30e3, 270.0, 0.06, 36e-3, 510.0, 8e-3, 24.5e-3)


def level(value: float):
    return lambda degrees: value + 0 * degrees


def forces() -> Known:
    """Bumps on a level force at the seat, others at the retainer; lift and room of a card."""
    channels = {
        "seat_force": lambda degrees: (
            300 + 500 * bump(degrees, 170, 100) - 45 * bump(degrees, 60, 20)
        ),
        "retainer_force": lambda degrees: (
            310 + 620 * bump(degrees, 180, 100) - 70 * bump(degrees, 300, 20)
        ),
        "valve_lift": lambda degrees: 9.25e-3 * bump(degrees, 180, 106),
    }
    found = evaluate(
        run(channels),
        Frame(
            (
                InstalledSpring(card=CARD),
                InstalledSpring(card=replace(CARD, solid_height=26e-3)),
                InstalledSpring(
                    card=replace(CARD, solid_height=None, wire_diameter=3.6e-3, active_coils=5)
                ),
            )
        ),
    ).quantities
    return found, {
        "peak_spring_force": 800.0,
        "raw_peak_spring_force": 800.0,
        "raw_peak_retainer_force": 930.0,
        "peak_spring_force_cam_angle": 170 * DEG,
        "minimum_spring_force": 255.0,
        "minimum_spring_force_cam_angle": 60 * DEG,
        "peak_retainer_force": 930.0,
        "minimum_retainer_force": 240.0,
        "peak_valve_lift": 9.25e-3,
        "coil_bind_clearance": 10e-3 - 9.25e-3,
        "wound_least_clearance": 36e-3 - 9.25e-3 - 7 * 3.6e-3,  # two turns more than active
        "wound_most_clearance": 36e-3 - 9.25e-3 - 6 * 3.6e-3,
    }


def bandwidth() -> Known:
    """200 waves of 10 kHz in a closed turn: 6 dB down at 10 kHz."""
    speed = 2 * 2 * np.pi * 10e3 / 200
    made = run(
        {"seat_force": lambda degrees: 300 + 100 * np.cos(200 * degrees * DEG)},
        per_turn=4000,
        turns=1,
        engine_speed=speed,
        system="train",
    )
    return evaluate(made).quantities, {
        "peak_spring_force": 350.0,
        "raw_peak_spring_force": 400.0,
        "minimum_spring_force": 200.0,
    }


def curve(rate: float) -> StaticCurve:
    x, none = np.linspace(0, 20e-3, 21), np.zeros((21, 0))
    return StaticCurve(x, rate * x, np.full(21, rate), none, none, np.zeros(0), none, np.zeros(0))


def surge() -> Known:
    """9 N at order 13, 25 N at order 18 and 40 N at order 3 on a static force; surge at order 13.2
    sees half to one and a half of it.
    """

    def lift(angle):
        return 4e-3 * (1 - np.cos(angle)) + 2e-5 * np.cos(13 * angle) + 7e-6 * np.cos(14 * angle)

    def force(degrees):
        angle = degrees * DEG
        waves = (
            9 * np.cos(13 * angle + 1)
            + 25 * np.cos(18 * angle)
            + 40 * np.sin(3 * angle)
            + 60 * np.sin(21 * angle)
        )
        return 30e3 * (9e-3 + lift(angle)) + waves

    spring = InstalledSpring(card=CARD)
    frequency = 13.2 * CAM_RATE / (2 * np.pi)
    frame = Frame(
        (spring,),
        (SpringAtRest(spring.name, "multi-mass", 9e-3, curve(30e3)),),
        (frequency,),
        EVENT,
        lift,
    )
    found = evaluate(
        run({"seat_force": force, "valve_lift": lambda degrees: lift(degrees * DEG)}), frame
    ).quantities
    return found, {
        "surge_frequency": frequency,
        "surge_cam_order": 13.2,
        "nearest_lift_harmonic_order": 13.0,
        "nearest_lift_harmonic_lift": 2e-5,
        "surge_amplitude_force": 25.0,
        "surge_amplitude_cam_order": 18.0,
        "surge_order_3_force": 40.0,
        "surge_order_13_force": 9.0,
        "surge_order_18_force": 25.0,
    }


def stress() -> Known:
    """Three wire points with 300 +- 100, 350 +- 20 and 200 +- 130 MPa: the peak stands at the
    first, the largest amplitude at the third.
    """

    def shear(degrees):
        wave = np.cos((degrees - 40) * DEG)
        return 1e6 * np.stack([300 + 100 * wave, 350 + 20 * wave, 200 + 130 * wave], axis=1)

    wire = cylindrical(4e-3, 24e-3, 7e-3, 6.0, ends="open")
    wire = replace(wire, material=material_by_name("EN 10270-2 VDSiCr"))
    spring = InstalledSpring(wire=wire, precompression=5e-3)
    extra = {
        name: (("wire_point",), "Pa", "made up")
        for name in ("inner_fibre_shear_stress", "inner_fibre_equivalent_stress")
    }
    values = {
        "inner_fibre_shear_stress": shear, "inner_fibre_equivalent_stress": lambda degrees: 1.8 * shear(degrees),
        "valve_lift": lambda degrees: 9e-3 * bump(degrees, 180, 106),
        "seat_force": lambda degrees: 300 + 200 * bump(degrees, 180, 100) - 25 * bump(degrees, 20, 10),
    }  # fmt: skip
    at = np.array([0.0, 20e-3])
    slow = StaticStress(
        at,
        np.array([1.0, 2.0, 3.5]),
        1e6 * np.array([[0, 0, 100], [400, 320, 420.0]]),
        np.zeros((2, 3)),
    )
    frame = Frame((spring,), (SpringAtRest(spring.name, "finite-element", 5e-3, stress=slow),))
    found = evaluate(run(values, extra=extra, coil_number=[1.0, 2.0, 3.5]), frame).quantities
    per_force = (
        (6 + 0.5) / (6 - 0.75) * 8 * 24e-3 / (np.pi * 4e-3**3)
    )  # EN 13906-1 with w = D / d = 6
    rate = wire.material.shear_modulus * 4e-3**4 / (8 * 24e-3**3 * 6)
    top = 100e6 + 320e6 * 14 / 20  # the third point at 14 mm; the first reaches 280 MPa
    return found, {
        "peak_shear_stress": 400e6,
        "peak_shear_stress_cam_angle": 40 * DEG,
        "peak_shear_stress_coil_number": 1.0,
        "minimum_shear_stress": 200e6,
        "peak_equivalent_stress": 720e6,
        "largest_amplitude_shear_stress": 130e6,
        "largest_amplitude_mean_shear_stress": 200e6,
        "largest_amplitude_coil_number": 3.5,
        "open_nominal_shear_stress": 14e-3 * rate * per_force,
        "closed_nominal_shear_stress": 5e-3 * rate * per_force,
        "open_uncorrected_shear_stress": 14e-3 * rate * 8 * 24e-3 / (np.pi * 4e-3**3),
        "wire_tensile_strength": 1860e6,  # EN 10270-2, 4 mm
        "permitted_shear_stress": 0.56 * 1860e6,
        "quasi_static_peak_shear_stress": top,
        "quasi_static_amplitude_shear_stress": 400e6 * 9 / 20 / 2,
        "dynamic_to_static_stress_ratio": 400e6 / top,
    }


def clashes() -> Known:
    """Three clashes that an integrator logged, in the second of two turns, the hardest of coils that
    come to rest; one in the first does not count.
    """
    logged = [
        (3.0, 999.0, 9.0, 9.0, Cause.COILS_STRIKE),
        (2 * np.pi + 1, 345.0, 17e-3, 31e-3, Cause.COILS_REST),
        (2 * np.pi + 2, 120.0, 23e-3, 11e-3, Cause.COILS_STRIKE),
        (2 * np.pi + 4, 80.0, 2e-3, 5e-3, Cause.COILS_STRIKE),
    ]
    events = tuple(
        Event(
            "clash",
            angle,
            angle / CAM_RATE,
            1e-5,
            size,
            "N",
            "",
            {"upper_coil": 2.0, "energy": energy, "impulse": impulse, "cause": cause},
        )
        for angle, size, energy, impulse, cause in logged
    )
    made = run({"seat_force": level(300.0)})
    counted = {
        "contact_record_interval_duration": 2e-6,
        "time_step_duration": 4e-6,
        "steps_per_cycle_count": 5357,
    }
    made = Solution(made.channels, events, provenance=made.provenance, statistics=counted)
    return evaluate(made, Frame((InstalledSpring(card=CARD),))).quantities, {
        "clash_count": 3.0,
        "peak_clash_force": 345.0,
        "surge_clash_peak_force": 120.0,
        "clash_energy": 42e-3,
        "largest_clash_energy": 23e-3,
        "largest_clash_impulse": 31e-3,
        "time_step_duration": 4e-6,
        "steps_per_cycle_count": 5357.0,
    }


def energies() -> Known:
    """Half of the heat is not booked: that half is what is missing, over the span of the work."""
    angle = np.arange(1440) * 2 * np.pi / 720
    stored, heat = 10 * (1 - np.cos(angle)), 0.1 * angle
    made = run(
        {
            "kinetic_energy": 0.25 * stored + 1,
            "elastic_energy": 0.7 * stored + 3,
            "contact_energy": 0.05 * stored,
            "energy_dissipated": 0.5 * heat + 7,
            "work_done": stored + heat + 2,
        }
    )
    return evaluate(made).quantities, {
        "dissipated_energy": 0.5 * heat[-1],
        "cycle_damper_energy": 0.05 * 2 * np.pi,
        "energy_imbalance_ratio": 0.5 * heat[-1] / np.ptp(stored + heat),
    }


def at_rest() -> Known:
    """A bilinear curve with its knee at 5 mm, two gaps that shut, three modes of which two are
    axial.
    """
    x = np.linspace(0, 10e-3, 101)
    force = 40e3 * x + 4e3 * np.maximum(x - 5e-3, 0)
    gap = np.maximum(np.array([7.5e-3, 8.5e-3, 7.2e-3]) - x[:, None], 0)
    bent = StaticCurve(
        x,
        force,
        40e3 + 4e3 * (x > 5e-3),
        gap,
        0 * gap,
        np.array([1.5, 1.9, 2.5]),
        np.zeros((101, 0)),
        np.zeros(0),
    )
    modes = ModalResult(
        7e-3,
        np.array([500.0, 630.0, 1120.0]),
        np.zeros((3, 2, 3)),
        np.arange(2.0),
        np.ones(3),
        (1, 2),
    )
    found = rest_quantities(
        SpringAtRest("spring", "finite-element", 7e-3, bent, modes), ["natural_1_frequency"]
    )
    return found, {
        "preload": 288.0,
        "installed_rate": 44e3,
        "stiffness_change_compression": (5e-3, 3e-5),
        "coil_1_2_installed_gap": 0.5e-3,
        "mode_2_frequency": 1120.0,
        "natural_1_frequency": 500.0,
    }


def design() -> Known:
    """A plain helix of six turns with open ends, pressed by 5 mm; a card states its solid height."""
    d, mean, pitch, turns = 4e-3, 24e-3, 7e-3, 6.0
    wire = cylindrical(d, mean, pitch, turns, ends="open")
    wire = wire.replace(stated_solid_height=27.2e-3)
    length = turns * np.hypot(np.pi * mean, pitch)
    mass = np.pi / 4 * d**2 * length * wire.material.density
    rate = wire.material.shear_modulus * d**4 / (8 * mean**3 * turns)
    free, solid = turns * pitch + d, 27.2e-3
    return design_quantities(InstalledSpring(wire=wire, precompression=5e-3)), {
        "total_coil_count": turns,
        "active_coil_count": turns,
        "free_length": free,
        "solid_height": solid,
        "computed_solid_height": (d + turns * d * np.hypot(1.0, d / (np.pi * mean)), 1e-6),
        "solid_compression": free - solid,
        "wire_length": length,
        "wire_mass": mass,
        "largest_outer_diameter": mean + d,
        "smallest_inner_diameter": mean - d,
        "estimated_rate": rate,
        "estimated_surge_frequency": 0.5 * np.sqrt(rate / mass),
        "installed_compression": 5e-3,
        "installed_height": free - 5e-3,
        "coil_bind_lift": free - 5e-3 - solid,
    }


def cone() -> Known:
    """A cone of 3 mm wire, 30 to 18 mm: its index runs from 10 to 6."""
    wire = conical(3e-3, 30e-3, 18e-3, 8e-3, 6.0, ends="open")
    return design_quantities(InstalledSpring(wire=wire, precompression=5e-3)), {
        "smallest_index_ratio": 6.0,
        "largest_index_ratio": 10.0,
        "largest_outer_diameter": 33e-3,
        "smallest_inner_diameter": 15e-3,
    }


def card() -> Known:
    """A card says what it says; 0.5 sqrt(k / m) and the room to solid follow."""
    return design_quantities(InstalledSpring(card=CARD)), {
        "card_rate": 30e3,
        "card_preload": 270.0,
        "card_mass": 0.06,
        "card_installed_height": 36e-3,
        "card_open_force": 510.0,
        "card_open_lift": 8e-3,
        "card_solid_height": 24.5e-3,
        "card_surge_frequency": 0.5 * np.sqrt(30e3 / 0.06),
        "coil_bind_lift": 11.5e-3,
    }


def rigid_train() -> Known:
    """A direct train: contact is lost where spring less weight equals mass times deceleration,
    first at the least of their quotients.
    """
    mass, weight = 0.05 + 0.09 + 0.04 / 3, (0.05 + 0.09) * 9.80665
    angle = np.linspace(0, 2 * np.pi, 2_000_001)
    lift, bend = LAW.lift(angle), LAW.lift(angle, 2)
    risky = (bend < 0) & (lift > 0)
    squares = (300.0 + 30e3 * lift[risky] - weight) / (-mass * bend[risky])
    motion = rigid_motion(system(direct()))
    begin, end = angle[risky][[0, -1]]
    return rigid_quantities(motion) | nose_ends(motion), {
        "rigid_contact_loss_engine_speed": 2 * np.sqrt(squares.min()),
        "rigid_maximum_valve_lift": 5e-3,
        "rigid_contact_loss_cam_angle": (angle[risky][np.argmin(squares)], 1e-4),
        "rigid_nose_begin_cam_angle": (begin, 1e-3),
        "rigid_nose_end_cam_angle": (end, 1e-3),
    }


def moving_train() -> Known:
    """One cycle whose channels, gaps, touches and statistics are made up, each with a number of its
    own.
    """
    lift = np.where(degrees(90, 270), 0.9 * lift_of(ANGLE), -1e-6)
    open_part = degrees(105, 255)
    flying = lift + np.where(degrees(160, 200), 1e-3, 0.0)
    acceleration = np.zeros(COUNT)
    acceleration[[10, 20]] = 300.0, -450.0
    cam = (
        np.where(open_part, 350.0, 700.0)
        + np.where(degrees(178, 182), 33.0, 0.0)
        - np.where(degrees(200, 202), 90.0, 0.0)
        + np.where(degrees(300, 301), 50.0, 0.0)
    )
    tip = (
        np.where(open_part, 210.0, 5.0)
        + np.where(degrees(150, 151), 44.0, 0.0)
        - np.where(degrees(140, 141), 33.0, 0.0)
    )
    speed = np.where(degrees(100, 101), -12.0, np.where(degrees(240, 241), 9.0, 1.0))
    values = {
        "valve_lift": flying, "valve_acceleration": acceleration, "cam_contact_force": cam, "valve_tip_contact_force": tip,
        "cam_torque": 2.0 + 8 * np.sin(ANGLE), "lever_speed": speed, "piston_clearance": 3e-3 - 0.2 * lift_of(ANGLE),
        "cam_gap": np.where(degrees(158, 170), 2e-4, np.where(degrees(175, 202), 3e-4, -1e-5)),
        "valve_tip_gap": np.where(degrees(168, 175), 1e-4, -1e-5),
    }  # fmt: skip
    touches = [(271.0, 0.321, 8e-3, 90.0), (276.0, 0.11, 2e-4, 272.0), (279.0, 0.06, 5e-5, 277.0)]
    logged = tuple(
        Event(
            "touch",
            place * DEG,
            place * DEG / CAM_SPEED,
            0.0,
            velocity,
            "m/s",
            "seat",
            {"largest_gap": gap, "release_cam_angle": begin * DEG},
        )
        for place, velocity, gap, begin in touches
    )
    counted = {
        "cycle_work_energy": 1.7, "cycle_dissipated_energy": 1.1, "spring_dissipated_energy": 0.6,
        "contact_friction_dissipated_energy": 0.4, "steady_cycles_count": 7, "steady_residual_ratio": 3e-5,
        "steady_tolerance_ratio": 1e-4, "motion_period_count": 2,
        "peak_cam_contact_force": 1234.0, "peak_support_force": 411.0, "peak_stem_force": 412.0, "peak_pushrod_bar_force": 413.0,
        "peak_lever_bending_moment": 414.0, "wall_time_per_cycle_duration": 9.0,
    }  # fmt: skip
    made = train(logged, statistics=counted, **values)
    moved = -4e-3 * bump(np.degrees(ANGLE), 180, 90)[:, None] * np.array([0.0, 1.0, 2.0])
    with_coils = made.channels.assign(
        axial_displacement=(("sample", "wire_point"), moved, {"units": "m", "long_name": "moved"})
    )
    made = replace(made, channels=with_coils)
    found = evaluate(made, Frame(rigid=rigid())).quantities
    step, second = TIME[1] - TIME[0], DEG / CAM_SPEED
    return found, {
        "peak_rigid_valve_lift": 8e-3,
        "lift_loss_displacement": (8e-3 - 8.2e-3, 1e-6),
        "peak_valve_acceleration": 450.0,
        "valve_open_duration": (181 + 4 + 2) * second,
        "loss_of_contact_duration": (44 * second, 2 * step),
        "peak_cam_torque": 10.0,
        "minimum_cam_torque": -6.0,
        "mean_cam_power": 1.7 / (2 * np.pi / CAM_SPEED),
        "minimum_cam_contact_force": 260.0,
        "peak_open_cam_contact_force": 383.0,
        "nose_cam_contact_force": 383.0,
        "peak_cam_contact_force_cam_angle": (300 * DEG, 0.5 * DEG),
        "minimum_valve_tip_contact_force": 177.0,
        "peak_open_valve_tip_contact_force": 254.0,
        "peak_lever_speed": 12.0,
        "peak_lever_speed_valve_lift": (0.9 * 8e-3 * np.sin(10 * DEG) ** 2, 3e-5),
        "minimum_piston_clearance_gap": 1.4e-3,
        "seating_velocity": 0.321,
        "seating_cam_angle": 271 * DEG,
        "bounce_count": 2.0,
        "bounce_height": 2e-4,
        "loft_gap": 3e-4,
        "loft_count": 2.0,
        "loft_duration": (39 * second, 2 * step),
        "float_excess_lift": 1e-3 - 0.8e-3 * np.sin(70 * DEG) ** 2,
        "float_duration": (40 * second, 2 * step),
        "cycle_work_energy": 1.7,
        "cycle_dissipated_energy": 1.1,
        "spring_dissipated_energy": 0.6,
        "cycle_damper_energy": 0.6,
        "contact_friction_dissipated_energy": 0.4,
        "steady_cycles_count": 7.0,
        "steady_residual_ratio": 3e-5,
        "steady_tolerance_ratio": 1e-4,
        "motion_period_count": 2.0,
        "peak_cam_contact_force": 1234.0,
        "peak_support_force": 411.0,
        "peak_stem_force": 412.0,
        "peak_pushrod_bar_force": 413.0,
        "peak_lever_bending_moment": 414.0,
        "spring_mean_peak_section_displacement": (0.0 + 4e-3 + 8e-3) / 3,
    }


def train_on_every_step() -> Known:
    """What only the integrator saw, each number beside what the samples of the same cycle tell; a
    cam that is off twice, once as the valve
    opens from its lash of 90 degrees before."""
    opened = [
        ("cam", 130.0, 140.5, 3e-4),
        ("valve tip", 138.25, 150.0, 2e-5),
        ("cam", -5.0, 91.5, 4e-4),
        ("cam", 200.0, 201.0, 1e-6),
    ]
    touches = tuple(
        Event(
            "touch",
            end * DEG,
            end * DEG / CAM_SPEED,
            0.0,
            0.1,
            "m/s",
            where,
            {"largest_gap": gap, "release_cam_angle": begin * DEG},
        )
        for where, begin, end, gap in (*opened, ("seat", 91.0, 268.5, 8e-3))
    )
    seen = {
        "peak_spring_force": 701.0, "minimum_spring_force": 201.0, "peak_retainer_force": 702.0, "minimum_retainer_force": 202.0,
        "raw_peak_spring_force": 901.0, "raw_peak_retainer_force": 902.0, "raw_peak_spring_force_cam_angle": 1.75,
        "raw_peak_spring_force_duration": 8e-6, "raw_peak_retainer_force_duration": 9e-6,
        "peak_spring_force_cam_angle": 1.25, "minimum_spring_force_cam_angle": 1.5, "peak_valve_acceleration": 9e3,
        "peak_valve_lift": 8.001e-3, "peak_cam_torque": 21.0, "minimum_cam_torque": -13.0, "peak_lever_speed": 31.0,
        "nose_cam_contact_force": 511.0, "peak_cam_contact_force_cam_angle": 1.9,
    }  # fmt: skip
    places = {"cam": (0.0, 811.0), "valve_tip": (32.0, 812.0)}
    statistics = seen | {"peak_lever_speed_cam_angle": 120 * DEG, "contacts_logged_ratio": 1.0}
    for place, (least, largest) in places.items():
        statistics |= {
            f"least_{place}_contact_force": least,
            f"open_{place}_contact_force": largest,
        }
    channels = {
        "valve_lift": lift_of(ANGLE), "lever_speed": np.sin(ANGLE), "cam_torque": np.sin(ANGLE),
        "cam_gap": np.where(degrees(0, 91), 3e-6, -1e-5),
    }  # fmt: skip
    found = evaluate(
        train(touches, statistics=statistics, **channels),
        Frame(rigid=rigid(), permitted_seating_velocity=0.3),
    ).quantities
    second = DEG / CAM_SPEED
    return found, seen | {
        "lift_loss_displacement": 8e-3 - 8.001e-3,
        # wide open any gap of a contact that carries no force at some step is a loss; the tip always carries some
        "loss_of_contact_duration": (10.5 + 1) * second,
        "loft_duration": (10.5 + 1) * second,
        "loft_count": 2.0,
        "permitted_seating_velocity": 0.3,
        "loft_gap": 3e-4,
        "valve_open_duration": 177.5 * second,
        "minimum_cam_contact_force": 0.0,
        "peak_open_cam_contact_force": 811.0,
        "minimum_valve_tip_contact_force": 32.0,
        "peak_open_valve_tip_contact_force": 812.0,
        "peak_lever_speed_valve_lift": (8e-3 * 0.25, 1e-6),
    }


def sweep() -> Known:
    """Measures that pass zero at 690, 745 and 801 rad/s: the roots are met to a relative 1e-6."""
    edges = {"contact-loss": 690.3, "float": 745.1, "bounce": 801.7}

    def look(engine_speed: float, orbit: object, precise: bool) -> SpeedSample:
        return SpeedSample({kind: edge - engine_speed for kind, edge in edges.items()})

    scan = Scan(look, 0.5)
    for speed in np.arange(600.0, 901.0, 50.0).tolist():
        scan.at(speed)
    found = {
        KINDS[kind]: critical_speed(kind, scan, "own", CriticalOptions()).engine_speed
        for kind in edges
    }
    return found, {
        "contact_loss_engine_speed": (690.3, 1e-3),
        "float_engine_speed": (745.1, 1e-3),
        "bounce_engine_speed": (801.7, 1e-3),
    }


def scatter() -> Known:
    """What the integrator found to differ from cycle to cycle stands under the name of the number
    that differs.
    """
    words = (
        "peak_valve_lift",
        "peak_spring_force",
        "raw_peak_spring_force",
        "raw_peak_retainer_force",
        "minimum_spring_force",
        "peak_retainer_force",
        "minimum_retainer_force",
        "loft_gap",
        "peak_cam_contact_force",
        "seating_velocity",
        "bounce_count",
        "bounce_height",
        "cycle_work_energy",
        "peak_valve_acceleration",
        "nose_cam_contact_force",
        "minimum_cam_contact_force",
    )
    numbers = {word: 0.5 + place for place, word in enumerate(words)}
    made = train(statistics=Scatter(1.25e-4, 8e-3, numbers).statistics)
    known = {f"cycle_scatter_{word}": value for word, value in numbers.items()} | {
        "cycle_scatter_valve_lift": 1.25e-4
    }
    return evaluate(made, Frame(rigid=rigid())).quantities, known


GROUPS = (
    forces, bandwidth, surge, stress, clashes, energies, at_rest, design, cone, card, rigid_train, moving_train,
    train_on_every_step, sweep, scatter,
    valve_events, rigid_valve_events, surge_speeds, *REST_GROUPS,
)  # fmt: skip
