"""Quantities of the pushrod study: its stock and performance springs side by side, and its closed forms evaluated as printed."""

from __future__ import annotations

from valvetrain.solution.definition import QuantityRow, Systems, row

_TRAIN: Systems = ("train",)

QUANTITIES: tuple[QuantityRow, ...] = (
    row("stock_nose_cam_contact_force", "cam contact force at the nose, stock spring", "Cam contact force at the nose, stock spring.",
        systems=_TRAIN),
    row("performance_nose_cam_contact_force", "cam contact force at the nose, performance spring",
        "Cam contact force at the nose, performance spring.", systems=_TRAIN),
    row("performance_damped_nose_cam_contact_force", "cam contact force at the nose, performance spring, zeta 1",
        "Cam contact force at the nose, performance spring, with the valve damper of zeta = 1.", systems=_TRAIN),
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
    row("cam_turn_frequency", "turns of the cam per second", "Turns of the cam per second in the runs compared (the source's equation 9).",
        systems=_TRAIN),
)  # fmt: skip
