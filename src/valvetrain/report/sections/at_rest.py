"""Springs at rest by every model: static curve with installed, open and bind marked, natural
frequencies and modes.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from valvetrain.report import theme
from valvetrain.report.chart import Chart, Layer, Line, Marks, Panel, Rule, thin
from valvetrain.report.page import Block, Cell, Grid, SectionSpec, figure_or_gap, text
from valvetrain.report.text import number
from valvetrain.solution.definition import NESTED
from valvetrain.solution.static import SpringAtRest, StaticCurve
from valvetrain.solution.status import COMPLETED
from valvetrain.solution.study import Study

MAX_SHAPES, MAX_MODES = 4, 6
#: Top of an axis over its highest curve, so that labels of rules fit above it, and its end beyond the
#: last rule, so that the label of that fits there.
LABELLED, BEYOND = 1.25, 1.14
#: Share by which a stiffness rises where coils close, and what is said of that.
RISE = 0.02
CLOSING = " The stiffness rises where coils come to rest on the ones below."
#: Dash of a model -> how a caption gives it.
DASHES = {"solid": "solid", "dash": "dashed", "dot": "dotted"}
#: Share of the largest force below which a difference in force is rounding.
LEAST_LOAD = 1e-3
#: Cam orders that are named with a mode, and share of its frequency that a figure shows about it.
MODE_ORDERS, ABOUT = (6, 12), 0.25
#: Names of the largest lift: of a spring alone, and of a train.
LIFTS = ("maximum_lift", "rigid_maximum_valve_lift")
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
        if study.command == "static":
            known = ((one, one.curve) for one in mine if one.curve is not None)
            found += [state_grid(study, one, curve) for one, curve in known]
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
    if key == "static":
        return springs_chart(study, key)
    if key.startswith("static"):
        return static_chart(study, mine, key, f"Static curve{whose}")
    return orders_chart(study, key) if key else None


def _opening_key(study: Study) -> str:
    """Key of that figure: of the modes where they were requested, or where no curve was; empty with
    any run.
    """
    if study.solutions or not study.rest:
        return ""
    mine = [one for one in study.rest if one.spring == study.rest[0].spring]
    curve = any(one.curve is not None and len(one.curve.compression) > 1 for one in mine)
    modes = any(one.modes is not None and len(one.modes.natural_frequency) for one in mine)
    if modes and (study.command == "modes" or not curve):
        return "modes-orders"
    if not curve:
        return ""
    return "static-1" if len({one.spring for one in study.rest}) == 1 else "static"


def marked_compressions(study: Study, rest: SpringAtRest) -> dict[str, float]:
    """Compressions (m) of the installed state, at the largest lift and with all coils closed, those
    that are known.
    """
    found = {"installed": rest.precompression} if rest.precompression else {}
    if rest.curve is not None and rest.curve.buckling is not None:
        found["buckles"] = rest.curve.buckling.compression
    lifts = [
        float(np.max(run.channel("valve_lift")))
        for run in study.solutions
        if run.has("valve_lift") and len(run.time)
    ]
    own = study.still.get(f"{rest.spring}, {rest.model}")
    known = (
        [(key.name, value) for key, value in study.quantities.items()]
        if own is None
        else list(own.items())
    )
    lifts += [value for name, value in known if name in LIFTS]
    if lifts:
        found["full lift"] = rest.precompression + max(lifts)
    names = (f"{rest.spring}_coil_bind_lift", "coil_bind_lift")
    solid = next(
        (value for word in names for name, value in known if name == word and np.isfinite(value)),
        None,
    )
    return found if solid is None else found | {"solid": rest.precompression + solid}


def springs_chart(study: Study, key: str) -> Chart | None:
    """Force and stiffness of several springs over the lift, and of a nested pair those of both together."""
    models = list(dict.fromkeys(one.model for one in study.rest))
    springs = [*dict.fromkeys(one.spring for one in study.rest), "together"]
    curves = {
        (one.spring, one.model): _over_lift(one, one.curve)
        for one in reversed(study.rest)
        if one.curve is not None
    }
    for model in models:
        pair = [curves[name, model] for name in NESTED if (name, model) in curves]
        if len(pair) == len(NESTED):
            lift = pair[0][0][pair[0][0] <= pair[1][0][-1]]
            both = [sum(np.interp(lift, one[0], one[at]) for one in pair) for at in (1, 2)]
            curves["together", model] = lift, both[0], both[1]
    force, stiffness = list[Layer](), list[Layer]()
    for spring, model in sorted(curves, key=lambda one: (springs.index(one[0]), one[1])):
        lift, load, rate = curves[spring, model]
        name = spring if model == models[0] else f"{spring}, {theme.model_label(model)}"
        colour = theme.SERIES[springs.index(spring) % len(theme.SERIES)]
        dash = list(DASHES)[models.index(model) % 3]
        named = model == models[0]
        force.append(Line(lift * 1e3, load, name, colour, dash=dash, in_legend=named))
        stiffness.append(Line(lift * 1e3, rate * 1e-3, name, colour, dash=dash, in_legend=False))
    lifts = [
        found["full lift"] - one.precompression
        for one in study.rest
        if "full lift" in (found := marked_compressions(study, one))
    ]
    rules = (Rule("x", max(lifts) * 1e3, "full lift"),) if lifts else ()
    # the wall of a solid spring would flatten all else
    top = max(min(rate.max(), 4 * np.median(rate)) for _, _, rate in curves.values()) * 1e-3
    axis, heights = "valve lift (mm)", (0.0, LABELLED * float(top))
    reach = 0.0, 1e3 * max(float(lift[-1]) for lift, _, _ in curves.values())
    panels = (
        Panel(axis, "force (N)", tuple(force), "Force", rules=rules, x_range=reach),
        Panel(axis, "tangent stiffness (N/mm)", tuple(stiffness), "Stiffness", rules=rules, x_range=reach, y_range=heights),
    )  # fmt: skip
    caption = "Static force over the lift from the installed state."
    caption += _closing(rate for _, _, rate in curves.values()) + dash_key(models)
    return Chart(key, "Static force of the springs", caption, panels, 2, 370)


def _closing(stiffnesses: Iterable[np.ndarray]) -> str:
    """What a caption says of coils that close; empty where no stiffness rises."""
    rises = any(
        float(rate.max()) > (1 + RISE) * float(rate[0]) for rate in stiffnesses if len(rate)
    )
    return CLOSING if rises else ""


def dash_key(models: Sequence[str]) -> str:
    """`` Solid: modal model, dashed: finite-element rod.``; empty for one model."""
    if len(models) < 2:
        return ""
    looks = [DASHES[list(DASHES)[place % 3]] for place in range(len(models))]
    texts = (
        f"{look}: {theme.model_label(model)}" for look, model in zip(looks, models, strict=True)
    )
    return f" {', '.join(texts).capitalize()}."


def _over_lift(one: SpringAtRest, curve: StaticCurve) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Lift (m) from the installed state on, force (N) and stiffness (N/m) there."""
    points = curve.path or curve
    there = points.compression >= one.precompression - 1e-9
    return (
        points.compression[there] - one.precompression,
        points.force[there],
        points.stiffness[there],
    )


def state_grid(study: Study, one: SpringAtRest, curve: StaticCurve) -> Grid:
    """Height, load, rate and stress of a spring as installed, at full lift, as requested and solid."""
    own = study.still.get(f"{one.spring}, {one.model}", study.still.get("", {}))
    free, per_force = None, one.stress_per_force
    if one.installed is not None and one.installed.height is not None:
        free = one.installed.height + one.installed.compression

    def row(word: str, at: float) -> tuple[tuple[Cell, ...], tuple[str, ...]]:
        force, rate, stress = None, None, None
        if word == "solid":
            force, stress = own.get("solid_force"), own.get("solid_nominal_shear_stress")
        elif at <= curve.compression[-1]:
            force, rate = float(curve.force_at(at)), float(curve.stiffness_at(at)) * 1e-3
            stress = None if per_force is None else per_force * force
        height = None if free is None else (free - at) * 1e3
        values = at * 1e3, height, force, rate, None if stress is None else stress * 1e-6
        return (Cell(word), *(Cell(number(value), "number") for value in values)), ()

    marks = marked_compressions(study, one)
    solid = marks.pop("solid", None)
    states = [*marks.items(), *(("as requested", point.compression) for point in one.points)]
    states += [] if solid is None else [("solid", solid)]
    heads = ("state", "compression (mm)", "height (mm)", "force (N)", "rate (N/mm)", "shear stress by EN 13906-1 (MPa)")  # fmt: skip
    caption = f"{one.spring} by {theme.model_label(one.model)}"
    return Grid(heads, tuple(row(word, at) for word, at in states), caption=caption)


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
        if one.model != known[0][0].model:
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
    top = LABELLED * min(float(every.max()), 4 * float(np.median(every)))
    # Space at the right for the words next to the last mark.
    reach = (
        0.0,
        BEYOND
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
    caption = "Static compression from the free length."
    caption += _closing(np.asarray(curve.stiffness, dtype=float) for _, curve in known)
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
    loaded = base > LEAST_LOAD * float(np.nanmax(base, initial=0.0))
    return 100 * (np.asarray(curve.force) / np.where(loaded, base, np.nan) - 1)


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


def orders_chart(study: Study, key: str) -> Chart | None:
    """First axial mode of every spring and the cam orders that meet it over engine speed, of one spring
    alone with its shapes.
    """
    found = {
        (one.spring, one.model): float(one.modes.axial_frequencies[0])
        for one in reversed(study.rest)
        if one.modes is not None and len(one.modes.axial_frequencies)
    }
    if not found:
        return None
    found = dict(reversed(found.items()))
    springs, models = (list(dict.fromkeys(part)) for part in zip(*found, strict=True))
    low, high = min(found.values()), max(found.values())
    first, last = 60 * 2 * low / MODE_ORDERS[1], 60 * 2 * high / MODE_ORDERS[0]
    ends = np.array([first - 0.06 * (last - first), last + 0.1 * (last - first)])
    layers: list[Layer] = []
    above = (1 + ABOUT) * high
    upper = [
        order
        for order in range(MODE_ORDERS[0], MODE_ORDERS[1] + 1)
        if 120 * above / order < ends[1]
    ]
    for order in range(MODE_ORDERS[0], MODE_ORDERS[1] + 1):
        x = np.clip(120 * np.array([(1 - ABOUT) * low, above]) / order, *ends)
        at_end = "" if order in upper else f"{order}"
        layers.append(
            Line(x, order * x / 120, f"order {order}", theme.MUTED, 1.0, "dot", False, at_end)
        )
    # numbers of the lines that end at the top are above those
    layers.append(
        Marks(
            120 * above / np.array(upper),
            np.full(len(upper), above),
            "",
            theme.MUTED,
            labels=tuple(map(str, upper)),
            in_legend=False,
            size=0,
        )
    )
    for (spring, model), value in found.items():
        name = spring if model == models[0] else f"{spring}, {theme.model_label(model)}"
        colour = theme.SERIES[springs.index(spring) % len(theme.SERIES)]
        dash = list(DASHES)[models.index(model) % 3]
        named = model == models[0] and len(springs) > 1
        layers.append(Line(ends, np.full(2, value), name, colour, dash=dash, in_legend=named))
        orders = np.arange(MODE_ORDERS[0], MODE_ORDERS[1] + 1)
        speeds = 120 * value / orders
        hints = tuple(
            f"order {order} at {speed:.0f} rpm" for order, speed in zip(orders, speeds, strict=True)
        )
        layers.append(
            Marks(
                speeds,
                np.full(len(speeds), value),
                "",
                colour,
                size=6,
                filled=True,
                in_legend=False,
                hints=hints,
            )
        )
    axes = "engine speed (rpm)", "frequency (Hz)"
    heights = (1 - ABOUT) * low, (1 + 1.4 * ABOUT) * high
    panels = [Panel(*axes, tuple(layers), "First axial mode and cam orders", x_range=(float(ends[0]), float(ends[1])), y_range=heights)]  # fmt: skip
    shapes = (shapes_panel(one) for one in study.rest if len(springs) == 1)
    panels += [one for one in shapes if one is not None][:1]
    caption = "Dotted: cam orders with their numbers; at a dot one meets the mode and excites surge most. Both ends of the spring are fixed."
    caption += dash_key(models)
    return Chart(key, "Natural modes", caption, tuple(panels), len(panels), 370)


def shapes_panel(one: SpringAtRest) -> Panel | None:
    """Axial part of the shapes of the axial modes along the wire; None of a model without shapes."""
    result, lines = one.modes, list[Layer]()
    if result is None or not len(result.natural_frequency):
        return None
    shapes = zip(result.axial_modes[:MAX_SHAPES], theme.SERIES, strict=False)
    for place, (mode, colour) in enumerate(shapes, start=1):
        shape = np.asarray(result.shape)[mode, :, 2]
        largest = shape[np.argmax(np.abs(shape))] if len(shape) else 0.0
        if largest:
            x, y = thin(np.asarray(result.coil_number), shape / largest)
            lines.append(Line(x, y, f"mode {place}", colour))
    axes, title = (
        ("coil number (turns from the lower end)", "axial part, largest 1"),
        f"Axial shapes, {theme.model_label(one.model)}",
    )
    return Panel(*axes, tuple(lines), title, y_range=(-1.15, 1.15)) if lines else None


def modes_chart(members: list[SpringAtRest], key: str, title: str) -> Chart | None:
    """Axial mode shapes of each model that gives them, and how much axial force each mode carries
    from end to end.
    """
    panels = []
    for one in members:
        shapes = shapes_panel(one)
        if shapes is None:  # every mode of a model without shapes is axial and carries all
            continue
        panels.append(shapes)
        panels.append(_carried(one, theme.model_label(one.model)))
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
    axial, found = (
        np.isin(np.arange(len(share)), result.axial_modes),
        np.asarray(result.natural_frequency, dtype=float),
    )
    top = float((found[axial] if np.any(axial) else found).max()) * 1.12
    share = share / max(float(share[found <= top].max(initial=0.0)), 1e-300)  # of what is drawn
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
    return Panel(
        "natural frequency (Hz)",
        "force carried, largest 1",
        tuple(layers),
        f"Modes, {label}",
        x_range=(0, top),
        y_range=(0, 1.15),
    )


SPEC = SectionSpec("at-rest", "Spring at rest", blocks)
