"""Pages that a build writes from the tables of the package: quantities, plausible values, defaults, stored error bars."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from defaults_page import defaults_page
from generated import write_changed

from valvetrain.parameters.loading import load_case
from valvetrain.parameters.summary import rpm
from valvetrain.quantities.limits import TABLES
from valvetrain.quantities.table import AT_REST, CAM, EVENTS, RUNS, SCATTER, SWEEP, TRAINS
from valvetrain.registry import BUILT_IN, find
from valvetrain.runs.stored_error_bars import load_uncertainty
from valvetrain.solution.definition import QuantityRow, label_of, shown, tables
from valvetrain.solution.uncertainty import Uncertainty

_HEAD = """\
# Named quantities

One name per number, the same in a case's `published` list, in results, in `--json` and in the report. A computed value is found by
name, engine speed (rad/s of the crank; none for what belongs to no run) and label of the run.

All values are SI inside and in JSON; tables show the unit given here. Angles are cam angles, engine speed is crank speed. Forces are
compressive positive and taken over the reported cycle. Motion along the spring is positive from seat to retainer; coil numbers count
from 1 at the seat. In a name, `{n}` and other single letters represent a number, longer words in braces for a place, a link or a spring.
Quantities of one spring of a nested pair carry its name in front: `outer_coil_bind_clearance`;
loads, rates and masses of both together: `pair_card_preload`.

A name that is in no table has the dimension of its last word (`_force`, `_cam_angle`, `_displacement`, ...). A package adds a
table of its own by the entry-point group `valvetrain.quantities`.
"""

_GROUPS: tuple[tuple[str, str, tuple[QuantityRow, ...]], ...] = (
    (
        "At rest",
        "Of springs and lift before anything runs; estimates hold for the free state.",
        AT_REST,
    ),
    (
        "Cam",
        "Of the lift law and the cam's contour before anything runs, as `valvetrain check` lists them.",
        CAM,
    ),
    ("Runs", "Of a run, for a spring under prescribed motion and for springs in a train.", RUNS),
    (
        "Trains",
        'Of one steady cycle of a train. "Open" means that the rigid lift is above a tenth of its maximum.',
        TRAINS,
    ),
    (
        "Valve events",
        "Of a train: opening and closing, in cam angle, and the crank angle between them.",
        EVENTS,
    ),
    ("Scatter of a train", "Of a train whose motion does not repeat: over 8 cycles.", SCATTER),
    ("Loss of control", "Of a sweep over engine speeds, and by rigid theory.", SWEEP),
)
_SYSTEMS = {("spring", "train"): "both", ("spring",): "spring", ("train",): "train"}


def quantities_page() -> str:
    """The page of quantities: general ones by group, then those of each published study."""
    parts = [_HEAD, *(f"## {title}\n\n{lead}\n\n{_table(rows)}" for title, lead, rows in _GROUPS)]
    parts += [_study(word) for word in BUILT_IN["quantities"] if word != "general"]
    return "\n".join(parts)


def _study(word: str) -> str:
    """Section of one published study, led by its description."""
    lead = find("sources", word).description.strip()
    return f"## Of the study {word}\n\n{lead}\n\n{_table(tables()[word])}"


def _table(rows: Sequence[QuantityRow]) -> str:
    lines = ["| quantity | in words | shown in | of | definition |", "|---|---|---|---|---|"]
    for one in rows:
        better = f" ({one.sense})" if one.sense else ""
        lines.append(
            f"| `{one.name}` | {one.label} | {one.shown_unit or '1'} | {_SYSTEMS[one.systems]} | {one.definition}{better} |"
        )
    return "\n".join(lines) + "\n"


def plausible_page() -> str:
    """The page of plausible values: every range with its reason."""
    lines = [
        "# Plausible values\n",
        "Equations have solutions for numbers that no valvetrain has. Beyond these ranges a request is refused before it is run,",
        "and a run, or a static curve, that reaches one ends with the status `diverged`, with its numbers. `--implausible`, or",
        "`implausible=True` in Python, accepts all of them.\n",
        "| | quantity | minimum | maximum | reason |",
        "|---|---|---|---|---|",
    ]
    for kind, ranges in TABLES.items():
        for one in ranges:
            low, high = (
                ("" if math.isinf(value) else f"{value / one.scale:g} {one.unit}".strip())
                for value in (one.low, one.high)
            )
            names = ", ".join(f"`{name}`" for name in one.names.split())
            shown = f" ({names})" if kind == "of a run" else ""
            lines.append(f"| {kind} | {one.label}{shown} | {low} | {high} | {one.reason} |")
    lines += [
        "",
        "Numbers of a case lie within the ranges of its tables; no option accepts others. An unusual value that has its unit (a rate of",
        "1 N/m, an engine speed above 30 000 rpm) is taken as written, with a warning; a bare number of Python there is refused as a slip.",
        "",
    ]
    return "\n".join(lines)


#: Library cases whose error bars are stored.
_REFINED = ("gu2021-beehive-blind", "tdi-pushrod", "vaz-ohc")


def error_bars_page() -> str:
    """The page of stored error bars: every headline number of the library cases."""
    lines = [
        "# Stored error bars\n",
        "Headline numbers of the library cases with their numerical error bars, and their ranges over constants that nobody",
        "knows: contact stiffness from half to twice the case's, damping from 0.6 to 1.5 times. [How they are made](uncertainty.md).\n",
    ]
    for name in _REFINED:
        lines.append(f"## {name}\n")
        groups: dict[tuple[float | None, str], list[Uncertainty]] = {}
        for row in load_uncertainty(load_case(name).record()):
            groups.setdefault((row.engine_speed, row.label), []).append(row)
        for (speed, label), rows in groups.items():
            at = "at rest" if speed is None else f"{rpm(speed):.0f} rpm"
            lines += [
                f"### {', '.join(filter(None, (label, at)))}\n",
                "| quantity | value | ± | unit | over contact stiffness | over damping |",
                "|---|---|---|---|---|---|",
                *map(_bar, rows),
                "",
            ]
    return "\n".join(lines)


def _bar(row: Uncertainty) -> str:
    numbers = np.array([row.value, row.numerical, *row.contact_stiffness, *row.damping])
    scaled, unit = shown(row.quantity, numbers)
    value, _, soft, stiff, least, most = (f"{number:.5g}" for number in scaled)
    bar = f"{scaled[1]:.3g}"
    if row.numerical > abs(row.value):
        bar = "not resolved"
    return f"| {label_of(row.quantity)} | {value} | {bar} | {unit} | {soft} to {stiff} | {least} to {most} |"


#: Page of the documentation -> its text.
PAGES: dict[str, Callable[[], str]] = {
    "quantities.md": quantities_page,
    "plausible.md": plausible_page,
    "defaults.md": defaults_page,
    "error-bars.md": error_bars_page,
}


def write(app) -> None:
    """Write the pages before the sources are read."""
    for name, text in PAGES.items():
        write_changed(Path(app.srcdir) / name, text())


def setup(app):
    """Write the pages of a build."""
    app.connect("builder-inited", write)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
