"""Curves that set a design beside the case: a limited quantity over engine speed, forces and lift over the cam angle, or
the static force over the compression; and the error bars of that design.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from valvetrain.explore.engine import Engine
from valvetrain.explore.measure import REST, RUNS, Measure, Values
from valvetrain.explore.objective import OptimumPlan
from valvetrain.explore.trial import Array
from valvetrain.findings.facts import cam_angles, over_turn
from valvetrain.parameters.case import Case
from valvetrain.solution.uncertainty import Uncertainty

#: Channels of a run that are drawn: the first that it has of each panel; largest number of samples.
CHANNELS, SAMPLES = (("cam_contact_force", "retainer_force", "seat_force"), ("valve_lift",)), 1500


@dataclass(frozen=True, eq=False)
class Curve:
    """``quantity`` (sample,) over ``across`` (sample,) of the ``design`` named, SI; ``engine_speed`` (rad/s) of its run, 0 without."""

    design: str
    across: str
    quantity: str
    x: Array
    y: Array
    engine_speed: float = 0.0


@dataclass(frozen=True, eq=False)
class Compared:
    """``curves`` of a case and a design, and the ``error_bars`` of the numbers of that design that are searched for."""

    curves: tuple[Curve, ...] = ()
    error_bars: tuple[Uncertainty, ...] = ()


def compare(
    points: Engine, plan: OptimumPlan, designs: Mapping[str, Values], cases: tuple[Case, Case]
) -> Compared:
    """Curves of designs by name, the case first, and error bars of the last one.

    Parameters
    ----------
    points : computes what the search has not
    plan : of the search
    designs : their values (SI), none of the case as it is
    cases : the same as cases
    """
    from valvetrain.explore.point_bars import study_of  # loads what runs

    values, sources = list(designs.values())[-1], plan.plans
    runs = sorted(sources[RUNS].runs, key=lambda run: run[0] or 0.0) if RUNS in sources else []
    studies = [study_of(sources[RUNS], values, run, True) for run in runs]
    searched = {one.quantity for one in plan.measures}
    every = (row for study in studies if study is not None for row in study.error_bars.rows)
    bars = {(row.quantity, row.label, row.engine_speed): row for row in every if row.quantity in searched}  # fmt: skip
    curves = list[Curve]()
    if limited := [one for one in plan.measures if one.limit is not None]:
        curves = _over_speed(points, plan, limited[0], designs)
    elif studies and studies[-1] is not None:
        for name, at in designs.items():
            study = studies[-1] if at == values else study_of(sources[RUNS], at, runs[-1], False)
            run = None if study is None else study.solutions[0]
            for names in CHANNELS:
                word = next((one for one in names if run is not None and run.has(one)), "")
                if word and run is not None:
                    x, y = cam_angles(run), over_turn(run, word)
                    step = -(-len(x) // SAMPLES)
                    curves.append(Curve(name, "cam_angle", word, x[::step], y[::step], run.engine_speed))  # fmt: skip
    elif REST in plan.plans:
        curves = _at_rest(plan, dict(zip(designs, cases, strict=False)))
    return Compared(tuple(curves), tuple(bars.values()))


def _over_speed(
    points: Engine, plan: OptimumPlan, one: Measure, designs: Mapping[str, Values]
) -> list[Curve]:
    """The quantity of a limit speed over the engine speeds that were searched."""
    assert one.limit is not None
    speeds, curves = np.array(one.limit.engine_speeds), []
    for name, values in designs.items():
        jobs = [(plan.plans[one.limit], values, (speed, *one.runs[0][1:])) for speed in one.limit.engine_speeds]  # fmt: skip
        y = [each.values.get(one.quantity, np.nan) for each in points.outcomes(jobs)]
        curves.append(Curve(name, "engine_speed", one.quantity, speeds, np.array(y)))
    return curves


def _at_rest(plan: OptimumPlan, cases: Mapping[str, Case]) -> list[Curve]:
    """Static force over the compression of the first spring."""
    from valvetrain.runs.prepared import FAILURES
    from valvetrain.runs.statics import static_study

    request = plan.plans[REST].outputs.request
    model = request.rest_model or ("massless" if request.sizes_alone else "")
    sets = tuple(filter(None, [plan.plans[REST].runs[0][2]]))
    try:
        studies = [static_study(one, tuple(filter(None, [model])), spring_sets=sets, implausible=True) for one in cases.values()]  # fmt: skip
    except FAILURES:
        return []
    found = ((name, one.rest[0].curve) for name, one in zip(cases, studies, strict=True) if one.rest)  # fmt: skip
    return [Curve(name, "compression", "spring_force", one.compression, one.force) for name, one in found if one is not None]  # fmt: skip
