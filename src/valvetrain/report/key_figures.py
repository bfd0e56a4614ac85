"""Key figures next to the verdict: of one spring set how long the valve is open, spring margin, force and power
of the cam, red line, the time step and where a spring begins; of several, and over engine speed, power, stress, surge, clash and clearance of each.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

from valvetrain.quantities.table import EVENT_LIFTS
from valvetrain.report.clauses import (
    Runs,
    Worst,
    figure,
    one_bracket,
    quantity_text,
)
from valvetrain.report.control import controlled_to, range_in_use, red_line_margin
from valvetrain.report.run_clauses import judged_runs, worst_run
from valvetrain.report.sweep_verdict import NO_SURGE, runs_over_speed
from valvetrain.report.text import rpm
from valvetrain.solution.critical import FLOAT_LIFT
from valvetrain.solution.definition import NESTED
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study

#: Heights of the valve at which a card gives its duration.
CARD_LIFTS = ("50_thou", "1_mm")
POWER = "mean_cam_power"
CAM_FORCE = "peak_cam_contact_force"
MARGIN = "minimum_spring_margin_force"
CLEARANCE = "coil_bind_clearance"
#: What is said of a power or force of the cam at a speed at which control is lost.
IMPACTS = ", beyond control: with impacts"
#: What is listed of each label, of runs alone what is next: quantity -> its name, and whether the least counts.
OF_RUNS = {
    MARGIN: ("spring margin over inertia, rigid parts", True),
    CAM_FORCE: ("largest cam force", False),
}
EACH = OF_RUNS | {
    POWER: ("cam power per valve", False),
    "open_nominal_shear_stress": ("shear stress", False),
    "surge_amplitude_force": ("surge of one cam order, 0 to peak", False),
    "clash_energy": ("clash energy", False),
    CLEARANCE: ("clearance to coil bind at full lift", True),
}
PRELOAD = "begins at rest, at a preload of"
#: Labels of which each is listed.
MAX_LABELS = 4


def key_figures(study: Study) -> tuple[tuple[str, str], ...]:
    """(name, value) of each, of the run that is worst or of the run where it is largest; of several
    spring sets and over engine speed of each label; nothing without runs.
    """
    runs = judged_runs(study)
    worst = worst_run(runs)
    if worst is None:
        return ()
    several = len({run.spring_set for run in runs.solutions}) > 1
    line = () if study.over_speed else tuple(_red_line(study, runs))
    if study.over_speed or (several and len(study.labels) <= MAX_LABELS):
        return (*_of_each(study), *line) if len(study.labels) <= MAX_LABELS else line
    figures = list(_figures(runs, worst))
    several = len(runs.solutions) > 1
    starts = {quantity_text("preload", runs.value(run, "preload")) for run in runs.solutions}
    alike = len({id(run) for _, run, _ in figures}) == 1
    named = (
        (
            name
            if not several or (alike and place) or (name == PRELOAD and len(starts) == 1)
            else f"{name} {runs.place(run)}",
            value,
        )
        for place, (name, run, value) in enumerate(figures)
    )
    return (*named, *line)


def _red_line(study: Study, runs: Runs) -> Iterator[tuple[str, str]]:
    """How far the fastest run is from the red line, where the case states one."""
    if study.record.red_line is not None:
        fastest = max(run.engine_speed for run in runs.solutions)
        margin = red_line_margin(fastest, study.record.red_line)
        yield "fastest run", f"{rpm(fastest):.0f} rpm{margin}"


def _of_each(study: Study) -> Iterator[tuple[str, str]]:
    """The largest or least value of every label, with its engine speed where that differs."""
    known = {label: runs_over_speed(study, label) for label in study.labels}
    every = Runs(study.solutions)
    names = {run.label: every.name(run) for run in study.solutions}
    # what parts take as they meet again is no cost of a valvetrain: power counts as far as control goes
    held = {label: _controlled(study, label, runs) for label, runs in known.items()}
    bound = {label: _with_bound(study, label, runs) for label, runs in known.items()}
    judged = {POWER: held, CLEARANCE: bound}
    for quantity, (name, least) in EACH.items():
        if study.over_speed and quantity in OF_RUNS:
            continue
        found = {
            label: one
            for label, runs in judged.get(quantity, known).items()
            if (one := _worst(_in_use(study, runs), quantity, least)) is not None
        }
        beyond = {
            label: _beyond(study, quantity, runs)
            for label, runs in judged.get(quantity, known).items()
        }
        places = {label: _place(known[label], one) + beyond[label] for label, one in found.items()}
        alike = len(set(places.values())) == 1
        values = {label: _value(known[label], one) for label, one in found.items()}
        same = len(set(values.values())) == 1 and len(values) == len(known)
        texts = [
            value
            + (f" ({names[label]})" if len(known) > 1 and not (same and alike) else "")
            + ("" if alike else places[label])
            for label, value in values.items()
        ]
        texts = texts[:1] if same and alike else texts
        if texts:
            yield (
                name,
                one_bracket(", ".join(texts) + (next(iter(places.values())) if alike else "")),
            )


def _in_use(study: Study, runs: Runs) -> Runs:
    """The runs of a label up to the red line, or while control is maintained; all of them where none is or of runs
    that are no sweep.
    """
    limit, _ = range_in_use(study)
    some = [run for run in runs.solutions if run.engine_speed <= limit]
    return replace(runs, solutions=tuple(some)) if some and study.over_speed else runs


def _beyond(study: Study, quantity: str, runs: Runs) -> str:
    """`` (beyond control 1573 MPa at 15000 rpm)``: an extreme that the speeds in use do not have; else empty."""
    least = EACH[quantity][1]
    used, every = (_worst(one, quantity, least) for one in (_in_use(study, runs), runs))
    if used is None or every is None or _value(runs, used) == _value(runs, every):
        return ""
    value = _value(runs, every)
    if quantity.endswith("shear_stress"):  # its bounds are those of the wire, said before
        value = runs.text(every)
    return f" (beyond {range_in_use(study)[1]} {value}{_place(runs, every)})"


def _controlled(study: Study, label: str, runs: Runs) -> Runs:
    """The runs of a label that keep control; all of them where none does."""
    limit = controlled_to(study, label)
    some = [run for run in runs.solutions if run.engine_speed < limit and not beyond_control(run)]
    return replace(runs, solutions=tuple(some)) if some else runs


def beyond_control(run: Solution) -> bool:
    """Whether the cam is left while the valve is open, or the valve floats: what meets again then is an
    impact on the cam, which a bounce on the seat is not.
    """
    left = run.quantities.get("minimum_cam_contact_force", math.inf) <= 0
    return left or run.quantities.get("float_excess_lift", 0.0) > FLOAT_LIFT


def _with_bound(study: Study, label: str, runs: Runs) -> Runs:
    """The runs of a label with those that ended at coil bind, which has no clearance."""
    every = (*study.runs(label), *(run for run in study.between if run.label == label))
    ended = tuple(run for run in every if run.status.code == "coil-bind")
    return replace(runs, solutions=(*runs.solutions, *ended))


def _worst(runs: Runs, quantity: str, least: bool) -> Worst | None:
    """Of a pair of springs the worse one; no surge that is round-off."""
    found = [
        one
        for spring in ("", *NESTED)
        if (one := runs.worst(f"{spring}_{quantity}".strip("_"), least)) is not None
    ]
    worst = (min if least else max)(found, key=lambda one: one.value, default=None)
    if worst is not None and quantity == "surge_amplitude_force":
        peak = runs.worst("peak_spring_force", least=False)
        if peak is not None and worst.value <= NO_SURGE * peak.value:
            return None
    return worst


def _place(runs: Runs, one: Worst) -> str:
    return "" if one.run is None or runs.speeds == 1 else f" at {rpm(one.run.engine_speed):.0f} rpm"


def _value(runs: Runs, one: Worst) -> str:
    """The value; of a stress its range, and what the wire is permitted, where that is known."""
    if one.value <= 0 and (one.name == "clash_energy" or one.name.endswith(CLEARANCE)):
        return "none"
    return f"{runs.bounded(one)}{_impacts(runs, one)}"


def _impacts(runs: Runs, one: Worst) -> str:
    """What is said of power and force of a cam beyond control; empty of other values."""
    run = one.run or runs.solutions[0]
    return IMPACTS if one.name in (POWER, CAM_FORCE) and beyond_control(run) else ""


def _figures(runs: Runs, worst: Solution) -> Iterator[tuple[str, Solution, str]]:
    open_for = [
        f"{figure(math.degrees(angle), 4)} {EVENT_LIFTS[lift]}"
        for lift in CARD_LIFTS
        if math.isfinite(angle := runs.value(worst, f"valve_{lift}_open_crank_angle_range"))
    ]
    if open_for:
        yield "valve open, crank deg", worst, ", ".join(open_for)
    more = OF_RUNS if runs.labels <= MAX_LABELS else {}  # of many the answer stays short
    for name, (label, smallest) in {**more, POWER: ("cam power per valve", False)}.items():
        if (one := runs.worst(name, smallest)) is not None:
            yield label, one.run or worst, f"{runs.text(one)}{_impacts(runs, one)}"
    floats = runs.value(worst, "rigid_contact_loss_engine_speed")
    known = {runs.value(run, "rigid_contact_loss_engine_speed") for run in runs.solutions}
    if math.isfinite(floats) and len(known) == 1:  # of several, a table has the range
        yield "contact-loss speed, rigid parts", worst, f"{rpm(floats):.0f} rpm"
    preload = runs.value(worst, "preload")
    if math.isfinite(preload):
        yield PRELOAD, worst, quantity_text("preload", preload)
