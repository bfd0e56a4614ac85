"""Motion of the coils and their clashes, of every spring whose runs show its wire."""

from __future__ import annotations

import numpy as np

from valvetrain.quantities.cycle import reported_cycle
from valvetrain.report import theme
from valvetrain.report.chart import Chart, HeatMap, Line, Panel, thin
from valvetrain.report.figures.common import ANGLE_LABEL, Array, by_speed, event_bands, looks
from valvetrain.report.page import Block, SectionSpec, Tabs, figure_or_gap
from valvetrain.report.words import speed_words
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study

MOST_COLUMNS, MOST_ROWS, MOST_LINES = 720, 160, 16
#: Runs of one engine speed whose figures stand below each other; more stand behind tabs.
MOST_OPEN = 2
#: What is drawn of the wire, the first that a run has.
_HEIGHTS = (("axial_position", "height of the wire above its seat (mm)"), ("axial_displacement", "displacement from installed (mm)"))


def blocks(study: Study) -> tuple[Block, ...]:
    """Coil positions (or displacements) and clash map of each run and spring, by engine speed."""
    known = looks(study)

    def at(engine_speed: float, runs: list[Solution], key: str) -> tuple[Block, ...]:
        items: list[tuple[str, tuple[Block, ...]]] = []
        for number, run in enumerate(runs, start=1):
            found: tuple[Block, ...] = ()
            for spring in run.springs:
                whose = f"{known[run.label].words}, {spring} spring" if len(run.springs) > 1 else known[run.label].words
                title, place = f"{whose}, {speed_words(engine_speed)}", f"{key}-{number}-{spring}"
                for name, build in (("Coil motion", position_chart), ("Clash map", clash_chart)):
                    words = f"{name}: {title}"
                    found += figure_or_gap(words, build, study, run, spring, f"{name.split()[0].lower()}-{place}", words)
            if found:
                items.append((known[run.label].words, found))
        if len(items) > MOST_OPEN and len(study.engine_speeds) == 1:
            return (Tabs(tuple(items), f"{key}-runs"),)
        return tuple(block for _, blocks in items for block in blocks)

    return by_speed(study, "coils", at)


def along(run: Solution, channel: str) -> tuple[Array, Array] | None:
    """Places along the wire (coil number) and a channel (sample, place) over the reported cycle, SI; None without it."""
    if not run.has(channel) or run.channel(channel).ndim != 2 or run.channel(channel).shape[1] == 0:
        return None
    places = run.arrays.along(channel)
    return None if places is None else (places, reported_cycle(run).channel(channel))


def position_chart(study: Study, run: Solution, spring: str, key: str, title: str) -> Chart | None:
    """Height of the wire, or its displacement where no height is told (mm), at even distances along the spring."""
    known = ((found, words) for name, words in _HEIGHTS if (found := along(run, run.channel_of(spring, name))) is not None)
    first = next(known, None)
    if first is None:
        return None
    (places, values), words = first
    angle, order = np.degrees(reported_cycle(run).cam_angle), np.argsort(places)
    wanted = np.linspace(places.min(), places.max(), min(MOST_LINES, len(places)))
    chosen = np.unique([int(np.argmin(np.abs(places[order] - place))) for place in wanted])
    lines = []
    for number, (place, colour) in enumerate(zip(order[chosen], theme.ramp(len(chosen)), strict=True)):
        direct = f"{places[place]:.3g}" if number % 5 == 0 and words == _HEIGHTS[0][1] else ""
        x, y = thin(angle, values[:, place] * 1e3)
        lines.append(Line(x, y, f"coil number {places[place]:.3g}", colour, 1.2, in_legend=False, direct=direct))
    panel = Panel(ANGLE_LABEL, words, tuple(lines), bands=event_bands(study), x_range=(0, 360), x_step=30)
    told = "coil number at the right" if words == _HEIGHTS[0][1] else "light at the seat, dark at the retainer"
    caption = f"Wire at even distances along the spring, {told}. Waves run up and down between the coils."
    return Chart(key, title, caption, (panel,), height=400, legend=False)


def clash_chart(study: Study, run: Solution, spring: str, key: str, title: str) -> Chart | None:
    """Force between coils (N) by cam angle and place along the wire; cells hold the largest force, so that thinning loses no clash."""
    found = along(run, run.channel_of(spring, "coil_contact_force"))
    if found is None:
        return None
    order = np.argsort(found[0])
    coil, force, angle = found[0][order], found[1].T[order], np.degrees(reported_cycle(run).cam_angle)
    force, angle = _largest(force, 1, MOST_COLUMNS), _middle(angle, MOST_COLUMNS)
    heat = HeatMap(angle, _middle(coil, MOST_ROWS), _largest(force, 0, MOST_ROWS), "contact force", "N", y_words="coil")
    bands = tuple(type(band)(band.first, band.last, band.words, False) for band in event_bands(study))
    panel = Panel(ANGLE_LABEL, "coil number of the upper coil", (heat,), bands=bands, x_range=(0, 360), x_step=30)
    caption = "Where, when and how hard a coil presses on the one below: long stretches are coils at rest, short ones clashes."
    return Chart(key, title, caption, (panel,), height=380, legend=False)


def _starts(count: int, most: int) -> np.ndarray:
    return np.arange(0, count, int(np.ceil(count / most)))


def _largest(values: np.ndarray, axis: int, most: int) -> np.ndarray:
    return np.maximum.reduceat(values, _starts(values.shape[axis], most), axis=axis)


def _middle(values: np.ndarray, most: int) -> np.ndarray:
    starts = _starts(len(values), most)
    return np.add.reduceat(values, starts) / np.diff(np.append(starts, len(values)))


SPEC = SectionSpec("coils", "Motion of the coils", blocks)
