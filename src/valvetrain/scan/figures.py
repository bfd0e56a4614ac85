"""Figures of a scanned spring: its points about the axis, its curves over the coil, and its forces next to the design's."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
from numpy.typing import ArrayLike

from valvetrain.scan.rules import ScanFacts
from valvetrain.views.style import LEAD, RIGID, SECOND, band, dots, line, panels, styled

#: Scan and design: name, colour and dash of their lines. The dashed ones are drawn last, so that they are seen on the others.
LOOKS = (("scan", LEAD, "solid"), ("design", SECOND, "dash"))


def cloud(facts: ScanFacts) -> go.Figure:
    """Points of the scan and the wire axis, unrolled about the axis of the spring: angle (deg) and height (mm)."""
    scan, curves = facts.scan, facts.scan.curves
    across = np.cross(scan.axis_direction, np.roll(scan.axis_direction, 1))
    frame = np.array([across, np.cross(scan.axis_direction, across), scan.axis_direction])
    fine = np.linspace(0.0, curves.coil[-1], 2000)
    wire = np.array([np.interp(fine, curves.coil, curve) for curve in curves.centre_line.T])
    shown = (frame @ (points - scan.axis_point[:, None]) for points in (scan.shown.T, wire))
    low = frame[2] @ (curves.centre_line[0] - scan.axis_point) - curves.height[0]
    looks = (("points of the scan", RIGID), ("fitted wire axis", LEAD))
    fig = go.Figure([
        dots(np.degrees(np.arctan2(y, x)) % 360, 1e3 * (z - low), *look) for (x, y, z), look in zip(shown, looks, strict=True)
    ])  # fmt: skip
    size = scan.section.diameter[0]
    styled(fig, "angle about the axis, deg", ("height, mm",), 420)
    fig.update_yaxes(range=[-1e3 * size, 1e3 * (scan.free_length[0] + size)])
    return fig.update_xaxes(range=[0, 360], dtick=60)


def curves(facts: ScanFacts) -> go.Figure:
    """Mean diameter, height, pitch and wire diameter (mm) over the coil with their band of 95 %, less the design's where
    there is one.
    """
    scan, over, design = facts.scan, facts.scan.curves, facts.design
    coil, (turn, wire, wire_spread, _) = over.coil, scan.section.turns.T
    drawn: tuple[ArrayLike, ...] = (0.0,) * 4 if design is None else (
        design.mean_diameter.value(coil), design.axial_position(coil) - design.lower_seat_height, design.pitch.value(coil),
        design.wire_diameter.value(turn),
    )  # fmt: skip
    rows = (
        ("diameter", coil, over.mean_diameter, over.mean_diameter_spread), ("height", coil, over.height, over.height_spread),
        ("pitch", coil, over.pitch, over.pitch_spread), ("wire", turn, wire, wire_spread),
    )  # fmt: skip
    fig = panels((0.25,) * 4)
    for row, ((_, at, values, spread), law) in enumerate(zip(rows, drawn, strict=True), 1):
        off = 1e3 * np.subtract(values, law)
        for curve in band(at, off - 2e3 * spread, off + 2e3 * spread, "95 %"):
            fig.add_trace(curve.update(showlegend=bool(curve.name) and row == 1), row, 1)
        fig.add_trace(line(at, off, *LOOKS[0], showlegend=row == 1), row, 1)
    return styled(fig, "coil, from the lower tip", tuple(f"{curve[0]}, mm" for curve in rows), 560)  # fmt: skip


def force(facts: ScanFacts) -> go.Figure | None:
    """Force (N) and rate (N/mm) of design and scan over the height between the seats (mm)."""
    fig = panels((0.6, 0.4))
    assert facts.compared is not None
    pairs = zip(facts.compared.rest[::-1], facts.compared.cases[::-1], LOOKS, strict=True)
    for study, case, look in pairs:
        curve, spring = study.rest[0].curve, case.springs[0]
        if curve is None or spring.installed_height is None:
            return None
        path = curve.path or curve
        height = 1e3 * (spring.installed_height + spring.precompression - path.compression)
        fig.add_trace(line(height, path.force, *look), 1, 1)
        fig.add_trace(line(height, 1e-3 * path.stiffness, *look, showlegend=False), 2, 1)
    return styled(fig, "height between the seats, mm", ("force, N", "rate, N/mm"), 420)
