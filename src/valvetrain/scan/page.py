"""The page of a scanned spring: what was measured, with figures, and the design next to it."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.report import theme
from valvetrain.report.chart import Chart, Layer, Line, Marks, Panel, stems, thin
from valvetrain.report.files import spring_text
from valvetrain.report.page import Block, Cell, Figure, Grid, Page, Section, figure_or_gap, text
from valvetrain.report.study import StudyFiles, with_page
from valvetrain.report.text import number, percent, speed_text, unit_text
from valvetrain.report.verdict import verdict_of
from valvetrain.scan.compare import ComparedNumber, ScanComparison
from valvetrain.scan.result import ScannedSpring
from valvetrain.solution.atomic import write_text
from valvetrain.solution.definition import definition_of, label_of, shown
from valvetrain.solution.study import Study

Array = NDArray[np.float64]
SCANNED = "3-D scan"
SCAN, DESIGN = theme.SERIES[0], theme.SERIES[1]
#: Points shown of the cloud and of the section, and bars of the residuals.
CLOUD, SECTION, BARS = 1500, 1200, 48
COIL = "coil, from the lower tip (turns)"


def wire_in_frame(scan: ScannedSpring) -> Array:
    """Wire axis (n, 3) in the frame that the shown points have, in m."""
    curves = scan.curves
    fine = np.linspace(0.0, curves.coil[-1], 60 * int(np.ceil(curves.coil[-1])))
    line = np.column_stack(
        [np.interp(fine, curves.coil, curves.centre_line[:, axis]) for axis in range(3)]
    )
    along = (line - scan.axis_point) @ scan.axis_direction
    # chords between stations cut the coil; the radius is put back
    radial = line - scan.axis_point - along[:, None] * scan.axis_direction
    radius = np.interp(fine, curves.coil, curves.mean_diameter) / 2
    first = radial[0] / np.linalg.norm(radial[0])
    base = np.stack([first, np.cross(scan.axis_direction, first)])
    angle = np.unwrap(np.arctan2(radial @ base[1], radial @ base[0]))
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), along])


def cloud_chart(scan: ScannedSpring) -> Chart:
    """Points of the scan and the fitted wire axis, seen from the front and from the side."""
    line, points = 1e3 * wire_in_frame(scan), 1e3 * _design_wire(scan)
    points = points[:: max(1, len(points) // CLOUD)]
    low = float(np.min(line[:, 2])) - 1e3 * float(scan.curves.height[0])
    half = 1.08 * float(np.max(np.abs(line[:, :2]))) + 2e3 * scan.section.diameter[0]
    tall = 2e3 * scan.section.diameter[0]
    near = (
        np.all(np.abs(points[:, :2]) < half, axis=1)
        & (points[:, 2] > line[:, 2].min() - tall)
        & (points[:, 2] < line[:, 2].max() + tall)
    )
    panels = []
    for axis, row_label in ((0, "front: across (mm)"), (1, "side: across (mm)")):
        layers: tuple[Layer, ...] = (
            Marks(
                points[near, axis],
                points[near, 2] - low,
                "point of the scan",
                theme.MUTED,
                size=2.0,
                filled=True,
                in_legend=axis == 0,
            ),
            Line(
                line[:, axis], line[:, 2] - low, "fitted wire axis", SCAN, 2.0, in_legend=axis == 0
            ),
        )
        panels.append(Panel(row_label, "along the axis (mm)", layers, x_range=(-half, half)))
    caption = f"{scan.points_read} points read, {scan.points_fitted} fitted; some of them are shown. The views are a quarter turn apart."
    return Chart("scan-cloud", "The cloud and the wire axis in it", caption, tuple(panels), 2, 560)


def _design_wire(scan: ScannedSpring) -> Array:
    """Shown points (n, 3) in the frame whose first direction points to the lower tip."""
    radial = scan.curves.centre_line[0] - scan.axis_point
    radial = radial - (radial @ scan.axis_direction) * scan.axis_direction
    first = radial / np.linalg.norm(radial)
    base = np.stack([first, np.cross(scan.axis_direction, first), scan.axis_direction])
    found: Array = (scan.shown - scan.axis_point) @ base.T
    return found


def curves_chart(scan: ScannedSpring, design: SpringDefinition | None = None) -> Chart:
    """Outer diameter, height and pitch over the coil, with the band that the scatter of the points
    leaves; the design's next to them.
    """
    curves, wire = scan.curves, 1e3 * scan.section.diameter[0]
    coil = curves.coil
    values = (
        (
            "outer diameter (mm)",
            1e3 * curves.mean_diameter + wire,
            1e3 * curves.mean_diameter_spread,
        ),
        ("height of the wire axis (mm)", 1e3 * curves.height, 1e3 * curves.height_spread),
        ("pitch (mm per turn)", 1e3 * curves.pitch, 1e3 * curves.pitch_spread),
    )
    design_curves = None if design is None else _design_curves(design)
    panels = []
    for place, (label, mean, spread) in enumerate(values):
        layers: list[Layer] = [
            Line(coil, mean - 2 * spread, "95 % band", theme.MUTED, 0.8, in_legend=place == 0),
            Line(coil, mean + 2 * spread, "95 % band", theme.MUTED, 0.8, in_legend=False),
            Line(coil, mean, "3-D scan", SCAN, 1.8, in_legend=place == 0),
        ]
        if design_curves is not None:
            layers.append(
                Line(
                    design_curves[0],
                    design_curves[place + 1],
                    "design",
                    DESIGN,
                    1.6,
                    "dash",
                    in_legend=place == 0,
                )
            )
        panels.append(
            Panel(
                COIL,
                label,
                tuple(layers),
                x_range=(
                    0.0,
                    float(max(coil[-1], 0.0 if design_curves is None else design_curves[0][-1])),
                ),
            )
        )
    title = "Diameter, height and pitch over the coil" + (
        "" if design is None else ": design and scan"
    )
    caption = "Heights are above the lower seat. Bands are two standard deviations either way, from the noise of the points alone."
    return Chart("scan-curves", title, caption, tuple(panels), 1, 820)


def _design_curves(design: SpringDefinition) -> tuple[Array, Array, Array, Array]:
    coil = np.linspace(0.0, design.total_coils, 401)
    height = design.axial_position(coil) - design.lower_seat_height
    return coil, 1e3 * design.outer_diameter(coil), 1e3 * height, 1e3 * design.pitch.value(coil)


def difference_chart(scan: ScannedSpring, design: SpringDefinition) -> Chart:
    """Scan less design of diameter and pitch, at the same coil number."""
    curves = scan.curves
    keep = curves.coil <= design.total_coils
    coil = curves.coil[keep]
    outer = curves.mean_diameter[keep] + scan.section.diameter[0] - design.outer_diameter(coil)
    height = curves.height[keep] - (design.axial_position(coil) - design.lower_seat_height)
    panels: list[Panel] = []
    for label, away, spread in (
        ("outer diameter, scan − design (mm)", outer, curves.mean_diameter_spread[keep]),
        ("height, scan − design (mm)", height, curves.height_spread[keep]),
    ):
        first = not panels
        layers = (
            Line(coil, 1e3 * (away - 2 * spread), "95 % band", theme.MUTED, 0.8, in_legend=first),
            Line(coil, 1e3 * (away + 2 * spread), "95 % band", theme.MUTED, 0.8, in_legend=False),
            Line(coil, 1e3 * away, "scan − design", SCAN, 1.6, in_legend=first),
        )
        panels.append(Panel(COIL, label, layers, x_range=(0.0, float(coil[-1]))))
    return Chart("scan-difference", "Made and drawn", "", tuple(panels), 1, 520)


def section_chart(scan: ScannedSpring) -> Chart:
    """Points about the wire axis with the fitted circle or ellipse, and the diameter of every turn."""
    section = scan.section
    points = 1e3 * section.shown[:: max(1, len(section.shown) // SECTION)]
    around = np.linspace(0, 2 * np.pi, 241)
    a, b, lean = 5e2 * section.long_axis[0], 5e2 * section.short_axis[0], section.inclination
    ring = np.column_stack([a * np.cos(around), b * np.sin(around)]) @ np.array(
        [[np.cos(lean), np.sin(lean)], [-np.sin(lean), np.cos(lean)]]
    )
    half = 1.25 * a
    word = "ellipse" if section.ovate else "circle"
    fitted: tuple[Layer, ...] = (
        Marks(points[:, 0], points[:, 1], "point of the scan", theme.MUTED, size=2.0, filled=True),
        Line(ring[:, 0], ring[:, 1], f"fitted {word}", SCAN, 2.0),
    )
    turns = section.turns
    mean, bars = 1e3 * turns[:, 1], 2e3 * turns[:, 2]
    strokes = np.column_stack([mean - bars, mean + bars, np.full(len(turns), np.nan)]).ravel()
    each: list[Layer] = [
        Line(np.repeat(turns[:, 0], 3), strokes, "95 % of a turn", theme.MUTED, 1.6),
        Marks(turns[:, 0], mean, "mean of a turn", SCAN, size=6.0, filled=True),
    ]
    whole = 5e2 * (section.long_axis[0] + section.short_axis[0])
    reach = (0.0, float(scan.curves.coil[-1]))
    each.append(
        Line(np.array(reach), np.array([whole, whole]), "whole wire", theme.INK, 1.0, "dash")
    )
    panels = (
        Panel("from the wire axis outward (mm)", "along the spring (mm)", fitted, "all turns laid upon each other", x_range=(-half, half),
              y_range=(-half, half)),
        Panel(COIL, "mean wire diameter (mm)", tuple(each), "turn by turn", x_range=reach),
    )  # fmt: skip
    caption = "The section is taken in the plane normal to the wire. Points nearer to the next coil than five standard deviations are left out."
    return Chart("scan-section", "Section of the wire", caption, panels, 2, 460)


def residual_chart(scan: ScannedSpring) -> Chart:
    """How far points are from the fitted surface, with the normal distribution of their scatter."""
    noise = 1e6 * scan.noise
    left = 1e6 * scan.residuals
    edges = np.linspace(-6 * noise, 6 * noise, BARS + 1)
    counts = np.histogram(left, edges)[0]
    middle = (edges[1:] + edges[:-1]) / 2
    fine = np.linspace(edges[0], edges[-1], 301)
    central = int(np.count_nonzero(np.abs(left) < 2 * noise)) / 0.9545
    bell = (
        central
        * (edges[1] - edges[0])
        / (noise * np.sqrt(2 * np.pi))
        * np.exp(-0.5 * (fine / noise) ** 2)
    )
    bars: tuple[Layer, ...] = (
        Line(*stems(middle, counts.astype(float)), "points", SCAN, 5.0),
        Line(fine, bell, f"bell of {noise:.0f} µm", theme.INK, 1.2, "dash"),
    )
    panel = Panel(
        "point outside (+) or inside (−) the surface (µm)",
        "points",
        bars,
        x_range=(float(edges[0]), float(edges[-1])),
    )
    caption = "Points beyond the bell are strays, or surface that is none of the wire; they do not count in the fit."
    return Chart("scan-residuals", "What the points leave", caption, (panel,), 1, 320)


def force_chart(found: ScanComparison) -> Chart | None:
    """Force and rate of both over the height between the seats."""
    panels: list[list[Layer]] = [[], []]
    design, scan = (case.springs[0] for case in found.cases)
    for study, word, colour, dash in _both(found.rest):
        curve, spring = study.rest[0].curve, scan if word == SCANNED else design
        if curve is None or not len(curve.compression):
            return None
        assert spring.installed_height is not None
        known = curve.path or curve
        height = 1e3 * (spring.installed_height + spring.precompression - known.compression)
        panels[0].append(Line(height, known.force, word, colour, 1.7, dash))
        panels[1].append(
            Line(height, 1e-3 * known.stiffness, word, colour, 1.7, dash, in_legend=False)
        )
    label = "height between the seats (mm)"
    drawn = (
        Panel(label, "force (N)", tuple(panels[0])),
        Panel(label, "rate (N/mm)", tuple(panels[1])),
    )
    return Chart("scan-force", "Force and rate over height", "", drawn, 1, 560)


def motion_chart(found: ScanComparison, engine_speed: float, model: str) -> Chart | None:
    """Spring force of both over the cam angle at one speed by one model."""
    assert found.runs is not None
    layers: list[Layer] = []
    for study, word, colour, dash in _both(found.runs):
        runs = [
            one
            for one in study.solutions
            if one.engine_speed == engine_speed and one.label == model and one.has("seat_force")
        ]
        if not runs:
            return None
        angle = np.degrees(np.mod(runs[0].cam_angle, 2 * np.pi))
        order = np.argsort(angle, kind="stable")
        layers.append(
            Line(*thin(angle[order], runs[0].channel("seat_force")[order]), word, colour, 1.4, dash)
        )
    title = f"Spring force at {speed_text(engine_speed)}, {theme.model_label(model)}"
    panel = Panel("cam angle (cam degrees)", "force on the cylinder head (N)", tuple(layers))
    return Chart(f"scan-motion-{round(engine_speed * 1000)}-{model}", title, "", (panel,), 1, 380)


def _both(studies: tuple[Study, Study]) -> list[tuple[Study, str, str, str]]:
    """Scan and design, the dashed one last, so that it is seen on the other."""
    return [(studies[1], SCANNED, SCAN, "solid"), (studies[0], "design", DESIGN, "dash")]


#: Quantities of a run that are compared where both have them, in this order: force spikes first.
IN_MOTION = (
    "peak_spring_force", "minimum_spring_force", "stage_2_peak_force", "stage_3_peak_force", "main_clash_peak_force",
    "main_clash_below_5_khz_peak_force", "peak_clash_force", "clash_count", "clash_energy", "surge_amplitude_force", "peak_shear_stress",
    "open_nominal_shear_stress", "coil_bind_clearance",
)  # fmt: skip


def scan_rows(scan: ScannedSpring) -> list[tuple[str, str, str, str]]:
    """Words, value, twice its standard deviation and unit of the results of a scan."""
    section, curves = scan.section, scan.curves
    rows = [
        _row("free length", scan.free_length, 1e3, "mm"),
        _row("turns, tip to tip", scan.total_coils, 1.0, ""),
    ]
    if section.ovate:
        rows += [
            _row("wire, long axis", section.long_axis, 1e3, "mm"),
            _row("wire, short axis", section.short_axis, 1e3, "mm"),
            _row("equivalent round wire", section.diameter, 1e3, "mm"),
        ]
    else:
        rows.append(_row("wire diameter", section.diameter, 1e3, "mm"))
    known = np.where(
        curves.mean_diameter_spread < 3 * np.median(curves.mean_diameter_spread),
        curves.mean_diameter,
        np.nan,
    )
    for row_label, place in (
        ("largest", int(np.nanargmax(known))),
        ("smallest", int(np.nanargmin(known))),
    ):
        pair = (
            float(curves.mean_diameter[place]) + section.diameter[0],
            float(curves.mean_diameter_spread[place]),
        )
        rows.append(_row(f"{row_label} outer diameter", pair, 1e3, "mm"))
    place = int(curves.pitch.argmax())
    rows.append(
        _row(
            "largest pitch",
            (float(curves.pitch[place]), float(curves.pitch_spread[place])),
            1e3,
            "mm",
        )
    )
    rows.append(("hand", scan.hand, "", ""))
    for word, end, coil in (
        ("lower", scan.lower_end, scan.definition.lower_end),
        ("upper", scan.upper_end, scan.definition.upper_end),
    ):
        rows.append((f"{word} end", end.kind.replace("-", " and "), "", ""))
        if end.face_points:
            rows.append((f"{word} end, ground turns", f"{coil.ground_coils:.3f}", "", ""))
            rows.append(
                (f"{word} face against the axis", f"{57.29578 * end.face_lean:.2f}", "", "deg")
            )
    rows.append(("noise of a point", f"{1e6 * scan.noise:.1f}", "", "µm"))
    return rows


def _row(
    row_label: str, pair: tuple[float, float], factor: float, unit: str
) -> tuple[str, str, str, str]:
    value, spread = factor * pair[0], 2 * factor * pair[1]
    return (
        row_label,
        f"{value:.4g}" if spread <= 0 else f"{value:.3f}",
        "" if spread <= 0 else f"{max(spread, 0.001):.3f}",
        unit,
    )


def compared_rows(found: ScanComparison) -> list[tuple[str, str, str, str, str, str]]:
    """Words, run, design, scan, unit and difference of what is compared."""
    still = [one for one in found.numbers if one.engine_speed is None]
    moving = [
        one
        for name in IN_MOTION
        for one in found.numbers
        if one.quantity == name and one.engine_speed is not None
    ]
    moving.sort(key=lambda one: (one.engine_speed or 0.0, one.label))
    return [_compared(one) for one in (*still, *moving)]


def _compared(one: ComparedNumber) -> tuple[str, str, str, str, str, str]:
    design, scanned = (float(shown(one.quantity, value)[0]) for value in (one.design, one.scanned))
    run = "" if one.engine_speed is None else f"{one.label}, {speed_text(one.engine_speed)}"
    apart = percent(one.scanned / one.design - 1) if one.design else ""
    return (
        label_of(one.quantity),
        run,
        number(design, 4),
        number(scanned, 4),
        unit_text(definition_of(one.quantity).unit_word),
        apart,
    )


def scan_page(scan: ScannedSpring, found: ScanComparison | None = None) -> Page:
    """The page of a scanned spring; ``found``: the comparison with its design."""
    design = None if found is None else found.cases[0].springs[0].wire
    design_curves = Grid(
        ("", "value", "95 %", ""),
        tuple(((Cell(row_label[:1].upper() + row_label[1:]), Cell(value, "number"), Cell(spread and f"±{spread}", "number quiet"), Cell(unit)), ())
              for row_label, value, spread, unit in scan_rows(scan)),
    )  # fmt: skip
    cloud = figure_or_gap("cloud", cloud_chart, scan)
    curves = figure_or_gap("curves", curves_chart, scan, design)
    picture, drawn = cloud, curves
    if design is not None:
        picture = figure_or_gap("difference", difference_chart, scan, design)
        drawn = (*cloud, *curves)
    sections = [Section("curves", "Cloud and curves", drawn)]
    if found is not None and design is not None:
        sections.append(Section("design", "Design against scan", _design_blocks(found, scan)))
    fits = (
        *figure_or_gap("section", section_chart, scan),
        *figure_or_gap("residuals", residual_chart, scan),
    )
    sections += [
        Section("found", "What the scan gives", (design_curves,)),
        Section("fits", "Section and residuals", fits),
        Section(
            "notes",
            "What was found and assumed",
            tuple(text(one[:1].upper() + one[1:] + ".", "note") for one in scan.notes),
            folded=True,
        ),
    ]
    facts = (
        ("read as", f"{scan.form}, {scan.unit}"), ("points", f"{scan.points_read}, {scan.points_on_wire} on the wire"),
        ("turns", f"{scan.total_coils[0]:.2f}, {scan.hand} hand"), ("noise of a point", f"{1e6 * scan.noise:.0f} µm"),
    )  # fmt: skip
    lead = (
        "The surface of a tube whose axis is a smooth curve is fitted to the points. Intervals hold for points whose errors do not depend "
        "on each other; a scanner that is out by a share of the length puts all sizes out by that share."
    )
    return Page(
        scan.source,
        "Spring from a scan",
        lead,
        facts,
        tuple(sections),
        "Coils are counted from the lower tip.",
        verdict=verdict_of(scan) if found is None else verdict_of(found),
        picture=picture[:1],
    )


def _design_blocks(found: ScanComparison, scan: ScannedSpring) -> tuple[Block, ...]:
    design = found.cases[0].springs[0].wire
    assert design is not None
    blocks: list[Block] = [
        *figure_or_gap("force", force_chart, found),
    ]
    for chart in motion_charts(found):
        blocks.append(chart)
    rows: list[tuple[tuple[Cell, ...], tuple[str, ...]]] = []
    for run, group in groupby(compared_rows(found), key=lambda row: row[1]):
        rows.append(((Cell(run or "at rest"),), ()))
        for row_label, _, *numbers, unit, apart in group:
            cells = (
                Cell(row_label[:1].upper() + row_label[1:]),
                *(Cell(one, "number") for one in numbers),
                Cell(unit),
                Cell(apart, "number"),
            )
            rows.append((cells, ()))
    blocks.append(Grid(("quantity", "design", "scan", "", "scan/design"), tuple(rows)))
    blocks += [text(sentence, "alert") for sentence in found.failures]
    return tuple(blocks)


def motion_charts(found: ScanComparison) -> Sequence[Block]:
    """The force of both at every speed, by every model."""
    if found.runs is None:
        return ()
    pairs = dict.fromkeys((one.engine_speed, one.label) for one in found.runs[0].solutions)
    charts = (motion_chart(found, engine_speed, label) for engine_speed, label in pairs)
    return [Figure(chart) for chart in charts if chart is not None]


#: Headings of the table of curves.
HEADINGS = (
    "coil", "mean diameter [mm]", "standard deviation of mean diameter [mm]", "height [mm]", "standard deviation of height [mm]",
    "pitch [mm]", "standard deviation of pitch [mm]", "x [mm]", "y [mm]", "z [mm]",
)  # fmt: skip


def scan_text(scan: ScannedSpring, installed: InstalledSpring | None = None) -> str:
    """A case that holds nothing but the scanned spring, as ``installed`` or free."""
    return spring_text("scan", installed or InstalledSpring(wire=scan.definition), "from a scan")


def write_scan(scan: ScannedSpring, folder: Path, text: str) -> list[Path]:
    """``spring.toml``, and ``curves.csv``: curves over the coil with standard deviations and the
    wire axis in the frame of the file.
    """
    curves = scan.curves
    columns = np.column_stack([
        curves.coil, 1e3 * curves.mean_diameter, 1e3 * curves.mean_diameter_spread, 1e3 * curves.height, 1e3 * curves.height_spread,
        1e3 * curves.pitch, 1e3 * curves.pitch_spread, 1e3 * curves.centre_line,
    ])  # fmt: skip
    lines = [",".join(HEADINGS), *(",".join(f"{value:.7g}" for value in row) for row in columns)]
    return [
        write_text(folder / "spring.toml", text),
        write_text(folder / "curves.csv", "\n".join(lines) + "\n"),
    ]


def report_scan(
    scan: ScannedSpring, folder: Path, compared: ScanComparison | None = None
) -> StudyFiles:
    """The page of a scan and the files of :func:`write_scan`."""
    files = write_scan(scan, folder, scan_text(scan))
    return with_page(scan_page(scan, compared), folder, files)
