"""What ``scan`` shows: whether the scan covers the spring, its sizes with their scatter, and its design next to it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
import plotly.graph_objects as go
from numpy.typing import ArrayLike

from valvetrain.findings.engine import Mark
from valvetrain.findings.words import Amount
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.summary import percent
from valvetrain.scan.compare import ComparedNumber, ScanComparison
from valvetrain.scan.result import ScannedSpring
from valvetrain.scan.rules import AS_DRAWN, BRIDGED, RULES, ScanFacts, degrees, length
from valvetrain.solution.atomic import write_text
from valvetrain.solution.definition import label_of
from valvetrain.views.files import csv_of, spring_text
from valvetrain.views.shown import ShownByRules
from valvetrain.views.style import LEAD, RIGID, SECOND, FigureSpec, band, dots, line, panels, styled
from valvetrain.views.table import Line, TextTable

#: Quantities at rest in the first table, and standard deviations of a 95 % interval.
FIRST, BAND = ("installed_rate", "preload", "coil_bind_lift", "mode_1_frequency"), 2.0
GREY = "grey: 95 % of what the scatter of the points leaves"


@dataclass(frozen=True)
class ScanAnswer(ShownByRules):
    """What is shown of a ``scan``, and of the comparison with its design, in the units of the reader by default."""

    rules = RULES

    scan: ScannedSpring
    compared: ScanComparison | None = None

    @property
    def facts(self) -> ScanFacts:
        """The scan as rules read it."""
        return ScanFacts(self.scan, self.compared)

    @property
    def title(self) -> str:
        """The file, and the design that it is compared with."""
        beside = "" if self.compared is None else f", design {self.compared.cases[0].name}"
        return f"Spring from the scan {self.scan.source} ({self.scan.form}, {self.scan.unit}){beside}"  # fmt: skip

    @property
    def headings(self) -> list[str]:
        """Columns of the first table."""
        return [""] if self.compared is None else ["design", "scan", "scan − design"]

    @property
    def rests_on(self) -> list[str]:
        """What the scan does not show."""
        return list(self.scan.notes)

    @cached_property
    def lines(self) -> list[Line]:
        """Sizes and ends, then how well the scan shows them, or rate and preload of design and scan."""
        return [*self._sizes(), *(self._seen() if self.compared is None else self._loads())]

    def _sizes(self) -> Iterator[Line]:
        facts, words = self.facts, replace(self.words, brief=True)
        off_design = {one.fields["name"] for one in self.findings.by("Y114")}
        for size in facts.sizes:
            bar, name = BAND * float(np.max(size.spread)), size.quantity
            low, high = (Amount(name, float(end(size.values)), bar) for end in (np.min, np.max))
            made = words.span(low, high, 4)
            cells: tuple[str, ...] = (f"{made} ± {words.amount(Amount(name, bar), 2)}",)
            if size.drawn is not None:  # next to the design's
                low, high = (Amount(name, float(end(size.drawn))) for end in (np.min, np.max))
                off = size.values - size.drawn
                furthest = Amount(name, float(off[np.argmax(np.abs(off))]), bar)
                sign = "+" if furthest.value > 0 else ""
                cells = words.span(low, high, 4), made, f"{sign}{words.amount(furthest, 2)}"
            yield Line(size.label, cells, "warn" if size.label in off_design else "")
        for place in ("lower_end", "upper_end"):
            ends = [
                getattr(wire, place)
                for wire in (facts.design, self.scan.definition)
                if wire is not None
            ]
            kinds = (*(end.kind for end in ends), "")[: len(self.headings)]
            yield Line(
                place.replace("_", " "), kinds, "", f"{ends[-1].ground_coils:.2f} turns ground"
            )

    def _seen(self) -> Iterator[Line]:
        scan, seen = self.scan, self.scan.coverage
        share, scatter = scan.points_on_wire / scan.points_fitted, self.words.amount(length(scan.noise), 2)  # fmt: skip
        mark: Mark = "bad" if seen.sector > BRIDGED else "ok"
        yield Line("points", (f"{scan.points_fitted}, scatter {scatter}",), "", f"{100 * share:.0f} % on the wire")  # fmt: skip
        yield Line("seen", (f"{100 * seen.around:.0f} % around the wire",), mark, f"gap about the axis {degrees(seen.sector)}")  # fmt: skip

    def _loads(self) -> Iterator[Line]:
        for number in self.facts.numbers:
            if number.quantity in FIRST:
                mark: Mark = "ok" if abs(number.difference) <= AS_DRAWN else "warn"
                yield Line(label_of(number.quantity), self._compared(number), mark)

    def _compared(self, number: ComparedNumber) -> tuple[str, ...]:
        both = (self.words.amount(Amount(number.quantity, value), 4) for value in (number.design, number.scanned))  # fmt: skip
        return *both, percent(number.difference) if number.design else ""

    def tables(self) -> Mapping[str, TextTable]:
        """Every compared number."""
        rows = tuple((label_of(number.quantity), *self._compared(number)) for number in self.facts.numbers)  # fmt: skip
        return {"numbers": TextTable("Design and scan", ("quantity", *self.headings), rows)}

    def write(self, folder: Path) -> list[Path]:
        """``spring.toml``, and ``curves.csv``: curves over the coil with standard deviations and the
        wire axis in the frame of the file.
        """
        curves = self.scan.curves
        columns = np.column_stack([
            curves.coil, 1e3 * curves.mean_diameter, 1e3 * curves.mean_diameter_spread, 1e3 * curves.height, 1e3 * curves.height_spread,
            1e3 * curves.pitch, 1e3 * curves.pitch_spread, 1e3 * curves.centre_line,
        ])  # fmt: skip
        return [
            write_text(folder / "spring.toml", self.text),
            write_text(folder / "curves.csv", csv_of(HEADINGS, columns.tolist(), 7)),
        ]

    def figures(self) -> Mapping[str, FigureSpec]:
        """The points about the axis and the curves; design and scan by force first where there is a design."""
        hint = "unrolled about the axis of the spring; a white band from bottom to top was not seen"
        cloud = FigureSpec("Points and wire axis", hint, cloud_figure)
        if self.compared is None:
            return {"cloud": cloud, "curves": FigureSpec("Curves over the coil", GREY, curves_figure)}  # fmt: skip
        curves = FigureSpec("Scan minus design", GREY, curves_figure)
        return {"force": FigureSpec("Force and rate", "", force_figure), "curves": curves, "cloud": cloud}  # fmt: skip

    def computed(self) -> Iterator[str]:
        """What was fitted, and what its intervals leave out."""
        yield "The surface of a tube whose axis is a smooth curve is fitted to the points. Coils are counted from the lower tip."
        yield "The intervals hold for independent errors of the points. A scanner that is wrong by a share of the length is wrong by it in all sizes."

    @property
    def text(self) -> str:
        """The case file that is written: the scanned spring free, or as its design is installed."""
        free = InstalledSpring(wire=self.scan.definition)
        spring = free if self.compared is None else self.compared.cases[1].springs[0]
        return spring_text("scan", spring, "from a scan")


def answer_of_comparison(compared: ScanComparison) -> ScanAnswer:
    """What is shown of a comparison with a design."""
    return ScanAnswer(compared.scan, compared)


#: Headings of the table of curves.
HEADINGS = (
    "coil", "mean diameter [mm]", "standard deviation of mean diameter [mm]", "height [mm]", "standard deviation of height [mm]",
    "pitch [mm]", "standard deviation of pitch [mm]", "x [mm]", "y [mm]", "z [mm]",
)  # fmt: skip


#: Scan and design: name, colour and dash of their lines. The dashed ones are drawn last, so that they are seen on the others.
LOOKS = (("scan", LEAD, "solid"), ("design", SECOND, "dash"))


def cloud_figure(facts: ScanFacts) -> go.Figure:
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


def curves_figure(facts: ScanFacts) -> go.Figure:
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


def force_figure(facts: ScanFacts) -> go.Figure | None:
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
