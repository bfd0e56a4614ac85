"""Motion of the coils and their clashes, of every spring whose runs show its wire."""

from __future__ import annotations

import numpy as np

from valvetrain.parameters.spring import SpringDefinition
from valvetrain.quantities.contact_patches import contact_patches, ground_width
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.report import theme
from valvetrain.report.chart import Chart, HeatMap, Layer, Line, Panel, thin
from valvetrain.report.motion.scene import member_of
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
from valvetrain.report.text import CAUSES, number, quantity_label, speed_text
from valvetrain.solution.critical import places_text
from valvetrain.solution.definition import names_for, shown
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study

MAX_COLUMNS, COILS_MAX_ROWS, MAX_LINES = 720, 160, 16
#: Runs of one engine speed whose figures are below each other; more are behind tabs.
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
                found += patch_blocks(study, run, spring, place, title)
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
    """Force between coils (N; of solid finite elements per length, N/mm) by cam angle and place along
    the wire; cells hold the largest force, so that thinning loses no clash.
    """
    per_length = along(run, run.channel_of(spring, "coil_line_force"))
    found = per_length or along(run, run.channel_of(spring, "coil_contact_force"))
    if found is None:
        return None
    caption = "Where, when and how hard a coil presses on the one below: long stretches are coils at rest, short ones clashes."
    if per_length is not None:
        caption += " Force per length of wire, the largest since the sample before."
        found = found[0], found[1] * 1e-3
    unit = "N" if per_length is None else "N/mm"
    return contact_map(
        study, run, (key, title, caption), found, "coil number of the upper coil", unit
    )


def contact_map(
    study: Study,
    run: Solution,
    texts: tuple[str, str, str],
    found: tuple[Array, Array],
    label: str,
    unit: str,
) -> Chart:
    """Map of ``found``, coil numbers and a force (sample, place) in ``unit``; ``texts``: key, title and
    caption of the figure.
    """
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
        unit,
        y_tick_labels="coil",
    )
    bands = tuple(
        type(band)(band.first, band.last, band.label, False) for band in event_bands(study)
    )
    panel = Panel(
        ANGLE_LABEL,
        label,
        (heat,),
        bands=bands,
        x_range=(0, 360),
        x_step=30,
    )
    return Chart(*texts, (panel,), height=380, legend=False)


#: Patches in the table, those of the largest force.
MAX_PATCHES = 24
PATCH_HEADERS = ("wire on", "coils", "first (deg)", "last (deg)", "N/mm", "at coil", "at (deg)", "width (µm)", "pressure (MPa)")  # fmt: skip


def patch_blocks(
    study: Study, run: Solution, spring: str, key: str, title: str
) -> tuple[Block, ...]:
    """What touches along the free wire and across it, by solid finite elements: map of the seats where
    the wire meets them, and a table of all patches.
    """
    if not run.has(run.channel_of(spring, "coil_line_force")):
        return ()
    member = member_of(study.record, run)
    named = zip(run.springs, member.springs if member else (), strict=False)
    wire = dict(named)[spring].wire if member else None
    if wire is None:
        return ()
    patches = contact_patches(run, wire, spring)
    rows = []
    for one in patches[:MAX_PATCHES]:
        always = one.duration > 2 * np.pi - 1e-9
        last = np.degrees(one.first_angle + one.duration) % 360
        spans = ("always", "") if always else (number(np.degrees(one.first_angle)), number(last))
        numbers = (
            f"{one.first_coil:.2f} to {one.last_coil:.2f}",
            *spans,
            number(one.line_force * 1e-3),
            f"{one.coil:.2f}",
            number(np.degrees(one.cam_angle)),
            number(one.width * 1e6),
            number(one.pressure * 1e-6),
        )
        cells = (Cell(one.partner), *(Cell(value, "number") for value in numbers))
        rows.append((cells, (one.partner,)))
    left = len(patches) - len(rows)
    first, end = wire.free_coils
    bonded = ", ".join(
        f"coils {turns[0]:.2f} to {turns[1]:.2f} are bonded to the {name} and never part, under at most {_on_bonded(run, spring, wire, name, turns)}"
        for name, turns in (("seat", (0.0, first)), ("retainer", (end, wire.total_coils)))
        if turns[1] > turns[0]
    )
    caption = (
        "Wire that touches without a break, over the cam cycle: its ends along the wire, from when to when, the largest force per length, "
        "and there the width across the wire and the pressure by Hertz for round elastic wires. Angles to one sample."
    )
    if left:
        caption += f" {left} more of less force are left out."
    if bonded:
        caption += f" {bonded[0].upper()}{bonded[1:]}."
    found: tuple[Block, ...] = ()
    seats, touched = _on_seats(run, spring), {one.partner for one in patches}
    untouched = [partner for partner in ("seat", "retainer") if partner not in touched]
    if seats is not None and len(untouched) < 2:
        label = f"Wire on its seats: {title}"
        about = (
            "Force per length of the free wire on seat (lower coils) and retainer (upper coils), the largest since the sample before. "
            "The turns bonded to them are left out."
        )
        found += figure_or_gap(
            label,
            contact_map,
            study,
            run,
            (f"seats-{key}", label, about),
            seats,
            "coil number",
            "N/mm",
        )
    if untouched:
        caption += f" The free wire never touches {' or '.join(untouched)}."
    grid = Grid(PATCH_HEADERS, tuple(rows), ("wire on",), caption)
    return (*found, text(f"Contact patches: {title}"), grid)


def _on_bonded(
    run: Solution, spring: str, wire: SpringDefinition, end: str, turns: tuple[float, float]
) -> str:
    """Largest force of an end over the length of its bonded turns, and over their ground face."""
    force = float(
        np.max(reported_cycle(run).channel(run.channel_of(spring, f"{end}_force_highest")))
    )
    coil = np.linspace(*turns, 401)
    face = float(np.trapezoid(ground_width(wire, coil, end) * wire.line_speed(coil), coil))
    found = f"{number(force / wire.integrate_along_wire(between=turns) * 1e-3)} N/mm on average"
    if face > 0:
        found += f" ({number(1e-6 * force / face)} MPa over a ground face of {number(1e6 * face)} mm\u00b2)"
    return found


def _on_seats(run: Solution, spring: str) -> tuple[Array, Array] | None:
    """Coil numbers and force per length (N/mm) of the free wire that seat or retainer may press on."""
    parts = [
        one
        for name in ("seat_line_force", "retainer_line_force")
        if (one := along(run, run.channel_of(spring, name))) is not None
    ]
    if not parts:
        return None
    coil = np.unique(np.concatenate([places for places, _ in parts]))
    force = np.zeros((len(parts[0][1]), len(coil)))
    for places, values in parts:
        at = np.searchsorted(coil, places)
        force[:, at] = np.maximum(force[:, at], values * 1e-3)
    return coil, force


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


#: Rows up to which the table is open.
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
                cause = Cell(CAUSES.get(str(event.details.get("cause")), ""), "quiet long")
                cells = (
                    Cell(label),
                    Cell(speed, "number"),
                    Cell(event.kind),
                    Cell(places_text(event.where)),
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
