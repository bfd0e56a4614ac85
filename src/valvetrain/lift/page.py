"""The page of measured lifts: what the table means, figures of the trade, lift and derivatives with
their bands.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from valvetrain import registry
from valvetrain.errors import InputError
from valvetrain.lift.band import CarriedSpread, LiftBandStudy
from valvetrain.lift.figures import LiftFigure, LobeResult, figure_rows
from valvetrain.lift.verdict import carried_text, lift_verdict
from valvetrain.measured.lift_formats import LiftFormat, LiftTable
from valvetrain.measured.lift_smoothing import BAND
from valvetrain.parameters.case import Case
from valvetrain.parameters.lift_law import LiftLawParameters
from valvetrain.parameters.loading import parse_case
from valvetrain.parameters.toml_text import resolved, toml_text
from valvetrain.report import theme
from valvetrain.report.chart import Chart, Layer, Line, Marks, Panel, thin
from valvetrain.report.page import Block, Cell, Figure, Grid, Page, Section, text
from valvetrain.solution.atomic import write_bytes, write_text

#: Derivative -> label of its axis and factor from SI.
AXES = (
    ("lift (mm)", 1e3), ("velocity (mm/deg)", 1e3 * np.pi / 180), ("acceleration (µm/deg²)", 1e6 * (np.pi / 180) ** 2),
    ("jerk (mm/deg³)", 1e3 * (np.pi / 180) ** 3),
)  # fmt: skip
#: Quantities of a run that are shown with the spread that the lift gives them, in this order.
CARRIED = (
    "peak_spring_force", "minimum_spring_force", "peak_cam_contact_force", "minimum_open_cam_contact_force", "peak_seat_contact_force",
    "seating_velocity", "bounce_height", "clash_energy", "surge_amplitude_force", "peak_valve_acceleration", "peak_shear_stress",
    "rigid_contact_loss_engine_speed", "contact_loss_engine_speed", "float_engine_speed", "bounce_engine_speed",
)  # fmt: skip


def lift_page(
    title: str,
    lobes: Sequence[LobeResult],
    pair: Sequence[LiftFigure],
    carried: LiftBandStudy | None,
) -> Page:
    """The whole page of one or two lobes; ``pair``: overlap and separation; ``carried``: what the
    noise does to a case.
    """
    sections = [
        Section(
            f"figures-{one.measured.name}",
            f"Figures of the {_whose(one)}",
            (figure_grid(one.figures),),
        )
        for one in lobes
    ]
    if pair:
        sections.append(Section("pair", "Both lobes", (figure_grid(pair),)))
    picture = Figure(derivatives_chart(lobes[0]) if len(lobes) == 1 else lobes_chart(lobes))
    for one in lobes:
        other = () if len(lobes) == 1 else (Figure(derivatives_chart(one)),)
        drawn = (*other, Figure(residuals_chart(one)))
        sections.append(
            Section(f"curves-{one.measured.name}", f"Lift and derivatives, {_whose(one)}", drawn)
        )
    if carried is not None:
        sections.append(
            Section(
                "carried",
                "What the noise of the lift does to forces and speeds",
                carried_blocks(carried),
            )
        )
    sections += [
        Section(
            f"table-{one.measured.name}",
            f"What the table of the {_whose(one)} means",
            answer_blocks(one),
            folded=True,
        )
        for one in lobes
    ]
    first = lobes[0]
    facts = (
        ("stations", ", ".join(str(len(one.measured.lifts)) for one in lobes)),
        ("noise of a station", ", ".join(f"{1e6 * one.smoothed.noise:.2g} µm" for one in lobes)),
        ("lift of", f"the {first.measured.lift_of}"), ("zero of the angle", first.measured.zero),
    )  # fmt: skip
    lead = (
        "The curves are the law behind the measured stations. The bands hold 95 % of the laws that these stations allow; where a band is "
        "wide, the table leaves it open."
    )
    foot, said = "Angles are cam degrees.", lift_verdict(lobes, pair, carried)
    return Page(title, "Measured lift", lead, facts, tuple(sections), foot, said, (picture,))


def _whose(one: LobeResult) -> str:
    name = one.measured.name
    return f"{'' if name == 'lift' else name + ' '}{one.measured.lift_of} lift"


def figure_grid(figures: Sequence[LiftFigure]) -> Grid:
    """Figures with their 95 % intervals."""
    rows = tuple(
        (
            (
                Cell(row_label[:1].upper() + row_label[1:]),
                Cell(value, "number"),
                Cell(spread, "number quiet"),
                Cell(unit),
            ),
            (),
        )
        for row_label, value, spread, unit in figure_rows(figures)
    )
    return Grid(("figure", "value", "95 % of laws within", ""), rows)


def derivatives_chart(one: LobeResult) -> Chart:
    """Lift, velocity, acceleration and jerk in two columns, each with its band; the stations on
    the lift.
    """
    lift, colour = one.smoothed, theme.SERIES[0]
    grid = np.linspace(*lift.event, 1501)
    degrees = np.degrees(grid)
    reach = (float(degrees[0]), float(degrees[-1]))
    panels = []
    for derivative, (label, factor) in enumerate(AXES):
        mean, spread = (
            lift.lift(grid, derivative) * factor,
            BAND * lift.spread(grid, derivative) * factor,
        )
        layers: list[Layer] = [
            Line(
                *thin(degrees, mean - spread),
                "95 % band",
                theme.MUTED,
                0.9,
                "solid",
                derivative == 0,
            ),
            Line(
                *thin(degrees, mean + spread),
                "95 % band",
                theme.MUTED,
                0.9,
                "solid",
                in_legend=False,
            ),
            Line(
                *thin(degrees, mean),
                "law behind the stations",
                colour,
                1.6,
                in_legend=derivative == 0,
            ),
        ]
        if derivative == 0:
            stations = 1e3 * (one.measured.lifts - lift.base)
            layers.append(
                Marks(
                    np.degrees(one.measured.cam_angles),
                    stations,
                    "station",
                    theme.INK,
                    size=3.0,
                    filled=True,
                )
            )
        panels.append(Panel("cam angle (cam degrees)", label, tuple(layers), x_range=reach))
    caption = "Derivatives by the cam angle. Bands are 1.96 standard deviations either way, which hold 95 %."
    return Chart(
        f"derivatives-{one.measured.name}",
        "Lift, velocity, acceleration and jerk",
        caption,
        tuple(panels),
        2,
        560,
    )


def lobes_chart(lobes: Sequence[LobeResult]) -> Chart:
    """Lift and acceleration of both lobes on their one zero of the angle."""
    panels = []
    for derivative in (0, 2):
        label, factor = AXES[derivative]
        layers = []
        for one, colour in zip(lobes, theme.SERIES, strict=False):
            grid = np.linspace(*one.smoothed.event, 1501)
            values = one.smoothed.lift(grid, derivative) * factor
            x, y = thin(np.degrees(grid), values)
            layers.append(Line(x, y, one.measured.name, colour, 1.6, in_legend=derivative == 0))
        ends = np.degrees([one.smoothed.event for one in lobes])
        reach = (float(ends.min()), float(ends.max()))
        panels.append(Panel("cam angle (cam degrees)", label, tuple(layers), x_range=reach))
    return Chart("lobes", "Lift and acceleration of both lobes", "", tuple(panels), 1, 480)


def residuals_chart(one: LobeResult) -> Chart:
    """What each station leaves: noise looks like noise, a slip of the probe does not."""
    lift = one.smoothed
    limit = BAND * lift.noise * 1e6
    angles = np.degrees(lift.cam_angles)
    reach = (float(angles[0]), float(angles[-1]))
    layers: tuple[Layer, ...] = (
        Marks(
            angles,
            1e6 * lift.residuals,
            "station minus law",
            theme.SERIES[0],
            size=4.0,
            filled=True,
        ),
        Line(
            np.array(reach), np.array([limit, limit]), "95 % of the noise", theme.MUTED, 1.0, "dash"
        ),
        Line(
            np.array(reach),
            np.array([-limit, -limit]),
            "",
            theme.MUTED,
            1.0,
            "dash",
            in_legend=False,
        ),
    )
    panel = Panel("cam angle (cam degrees)", "station minus law (µm)", layers, x_range=reach)
    caption = "Stations of the event. One in twenty is outside by chance; a run of them on one side is a fault of the table."
    return Chart(
        f"residuals-{one.measured.name}", "What the stations leave", caption, (panel,), 1, 300
    )


def answer_blocks(one: LobeResult) -> tuple[Block, ...]:
    """Every question that the table raised, its answer and who gave it; what was found in it."""
    origin_text = {"file": "given by the file", "asked": "as requested", "assumed": "assumed"}
    rows = tuple(
        (
            (
                Cell(answer.question.replace("_", " ")),
                Cell(answer.answer),
                Cell(origin_text[answer.by], "tag"),
            ),
            (origin_text[answer.by],),
        )
        for answer in one.measured.answers
    )
    notes = (*one.measured.notes, *lift_notes(one))
    return (
        Grid(("question", "answer", "by"), rows),
        *(text(note[:1].upper() + note[1:] + ".", "note") for note in notes),
    )


def lift_notes(one: LobeResult) -> tuple[str, ...]:
    """Sentences on base circle, noise and stations outside their band."""
    lift = one.smoothed
    notes = [f"the noise of a station is {1e6 * lift.noise:.2g} µm (standard deviation)"]
    if lift.base or lift.runout:
        notes.append(
            f"the base circle was at {1e6 * lift.base:.3g} µm, scattering by {1e6 * lift.runout:.2g} µm, and was set to zero"
        )
    far = np.flatnonzero(np.abs(lift.residuals) > 4 * lift.noise)
    if len(far):
        worst = far[np.argmax(np.abs(lift.residuals[far]))]
        notes.append(
            f"{len(far)} stations are more than four standard deviations off the law, the worst at "
            f"{np.degrees(lift.cam_angles[worst]):.4g} cam deg by {1e6 * lift.residuals[worst]:.3g} µm; look at them"
        )
    if lift.widened:
        notes.append(
            "the requested band is tighter than the noise, so the law follows stations more closely than they deserve"
        )
    return tuple(notes)


def carried_rows(carried: LiftBandStudy) -> list[CarriedSpread]:
    """The quantities of :data:`CARRIED` that the study has, by quantity."""
    return [one for name in CARRIED for one in carried.spreads if one.quantity == name]


def carried_blocks(carried: LiftBandStudy) -> tuple[Block, ...]:
    """Table of forces and speeds with the interval that the noise of the lift gives them."""
    rows = []
    for one in carried_rows(carried):
        row_label, run, value, spread, unit = carried_text(one)
        cells = (
            Cell(row_label[:1].upper() + row_label[1:]),
            Cell(run),
            Cell(value, "number"),
            Cell(spread, "number quiet"),
            Cell(unit),
        )
        rows.append(((*cells, Cell(str(one.draws), "number quiet")), ()))
    grid = Grid(("quantity", "run", "mean law", "95 % of laws within", "", "laws"), tuple(rows))
    return (grid, *(text(sentence, "alert") for sentence in carried.failures))


#: Cam degrees between the rows of the curves.
STEP = 0.25
#: First line of the law for a case file.
AS_MEASURED = "# Stations as measured; a noise or band of 0 is found from them in each run.\n"


def lift_parameters(
    lobe: LobeResult, noise: float | None = None, band: float | None = None
) -> LiftLawParameters:
    """The measured law of a lobe as a case says it."""
    values = {
        "cam_angles": tuple(map(float, lobe.measured.cam_angles)), "lifts": tuple(map(float, lobe.measured.lifts)), "noise": noise or 0.0,
        "band": band or 0.0, "draw": 0,
    }  # fmt: skip
    return LiftLawParameters("measured", values, lobe.measured.lift_of, lobe.measured.zero)  # type: ignore[arg-type]


def lift_case(
    name: str, lobe: LobeResult, noise: float | None = None, band: float | None = None
) -> Case:
    """A case that holds nothing but the lift of ``lobe``; its text can be put into any case file."""
    law = lift_parameters(lobe, noise, band)
    return parse_case(toml_text({"name": name, **resolved({"lift_law": {}}, law)}), name)


def write_lift(
    lobes: Sequence[LobeResult],
    folder: Path,
    noise: float | None = None,
    band: float | None = None,
) -> list[Path]:
    """``lift.csv`` (or ``intake.csv``, ``exhaust.csv``): lift to jerk and standard deviations; and
    the lift as part of a case file, with the stated ``noise`` and ``band`` (m).
    """
    files = []
    for lobe in lobes:
        name = lobe.measured.name
        first, last = np.degrees(lobe.smoothed.event)
        degrees = np.arange(np.ceil(first / STEP), np.floor(last / STEP) + 1) * STEP
        angles = np.radians(degrees)
        columns, heads = [degrees], ["cam angle [deg]"]
        for derivative, (quantity, unit) in enumerate(
            (
                ("lift", "mm"),
                ("velocity", "mm/rad"),
                ("acceleration", "mm/rad2"),
                ("jerk", "mm/rad3"),
            )
        ):
            heads += [f"{quantity} [{unit}]", f"standard deviation of {quantity} [{unit}]"]
            columns += [
                1e3 * lobe.smoothed.lift(angles, derivative),
                1e3 * lobe.smoothed.spread(angles, derivative),
            ]
        lines = [
            ",".join(heads),
            *(",".join(f"{value:.9g}" for value in row) for row in np.column_stack(columns)),
        ]
        files.append(write_text(folder / f"{name}.csv", "\n".join(lines) + "\n"))
        files.append(
            write_text(
                folder / f"{name}.toml",
                AS_MEASURED
                + toml_text(resolved({"lift_law": {}}, lift_parameters(lobe, noise, band))),
            )
        )
    return files


def write_table(lobes: Sequence[LobeResult], path: Path, form: str) -> Path:
    """The smoothed lifts at whole cam degrees in one of the forms. Raises :class:`InputError` for a
    form that cannot be written.
    """
    found: LiftFormat = registry.find("lift_formats", form, "--write-form")
    if found.write is None:
        raise InputError(f"lifts are not written in the form '{form}'; use columns", "--write-form")
    first = min(lobe.smoothed.event[0] for lobe in lobes)
    degrees = np.ceil(np.degrees(first)) - 1 + np.arange(360.0)
    lifts = np.column_stack([lobe.smoothed.lift(np.radians(degrees)) for lobe in lobes])
    lead = lobes[0].measured
    table = LiftTable(
        np.radians(degrees),
        lifts,
        tuple(lobe.measured.name for lobe in lobes),
        lead.lift_of,
        lead.zero,
    )
    return write_bytes(path, found.write(table))
