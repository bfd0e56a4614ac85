"""Static curve: force and stiffness over compression, coils closing."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from valvetrain.parameters.case import PublishedValue
from valvetrain.report import theme
from valvetrain.report.chart import Chart, Line, Marks, Panel, Rule, thin
from valvetrain.report.table import Table, table
from valvetrain.solution.static import StaticCurve


def static_table(curve: StaticCurve) -> Table:
    """``compression`` (mm), ``force`` (N), ``stiffness`` (N/mm), ``closed pairs`` (turns of wire lying on the turn below)."""
    pairs = curve.coil_gap.shape[1]
    span = float(np.ptp(curve.upper_coil)) / max(pairs - 1, 1) if pairs else 0.0
    closed = np.sum(curve.coil_contact_force > 0, axis=1) * span
    return table(
        ("compression", "mm", curve.compression * 1e3), ("force", "N", np.asarray(curve.force)),
        ("stiffness", "N/mm", curve.stiffness * 1e-3), ("closed turns", "", closed.astype(float)),
    )  # fmt: skip


def static_chart(data: Table, published: Sequence[PublishedValue], precompression: float) -> Chart:
    """Force left, tangent stiffness right; the published preload and stiffness change marked; ``precompression`` in m."""
    values = {value.quantity: value for value in published if value.engine_speed is None}
    colour, x_label = theme.model_colour("finite-element"), "compression from the free length (mm)"
    installed = precompression * 1e3
    rules = [Rule("x", installed, f"installed, {installed:g} mm")]
    force: list = [Line(*thin(data["compression"], data["force"]), theme.model_words("finite-element"), colour)]
    if "preload" in values:
        sign, words, dark, symbol = theme.origin_style(values["preload"].model)
        preload = values["preload"].value
        force.append(Marks(np.array([installed]), np.array([preload]), words, dark, symbol, (f"{sign} {preload:g} N",)))
    change = values.get("stiffness_change_compression")
    knees = [] if change is None else [Rule("x", change.value * 1e3, f"published change, {change.value * 1e3:g} mm")]
    stiffness = Line(*thin(data["compression"], data["stiffness"]), theme.model_words("finite-element"), colour)
    upright, low_high = (*rules, *knees), _round_range(data["stiffness"])
    panels = (
        Panel(x_label, "force (N)", tuple(force), title="Force", rules=tuple(rules)),
        Panel(x_label, "tangent stiffness (N/mm)", (stiffness,), title="Stiffness k(x)", rules=upright, y_range=low_high),
    )
    caption = (
        "Static compression from the free length, coils closing on the way. The stiffness rises where turns come to lie on the one below; "
        "the modal model takes its k(x) from this curve."
    )
    return Chart("static", "Static curve", caption, panels, columns=2, height=380)


def _round_range(stiffness: np.ndarray) -> tuple[float, float]:
    """From nought, and without the wall of the solid spring, which would flatten all else."""
    usual = float(np.median(stiffness))
    return 0.0, float(min(np.max(stiffness), 4 * usual) * 1.08)
