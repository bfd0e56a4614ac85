"""Springs at rest by every model: static curve with installed, open and bind marked, natural
frequencies and modes.
"""

from __future__ import annotations

import numpy as np

from valvetrain.report import theme
from valvetrain.report.chart import Chart, Layer, Line, Marks, Panel, Rule, thin
from valvetrain.report.page import Block, Cell, Grid, SectionSpec, figure_or_gap, text
from valvetrain.report.text import number
from valvetrain.solution.static import SpringAtRest, StaticCurve
from valvetrain.solution.status import COMPLETED
from valvetrain.solution.study import Study

MAX_SHAPES, MAX_MODES = 4, 6
_COMPRESSION = "compression from the free length (mm)"


def blocks(study: Study) -> tuple[Block, ...]:
    """Per spring: curves of all models, their frequencies side by side, mode shapes; without the figure
    that opens the page.
    """
    found: list[Block] = []
    springs = tuple(dict.fromkeys(one.spring for one in study.rest))
    taken = _opening_key(study)
    for place, spring in enumerate(springs, start=1):
        mine = [one for one in study.rest if one.spring == spring]
        whose = f", {spring} spring" if len(springs) > 1 else ""
        if (key := f"static-{place}") != taken:
            title = f"Static curve{whose}"
            found += figure_or_gap(title, static_chart, study, mine, key, title)
        found += frequency_grid(mine, whose)
        if (key := f"modes-{place}") != taken:
            title = f"Natural modes{whose}"
            found += figure_or_gap(title, modes_chart, mine, key, title)
        for one in mine:
            for word, part in (("static curve", one.curve), ("modes", one.modes)):
                if part is not None and part.status != COMPLETED:
                    found.append(
                        text(
                            f"{theme.model_label(one.model)}{whose}, {word}: {part.status.sentence()}",
                            "note",
                        )
                    )
    return tuple(found)


def opening_chart(study: Study) -> Chart | None:
    """The figure that opens the page of springs at rest: curve or modes of the first of them; None
    with any run.
    """
    mine = [one for one in study.rest if one.spring == study.rest[0].spring]
    whose = f", {mine[0].spring} spring" if len({one.spring for one in study.rest}) > 1 else ""
    key = _opening_key(study)
    if key.startswith("static"):
        return static_chart(study, mine, key, f"Static curve{whose}")
    return modes_chart(mine, key, f"Natural modes{whose}") if key else None


def _opening_key(study: Study) -> str:
    """Key of that figure: of the modes where they were asked for, or where no curve was; empty with
    any run.
    """
    if study.solutions or not study.rest:
        return ""
    mine = [one for one in study.rest if one.spring == study.rest[0].spring]
    curve = any(one.curve is not None and len(one.curve.compression) > 1 for one in mine)
    modes = any(one.modes is not None and len(one.modes.natural_frequency) for one in mine)
    if modes and (study.command == "modes" or not curve):
        return "modes-1"
    return "static-1" if curve else ""


def marked_compressions(study: Study, rest: SpringAtRest) -> dict[str, float]:
    """Compressions (m) of the installed state, at the largest lift and at coil bind, those that are
    known.
    """
    found = {"installed": rest.precompression} if rest.precompression else {}
    if rest.curve is not None and rest.curve.buckling is not None:
        found["buckles"] = rest.curve.buckling.compression
    lifts = [
        float(np.max(run.channel("valve_lift")))
        for run in study.solutions
        if run.has("valve_lift") and len(run.time)
    ]
    lifts += [
        value
        for key, value in study.quantities.items()
        if key.name in ("maximum_lift", "rigid_maximum_valve_lift")
    ]
    if lifts:
        found["open"] = rest.precompression + max(lifts)
    names = (f"{rest.spring}_coil_bind_lift", "coil_bind_lift")
    bind = next(
        (
            value
            for name in names
            for key, value in study.quantities.items()
            if key.name == name and np.isfinite(value)
        ),
        None,
    )
    return found if bind is None else found | {"bind": rest.precompression + bind}


def static_chart(study: Study, members: list[SpringAtRest], key: str, title: str) -> Chart | None:
    """Force and tangent stiffness by model, and, of several models, the difference in force from
    the first.
    """
    known = [
        (one, one.curve)
        for one in members
        if one.curve is not None and len(one.curve.compression) > 1
    ]
    if not known:
        return None
    force: list[Layer] = []
    stiffness: list[Layer] = []
    apart: list[Layer] = []
    for one, curve in known:
        label, colour = theme.model_label(one.model), theme.model_colour(one.model)
        force.append(Line(*thin(curve.compression * 1e3, curve.force), label, colour))
        stiffness.append(
            Line(
                *thin(curve.compression * 1e3, curve.stiffness * 1e-3),
                label,
                colour,
                in_legend=False,
            )
        )
        if one is not known[0][0]:
            apart.append(
                Line(
                    curve.compression * 1e3,
                    difference(curve, known[0][1]),
                    label,
                    colour,
                    in_legend=False,
                )
            )
    rules = tuple(
        Rule("x", value * 1e3, word)
        for word, value in marked_compressions(study, known[0][0]).items()
    )
    every = np.concatenate([np.asarray(curve.stiffness, dtype=float) for _, curve in known]) * 1e-3
    # The wall of the solid spring would flatten all else.
    top = 1.08 * min(float(every.max()), 4 * float(np.median(every)))
    # Room at the right for the words next to the last mark.
    reach = (
        0.0,
        1.08
        * max(
            [
                *(float(curve.compression[-1]) * 1e3 for _, curve in known),
                *(rule.value for rule in rules),
            ]
        ),
    )
    panels = [
        Panel(_COMPRESSION, "force (N)", tuple(force), "Force", rules=rules, x_range=reach),
        Panel(
            _COMPRESSION,
            "tangent stiffness (N/mm)",
            tuple(stiffness),
            "Stiffness",
            rules=rules,
            x_range=reach,
            y_range=(0.0, top or 1.0),
        ),
    ]
    if apart:
        against = f"from the {theme.model_label(known[0][0].model)} (%)"
        panels.append(
            Panel(
                _COMPRESSION,
                against,
                tuple(apart),
                "Difference in force",
                rules=rules,
                x_range=reach,
            )
        )
    caption = "Static compression from the free length. The stiffness rises where coils come to lie on the ones below."
    return Chart(
        key, title, caption, tuple(panels), 2, 350 * (-(-len(panels) // 2)) + 20, len(known) > 1
    )


def difference(curve: StaticCurve, reference: StaticCurve) -> np.ndarray:
    """Difference (%) of the force from that of ``reference`` at the same compression; nan where
    that has none.
    """
    base = np.interp(
        curve.compression, reference.compression, reference.force, left=np.nan, right=np.nan
    )
    return 100 * (np.asarray(curve.force) / np.where(base > 0, base, np.nan) - 1)


def frequency_grid(members: list[SpringAtRest], whose: str = "") -> tuple[Block, ...]:
    """Axial natural frequencies (Hz) by model, with the difference (%) from the first."""
    known = [
        (one.model, one.modes.axial_frequencies)
        for one in members
        if one.modes is not None and len(one.modes.axial_modes)
    ]
    if not known:
        return ()
    headers, rows = ["axial mode", f"{theme.model_label(known[0][0])} (Hz)"], []
    for model, _ in known[1:]:
        headers += [f"{theme.model_label(model)} (Hz)", "difference (%)"]
    for place in range(min(max(len(values) for _, values in known), MAX_MODES)):
        given = [float(values[place]) if place < len(values) else None for _, values in known]
        cells = [Cell(str(place + 1)), Cell(number(given[0]), "number")]
        for value in given[1:]:
            apart = None if given[0] is None or value is None else 100 * (value / given[0] - 1)
            cells += [Cell(number(value), "number"), Cell(number(apart, 2), "number quiet")]
        rows.append((tuple(cells), ()))
    return (
        Grid(
            tuple(headers),
            tuple(rows),
            caption=f"Axial natural frequencies about the installed state, both ends fixed{whose}.",
        ),
    )


def modes_chart(members: list[SpringAtRest], key: str, title: str) -> Chart | None:
    """Axial mode shapes of each model that gives them, and how much axial force each mode carries
    from end to end.
    """
    panels = []
    for one in members:
        result, lines = one.modes, []
        if result is None or not len(result.natural_frequency):
            continue
        label = theme.model_label(one.model)
        for place, (mode, colour) in enumerate(
            zip(result.axial_modes[:MAX_SHAPES], theme.SERIES, strict=False), start=1
        ):
            shape = np.asarray(result.shape)[mode, :, 2]
            largest = shape[np.argmax(np.abs(shape))] if len(shape) else 0.0
            if largest:
                lines.append(
                    Line(
                        *thin(np.asarray(result.coil_number), shape / largest),
                        f"mode {place}",
                        colour,
                    )
                )
        if lines:
            x_label = "coil number (turns from the lower end)"
            panels.append(
                Panel(
                    x_label,
                    "axial part, largest 1",
                    tuple(lines),
                    f"Shapes, {label}",
                    y_range=(-1.15, 1.15),
                )
            )
        panels.append(_carried(one, label))
    caption = (
        "Modes about the installed state, both ends fixed. Axial modes carry force from end to end, found by the residue of the axial "
        "force transmission."
    )
    return (
        Chart(key, title, caption, tuple(panels), 2, 300 * (-(-len(panels) // 2)) + 20)
        if panels
        else None
    )


def _carried(one: SpringAtRest, label: str) -> Panel:
    result = one.modes
    assert result is not None
    share = np.abs(np.asarray(result.axial_transmission, dtype=float))
    share = share / max(float(share.max(initial=0.0)), 1e-300)
    axial, found = (
        np.isin(np.arange(len(share)), result.axial_modes),
        np.asarray(result.natural_frequency, dtype=float),
    )
    layers: list[Layer] = []
    for name, mine, colour in (
        ("other mode", ~axial, theme.MUTED),
        ("axial mode", axial, theme.SERIES[0]),
    ):
        if np.any(mine):
            hints = tuple(f"{number(value)} Hz, {name}" for value in found[mine])
            layers.append(
                Marks(found[mine], share[mine], name, colour, size=8, filled=True, hints=hints)
            )
    top = float((found[axial] if np.any(axial) else found).max()) * 1.12
    return Panel(
        "natural frequency (Hz)",
        "force carried, largest 1",
        tuple(layers),
        f"Modes, {label}",
        x_range=(0, top),
        y_range=(0, 1.15),
    )


SPEC = SectionSpec("at-rest", "Spring at rest", blocks)
