"""Quantities of the published studies on simple systems whose every number is known from a formula."""

from __future__ import annotations

import numpy as np
from scipy import signal

from known_quantities import CAM_RATE, DEG, Known, level
from synthetic_spring import EVENT, bump, clashing_run, run
from valvetrain.quantities.cycle import Frame
from valvetrain.quantities.evaluate import evaluate
from valvetrain.solution.provenance import CaseRecord, Provenance, PublishedValue
from valvetrain.solution.result import Solution, empty_channels
from valvetrain.solution.study import Study
from valvetrain.sources.contract import MULTIBODY4B17


def stages() -> Known:
    """A force drawn of bumps: each stage of the beehive's study has its peaks where they were
    drawn, read at four phases that stand 0, 1, 3 and 2 N higher and an eighth of a degree apart.
    """

    def force(degrees):
        first = (
            30 * bump(degrees, 12, 20)
            + 31 * bump(degrees, 42, 20)
            + 40 * bump(degrees, 84.5, 20)
            - 15 * bump(degrees, 65, 12)
        )
        event = (
            640 * bump(degrees, 160, 24)
            + 900 * bump(degrees, 190, 28)
            + 77 * bump(degrees, 234, 20)
            - 50 * bump(degrees, 174, 3)
        )
        return 280 + first + event + 500 * bump(degrees, 254.5, 4) + 200 * bump(degrees, 297, 4)

    def fine(degrees):
        return force(degrees)[:, None] + np.array([0.0, 1.0, 3.0, 2.0])

    made = run(
        {"seat_force": force, "seat_force_fine": fine},
        extra={"seat_force_fine": (("subsample",), "N", "made up")},
    )
    found = evaluate(made, Frame(source="gu2021", lift_event=EVENT)).quantities
    higher, later = (
        1.5,
        0.25 * DEG,
    )  # median of the heights; the angle is that of a phase, the upper of the middle two
    end, before = (280 + 77 * np.cos(np.pi * away / 20) ** 2 for away in (1.0, 1.5))
    return found, {
        "stage_1_minimum_force": 265.0 + higher,
        "stage_1_force_range": 55.0,
        "stage_1_maximum_force": 320.0 + higher,
        "stage_1_peak_1_cam_angle": 12 * DEG,
        "stage_1_peak_2_cam_angle": 42 * DEG,
        "stage_2_peak_force": 1180.0 + higher,
        "stage_2_peak_cam_angle": 190 * DEG + later,
        "stage_2_first_peak_force": 920.0 + higher,
        "stage_2_first_peak_cam_angle": 160 * DEG + later,
        "stage_2_valley_force": 230.0 + higher,
        "stage_2_valley_cam_angle": 174 * DEG + later,
        "stage_2_second_peak_force": 1180.0 + higher,
        "stage_2_second_peak_cam_angle": 190 * DEG + later,
        "stage_2_end_force": np.median([end, end + 1, before + 3, before + 2]),
        "stage_3_peak_force": 780.0 + higher,
        "stage_3_least_sampled_peak_force": 780.0,
        "stage_3_largest_sampled_peak_force": 783.0,
        "stage_3_peak_cam_angle": 254.5 * DEG + later,
        "stage_3_every_instant_peak_force": 783.0,
        "stage_3_second_peak_cam_angle": 297 * DEG + later,
    }


def spike() -> Known:
    """A triangle of 500 N over four degrees: half of them at half its height, and its area."""

    def force(degrees):
        return 280 + 500 * np.maximum(0.0, 1 - abs(degrees - 254.5) / 2)

    def fine(degrees):
        return np.stack([force(degrees + 0.125 * place) for place in range(4)], axis=1)

    made = run(
        {"seat_force": force, "seat_force_fine": fine},
        extra={"seat_force_fine": (("subsample",), "N", "made up")},
    )
    return evaluate(made, Frame(source="gu2021", lift_event=EVENT)).quantities, {
        "stage_3_peak_duration": 2 * DEG / CAM_RATE,
        "stage_3_peak_impulse": 500 * 2 * DEG / CAM_RATE,
    }


def burst() -> Known:
    """A burst of 5 kHz and 20 N on a level force is all that is left between 2.5 and 10 kHz."""

    def force(degrees):
        away = degrees - 250
        return 300 + 20 * np.cos(np.radians(107 * away)) * np.exp(-((away / 8) ** 2))

    found = evaluate(
        run({"seat_force": force}), Frame(source="gu2021", lift_event=EVENT)
    ).quantities
    return found, {
        "stage_3_above_2500_hz_peak_force": (20.0, 0.2),
        "stage_3_above_2500_hz_peak_cam_angle": (250 * DEG, 0.5 * DEG),
    }


def node() -> Known:
    """Motion of the end of coil 2 drawn of bumps, at a wire point of its own; coil 1 moves by other
    numbers.
    """

    def both(one, two):
        return lambda degrees: np.stack([one(degrees), two(degrees)], axis=1)

    def velocity(degrees):
        slow = (
            0.5 * bump(degrees, 60, 30)
            - 0.7 * bump(degrees, 90, 30)
            + 1.1 * bump(degrees, 150, 20)
            - 1.2 * bump(degrees, 200, 20)
        )
        fast = (
            1.0 * bump(degrees, 236, 4)
            - 1.35 * bump(degrees, 241.5, 4)
            + 0.6 * bump(degrees, 245, 3)
        )
        return slow + fast - 0.9 * bump(degrees, 280, 4) + 0.8 * bump(degrees, 300, 10)

    def lift_off(degrees):
        return 2e-6 + 2e-4 * bump(degrees, 50, 40) + 7e-4 * bump(degrees, 243, 10)

    def spikes(degrees, scale):
        return scale * (
            1e4 * bump(degrees, 245.5, 3) - 8e3 * bump(degrees, 60, 3) + 6e3 * bump(degrees, 150, 3)
        )

    values = {
        "seat_force": level(300.0), "axial_velocity": both(level(0.0), velocity), "coil_gap": both(level(1e-3), lift_off),
        "axial_displacement": both(level(-9e-3), lambda degrees: -3e-3 * bump(degrees, 180, 106)),
        "coil_contact_force": both(level(0.0), lambda degrees: 55.0 * (np.abs(degrees - 180) < 20.2)),
        "axial_acceleration": both(lambda degrees: spikes(degrees, 0.5), lambda degrees: spikes(degrees, 1.0)),
    }  # fmt: skip
    made = run(values, coil_number=[1.0, 2.0], upper_coil=[1.0, 2.0])
    found = evaluate(made, Frame(source="gu2021", lift_event=EVENT)).quantities
    return found, {
        "node_2_contact_displacement": 3e-3 * np.cos(np.pi * 20 / 106) ** 2,
        "node_2_maximum_displacement": 7.02e-4,
        "node_2_maximum_displacement_cam_angle": 243 * DEG,
        "node_2_stage_1_maximum_displacement": 2.02e-4,
        "node_2_stage_1_displacement_range": 2e-4,
        "node_2_stage_1_minimum_velocity": -0.7,
        "node_2_stage_1_minimum_velocity_cam_angle": 90 * DEG,
        "node_2_stage_1_maximum_velocity": 0.5,
        "node_2_stage_2_maximum_velocity_cam_angle": 150 * DEG,
        "node_2_stage_2_maximum_velocity": 1.1,
        "node_2_stage_2_minimum_velocity": -1.2,
        "node_2_stage_1_velocity_range": 1.2,
        "node_2_stage_3_minimum_velocity": -1.35,
        "node_2_stage_3_maximum_velocity": 1.0,
        "node_2_late_stage_3_minimum_velocity": -0.9,
        "node_2_late_stage_3_maximum_velocity": 0.8,
        "node_2_rebound_velocity": 0.6,
        "node_2_rebound_velocity_cam_angle": 245 * DEG,
        "node_2_rebound_duration": 3.5 * DEG / CAM_RATE,
        "node_2_peak_acceleration": 1e4,
        "node_2_peak_acceleration_cam_angle": 245.5 * DEG,
        "node_1_peak_acceleration": 5e3,
        "node_2_second_peak_acceleration": -8e3,
        "node_2_second_peak_acceleration_cam_angle": 60 * DEG,
        "node_2_third_peak_acceleration": 6e3,
        "node_2_third_peak_acceleration_cam_angle": 150 * DEG,
    }


def collisions() -> Known:
    """Coil 2 meets coil 1 at 20, 46, 72, 245.5 and 272 degrees, 25 % off one period; after 245.5,
    where the spike is, it meets again 4 degrees later.
    """
    touched = [(20, 22), (46, 48), (72, 74), (245.5, 246.5), (249.5, 251), (272, 274)]

    def gap(degrees):
        shut = np.any([(degrees >= first) & (degrees < last) for first, last in touched], axis=0)
        return np.where(shut, -1e-7, 1e-5)[:, None]

    def force(degrees):
        return 300 + 200 * bump(degrees, 246, 2)

    made = run({"seat_force": force, "coil_gap": gap}, upper_coil=[2.0])
    mean = (26 + 26 + 26.5) / 3
    surge_frequency = 1.25 * CAM_RATE / (mean * DEG)
    found = evaluate(
        made, Frame(source="gu2021", lift_event=EVENT, surge_frequencies=(surge_frequency,))
    ).quantities
    return found, {
        "clash_1_cam_angle": 20 * DEG,
        "clash_4_cam_angle": 245.5 * DEG,
        "clash_interval_cam_angle": mean * DEG,
        "clash_interval_to_mode_1_period_ratio": 1.25,
        "coil_1_2_bounce_start_cam_angle": 245.5 * DEG,
        "coil_1_2_bounce_end_cam_angle": 249.5 * DEG,
        "coil_1_2_bounce_duration": 4 * DEG / CAM_RATE,
    }


def main_clash() -> Known:
    """A bump of 400 N over 3 degrees at 250 on 300 N: height, angle and the area A w / 2 of the
    cosine squared within 0.1 ms.
    """
    closed = 360 - 106 * (
        1 - 2 / np.pi * np.arcsin(np.sqrt(1e-3))
    )  # degrees with less than a thousandth of the lift
    above = 400 * 1.5 / closed  # by which the spike itself raises the mean that it is counted from
    held = 400 * 1.5 * DEG / CAM_RATE - above * 2e-4
    made = clashing_run(2880)
    found = evaluate(
        made, Frame(source="gu2021", lift_event=EVENT, surge_frequencies=(600.0,))
    ).quantities
    series, step = made.channel("seat_force_fine").ravel(), made.time[1] / 4
    last = slice(
        4 * 2880 * 601 // 360, 4 * 2880 * 659 // 360
    )  # 241 to 299 degrees of the second turn
    filters = (signal.butter(4, 2 * cutoff * step, output="sos") for cutoff in (5e3,))
    heights = [float(np.max(signal.sosfiltfilt(one, series)[last])) for one in filters]
    return found, {
        "main_clash_peak_force": 700.0,
        "main_clash_cam_angle": (250 * DEG, 2e-4),
        "main_clash_impulse": (held, 0.002 * held),
        "main_clash_below_5_khz_peak_force": (heights[0], 0.5),
        "stage_3_below_5_khz_peak_force": (heights[0], 0.5),
    }


def pushrod_study() -> Known:
    """Stock and performance springs side by side, each with numbers of its own."""
    numbers = {
        "stock, as printed": (283.0, 9.1e-3, 1.0, 0.0, 284.0), "performance, as printed": (400.0, 8.9e-3, 6.7, 4.4e-3, 401.0),
        "performance, as printed, zeta 1": (412.0, 8.8e-3, 2.0, 0.0, 830.0), "stock": (574.0, 9.0e-3, 3.0, 0.0, 575.0),
    }  # fmt: skip
    names = (
        "nose_cam_contact_force",
        "peak_valve_lift",
        "peak_lever_speed",
        "peak_lever_speed_valve_lift",
        "peak_open_cam_contact_force",
    )
    runs = tuple(
        Solution(
            empty_channels(),
            quantities=dict(zip(names, values, strict=True)),
            provenance=Provenance("pushrod", "massless", 100.0, label=label, system="train"),
        )
        for label, values in numbers.items()
    )
    printed = (
        PublishedValue("contact_force_rise_ratio", 0.4, "", engine_speed=100.0, model="as printed"),
    )
    study = Study(CaseRecord("pushrod", study="multibody4b17", published=printed), solutions=runs)
    return {key.name: value for key, value in MULTIBODY4B17.of_runs(study).items()}, {
        "stock_nose_cam_contact_force": 283.0,
        "performance_nose_cam_contact_force": 400.0,
        "performance_damped_nose_cam_contact_force": 412.0,
        "performance_damped_peak_cam_contact_force": 830.0,
        "contact_force_rise_ratio": 400 / 283 - 1,
        "stock_peak_valve_lift": 9.1e-3,
        "performance_lift_difference_displacement": 0.2e-3,
        "peak_lever_speed": 6.7,
        "peak_lever_speed_valve_lift": 4.4e-3,
    }


SOURCE_GROUPS = (stages, spike, burst, node, collisions, main_clash, pushrod_study)
