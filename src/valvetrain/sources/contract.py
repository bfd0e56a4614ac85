"""Contract of a published study: its names, findings and contradictions; no other package refers to a
paper.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

from valvetrain import registry
from valvetrain.parameters.loading import load_case
from valvetrain.quantities.compare import compare
from valvetrain.quantities.cycle import Array, Frame
from valvetrain.quantities.signal import Window
from valvetrain.solution.comparison import Finding
from valvetrain.solution.provenance import PublishedValue
from valvetrain.solution.quantity import Quantities, Quantity
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study


@dataclass(frozen=True, slots=True)
class Origin:
    """How a published value is marked: a short ``sign`` and a ``label`` of what produced it."""

    sign: str
    label: str


@dataclass(frozen=True)
class SourceStudy:
    """One published study; ``key``: its citation key and its name in the registry.

    ``quantities``: numbers of a run by the names of the study. ``study_quantities``: numbers of
    several runs, or of none, by name and engine speed of its published values. ``by_phase``: numbers of
    the runs once for each phase of the samples that it stored. ``findings``:
    published findings compared with the computed results; ``notes``: contradictions within it.
    ``counterparts``: what produced a published value -> label of the run to compare with.
    ``origins``: the same -> mark. ``counted``: names of its angles that are numbered through a
    cycle. ``window_names``: its names of the windows about the lift event
    (`valvetrain.quantities.signal`); ``point_names``: its names of points on the wire, by coil
    number. ``case``: the library case that holds what it publishes.
    """

    key: str
    quantities: Callable[[Solution, Frame], dict[str, float]] = lambda solution, frame: {}
    study_quantities: Callable[[Study], dict[Quantity, float]] = lambda study: {}
    by_phase: Callable[[Study], dict[Quantity, Array]] = lambda study: {}
    findings: Callable[[Study], tuple[Finding, ...]] = lambda study: ()
    notes: Callable[[Study], tuple[str, ...]] = lambda study: ()
    counterparts: Mapping[str, str] = field(default_factory=dict)
    origins: Mapping[str, Origin] = field(default_factory=dict)
    counted: tuple[str, ...] = ()
    window_names: Mapping[Window, str] = field(default_factory=dict)
    point_names: Mapping[float, str] = field(default_factory=dict)
    case: str = ""


def published_by(key: str) -> tuple[PublishedValue, ...]:
    """The values that the study of that key publishes, for a case of one's own that names it.

    All are checks there: what such a case was fitted to is not known here. Nothing for a study
    without a library case. Raises :class:`InputError` for an unknown source.
    """
    source: SourceStudy = registry.find("sources", key)
    if not source.case:
        return ()
    return tuple(
        replace(one, role="check", used_for="") for one in load_case(source.case).published
    )


def against_source(study: Study) -> Study:
    """The study with comparisons, findings and notes of the published study that its case re-runs.

    A study of a case of one's own, or of a changed one, is returned as it is. Raises
    :class:`InputError` for an unknown source.
    """
    record = study.record
    if record.changed or not (record.study or record.published):
        return study
    source: SourceStudy = (
        registry.find("sources", record.study) if record.study else SourceStudy("")
    )
    derived = source.study_quantities(study)
    at_rest = {
        key.name: value
        for key, value in derived.items()
        if key.engine_speed is None and not key.label
    }
    still = {**study.still, "": {**study.still.get("", {}), **at_rest}} if at_rest else study.still
    quantities = Quantities({**study.quantities, **derived})
    counterparts = source.counterparts if record.study else None
    return replace(
        study,
        still=still,
        comparisons=compare(
            record.published, quantities, counterparts, source.counted, source.by_phase(study)
        ),
        findings=(*study.findings, *source.findings(study)),
        notes=(*study.notes, *source.notes(study)),
    )
