"""Energy balance and order spectrum of a run."""

from __future__ import annotations

import numpy as np

from valvetrain.quantities.cycle import reported_cycle
from valvetrain.quantities.energy import energy_balance
from valvetrain.quantities.spectrum import order_spectrum, surge_order
from valvetrain.quantities.study import SpringStudy
from valvetrain.report import theme
from valvetrain.report.chart import Chart, Line, Panel, Rule, thin
from valvetrain.report.figures.force import runs_at
from valvetrain.report.table import Table, table
from valvetrain.report.words import rpm, speed_words
from valvetrain.solution.result import Solution

LARGEST_ORDER = 80


def energy_table(run: Solution) -> Table | None:
    """``cam angle`` (deg, unwrapped), ``work done``, ``stored``, ``kinetic``, ``dissipated`` and ``imbalance`` (mJ).

    None for a model without energies.
    """
    balance = energy_balance(run)
    if balance is None:
        return None
    parts = {
        "work done": balance.work, "stored": balance.stored, "kinetic": balance.kinetic,
        "dissipated": balance.dissipated, "imbalance": balance.imbalance,
    }  # fmt: skip
    return table(("cam angle", "deg", np.degrees(balance.cam_angle)), *((name, "mJ", values * 1e3) for name, values in parts.items()))


def energy_chart(data: Table, engine_speed: float) -> Chart:
    """What went in, what is stored, what became heat (left) and what is missing (right), over the whole run."""
    names = ("work done", "stored", "kinetic", "dissipated")
    lines = tuple(
        Line(*thin(data["cam angle"], data[name]), name, colour, dash="dash" if name == "work done" else "solid")
        for name, colour in zip(names, theme.SERIES, strict=False)
    )
    missing = Line(*thin(data["cam angle"], data["imbalance"]), "stored + dissipated − work", theme.ALERT)
    x_label, span = "cam angle from the start of the run (cam degrees)", float(np.ptp(data["work done"])) or 1.0
    bound = 1.25 * max(0.01 * span, float(np.max(np.abs(data["imbalance"]))))
    limits = tuple(Rule("y", sign * 0.01 * span, "1 % of the work done" if sign > 0 else "") for sign in (1, -1))
    panels = (
        Panel(x_label, "energy (mJ)", lines, title="Energies", x_step=90),
        Panel(x_label, "imbalance (mJ)", (missing,), title="Imbalance", rules=limits, y_range=(-bound, bound), x_step=180),
    )
    speed = speed_words(engine_speed)
    caption = f"Energy balance of the whole run at {speed}, from its first sample. Work is done on the spring by the retainer."
    return Chart(f"energy-{rpm(engine_speed):g}", f"Energy balance at {speed}", caption, panels, columns=2, height=360)


def spectrum_table(study: SpringStudy, engine_speed: float) -> Table:
    """``run``, ``order`` (per cam revolution) and ``amplitude`` (N, zero to peak) of the seat force of whole cycles."""
    models, orders, sizes = [], [], []
    for run in runs_at(study, engine_speed):
        cycle = reported_cycle(run)
        if cycle.whole:
            spectrum = order_spectrum(cycle, "seat_force", LARGEST_ORDER)
            models += [run.model] * (len(spectrum.order) - 1)
            orders.append(spectrum.order[1:])
            sizes.append(spectrum.amplitude[1:])
    joined = [np.concatenate(parts) if parts else np.zeros(0) for parts in (orders, sizes)]
    return table(("run", "", np.array(models, dtype=object)), ("order", "", joined[0]), ("amplitude", "N", joined[1]))


def spectrum_chart(data: Table, axial_frequencies: np.ndarray, engine_speed: float) -> Chart:
    """Amplitude by cam order on a logarithmic axis; the orders of the axial modes ruled."""
    lines = []
    for model in dict.fromkeys(data["run"].tolist()):
        mine = data["run"] == model
        level = np.maximum(data["amplitude"][mine], 1e-2)
        lines.append(Line(data["order"][mine], level, theme.model_words(model), theme.model_colour(model), width=1.4))
    lines.sort(key=lambda line: line.colour == theme.model_colour("finite-element"))
    orders = [surge_order(float(value), engine_speed) for value in axial_frequencies[:3]]
    rules = tuple(Rule("x", order, f"mode {index}") for index, order in enumerate(orders, start=1) if order < LARGEST_ORDER)
    x_label, y_label = "order (oscillations per cam revolution)", "amplitude (N, 0 to peak)"
    panel = Panel(x_label, y_label, tuple(lines), rules=rules, x_range=(0, LARGEST_ORDER), y_log=True)
    speed = speed_words(engine_speed)
    caption = f"Order spectrum of the seat force at {speed}. Coil clash fills the orders above those of the lift law and the first modes."
    return Chart(f"orders-{rpm(engine_speed):g}", f"Order spectrum at {speed}", caption, (panel,), height=340)
