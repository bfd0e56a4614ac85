"""A search as one JSON object and as files: trials, page, Optuna study, case files of the designs."""

from __future__ import annotations

import csv
import io
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.report.optimum_page import optimum_page
from valvetrain.report.page import render
from valvetrain.solution.atomic import write_text
from valvetrain.solution.gaps import Gaps
from valvetrain.studies.optimum.kept import case_text, write_optuna
from valvetrain.studies.optimum.limit_speed import LimitFound
from valvetrain.studies.optimum.measure import Measure
from valvetrain.studies.optimum.result import Confirmed, Design, Optimum, bound_words
from valvetrain.studies.optimum.trial import Trial
from valvetrain.studies.optimum.words import sentences

#: Trials that the JSON answer holds whole; more stand in trials.csv.
MOST_TRIALS = 2000
TRIALS, OPTUNA, BEST = "trials.csv", "optuna.db", "best.toml"


def optimum_json(found: Optimum) -> dict[str, Any]:
    """The JSON answer, SI."""
    plan = found.plan
    data: dict[str, Any] = {
        "case": plan.case.name, "title": plan.title, "method": plan.search.method, "seeds": list(found.seeds),
        "trials": len(found.trials), "feasible_trials": found.feasible, "computed_now": found.computed,
        "varied": [
            {"name": one.name, "key": one.key, "as": one.operation, "unit": one.si_unit or "1", "label": one.words} for one in plan.varied
        ],
        "objectives": [{**_of(one.measure), "direction": "maximise" if one.maximise else "minimise"} for one in plan.objectives],
        "constraints": [
            {**_of(one.measure), "sense": "at_most" if one.upper else "at_least", "bound": one.bound, "share_of_case": one.share,
             "words": bound_words(plan, place)} for place, one in enumerate(plan.constraints)
        ],
        "of_case": _trial(found.case), "designs": [_design(found, one) for one in found.designs],
        "front": [one.number for one in found.front], "history": found.history() if len(plan.objectives) == 1 else None,
        "best_by_seed": {str(seed): value for seed, value in found.best_by_seed.items()}, "sentences": list(sentences(found)),
        "completed": found.finished and found.best is not None,
    }  # fmt: skip
    if len(found.trials) <= MOST_TRIALS:
        data["rows"] = [_trial(one) for one in found.trials]
    return data


def _of(one: Measure) -> dict[str, Any]:
    speeds = [run[0] for run in one.runs if run[0] is not None]
    told: dict[str, Any] = {"quantity": one.quantity, "unit": one.si_unit, "label": one.label}
    if one.limit is not None:
        sense = "at_most" if one.limit.upper else "at_least"
        told["limit_speed"] = {
            sense: one.limit.bound,
            "engine_speeds": list(one.limit.engine_speeds),
            "resolution": one.limit.resolution,
        }
    return told | (
        {"engine_speeds": list(dict.fromkeys(speeds)), "over": one.over} if speeds else {}
    )


def _trial(one: Trial) -> dict[str, Any]:
    return {
        "number": one.number,
        "seed": None if one.number == 0 else one.seed,
        "values": one.values,
        "objectives": one.objectives,
        "constraints": one.constraints,
        "missed": one.missed if not one.failure else None,
        "state": one.state,
        "failure": one.failure,
        "limits": [
            _bracket(bracket) for brackets in one.measured.limits.values() for bracket in brackets
        ],
    }


def _bracket(one: LimitFound) -> dict[str, Any]:
    return {"kind": one.kind, "low": one.low, "high": one.high}


def _design(found: Optimum, one: Design) -> dict[str, Any]:
    return {
        **_trial(one.trial),
        "chosen": one.chosen,
        "active": list(found.active(one.trial)),
        "at_ends": [
            {"quantity": found.plan.varied[place].name, "end": end}
            for place, end in found.at_ends(one.trial)
        ],
        "steps": [
            {
                "quantity": found.plan.varied[step.place].name,
                "step": step.size,
                "objectives": step.objectives,
                "feasible": step.feasible,
                "improves": step.improves,
                "failure": step.failure,
            }
            for step in one.steps
        ],
        "confirmed": [_confirmed(other) for other in one.confirmed],
    }


def _confirmed(one: Confirmed) -> dict[str, Any]:
    return {
        "by": one.label,
        "of_case": _trial(one.case),
        "design": _trial(one.design),
        "keeps_every_bound": one.design.feasible,
    }


def trials_csv(found: Optimum) -> str:
    """Every trial with all digits, SI; the head tells the units."""
    plan, stream = found.plan, io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    heads = [f"{one.name} [{one.si_unit or '1'}]" for one in plan.varied]
    heads += [
        f"objective {place + 1}: {one.measure.label} [{one.measure.si_unit}]"
        for place, one in enumerate(plan.objectives)
    ]
    heads += [
        f"constraint {place + 1}: {one.measure.label} [{one.measure.si_unit}]"
        for place, one in enumerate(plan.constraints)
    ]
    heads += [f"missed {place + 1} [1]" for place in range(len(plan.constraints))]
    writer.writerow(["trial", "seed", *heads, "state", "sentence"])
    for one in found.trials:
        missed = one.missed[: len(plan.constraints)]
        cells = [
            "" if np.isnan(value) else repr(float(value))
            for value in (*one.values, *one.objectives, *one.constraints, *missed)
        ]
        writer.writerow(
            [one.number, "" if one.number == 0 else one.seed, *cells, one.state, one.failure]
        )
    return stream.getvalue()


def _write_case(found: Optimum, design: Design, path: Path) -> Path:
    return write_text(path, case_text(found, design))


def write_optimum(found: Optimum, folder: Path, gaps: Gaps) -> tuple[list[Path], Path | None]:
    """Write trials, Optuna study, case files and page into ``folder``; what could not be written
    stands in ``gaps``. Files, and page.
    """
    made = [
        gaps.part(f"file '{TRIALS}'", None, lambda: write_text(folder / TRIALS, trials_csv(found))),
        gaps.part(f"file '{OPTUNA}'", None, lambda: write_optuna(found, folder / OPTUNA)),
    ]
    for place, design in enumerate(found.designs):
        name = BEST if place == 0 else f"design-{place + 1}.toml"
        made.append(
            gaps.part(f"file '{name}'", None, partial(_write_case, found, design, folder / name))
        )
    page = gaps.part(
        "report page",
        None,
        lambda: write_text(folder / "report.html", render(optimum_page(found), gaps)),
    )
    return [path for path in (*made, page) if path is not None], page
