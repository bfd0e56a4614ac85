"""Rows of the quantities of the published studies; each study is described in its own module."""

from __future__ import annotations

from functools import partial

from valvetrain.solution.definition import QuantityRow, Systems, row

_row = partial(row, systems=("spring",))


def _both(name: str, label: str, definition: str) -> tuple[QuantityRow, QuantityRow]:
    """A row and the one of its cam angle."""
    return _row(name, label, definition), _row(
        f"{name}_cam_angle", f"{label}, cam angle", f"Cam angle of the {label}."
    )


def _force(place: str, label: str, definition: str) -> tuple[QuantityRow, QuantityRow]:
    """A force and its cam angle, which share the name of the place: ``stage_2_peak_force``,
    ``stage_2_peak_cam_angle``.
    """
    angle = _row(f"{place}_cam_angle", f"{label}, cam angle", f"Cam angle of the {label} force.")
    return _row(f"{place}_force", f"{label} force", definition), angle


_STAGES = (
    _row("stage_1_minimum_force", "Stage I minimum force", "Smallest force in Stage I."),
    _row("stage_1_maximum_force", "Stage I largest force", "Largest force in Stage I."),
    _row("stage_1_force_range", "Stage I range of the force", "Largest less smallest force in Stage I."),
    _row("stage_1_peak_{n}_cam_angle", "Stage I peak {n}, cam angle",
         "Cam angle of local force maximum {n} in Stage I that exceeds the oscillation."),
    *_force("stage_2_peak", "Stage II peak", "Largest force in Stage II."),
    *_force("stage_2_first_peak", "Stage II first peak",
            "First of two force maxima in the upper half of Stage II's forces: the largest sample within 3 degrees of the maximum below 2.5 kHz."),
    *_force("stage_2_valley", "Stage II valley", "Smallest force between the two maxima of Stage II."),
    *_force("stage_2_second_peak", "Stage II second peak", "Second of the two force maxima in Stage II."),
    _row("stage_2_end_force", "Stage II end force", "Force at the end of Stage II."),
    *_force("stage_3_peak", "Stage III peak",
            "Largest force in Stage III after the coils are released (the clash spike), at samples of 0.5 cam degrees as the source stored "
            "its own: the median over their phase; where the run's record is no finer, at its own samples."),
    _row("stage_3_least_sampled_peak_force", "Stage III peak force, least over the phase of samples",
         "The same spike at samples of 0.5 cam degrees whose phase finds the least of it."),
    _row("stage_3_largest_sampled_peak_force", "Stage III peak force, largest over the phase of samples",
         "The same spike at samples of 0.5 cam degrees whose phase finds the most of it."),
    _row("stage_3_peak_duration", "Stage III peak, time at half height",
         "Time that the spike of Stage III is above half its height over its foot, the median force around it."),
    _row("stage_3_peak_impulse", "Stage III peak, impulse", "Integral over time of that spike's force above its foot."),
    _row("stage_3_every_instant_peak_force", "Stage III peak force, every instant",
         "The same spike at the highest instant of the whole record, for runs that keep every substep."),
    _row("stage_3_below_5_khz_peak_force", "Stage III peak force below 5 kHz",
         "Largest force in Stage III after a zero-phase low pass (6 dB down at 5 kHz), as an instrument of that bandwidth shows it."),
    _row("stage_3_second_peak_cam_angle", "Stage III second spike, cam angle", "Cam angle of the second clash spike in Stage III."),
)  # fmt: skip

_NODES = (
    _row("node_2_contact_displacement", "displacement of node 2 at contact",
         "Compressive displacement of node 2 from the installed state at which coil 2 meets coil 1 in Stage II."),
    *_both("node_2_maximum_displacement", "largest displacement of node 2",
           "Largest displacement of node 2, zero where coil 2 touches coil 1."),
    _row("node_2_stage_1_maximum_displacement", "largest displacement of node 2 in Stage I",
         "Largest displacement of node 2 in Stage I, zero where coil 2 touches coil 1."),
    _row("node_2_stage_1_displacement_range", "displacement range of node 2 in Stage I", "Displacement range of node 2 in Stage I."),
    *_both("node_2_stage_{s}_minimum_velocity", "minimum velocity of node 2 in stage {s}", "Smallest velocity of node 2 in stage {s}."),
    *_both("node_2_stage_{s}_maximum_velocity", "largest velocity of node 2 in stage {s}", "Largest velocity of node 2 in stage {s}."),
    _row("node_2_stage_1_velocity_range", "velocity range of node 2 in Stage I", "Velocity of node 2 in Stage I, peak to peak."),
    _row("node_2_late_stage_3_minimum_velocity", "minimum velocity of node 2 late in Stage III",
         "Smallest velocity of node 2 in Stage III after the first clash."),
    _row("node_2_late_stage_3_maximum_velocity", "largest velocity of node 2 late in Stage III",
         "Largest velocity of node 2 in Stage III after the first clash."),
    *_both("node_2_rebound_velocity", "rebound velocity of node 2",
           "First maximum of the velocity of node 2 after its minimum in Stage III."),
    _row("node_2_rebound_duration", "rebound time of node 2",
         "Time from the minimum of the velocity of node 2 in Stage III to its first maximum after."),
    *_both("node_{n}_peak_acceleration", "node {n} peak acceleration", "Acceleration of node {n} of largest size, signed."),
    *_both("node_{n}_second_peak_acceleration", "node {n} second peak acceleration",
           "The next largest acceleration of node {n}, signed, of another collision."),
    *_both("node_{n}_third_peak_acceleration", "node {n} third peak acceleration",
           "The third largest acceleration of node {n}, signed, of a third collision."),
)  # fmt: skip

_COLLISIONS = (
    _row("coil_1_2_bounce_start_cam_angle", "bounce of coils 1 and 2, start",
         "Cam angle at which coils 1 and 2 meet in the collision of the spike of Stage III: of the points within half a turn of node 2 "
         "that leave and meet again, the one that is pressed hardest at the spike's top."),
    _row("coil_1_2_bounce_end_cam_angle", "bounce of coils 1 and 2, end", "Cam angle at which they meet again after a time apart."),
    _row("coil_1_2_bounce_duration", "bounce of coils 1 and 2, time", "Time between their meeting and meeting again."),
    _row("clash_{k}_cam_angle", "collision {k} of coils 1 and 2, cam angle",
         "Cam angle of collision {k} of coils 1 and 2 in the cycle, counted from 0 degrees: first touch of any point within half a turn "
         "of node 2, or a spike of the acceleration in models without coil gaps."),
    _row("clash_interval_cam_angle", "interval of collisions",
         "Mean distance of successive collisions outside Stage II, one that did not show left out."),
    _row("clash_interval_to_mode_1_period_ratio", "interval of collisions over the period of mode 1",
         "That distance as a time, over the period of the first axial mode."),
    _row("main_clash_peak_force", "main clash",
         "Height of the main clash of coils 1 and 2: first spike of the force after the event that reaches 60 % of the highest (found "
         "below 16 times the surge frequency), as computed; absent where no coil meets another."),
    _row("main_clash_below_5_khz_peak_force", "main clash below 5 kHz", "Height of the main clash in a bandwidth of 5 kHz."),
    _row("main_clash_cam_angle", "main clash, cam angle", "Cam angle of the top of the main clash below 16 times the surge frequency."),
    _row("main_clash_impulse", "main clash, impulse",
         "Integral of the force above the base circle's mean over a sixteenth of the surge period (0.1 ms) either side of the main clash."),
)  # fmt: skip

GU2021_QUANTITIES: tuple[QuantityRow, ...] = (*_STAGES, *_NODES, *_COLLISIONS)


_TRAIN: Systems = ("train",)

MULTIBODY4B17_QUANTITIES: tuple[QuantityRow, ...] = (
    row("stock_nose_cam_contact_force", "cam contact force at the nose, stock spring", "Cam contact force at the nose, stock spring.",
        systems=_TRAIN),
    row("performance_nose_cam_contact_force", "cam contact force at the nose, performance spring",
        "Cam contact force at the nose, performance spring.", systems=_TRAIN),
    row("performance_damped_nose_cam_contact_force", "cam contact force at the nose, performance spring, zeta 1",
        "Cam contact force at the nose, performance spring, with the valve damper of zeta = 1.", systems=_TRAIN),
    row("performance_damped_peak_cam_contact_force", "peak cam contact force, performance spring, zeta 1",
        "Largest cam contact force while the valve is open, performance spring, with the valve damper of zeta = 1.", systems=_TRAIN),
    row("contact_force_rise_ratio", "rise of the cam contact force",
        "Share by which the performance spring raises the cam contact force at the nose.", systems=_TRAIN),
    row("stock_peak_valve_lift", "peak valve lift, stock spring", "Largest valve lift with the stock spring.", systems=_TRAIN),
    row("performance_lift_difference_displacement", "lift lost with the performance spring",
        "Largest valve lift with the stock spring less that with the performance spring.", systems=_TRAIN),
    row("contact_formula_force", "contact force by the source's formula", "The source's equation 5 at 0.02 mm, evaluated as printed.",
        systems=_TRAIN),
    row("lumped_natural_frequency", "natural frequency of the lumped train",
        "All masses as one on the rate of the performance spring (the source's equation 8).", systems=_TRAIN),
    row("critical_damping", "critical damping of the lumped train", "Twice the root of rate times mass (the source's equation 10).",
        systems=_TRAIN, dimension="damping", shown_unit="N s/m"),
    row("stock_spring_rate", "rate of the stock spring",
        "Difference of the two printed loads over the printed lift (the source's table 2).", systems=_TRAIN),
    row("performance_spring_rate", "rate of the performance spring",
        "Difference of the two printed loads over the printed lift (the source's table 2).", systems=_TRAIN),
    row("lumped_mass", "mass of the lumped train", "Sum of the printed masses of valve, rocker and pushrod.", systems=_TRAIN),
    row("lumped_angular_speed", "natural angular frequency of the lumped train",
        "The natural frequency of the lumped train in rad/s (the source's equation 8).", systems=_TRAIN, shown_unit="rad/s"),
    row("cam_turn_frequency", "cam revolutions per second", "Cam revolutions per second in the runs compared (the source's equation 9).",
        systems=_TRAIN),
)  # fmt: skip


VASILYEV2016_QUANTITIES: tuple[QuantityRow, ...] = (
    row("{spring}_mean_peak_section_displacement", "mean peak motion of the coils ({spring})",
        "Mean along the spring ({spring}) of each section's largest displacement over the cycle.", sense="smaller is better",
        systems=("train",)),
)  # fmt: skip
