"""Results as parts of the JSON object; every number with its unit, all SI but the engine speed (rpm of the crank)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from valvetrain.cli.outcome import measured

if TYPE_CHECKING:
    from valvetrain.quantities.study import SpringStudy
    from valvetrain.solution.comparison import Comparison
    from valvetrain.solution.result import Solution
    from valvetrain.solution.status import Status


def quantities_object(values: Mapping[str, float]) -> dict[str, Any]:
    """``{name: {value, unit}}`` of named SI quantities."""
    from valvetrain.solution.quantity import unit_of

    return {name: measured(float(value), unit_of(name)) for name, value in values.items()}


def engine_speed_object(engine_speed: float | None) -> dict[str, Any] | None:
    """A crank speed (rad/s) as rpm, null where none applies."""
    from valvetrain.report.words import rpm

    return None if engine_speed is None else measured(rpm(engine_speed), "rpm")


def status_object(status: Status) -> dict[str, Any]:
    """How a run ended."""
    if status.completed:
        return {"code": status.code}
    words = {"message": status.message, "where": status.where, "remedy": status.remedy}
    return {"code": status.code, "time": measured(status.time, "s"), **words}


def comparison_objects(rows: Iterable[Comparison]) -> list[dict[str, Any]]:
    """Computed beside published, one object per published value."""
    from valvetrain.solution.quantity import unit_of

    found = []
    for row in rows:
        unit = unit_of(row.quantity)
        values = {name: getattr(row, name) for name in ("published", "computed", "difference", "tolerance")}
        found.append({
            "quantity": row.quantity, "engine_speed": engine_speed_object(row.engine_speed), "model": row.model, "published_by": row.origin,
            "role": row.role, **{name: None if value is None else measured(float(value), unit) for name, value in values.items()},
            "verdict": row.verdict, "source": row.source,
        })  # fmt: skip
    return found


def study_object(study: SpringStudy) -> dict[str, Any]:
    """A spring study: quantities of statics and modes, one entry per run, comparisons, notes, papers."""
    still = {key.name: value for key, value in study.quantities.items() if key.engine_speed is None}
    return {
        "quantities": quantities_object(still), "runs": [_run_object(study, solution) for solution in study.solutions],
        "comparisons": comparison_objects(study.comparisons), "notes": list(study.notes), "cite": list(study.provenance.citations),
    }  # fmt: skip


def _run_object(study: SpringStudy, solution: Solution) -> dict[str, Any]:
    mine = {
        key.name: value
        for key, value in study.quantities.items()
        if key.engine_speed == solution.engine_speed and key.label == solution.model
    }
    return {
        "model": solution.model, "engine_speed": engine_speed_object(solution.engine_speed), "status": status_object(solution.status),
        "clash_count": measured(sum(event.kind == "clash" for event in solution.events), "1"), "quantities": quantities_object(mine),
    }  # fmt: skip
