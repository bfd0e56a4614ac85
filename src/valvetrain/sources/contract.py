"""What a published study brings of its own: names, findings, contradictions. Everything else of the
package knows no paper.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib import import_module

from valvetrain import registry
from valvetrain.errors import InputError
from valvetrain.quantities.compare import compare
from valvetrain.quantities.cycle import Frame
from valvetrain.quantities.signal import Window
from valvetrain.solution.comparison import Finding
from valvetrain.solution.quantity import Quantities, Quantity
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study


@dataclass(frozen=True, slots=True)
class Origin:
    """How a published value is marked: a short ``sign`` and what produced it in ``words``."""

    sign: str
    words: str


def _no_quantities(solution: Solution, frame: Frame) -> dict[str, float]:
    return {}


def _no_study_quantities(study: Study) -> dict[Quantity, float]:
    return {}


def _no_findings(study: Study) -> tuple[Finding, ...]:
    return ()


def _no_notes(study: Study) -> tuple[str, ...]:
    return ()


@dataclass(frozen=True)
class PointsOfSource:
    """How a study computes the points of an identification in its own way.

    ``points(names, options)``: for the unknown quantities of those names, what takes their values
    (SI) and gives numbers by name (SI), None
    for an impossible point; it pickles. ``values(names)``: the values its shipped case holds.
    """

    points: Callable[
        [Sequence[str], Mapping[str, float]],
        Callable[[Sequence[float]], Mapping[str, float] | None],
    ]
    values: Callable[[Sequence[str]], tuple[float, ...]]


@dataclass(frozen=True)
class SourceStudy:
    """One published study; ``key`` is its citation key and its word in the registry.

    ``quantities``: numbers of a run by the study's own names. ``study_quantities``: numbers of
    several runs, or of none, under the names
    and engine speeds of its published values. ``findings``: what it found in words beside what came
    out here; ``notes``: contradictions
    within it. ``counterparts``: what produced a published value -> label of the run that stands for
    it. ``origins``: the same -> mark.
    ``counted``: words of its angles that are counted through a cycle. ``window_names``: its names
    of the windows about the lift event
    (`valvetrain.quantities.signal`); ``point_names``: its names of points on the wire, by coil
    number. ``identification``: place
    (``"module:attribute"``) of its :class:`PointsOfSource`, loaded on first use; empty for a study
    that has none.
    """

    key: str
    quantities: Callable[[Solution, Frame], dict[str, float]] = _no_quantities
    study_quantities: Callable[[Study], dict[Quantity, float]] = _no_study_quantities
    findings: Callable[[Study], tuple[Finding, ...]] = _no_findings
    notes: Callable[[Study], tuple[str, ...]] = _no_notes
    counterparts: Mapping[str, str] = field(default_factory=dict)
    origins: Mapping[str, Origin] = field(default_factory=dict)
    counted: tuple[str, ...] = ()
    window_names: Mapping[Window, str] = field(default_factory=dict)
    point_names: Mapping[float, str] = field(default_factory=dict)
    identification: str = ""

    def points_of_identification(self) -> PointsOfSource:
        """What :attr:`identification` leads to. Raises :class:`InputError` for a study that has
        none.
        """
        if not self.identification:
            raise InputError(
                f"source study '{self.key}' computes no points of its own; leave it out",
                "evaluator",
            )
        module, _, attribute = self.identification.partition(":")
        found: PointsOfSource = getattr(import_module(module), attribute)
        return found


def against_source(study: Study) -> Study:
    """The study with comparisons, findings and notes of the published study that its case re-runs.

    A case of one's own, or one that was changed from outside, comes back as it is: it does not
    speak of published numbers.
    Raises :class:`InputError` for an unknown source.
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
        comparisons=compare(record.published, quantities, counterparts, source.counted),
        findings=(*study.findings, *source.findings(study)),
        notes=(*study.notes, *source.notes(study)),
    )
