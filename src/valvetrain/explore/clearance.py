"""A study over the clearance to coil bind: at which clearance clash, surge and peak force are least,
and the figure of them over it.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from valvetrain.explore.study_charts import output_label, shown_output
from valvetrain.explore.study_points import changing, is_chosen
from valvetrain.explore.table import StudyTable, run_label
from valvetrain.report import theme
from valvetrain.report.chart import Band, Chart, Line, Marks, Panel
from valvetrain.report.clauses import joined
from valvetrain.report.text import number, unit_text
from valvetrain.solution.definition import definition_of, label_of
from valvetrain.solution.uncertainty import NOT_RESOLVED

Array = NDArray[np.float64]
CLEARANCE = "coil_bind_clearance"
#: What less clearance is hoped to calm, and what it costs.
CALMED = ("clash_energy", "surge_amplitude_force", "peak_spring_force")
#: Clearance (mm) that the trade runs on purpose, as docs/limits.md says.
TRADE = (1.3, 1.8)
#: Runs of each point that are drawn, and height (px) of the figure.
MAX_RUNS, HEIGHT = 4, 340


def over_clearance(table: StudyTable) -> tuple[str, ...]:
    """The outputs of :data:`CALMED` of a study whose points differ in clearance by one quantity;
    empty for any other.
    """
    if CLEARANCE not in table.outputs or not is_chosen(table) or len(changing(table)) != 1:
        return ()
    at = _per_point(table, CLEARANCE)
    known = np.isfinite(at).all(axis=1)
    if np.count_nonzero(known) < 3 or np.ptp(at[known].mean(axis=1)) <= 0:
        return ()
    names = [
        name
        for name in CALMED
        if name in table.outputs and np.isfinite(_per_point(table, name)[known]).all()
    ]
    return tuple(names) if names != ["peak_spring_force"] else ()


def clearance_clause(table: StudyTable, names: tuple[str, ...]) -> str:
    """Whether the clearance of the trade pays, where it was computed; else ``clash energy is least at
    3.74 mm of clearance to coil bind (1.61 mJ, 4.99 mJ at most)``; the worst run of each point counts.
    """
    at = _per_point(table, CLEARANCE).mean(axis=1)
    worst = {name: _per_point(table, name).max(axis=1) for name in names}
    inside = np.flatnonzero((at >= TRADE[0]) & (at <= TRADE[1]))
    if len(inside):
        said = _of_trade(table, worst, at, inside)
    else:
        parts = []
        for place, (name, values) in enumerate(worst.items()):
            least = int(np.nanargmin(values))
            where = (
                f"{number(float(at[least]), 3)} mm{'' if place else ' of clearance to coil bind'}"
            )
            most = _text(name, float(np.nanmax(values)))
            is_least = " is least" if not place else ""
            parts.append(
                f"{label_of(name)}{is_least} at {where} ({_text(name, values[least])}, {most} at most)"
            )
        said = joined(parts)
    runs = len(table.plan.runs)
    return f"{said}{f', each the worst of {runs} runs' if runs > 1 else ''}"


def _of_trade(
    table: StudyTable, worst: dict[str, Array], at: Array, inside: NDArray[np.intp]
) -> str:
    """Whether the clearances of the trade pay next to the widest one, and which to choose instead: they
    do where what they calm falls by a larger factor than what they worsen rises.
    """
    widest = int(np.nanargmax(at))
    less, more, same, gain, loss = list[str](), list[str](), list[str](), 1.0, 1.0
    for name, values in worst.items():
        there, wide = values[inside], float(values[widest])
        low, high = (float(one) for one in (there.min(), there.max()))
        error = _error(table, name)
        ends = f"{number(low, 3)} to {_text(name, high)}" if low < high else _text(name, high)
        list_of = (
            less
            if high + error(high) < wide - error(wide)
            else more
            if low - error(low) > wide + error(wide)
            else same
        )
        list_of.append(f"{label_of(name)} ({ends} for {_text(name, wide)})")
        if low > 0 and wide > 0 and list_of is not same:
            gain, loss = (
                max(gain, wide / float(there.mean())),
                max(loss, float(there.mean()) / wide),
            )
    span = " to ".join(
        dict.fromkeys(number(float(one), 3) for one in (at[inside].min(), at[inside].max()))
    )
    pays = "pays" if gain > loss else "does not pay"
    changes = [
        f"{word} {joined(names)}"
        for word, names in (("less", less), ("more", more), ("as much", same))
        if names
    ]
    said = (
        f"{span} mm of clearance to coil bind, as the trade runs, {pays} here: "
        f"{' but '.join(changes[:2])}{''.join(f' and {one}' for one in changes[2:])} next to {number(float(at[widest]), 3)} mm"
    )
    name, values = next(iter(worst.items()))
    best = int(np.nanargmin(values))
    error, wide, least = _error(table, name), float(values[widest]), float(values[best])
    if gain > loss or at[best] <= TRADE[1]:
        return said
    if best != widest and least + error(least) >= wide - error(wide):
        return f"{said}; where {label_of(name)} is least is {NOT_RESOLVED}"
    tried = ", the largest tried, or more" if best == widest else ""
    others = [f"{label_of(one)} {_text(one, float(worst[one][best]))}" for one in list(worst)[1:]]
    price = f", with {joined(others)}" if others else ""
    return f"{said}; choose {number(float(at[best]), 3)} mm{tried}, for {label_of(name)} is least there ({_text(name, float(values[best]))}{price})"


def _error(table: StudyTable, name: str) -> Callable[[float], float]:
    """The error bar of a value of an output: the largest share that is known of it, none where error bars were not
    computed.
    """
    known = vars(table).get("error_bars", {})  # words compute nothing
    bars = [one[name] for one in known.values() if name in one]
    share = max((one.numerical / abs(one.value) for one in bars if one.value), default=0.0)
    return lambda value: share * abs(value)


def clearance_chart(table: StudyTable, names: tuple[str, ...]) -> Chart:
    """Each of ``names`` over the clearance, a line per run; shaded what the trade runs."""
    at, panels = _per_point(table, CLEARANCE), list[Panel]()
    for name in names:
        values, layers = _per_point(table, name), list[Line | Marks]()
        for place, run in enumerate(table.plan.runs[:MAX_RUNS]):
            order = np.argsort(at[:, place])
            x, y = at[order, place], values[order, place]
            label, colour = run_label(run) or "points", theme.SERIES[place]
            layers += [
                Line(x, y, label, colour),
                Marks(x, y, label, colour, filled=True, size=6.0, in_legend=False),
            ]
        low, high = float(np.nanmin(at)), float(np.nanmax(at))
        seen = low < TRADE[1] and high > TRADE[0]
        bands = (Band(max(TRADE[0], low), min(TRADE[1], high), ""),) if seen else ()
        room = 0.03 * (high - low)
        panels.append(
            Panel(
                f"{label_of(CLEARANCE)} (mm)",
                output_label(name),
                tuple(layers),
                bands=bands,
                x_range=(low - room, high + room),
            )
        )
    titles = joined([label_of(name) for name in names])
    return Chart(
        "over-clearance",
        f"{titles[:1].upper()}{titles[1:]} over the clearance to coil bind",
        f"Shaded: {TRADE[0]} to {TRADE[1]} mm, which the trade runs on purpose.",
        tuple(panels),
        len(panels),
        HEIGHT,
        len(table.plan.runs) > 1,
    )


def _per_point(table: StudyTable, name: str) -> Array:
    """An output (points, runs) in the unit of tables."""
    return shown_output(table, name).reshape(-1, max(1, len(table.plan.runs)))


def _text(name: str, value: float) -> str:
    return f"{number(float(value), 3)} {unit_text(definition_of(name).unit_word)}".strip()
