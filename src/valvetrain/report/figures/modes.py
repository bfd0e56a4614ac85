"""Mode shapes along the wire and all natural frequencies found."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from valvetrain.parameters.case import PublishedValue
from valvetrain.report import theme
from valvetrain.report.chart import Chart, Line, Marks, Panel, Rule, thin
from valvetrain.report.table import Table, table
from valvetrain.report.words import number
from valvetrain.solution.modal import ModalResult

MOST_SHAPES = 4


def shape_table(result: ModalResult) -> Table:
    """``coil number`` and the axial part of each axial mode's shape, largest value 1, columns ``mode 1``, ``mode 2``..."""
    columns: list = [("coil number", "", np.asarray(result.coil_number))]
    for index, mode in enumerate(result.axial_modes[:MOST_SHAPES], start=1):
        axial = np.asarray(result.shape)[mode, :, 2]
        largest = axial[np.argmax(np.abs(axial))] if len(axial) else 1.0
        columns.append((f"mode {index}", "", axial / largest if largest else axial))
    return table(*columns)


def frequency_table(result: ModalResult) -> Table:
    """``natural frequency`` (Hz), ``transmission`` (size of the axial force-transmission residue, largest 1) and ``axial`` of all modes."""
    residue = np.abs(np.asarray(result.axial_transmission, dtype=float))
    axial = np.isin(np.arange(len(residue)), result.axial_modes)
    share = residue / max(float(residue.max(initial=0.0)), 1e-300)
    return table(("natural frequency", "Hz", np.asarray(result.natural_frequency)), ("transmission", "", share), ("axial", "", axial))


def modes_chart(shapes: Table, all_modes: Table, published: Sequence[PublishedValue]) -> Chart:
    """Axial shapes left, the frequencies of all modes by how much axial force they transmit right."""
    known = {value.quantity: value.value for value in published if value.engine_speed is None and value.quantity.startswith("mode_")}
    axial = all_modes["natural frequency"][all_modes["axial"].astype(bool)]
    lines = []
    names = [column.name for column in shapes.columns[1:]]
    for index, (name, colour) in enumerate(zip(names, theme.SERIES, strict=False)):
        lines.append(Line(*thin(shapes["coil number"], shapes[name]), f"{name}, {number(float(axial[index]), 4)} Hz", colour))
    x_label = "coil number (turns from the lower wire tip)"
    left = Panel(x_label, "axial part of the shape", tuple(lines), title="Axial mode shapes", y_range=(-1.15, 1.15))
    caption = (
        "Modes about the installed state, both ends held. A coil spring has many modes; the axial ones are those that carry force from end "
        "to end, found by the residue of the axial force transmission. Dotted lines: published frequencies."
    )
    return Chart("modes", "Natural modes", caption, (left, _frequency_panel(all_modes, axial, known)), columns=2, height=400)


def _frequency_panel(all_modes: Table, axial: np.ndarray, known: dict[str, float]) -> Panel:
    mine, found, share = all_modes["axial"].astype(bool), all_modes["natural frequency"], all_modes["transmission"]
    top = max([float(axial.max(initial=1.0)), *known.values()]) * 1.12
    stems = np.stack([found, found, np.full_like(found, np.nan)], axis=1).ravel()
    heights = np.stack([0 * share, share, np.full_like(share, np.nan)], axis=1).ravel()
    layers = (
        Line(stems, heights, "", theme.RULE, in_legend=False, width=1.4),
        Marks(found[~mine], share[~mine], "other mode", theme.MODEL_COLOURS["massless"], size=5, filled=True),
        Marks(found[mine], share[mine], "axial mode", theme.SERIES[0], size=8, filled=True),
    )
    rules = tuple(Rule("x", value, f"{value:g} Hz") for value in known.values())
    label = "force transmission (largest = 1)"
    return Panel("natural frequency (Hz)", label, layers, title="All modes", rules=rules, x_range=(0, top), y_range=(0, 1.15))
