"""Key figures below the verdict of runs: how long the valve is open, what the cam takes, the
hardest clash of coils, the time step.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from valvetrain.quantities.table import EVENT_LIFTS
from valvetrain.report.clauses import Runs, figure, quantity_text
from valvetrain.report.headlines import clash_pair
from valvetrain.report.run_clauses import judged_runs, worst_run
from valvetrain.report.text import unit_text
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study

#: Heights of the valve at which a card gives its duration.
CARD_LIFTS = ("50_thou", "1_mm")


def key_figures(study: Study) -> tuple[tuple[str, str], ...]:
    """(name, value) of each, of the run that is worst or of the run where it is largest; nothing over
    engine speed and without runs.
    """
    runs = judged_runs(study)
    worst = worst_run(runs)
    if worst is None or study.over_speed:
        return ()
    figures = list(_figures(runs, worst))
    several = len(runs.solutions) > 1
    alike = len({id(run) for _, run, _ in figures}) == 1
    return tuple(
        (f"{name} {runs.place(run)}" if several and not (alike and place) else name, value)
        for place, (name, run, value) in enumerate(figures)
    )


def _figures(runs: Runs, worst: Solution) -> Iterator[tuple[str, Solution, str]]:
    open_for = [
        f"{figure(math.degrees(angle))} {EVENT_LIFTS[lift]}"
        for lift in CARD_LIFTS
        if math.isfinite(angle := runs.value(worst, f"valve_{lift}_open_crank_angle_range"))
    ]
    if open_for:
        yield "valve open, crank deg", worst, ", ".join(open_for)
    if (power := runs.worst("mean_cam_power", least=False)) is not None:
        yield "power of the cam", power.run or worst, runs.text(power)
    clashes = [
        (event, run) for run in runs.solutions for event in run.events if event.kind == "clash"
    ]
    if clashes:
        hardest, run = max(clashes, key=lambda pair: pair[0].size)
        angle = math.degrees(hardest.cam_angle) % 360
        size = f"{figure(hardest.size)} {unit_text(hardest.unit)}"
        yield (
            "clash of largest force",
            run,
            f"{size}, coils {clash_pair(hardest)} at {angle:.0f} deg",
        )
    if math.isfinite(step := runs.value(worst, "time_step_duration")):
        yield "time step", worst, quantity_text("time_step_duration", step)
