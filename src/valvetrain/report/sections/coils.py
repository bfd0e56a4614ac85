"""Motion of the coils and their clashes, of every spring whose runs show its wire."""

from __future__ import annotations

import numpy as np

from valvetrain.quantities.cycle import reported_cycle
from valvetrain.report import theme
from valvetrain.report.chart import Chart, HeatMap, Layer, Line, Panel, thin
from valvetrain.report.page import (
    Block,
    Cell,
    Details,
    Grid,
    SectionSpec,
    Tabs,
    figure_or_gap,
    text,
)
from valvetrain.report.run_charts import ANGLE_LABEL, Array, by_speed, event_bands, line_styles
from valvetrain.report.text import number, quantity_label, speed_text
from valvetrain.solution.definition import names_for, shown
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study

MAX_COLUMNS, COILS_MAX_ROWS, MAX_LINES = 720, 160, 16
#: Runs of one engine speed whose figures stand below each other; more stand behind tabs.
MAX_OPEN = 2
#: What is drawn of the wire, the first that a run has.
_HEIGHTS = (
    ("axial_position", "height of the wire above its seat (mm)"),
    ("axial_displacement", "displacement from installed (mm)"),
)


def coils_blocks(study: Study) -> tuple[Block, ...]:
    """Coil positions (or displacements) and clash map of each run and spring, by engine speed."""
    known = line_styles(study)

    def at(engine_speed: float, runs: list[Solution], key: str) -> tuple[Block, ...]:
        items: list[tuple[str, tuple[Block, ...]]] = []
        for index, run in enumerate(runs, start=1):
            found: tuple[Block, ...] = ()
            for spring in run.springs:
                whose = (
                    f"{known[run.label].label}, {spring} spring"
                    if len(run.springs) > 1
                    else known[run.label].label
                )
                title, place = f"{whose}, {speed_text(engine_speed)}", f"{key}-{index}-{spring}"
                for name, build in (("Coil motion", position_chart), ("Clash map", clash_chart)):
                    label = f"{name}: {title}"
                    found += figure_or_gap(
                        label,
                        build,
                        study,
                        run,
                        spring,
                        f"{name.split()[0].lower()}-{place}",
                        label,
                    )
            if found:
                items.append((known[run.label].label, found))
        if len(items) > MAX_OPEN and len(study.engine_speeds) == 1:
            return (Tabs(tuple(items), f"{key}-runs"),)
        return tuple(block for _, blocks in items for block in blocks)

    return by_speed(study, "coils", at)


def along(run: Solution, channel: str) -> tuple[Array, Array] | None:
    """Places along the wire (coil number) and a channel (sample, place) over the reported cycle,
    SI; None without it.
    """
    if not run.has(channel) or run.channel(channel).ndim != 2 or run.channel(channel).shape[1] == 0:
        return None
    places = run.arrays.along(channel)
    return None if places is None else (places, reported_cycle(run).channel(channel))


def position_chart(study: Study, run: Solution, spring: str, key: str, title: str) -> Chart | None:
    """Height of the wire, or its displacement where no height is given (mm), at even distances
    along the spring.
    """
    known = (
        (found, label)
        for name, label in _HEIGHTS
        if (found := along(run, run.channel_of(spring, name))) is not None
    )
    first = next(known, None)
    if first is None:
        return None
    (places, values), label = first
    angle, order = np.degrees(reported_cycle(run).cam_angle), np.argsort(places)
    targets = np.linspace(places.min(), places.max(), min(MAX_LINES, len(places)))
    chosen = np.unique([int(np.argmin(np.abs(places[order] - place))) for place in targets])
    lines = []
    for index, (place, colour) in enumerate(
        zip(order[chosen], theme.ramp(len(chosen)), strict=True)
    ):
        direct = f"{places[place]:.3g}" if index % 5 == 0 and label == _HEIGHTS[0][1] else ""
        x, y = thin(angle, values[:, place] * 1e3)
        lines.append(
            Line(
                x,
                y,
                f"coil number {places[place]:.3g}",
                colour,
                1.2,
                in_legend=False,
                direct=direct,
            )
        )
    panel = Panel(
        ANGLE_LABEL, label, tuple(lines), bands=event_bands(study), x_range=(0, 360), x_step=30
    )
    given = (
        "coil number at the right"
        if label == _HEIGHTS[0][1]
        else "light at the seat, dark at the retainer"
    )
    caption = f"Wire at even distances along the spring, {given}. Waves run up and down between the coils."
    return Chart(key, title, caption, (panel,), height=400, legend=False)


def clash_chart(study: Study, run: Solution, spring: str, key: str, title: str) -> Chart | None:
    """Force between coils (N) by cam angle and place along the wire; cells hold the largest force,
    so that thinning loses no clash.
    """
    found = along(run, run.channel_of(spring, "coil_contact_force"))
    if found is None:
        return None
    order = np.argsort(found[0])
    coil, force, angle = (
        found[0][order],
        found[1].T[order],
        np.degrees(reported_cycle(run).cam_angle),
    )
    force, angle = _largest(force, 1, MAX_COLUMNS), _middle(angle, MAX_COLUMNS)
    heat = HeatMap(
        angle,
        _middle(coil, COILS_MAX_ROWS),
        _largest(force, 0, COILS_MAX_ROWS),
        "contact force",
        "N",
        y_tick_labels="coil",
    )
    bands = tuple(
        type(band)(band.first, band.last, band.label, False) for band in event_bands(study)
    )
    panel = Panel(
        ANGLE_LABEL,
        "coil number of the upper coil",
        (heat,),
        bands=bands,
        x_range=(0, 360),
        x_step=30,
    )
    caption = "Where, when and how hard a coil presses on the one below: long stretches are coils at rest, short ones clashes."
    return Chart(key, title, caption, (panel,), height=380, legend=False)


def _starts(count: int, most: int) -> np.ndarray:
    return np.arange(0, count, int(np.ceil(count / most)))


def _largest(values: np.ndarray, axis: int, most: int) -> np.ndarray:
    return np.maximum.reduceat(values, _starts(values.shape[axis], most), axis=axis)


def _middle(values: np.ndarray, most: int) -> np.ndarray:
    starts = _starts(len(values), most)
    return np.add.reduceat(values, starts) / np.diff(np.append(starts, len(values)))


COILS_SPEC = SectionSpec("coils", "Motion of the coils", coils_blocks)


SHEAR = "inner_fibre_shear_stress"
_LEAD = "Shear at the inner fibre: torsion and direct shear with the curvature of the wire. No stress concentration under coil contacts."


def stress_blocks(study: Study) -> tuple[Block, ...]:
    """Figures by engine speed, then the named numbers, one column per run."""
    known = line_styles(study)

    def at(engine_speed: float, runs: list[Solution], key: str) -> tuple[Block, ...]:
        found: tuple[Block, ...] = ()
        for place, run in enumerate(runs, start=1):
            for spring in run.springs:
                whose = (
                    f"{known[run.label].label}, {spring} spring"
                    if len(run.springs) > 1
                    else known[run.label].label
                )
                title = f"Wire stress: {whose}, {speed_text(engine_speed)}"
                found += figure_or_gap(
                    title, stress_chart, study, run, spring, f"{key}-{place}-{spring}", title
                )
        return found

    figures = by_speed(study, "stress", at)
    runs = [run for run in study.solutions if run.quantities.keys() & names_for("stress")]
    if study.over_speed or not runs:
        return figures
    rows = []
    for name in names_for("stress"):
        if not any(name in run.quantities for run in runs):
            continue
        unit = shown(name, 1.0)[1]
        values = [
            shown(name, run.quantities[name])[0] if name in run.quantities else None for run in runs
        ]
        cells = (
            Cell(quantity_label(name), "", name),
            Cell(unit, "quiet"),
            *(Cell(number(value), "number") for value in values),
        )
        rows.append((cells, ()))
    headers = (
        "",
        "unit",
        *(f"{known[run.label].label}, {speed_text(run.engine_speed)}" for run in runs),
    )
    return (text(_LEAD, "quiet"), *figures, Grid(headers, tuple(rows)))


def stress_chart(study: Study, run: Solution, spring: str, key: str, title: str) -> Chart | None:
    """Largest and least shear along the wire, and the worst point over one cam cycle (MPa), next to
    those of the static curve.
    """
    found = along(run, run.channel_of(spring, SHEAR))
    if found is None:
        return None
    (coil, shear), cycle = found, reported_cycle(run)
    angle, worst = np.degrees(cycle.cam_angle), int(np.argmax(shear.max(axis=0)))
    dynamic, slow, label = (
        theme.model_colour(run.model),
        theme.model_colour("massless"),
        "static curve at the same lift",
    )
    first: list[Layer] = [
        Line(coil, shear.max(axis=0) * 1e-6, "largest", dynamic),
        Line(coil, shear.min(axis=0) * 1e-6, "minimum", theme.mix(dynamic, "#ffffff", 0.5)),
    ]
    second: list[Layer] = [
        Line(*thin(angle, shear[:, worst] * 1e-6), "largest", dynamic, in_legend=False)
    ]
    rest = next(
        (one for one in study.rest if one.spring == spring and one.stress is not None), None
    )
    if rest is not None and rest.stress is not None and run.has("valve_lift"):
        still = rest.stress.shear_at(rest.precompression + cycle.channel("valve_lift")) * 1e-6
        near = int(np.argmin(np.abs(rest.stress.coil_number - coil[worst])))
        first.insert(0, Line(rest.stress.coil_number, still.max(axis=0), label, slow, 1.4, "dash"))
        second.insert(0, Line(*thin(angle, still[:, near]), label, slow, 1.4, "dash"))
    place = f"At coil number {coil[worst]:.3g}"
    panels = (
        Panel("coil number from the seat", "shear stress (MPa)", tuple(first), "Along the wire"),
        Panel(
            ANGLE_LABEL,
            "shear stress (MPa)",
            tuple(second),
            place,
            event_bands(study),
            x_range=(0, 360),
            x_step=60,
        ),
    )
    return Chart(
        key,
        title,
        "Shear stress at the inner fibre of the wire over the reported cycle.",
        panels,
        2,
        330,
    )


STRESS_SPEC = SectionSpec("stress", "Wire stress", stress_blocks)


#: Rows up to which the table stands open.
OPEN_ROWS = 24
EVENTS_MAX_ROWS = 400
HEADERS = (
    "run",
    "engine speed",
    "event",
    "place",
    "cam angle (deg)",
    "duration (ms)",
    "size",
    "unit",
    "cause",
)


def events_blocks(study: Study) -> tuple[Block, ...]:
    """A table with filters by run and kind; a sweep's events are in its file."""
    if study.over_speed:
        return ()
    known, rows = line_styles(study), []
    for run in study.solutions:
        for event in run.events:
            if event.kind != "clash":
                label, speed = known[run.label].label, speed_text(run.engine_speed)
                angle = float(np.degrees(event.cam_angle)) % 360
                numbers = [
                    Cell(number(value), "number")
                    for value in (angle, event.duration * 1e3, event.size)
                ]
                cause = Cell(str(event.details.get("cause", "")), "quiet long")
                cells = (
                    Cell(label),
                    Cell(speed, "number"),
                    Cell(event.kind),
                    Cell(event.where),
                    *numbers,
                    Cell(event.unit, "quiet"),
                    cause,
                )
                rows.append((cells, (label, speed, event.kind)))
    if not rows:
        return ()
    caption = (
        ""
        if len(rows) <= EVENTS_MAX_ROWS
        else f"The first {EVENTS_MAX_ROWS} of {len(rows)}; all of them are in events.csv."
    )
    grid = Grid(HEADERS, tuple(rows[:EVENTS_MAX_ROWS]), ("run", "engine speed", "event"), caption)
    return (grid,) if len(rows) <= OPEN_ROWS else (Details(f"{len(rows)} events", (grid,)),)


EVENTS_SPEC = SectionSpec("events", "Seating and losses of contact", events_blocks)
