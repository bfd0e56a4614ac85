"""What ``lift`` shows: the law behind the stations, how well they determine it, and what it does in a case."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import cycle

import numpy as np
import plotly.graph_objects as go

from valvetrain.arrays import Array
from valvetrain.findings.words import Amount, speed_text
from valvetrain.lift.band import CarriedSpread, LiftBandStudy
from valvetrain.lift.figures import OFF, LobeResult, figure_text, lift_figures
from valvetrain.lift.rules import RULES, LiftFacts
from valvetrain.measured.lift_file import MeasuredLift
from valvetrain.measured.lift_smoothing import BAND, SmoothedLift, smooth_lift
from valvetrain.solution.definition import label_of
from valvetrain.views.shown import ShownByRules
from valvetrain.views.style import (
    ANGLE,
    BAD,
    LEAD,
    OTHER,
    SECOND,
    FigureSpec,
    band,
    line,
    panels,
    styled,
)
from valvetrain.views.table import Line, TextTable

#: Derivative -> title of its axis and factor from SI.
AXES = (
    ("lift, mm", 1e3), ("velocity, mm/deg", 1e3 * np.pi / 180), ("acceleration, µm/deg²", 1e6 * (np.pi / 180) ** 2),
    ("jerk, mm/deg³", 1e3 * (np.pi / 180) ** 3)
)  # fmt: skip
#: Beginnings of the figures that are rows.
ROWS = (
    "peak_lift", "duration", "lift_area", "largest_acceleration", "nose_acceleration", "lobe_separation", "overlap",
    "event", "ivo_at_50", "ivc_at_50", "evo_at_50", "evc_at_50",
    "base_radius", "least_radius", "hollow_radius", "flat_width", "largest_pressure", "largest_roller"
)  # fmt: skip
BAND_HINT = "the band holds 95 % of the lifts that the stations allow"
CONTOUR_HINT = "the cam as its follower needs it, about its centre"
OFF_HINT = f"red: more than {OFF:g} standard deviations off; a run of stations on one side is a fault of the table"


@dataclass(frozen=True)
class LiftAnswer(ShownByRules):
    """What is shown of ``measured`` lifts; ``name`` of the table."""

    rules = RULES

    measured: LiftFacts
    name: str = ""

    @property
    def facts(self) -> LiftFacts:
        """The lifts as rules read them."""
        return self.measured

    @property
    def title(self) -> str:
        """The table, what was lifted, and the case that has the lift."""
        study = self.facts.carried
        said = [f"{one.measured.lift_of} lift" for one in self.facts.lobes[:1]]
        case = "" if study is None else study.mean.record.title or study.mean.record.name
        return ", ".join(filter(None, (self.name, *said, case)))

    @property
    def headings(self) -> list[str]:
        """The lobes, where there are two."""
        return [one.measured.name for one in self.facts.lobes] if self.facts.lobes[1:] else [""]

    @cached_property
    def lines(self) -> list[Line]:
        """Figures of the lobes with their 95 % intervals, noise, both lobes together, and the case."""
        lobes, worst = self.facts.lobes, map(self._spread, self.facts.worst)
        probed = [one for one in lobes if one.measured.form != "case"]
        noise = (self.words.amount(Amount("lift", one.smoothed.noise), 2) for one in probed)
        off = (f"{one.off.size} of {one.smoothed.residuals.size}" for one in probed)
        rows = [
            *(Line(label, tuple(cells)) for name, label, *cells in self._figures() if name.startswith(ROWS)),
            self._line("noise of a station", "station_noise_lift", *noise),
            self._line("stations off", "station_lift", *off),
            *(Line(label, (value, "")[: len(self.headings)], "", run) for label, run, value in worst)
        ]  # fmt: skip
        return [one for one in rows if any(one.cells)]

    def _line(self, label: str, quantity: str, *cells: str) -> Line:
        """A row that a doubt reads, marked as good where there is none."""
        doubt = next(iter(self.findings.about((quantity,))), None)
        return Line(label, cells, doubt.mark, doubt.remark) if doubt else Line(label, cells, "ok")

    def _figures(self) -> Iterator[tuple[str, ...]]:
        """Name, label and texts of every figure of the lobes, then of both together."""
        lobes, units = self.facts.lobes, self.words.units
        for one in lobes[0].figures if lobes else ():
            found = [fig for lobe in lobes for fig in lobe.figures if fig.name == one.name]
            yield one.name, one.label, *(figure_text(fig, units) for fig in found)
        for one in (*self.facts.pair, *self.facts.timing):
            yield one.name, one.label, figure_text(one, units), *[""] * (len(self.headings) - 1)

    def _spread(self, one: CarriedSpread) -> tuple[str, ...]:
        """A quantity of a case: its label, its run, and its value with half of its 95 % interval."""
        speed = "" if one.engine_speed is None else speed_text(one.engine_speed)
        text = self.words.between(Amount(one.quantity, one.value, BAND * one.spread))
        return label_of(one.quantity), " ".join((one.label, speed)).strip(), text

    @property
    def rests_on(self) -> list[str]:
        """What the table leaves open."""
        return [one.remark for one in self.findings.by("L232")]

    def tables(self) -> Mapping[str, TextTable]:
        """Every figure, the stations off the law, the case, and what the table means."""
        study, lobes = self.facts.carried, self.facts.lobes
        values = ["value"] if self.headings == [""] else self.headings
        figures = tuple(tuple(cells) for _, *cells in self._figures())
        off = tuple(
            (self.words.amount(Amount("cam_angle", float(angle)), 4), self.words.amount(Amount("lift", float(left)), 2))
            for law, places in ((lobe.smoothed, lobe.off) for lobe in lobes)
            for angle, left in zip(law.cam_angles[places], law.residuals[places], strict=True)
        )  # fmt: skip
        answers = [one for lobe in lobes[:1] for one in lobe.measured.answers]
        said = tuple((one.question.replace("_", " "), one.answer, one.by) for one in answers)
        notes = tuple((str(one),) for one in self.findings.by("L23"))
        case = () if study is None else tuple(map(self._spread, study.spreads))
        return {
            "figures": TextTable("Figures with 95 % intervals", ("figure", *values), figures),
            "off": TextTable("Stations off the law", ("at", "off by"), off),
            "case": TextTable("The case, with 95 % intervals", ("quantity", "run", "value"), case),
            "meaning": TextTable("What the table means", ("question", "answer", "by"), said + notes)
        }  # fmt: skip

    def figures(self) -> Mapping[str, FigureSpec]:
        """Events that were typed in; else lift and acceleration, all derivatives, and what the stations leave."""
        return {
            "events": FigureSpec("When the valves are open", "at 0.050 in of lift", _timed),
            "lift": FigureSpec("Lift and acceleration", BAND_HINT, lambda facts: _curves(facts, 0, 2)),
            "derivatives": FigureSpec("Lift, velocity, acceleration and jerk", BAND_HINT, lambda facts: _curves(facts, 0, 1, 2, 3)),
            "stations": FigureSpec("Stations less the law", OFF_HINT, _stations),
            "contour": FigureSpec("Contour of the cam", CONTOUR_HINT, _contour)
        }  # fmt: skip

    def computed(self) -> Iterator[str]:
        """How the law was made."""
        yield "The law is the likeliest spline whose jerk is white noise; bands are 1.96 standard deviations."
        yield "A case runs with the mean law and with laws drawn from those that the stations allow; name yours with --case."
        if self.facts.carried is None:
            yield f"Copy the lift_law table of {self.facts.file or 'the file'} into your case."
        yield from self.facts.failures


def _timed(facts: LiftFacts) -> go.Figure | None:
    """From which crank angle (deg) to which each valve is open, of events that were typed in."""
    angles = {one.name: math.degrees(one.value) for one in facts.timing}
    valves = [one for one in ("exhaust", "intake") if f"event_centre_{one}" in angles]
    if facts.lobes or not valves:
        return None
    width = [angles[f"event_duration_{one}"] for one in valves]
    centre = [angles[f"event_centre_{one}"] * (-1 if one == "exhaust" else 1) for one in valves]
    begin = [at - size / 2 for at, size in zip(centre, width, strict=True)]
    text = [f"{at:.4g}° to {at + size:.4g}°" for at, size in zip(begin, width, strict=True)]
    bars = go.Bar(
        x=width,
        base=begin,
        y=valves,
        text=text,
        orientation="h",
        marker_color=LEAD,
        textposition="inside",
        insidetextanchor="middle",
    )
    fig = styled(panels((1.0,)).add_trace(bars), "crank angle, deg", ("",), 240)
    fig.update_yaxes(automargin=True)
    ends = ["−180, bottom", "0, top", "180, bottom"]
    return fig.update_xaxes(tickvals=[-180, 0, 180], ticktext=ends, range=[-300, 300])


def _curves(facts: LiftFacts, *derivatives: int) -> go.Figure | None:
    """Derivatives of the lift over the cam angle, each with its band; the stations on the lift."""
    if not facts.lobes:
        return None
    fig = panels((1 / len(derivatives),) * len(derivatives))
    for lobe, colour in zip(facts.lobes, cycle((LEAD, SECOND)), strict=False):
        name, law = lobe.measured.name, lobe.smoothed
        grid = np.linspace(*law.event, 1001)
        angle = np.degrees(grid)
        for row, derivative in enumerate(derivatives, 1):
            mean, half = AXES[derivative][1] * np.array([law.lift(grid, derivative), BAND * law.spread(grid, derivative)])  # fmt: skip
            for edge in band(angle, mean - half, mean + half, f"{name} 95 %" * (not derivative), colour):  # fmt: skip
                fig.add_trace(edge.update(showlegend=bool(edge.name)), row, 1)
            fig.add_trace(line(angle, mean, name, colour, showlegend=not derivative), row, 1)
        fig.add_trace(_marks(lobe, 1e3 * (lobe.measured.lifts - law.base), lobe.measured.cam_angles), 1, 1)  # fmt: skip
    titles = (AXES[one][0] for one in derivatives)
    return styled(fig, ANGLE, (f"{facts.lobes[0].measured.lift_of} {next(titles)}", *titles), 180 * len(derivatives) + 60)  # fmt: skip


def _marks(lobe: LobeResult, y: Array, angles: Array) -> go.Scatter:
    """Stations as dots, those off the law in red."""
    wrong = np.isin(angles, lobe.smoothed.cam_angles[lobe.off])
    marker = {"size": np.where(wrong, 9, 3), "color": np.where(wrong, BAD, OTHER)}
    x, name = np.degrees(angles), f"{lobe.measured.name} stations"
    return go.Scatter(x=x.astype(np.float32), y=y.astype(np.float32), name=name, mode="markers", marker=marker)  # fmt: skip


def _stations(facts: LiftFacts) -> go.Figure | None:
    """Stations less the law (µm) over the cam angle (deg), next to 95 % of the noise."""
    fig = go.Figure()
    for lobe in facts.lobes:
        law, edge = lobe.smoothed, 1e6 * BAND * lobe.smoothed.noise
        fig.add_trace(_marks(lobe, 1e6 * law.residuals, law.cam_angles))
        fig.add_hrect(-edge, edge, line={"width": 0}, fillcolor=OTHER, opacity=0.15)
    return styled(fig, ANGLE, ("station less law, µm",), 300) if facts.lobes else None


def _contour(facts: LiftFacts) -> go.Figure | None:
    """The contours of the cams (mm)."""
    fig = go.Figure()
    for lobe in facts.lobes:
        if (one := lobe.contour) is not None:
            turned = np.append(one.polar_angles, one.polar_angles[0])
            radii = 1e3 * np.append(one.radii, one.radii[0])
            fig.add_trace(line(radii * np.cos(turned), radii * np.sin(turned), lobe.measured.name, LEAD))  # fmt: skip
    fig.update_yaxes(scaleanchor="x")
    return styled(fig, "x, mm", ("y, mm",), 400) if fig.data else None


def answer_of_law(law: SmoothedLift) -> LiftAnswer:
    """What is shown of the law behind stations that are no longer there."""
    stations = law.lift(law.cam_angles) + law.residuals + law.base
    return _answer(MeasuredLift("lift", law.cam_angles, stations, "smoothed", ""), law)


def answer_of_stations(measured: MeasuredLift) -> LiftAnswer:
    """What is shown of stations: the law behind them, which takes some hundredths of a second."""
    return _answer(measured, smooth_lift(measured.cam_angles, measured.lifts))


def _answer(measured: MeasuredLift, law: SmoothedLift) -> LiftAnswer:
    return LiftAnswer(LiftFacts((LobeResult(measured, law, lift_figures(law)),)))


def answer_of_band(study: LiftBandStudy) -> LiftAnswer:
    """What is shown of a case with a measured lift."""
    return LiftAnswer(LiftFacts(carried=study))
