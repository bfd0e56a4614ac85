"""Spring models over each other: static curves, natural frequencies, end forces of a ride."""

from __future__ import annotations

import numpy as np

from valvetrain.quantities.spring_comparison import SpringComparison, curve_at
from valvetrain.report import theme
from valvetrain.report.chart import Chart, Line, Marks, Panel, Rule, thin
from valvetrain.report.table import Table, table
from valvetrain.report.words import speed_words

DASHES = {"modal-varied": "dash"}


def curve_table(study: SpringComparison) -> Table:
    """``model``, ``compression`` (mm) and ``force`` (N), all curves below each other."""
    models = np.array([item.model for item in study.members for _ in item.curve.compression], dtype=object)
    compression, force = ([getattr(item.curve, name) for item in study.members] for name in ("compression", "force"))
    return table(("model", "", models), ("compression", "mm", np.concatenate(compression) * 1e3), ("force", "N", np.concatenate(force)))


def difference_table(study: SpringComparison) -> Table:
    """Compression (mm) of each increment of the reference, force (N) of each model there, its difference (%)."""
    at = study.members[0].curve.compression[1:]
    forces = {item.model: curve_at(item.curve, at) for item in study.members}
    columns: list = [("compression", "mm", at * 1e3)]
    columns += [(theme.model_words(name), "N", values) for name, values in forces.items()]
    base = np.where(forces[study.reference] != 0, forces[study.reference], np.nan)
    columns += [(f"{theme.model_words(name)}, difference", "%", 100 * (forces[name] / base - 1)) for name in study.models[1:]]
    return table(*columns)


def frequency_table(study: SpringComparison) -> Table:
    """Mode of the reference, ``axial`` number (0: not axial), natural frequency (Hz) by each model, difference (%), shape agreement."""
    rows = [row for row in study.differences if row.quantity == "natural frequency"]
    columns: list = [("mode", "", np.array([int(row.place) for row in rows])), ("axial", "", np.array([row.axial for row in rows]))]
    columns += [(theme.model_words(name), "Hz", np.array([row.values.get(name, np.nan) for row in rows])) for name in study.models]
    shown = [name for name in study.models[1:] if name != "modal-varied" or len(study.models) == 2]
    agreement = [
        (f"shape agreement, {theme.model_words(name)}", "", np.array([row.shape_agreement.get(name, np.nan) for row in rows]))
        for name in shown
    ]
    return table(*columns, *_differences(study, rows), *agreement)


def _differences(study: SpringComparison, rows: list) -> list:
    found = []
    for name in study.models[1:]:
        shares = [row.relative(name, study.reference) for row in rows]
        values = np.array([np.nan if share is None else 100 * share for share in shares], dtype=float)
        found.append((f"{theme.model_words(name)}, difference", "%", values))
    return found


def curve_chart(data: Table, differences: Table, study: SpringComparison) -> Chart:
    """Static curves over each other left, their difference from the reference at its increments right."""
    forces: list[Line | Marks] = []
    apart: list[Line] = []
    for name in study.models:
        mine = data["model"] == name
        x, colour, dash = data["compression"][mine].astype(float), theme.model_colour(name), DASHES.get(name, "solid")
        force = data["force"][mine].astype(float)
        forces.append(Line(*thin(x, force), theme.model_words(name), colour, dash=dash))
        if name == study.reference:
            forces.append(Marks(x, force, f"{theme.model_words(name)}, increments", colour, size=5, filled=True))
        else:
            share = differences[f"{theme.model_words(name)}, difference"]
            apart.append(Line(differences["compression"], share, theme.model_words(name), colour, dash=dash))
    label, installed = "compression from the free length (mm)", study.installed * 1e3
    rules = (Rule("x", installed, f"installed, {installed:g} mm"),) if installed else ()
    panels = [Panel(label, "force (N)", tuple(forces), title="Force", rules=rules)]
    if apart:
        panels.append(Panel(label, "force, difference (%)", tuple(apart), title="Difference", rules=(*rules, Rule("y", 0.0))))
    caption = "Static compression from the free length to a little beyond the installed state, coils closing on the way."
    return Chart("spring-models-static", "Static curves", caption, tuple(panels), columns=2, height=380)


def frequency_chart(data: Table, study: SpringComparison) -> Chart:
    """Natural frequencies side by side left, differences from the reference right, axial modes filled."""
    beside, apart = [], []
    mode, axial = data["mode"].astype(float), data["axial"] > 0
    marks = ("circle", "diamond", "triangle")
    for name, symbol in zip(study.models, marks, strict=False):
        words, colour = theme.model_words(name), theme.model_colour(name)
        values = data[words].astype(float)
        for kind, filled in ((axial, True), (~axial, False)):
            known = kind & np.isfinite(values)
            label = f"{words}, {'axial' if filled else 'other'} mode"
            if known.any():
                beside.append(Marks(mode[known], values[known], label, colour, symbol, size=8, filled=filled))
            if known.any() and name != study.reference:
                shares = data[f"{words}, difference"].astype(float)[known]
                apart.append(Marks(mode[known], shares, label, colour, symbol, size=8, filled=filled))
    x_range = (0.3, len(mode) + 0.7)
    x_label = f"mode of the {theme.model_words(study.reference)}"
    panels = [Panel(x_label, "natural frequency (Hz)", tuple(beside), title="Natural frequencies", x_range=x_range)]
    if apart:
        rules = (Rule("y", 0.0),)
        panels.append(Panel(x_label, "frequency, difference (%)", tuple(apart), title="Difference", rules=rules, x_range=x_range))
    caption = (
        "Modes about the installed state, both ends held, coils that touch kept together. Modes are paired by the agreement of their "
        "shapes and by frequency; filled marks are axial modes."
    )
    return Chart("spring-models-modes", "Natural frequencies", caption, tuple(panels), columns=2, height=400)


def ride_table(study: SpringComparison) -> Table:
    """``model``, ``cam angle`` (deg), ``retainer force`` and ``seat force`` (N) of the rides."""
    runs = [run for run in study.rides if len(run.time) > 2]
    models = np.array([run.model for run in runs for _ in run.time], dtype=object)

    def joined(values: list) -> np.ndarray:
        return np.concatenate(values) if values else np.zeros(0)

    return table(
        ("model", "", models), ("cam angle", "deg", joined([np.degrees(run.cam_angle) for run in runs])),
        ("retainer force", "N", joined([run.channel("retainer_force") for run in runs])),
        ("seat force", "N", joined([run.channel("seat_force") for run in runs])),
    )  # fmt: skip


def ride_chart(data: Table, study: SpringComparison) -> Chart:
    """Retainer force left and seat force right over the cam angle."""
    panels = []
    for name in ("retainer force", "seat force"):
        lines = []
        for model in dict.fromkeys(data["model"]):
            mine = data["model"] == model
            x, y = data["cam angle"][mine].astype(float), data[name][mine].astype(float)
            lines.append(Line(*thin(x, y), theme.model_words(model), theme.model_colour(model)))
        panels.append(Panel("cam angle (cam degrees)", f"{name} (N)", tuple(lines), title=name.capitalize()))
    words = speed_words(study.rides[0].engine_speed)
    caption = (
        f"From rest in the installed state, at {words}, mass-proportional damping only, forces of the rod as means over the increments of "
        "the solid. A jolt in its first increments comes from the solver, which shows it at rest too; it fades."
    )
    return Chart("spring-models-ride", f"Ride at {words}", caption, tuple(panels), columns=2, height=380)
