"""The files of a search: JSON, trials, the Optuna study, case files of the designs, and the page."""

from __future__ import annotations

import csv
import io
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.explore.measure import Measure
from valvetrain.explore.optimum import (
    Design,
    Optimum,
    bound_label,
    case_text,
    write_optuna,
)
from valvetrain.explore.optimum_answer import OptimumAnswer, answer_of_search
from valvetrain.explore.trial import Trial
from valvetrain.explore.valley import ALIKE
from valvetrain.findings.words import Words
from valvetrain.solution.atomic import write_text
from valvetrain.solution.partial_failures import PartialFailures
from valvetrain.views.json import uncertainty_object
from valvetrain.views.results import write_page
from valvetrain.views.study_files import StudyFiles, files_of

#: Trials that the JSON answer holds whole; more are in trials.csv.
MAX_TRIALS = 2000
TRIALS, OPTUNA, BEST = "trials.csv", "optuna.db", "best.toml"


def optimum_json(found: Optimum) -> dict[str, Any]:
    """The JSON answer, SI."""
    plan = found.plan
    data: dict[str, Any] = {
        "case": plan.case_name, "title": plan.title, "method": plan.search.method, "seeds": list(found.seeds),
        "trials": len(found.trials), "feasible_trials": found.feasible, "computed_now": found.computed,
        "varied": [
            {"name": one.name, "key": one.key, "as": one.operation, "unit": one.si_unit or "1", "label": one.shown_name} for one in plan.varied
        ],
        "objectives": [{**_of(found, one.measure), "direction": "maximise" if one.maximise else "minimise"} for one in plan.objectives],
        "constraints": [
            {**_of(found, one.measure), "sense": "at_most" if one.upper else "at_least", "bound": one.bound, "share_of_case": one.share,
             "words": bound_label(plan, index)} for index, one in enumerate(plan.constraints)
        ],
        "of_case": _trial(found.case), "designs": [_design(found, one) for one in found.designs],
        "front": [one.number for one in found.front], "history": found.history() if len(plan.objectives) == 1 else None,
        "best_by_seed": {str(seed): value for seed, value in found.best_by_seed.items()},
        "completed": found.finished and found.best is not None,
    }  # fmt: skip
    data["findings"] = [one.to_dict() for one in OptimumAnswer(found, Words()).findings]
    data["uncertainties"] = [uncertainty_object(one) for one in found.error_bars]
    if len(found.trials) <= MAX_TRIALS:
        data["rows"] = [_trial(one) for one in found.trials]
    return data


def _of(found: Optimum, one: Measure) -> dict[str, Any]:
    speeds = [run[0] for run in one.runs if run[0] is not None]
    reported: dict[str, Any] = {"quantity": one.quantity, "unit": one.si_unit, "label": one.label}
    if one.limit is not None:
        sense = "at_most" if one.limit.upper else "at_least"
        reported["limit_speed"] = {
            sense: found.bound_of_limit(one),
            "engine_speeds": list(one.limit.engine_speeds),
            "resolution": one.limit.resolution,
        }
    return reported | (
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
            {"kind": bracket.kind, "low": bracket.low, "high": bracket.high}
            for brackets in one.measured.limits.values()
            for bracket in brackets
        ],
    }


def _design(found: Optimum, one: Design) -> dict[str, Any]:
    return {
        **_trial(one.trial),
        "chosen": one.chosen,
        "active": list(found.active(one.trial)),
        "at_ends": [
            {"quantity": found.plan.varied[index].name, "end": end}
            for index, end in found.at_ends(one.trial)
        ],
        "steps": [
            {
                "quantity": found.plan.varied[step.index].name,
                "step": step.size,
                "improves": step.improves,
                **{
                    name: getattr(step.trial, name)
                    for name in ("objectives", "feasible", "failure")
                },
            }
            for step in one.steps
        ],
        "confirmed": [
            {
                "by": other.label,
                "of_case": _trial(other.case),
                "design": _trial(other.design),
                "keeps_every_bound": other.design.feasible,
            }
            for other in one.confirmed
        ],
        "valley": _valley(found, one),
    }


def _valley(found: Optimum, one: Design) -> dict[str, Any] | None:
    """Designs as good as the best: least and most of each quantity, and which are left open."""
    if one.valley is None:
        return None
    names = [varied.name for varied in found.plan.varied]
    ends = zip(one.valley.values.min(axis=0), one.valley.values.max(axis=0), strict=True)
    return {
        "within": ALIKE,
        "designs": len(one.valley.values),
        "quantities": {
            name: {"low": low, "high": high} for name, (low, high) in zip(names, ends, strict=True)
        },
        "open": [names[place] for place in one.valley.open],
    }


def trials_csv(found: Optimum) -> str:
    """Every trial with all digits, SI; the head gives the units."""
    plan, stream = found.plan, io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    heads = [f"{one.name} [{one.si_unit or '1'}]" for one in plan.varied]
    for word, every in (("objective", plan.objectives), ("constraint", plan.constraints)):
        measures = [one.measure for one in every]
        heads += [f"{word} {k + 1}: {one.label} [{one.si_unit}]" for k, one in enumerate(measures)]
    heads += [f"missed {index + 1} [1]" for index in range(len(plan.constraints))]
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


def write_optimum(
    found: Optimum, folder: Path, gaps: PartialFailures
) -> tuple[list[Path], Path | None]:
    """Write trials, Optuna study, case files and page into ``folder``; what could not be written
    is in ``gaps``. Files, and page.
    """
    made = [
        gaps.part(f"file '{TRIALS}'", None, lambda: write_text(folder / TRIALS, trials_csv(found))),
        gaps.part(f"file '{OPTUNA}'", None, lambda: write_optuna(found, folder / OPTUNA)),
    ]
    for index, design in enumerate(found.designs if found.plan.case is not None else ()):
        name = BEST if index == 0 else f"design-{index + 1}.toml"
        made.append(
            gaps.part(f"file '{name}'", None, partial(_write_case, found, design, folder / name))
        )
    page = write_page(answer_of_search(found, best_file(found, folder)), folder, gaps)
    return [path for path in (*made, page) if path is not None], page


def best_file(found: Optimum, folder: Path) -> str:
    """The case file of the best design in ``folder``; empty where there is none, as of a function."""
    return str(folder / BEST) if found.best is not None and found.plan.case is not None else ""


def report_optimum(found: Optimum, folder: Path) -> StudyFiles:
    """As :func:`write_optimum`. Raises :class:`RunFailedError` where a part could not be written."""
    failures = PartialFailures()
    files, _ = write_optimum(found, folder, failures)
    return files_of(folder, files, failures.sentences)
