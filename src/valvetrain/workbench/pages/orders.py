"""What may be run of a case, as the page offers it, and the request that a choice becomes."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from valvetrain import registry
from valvetrain.errors import InputError
from valvetrain.findings.words import RPM
from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.toml_text import toml_text
from valvetrain.solution.definition import definition_of, label_of, names_for
from valvetrain.springs.spec import SpringModelSpec, spring_model
from valvetrain.system.build import default_models
from valvetrain.workbench.jobs import JobRequest

#: The model that a first run of a spring alone uses: seconds, and it moves.
FIRST_MODEL, SWEEP = "multi-mass", "1000:8000:250 rpm"
#: Points of a study, and letters of what its quantity is called.
MIN_POINTS, MAX_POINTS, MAX_LABEL = 2, 200, 80


def springs_of(case: Case) -> tuple[InstalledSpring, ...]:
    """Every spring of a case, of a train those of the set in use: a card in another set runs by fewer models."""
    if case.train is None:
        return case.springs
    sets = case.train.springs
    return tuple(sets[case.train.spring_set or next(iter(sets))]) if sets else ()


def models_for(case: Case, chosen: Sequence[str] = ()) -> list[dict[str, Any]]:
    """Spring models that can run the case: word, words, what they know; ``chosen`` or else the
    default first one is ticked.
    """
    springs = springs_of(case)
    fit = [spec for spec in map(spring_model, registry.names("springs")) if _fits(spec, case)]
    names = [spec.word for spec in fit]
    first = FIRST_MODEL if case.train is None else case.train.model_of()
    ticked = [word for word in chosen if word in names] or [
        word for word in (first, *default_models(springs)) if word in names
    ][:1]
    return [
        {
            "word": spec.word,
            "label": spec.label,
            "hint": f"knows {spec.knows}; leaves out {spec.leaves_out}",
            "chosen": spec.word in ticked,
        }
        for spec in fit
    ]


def _fits(spec: SpringModelSpec, case: Case) -> bool:
    springs = springs_of(case)
    moves = not spec.no_motion and not (case.train is not None and spec.alone and not spec.driver)
    return moves and bool(springs) and not any(spec.why_not(spring) for spring in springs)


def sets_for(case: Case, remembered: str = "") -> list[dict[str, Any]]:
    """Spring sets to choose from, where a train has more than one: word and whether it is ticked;
    ``remembered``: those chosen last, a name on each line.
    """
    if case.train is None or len(case.train.springs) < 2:
        return []
    names, last = list(case.train.springs), remembered.split("\n")
    ticked = set(last) & set(names) or {case.train.spring_set or names[0]}
    return [{"word": name, "chosen": name in ticked} for name in names]


def to_remember(wish: Mapping[str, Any]) -> dict[str, str]:
    """What of a choice is remembered for the next one of the case."""
    speeds = {"sweep" if wish.get("kind") == "sweep" else "speeds": str(wish.get("speeds", ""))}
    sets = {"sets": "\n".join(map(str, wish["sets"]))} if wish.get("sets") else {}
    return speeds | {"models": ",".join(map(str, wish.get("models", ())))} | sets


def outputs_for(case: Case) -> list[dict[str, str]]:
    """Quantities that a study can have as outputs."""
    names = names_for("study", "spring" if case.train is None else "train")
    labels = (", ".join(filter(None, (label_of(one), definition_of(one).remark))) for one in names)
    return [{"name": name, "label": label} for name, label in zip(names, labels, strict=True)]


def choices_for(
    case: Case, quantities: Sequence[Mapping[str, Any]], remembered: Mapping[str, str]
) -> dict[str, Any]:
    """All that the page offers; ``remembered``: what was chosen last."""
    own = ", ".join(f"{speed / RPM:.10g}" for speed in case.operation.engine_speeds)
    return {
        "models": models_for(case, remembered.get("models", "").split(",")),
        "sets": sets_for(case, remembered.get("sets", "")),
        "speeds": remembered.get("speeds") or (f"{own} rpm" if own else "4000 rpm"),
        "sweep": remembered.get("sweep") or SWEEP,
        "quantities": list(quantities),
        "outputs": outputs_for(case),
    }


def request_of(case: str, wish: Mapping[str, Any]) -> JobRequest:
    """The request of what was chosen on the page; ``sets`` are given where the train has more than
    one.

    Raises :class:`InputError` for a choice that is missing.
    """
    kind, models = str(wish.get("kind", "run")), tuple(map(str, wish.get("models", ())))
    speeds, sets = str(wish.get("speeds", "")).strip(), tuple(map(str, wish.get("sets") or ()))
    if not models:
        raise InputError("no spring model is chosen; tick one or more", "spring models")
    if wish.get("sets") is not None and not sets:
        raise InputError("no spring set is chosen; tick one or more", "spring sets")
    if kind in ("run", "sweep"):
        return JobRequest("sweep" if kind == "sweep" else "run", case, models, speeds, sets)
    if kind != "study":
        raise InputError(f"'{kind[:20]}' is nothing to run; choose run, sweep or study", "kind")
    return JobRequest("study", case, study=_study(case, models, sets, speeds, wish))


def _study(
    case: str, models: tuple[str, ...], sets: tuple[str, ...], speeds: str, wish: Mapping[str, Any]
) -> str:
    points = wish.get("points")
    if not wish.get("key"):
        raise InputError("no quantity to vary is chosen; choose one", "quantity varied")
    if not isinstance(points, (int, float)) or not MIN_POINTS <= points <= MAX_POINTS:
        raise InputError(
            f"the number of points is to be from {MIN_POINTS} to {MAX_POINTS}", "points"
        )
    vary = {name: str(wish.get(name, "")).strip() for name in ("key", "low", "high", "label")}
    study = {
        "case": case,
        "engine_speeds": speeds,
        "spring_sets": list(sets),
        "spring_models": list(models),
        "outputs": [str(wish.get("output", ""))],
        "points": {"sampler": "grid", "levels": int(points)},
        "vary": [{name: _number_or_text(text[:MAX_LABEL]) for name, text in vary.items() if text}],
    }
    return toml_text({name: value for name, value in study.items() if value})


def _number_or_text(value: str) -> float | str:
    return float(value) if re.fullmatch(r"[-+]?\d+(\.\d+)?", value) else value
