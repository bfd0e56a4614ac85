"""A published study as data: its names, how it read numbers, and what it claims."""

from __future__ import annotations

from dataclasses import field, replace

import numpy as np
from pydantic.dataclasses import dataclass as table

from valvetrain import registry
from valvetrain.parameters.loading import load_case
from valvetrain.quantities.compare import compare
from valvetrain.quantities.cycle import Array, Cycle, Frame, reported_cycle
from valvetrain.quantities.signal import Window
from valvetrain.solution.provenance import PublishedValue
from valvetrain.solution.quantity import Quantities, Quantity
from valvetrain.solution.result import Solution
from valvetrain.solution.study import LiftEvent, Study
from valvetrain.sources.claims import Claim, run_of
from valvetrain.sources.reader import Reader, Sampling
from valvetrain.sources.readings import KNOWN_KEYS, Reading


@table(frozen=True, config=KNOWN_KEYS)
class Origin:
    """What produced a published value: its short ``sign``, and the label of the ``run`` to compare with."""

    sign: str
    run: str = ""


@table(frozen=True, config=KNOWN_KEYS)
class SourceStudy:
    """One published study; ``key``: its citation key and its name in the registry.

    ``description``: what it is, and what its names mean. ``case``: the library case that holds what it
    publishes. ``origins``: what produced a published value -> mark and run. ``counted``: words of its
    angles that are counted through a cycle. ``windows``: its names of the windows about the lift event;
    ``points``: coil number of each of its points on the wire. ``readings``: how it read numbers;
    ``sampling``: the samples that it stored. ``claims``: what it says of them.
    """

    key: str
    description: str = ""
    case: str = ""
    origins: dict[str, Origin] = field(default_factory=dict)
    counted: tuple[str, ...] = ()
    windows: dict[Window, str] = field(default_factory=dict)
    points: dict[str, float] = field(default_factory=dict)
    sampling: Sampling | None = None
    readings: tuple[Reading, ...] = ()
    claims: tuple[Claim, ...] = ()

    def reader(
        self, cycle: Cycle, event: LiftEvent | None, surge_frequency: float | None, **coils: float
    ) -> Reader:
        """What takes its readings of a cycle; ``surge_frequency`` in Hz, ``coils`` of points that the case moves."""
        return Reader(cycle, event, surge_frequency, {**self.points, **coils}, self.sampling)

    def quantities(self, solution: Solution, frame: Frame) -> dict[str, float]:
        """Numbers of a run (SI) by the names of the study; what the run does not cover is absent."""
        if len(solution.time) < 3 or all(one.runs for one in self.readings):
            return {}
        coils = dict(frame.points)
        cycle = reported_cycle(solution)
        reader = self.reader(cycle, frame.lift_event, frame.surge_frequency, **coils)
        return reader.read(self.readings)

    def by_phase(self, study: Study) -> dict[Quantity, Array]:
        """Numbers of the runs that are compared, once for each phase of the samples that it stored."""
        found = dict[Quantity, Array]()
        sampled = [one for one in self.readings if one.sampled or one.kind == "difference"]
        labels = {origin.run for origin in self.origins.values()} if sampled else set()
        surge = study.quantities.get(Quantity("mode_1_frequency"))
        for run in study.solutions:
            if run.label in labels and len(run.time) > 2:
                reader = self.reader(reported_cycle(run), study.lift_event, surge)
                reader.read(sampled)
                for name, values in reader.phases.items():
                    found[Quantity(name, run.engine_speed, run.label)] = values
        return found

    def of_runs(self, study: Study) -> dict[Quantity, float]:
        """Quantities of one labelled run or of two at every engine speed at which they ran: the value, the
        share by which the first is above the second, or the difference.
        """
        found = dict[Quantity, float]()
        for reading in self.readings if study.solutions else ():
            for speed in study.engine_speeds if reading.runs else ():
                runs = [run_of(study, label, speed) for label in reading.runs]
                values = [run.quantities.get(reading.of[0], np.nan) for run in runs if run]
                if len(values) == len(runs):
                    first, second = values[0], values[-1]
                    rise = first / second - 1 if second > 0 else np.nan
                    kinds = {"run": first, "rise": rise, "difference": first - second}
                    found[Quantity(reading.names[0], speed)] = float(kinds[reading.kind])
        return {key: value for key, value in found.items() if np.isfinite(value)}


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
    """The study with comparisons and findings of the published study that its case re-runs.

    A study of a case of one's own, or of a changed one, is returned as it is. Raises
    :class:`InputError` for an unknown source.
    """
    record = study.record
    if record.changed or not (record.study or record.published):
        return study
    source: SourceStudy = (
        registry.find("sources", record.study) if record.study else SourceStudy("")
    )
    quantities = Quantities({**study.quantities, **source.of_runs(study)})
    runs = {name: origin.run for name, origin in source.origins.items()}
    findings = filter(None, (claim.finding(study) for claim in source.claims))
    return replace(
        study,
        comparisons=compare(
            record.published,
            quantities,
            runs if record.study else None,
            source.counted,
            source.by_phase(study),
        ),
        findings=(*study.findings, *findings),
    )
