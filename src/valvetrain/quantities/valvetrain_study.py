"""Everything one study of a train computed: what its report prints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING

from valvetrain.quantities.kinematics import RigidTable
from valvetrain.quantities.valvetrain_traces import CycleTraces
from valvetrain.solution.comparison import Comparison, Finding
from valvetrain.solution.event import Event
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.quantity import Quantity
from valvetrain.solution.status import Status

if TYPE_CHECKING:
    from valvetrain.parameters.case import Case


@dataclass(frozen=True, eq=False)
class TrainRun:
    """One steady cycle: ``label`` of the variant, spring words, ``engine_speed`` (rad/s of the crank), named numbers (SI), events, status.

    ``traces``: the curves of the cycle; None in sweeps, which keep numbers only.
    """

    label: str
    spring_model: str
    spring_set: str
    engine_speed: float
    quantities: Mapping[str, float]
    events: tuple[Event, ...]
    status: Status
    traces: CycleTraces | None = None
    table: RigidTable | None = None
    wall_time_per_cycle: float = 0.0


@dataclass(frozen=True, eq=False)
class TrainStudy:
    """A case with its runs; ``quantities`` by :class:`Quantity` (``model`` is the run's label), comparisons, findings, notes."""

    case: Case
    runs: tuple[TrainRun, ...] = ()
    quantities: Mapping[Quantity, float] = field(default_factory=dict)
    comparisons: tuple[Comparison, ...] = ()
    findings: tuple[Finding, ...] = ()
    notes: tuple[str, ...] = ()
    provenance: Provenance = field(default_factory=lambda: Provenance("", ""))

    def __post_init__(self) -> None:
        object.__setattr__(self, "quantities", MappingProxyType(dict(self.quantities)))

    def run(self, label: str) -> TrainRun | None:
        """The run of that label, or None."""
        return next((run for run in self.runs if run.label == label), None)
