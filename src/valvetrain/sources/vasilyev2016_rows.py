"""Quantities of the valve gear study: the motion of a spring's sections, which its figure 3 shows."""

from __future__ import annotations

from valvetrain.solution.definition import QuantityRow, row

QUANTITIES: tuple[QuantityRow, ...] = (
    row("{spring}_mean_peak_section_displacement", "mean peak motion of the coils ({spring})",
        "Mean along the spring ({spring}) of each section's largest displacement over the cycle.", sense="smaller is better",
        systems=("train",)),
)  # fmt: skip
