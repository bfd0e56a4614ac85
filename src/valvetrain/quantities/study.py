"""Everything one spring study computed: what the report prints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING

from valvetrain.quantities.stress import StaticStress
from valvetrain.solution.comparison import Comparison
from valvetrain.solution.modal import ModalResult
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.quantity import Quantity
from valvetrain.solution.result import Solution
from valvetrain.solution.static import StaticCurve

if TYPE_CHECKING:
    from valvetrain.parameters.case import Case


@dataclass(frozen=True, eq=False)
class SpringStudy:
    """A case with its static curve, modes, one :class:`Solution` per model and engine speed, and what follows from them.

    ``quantities`` are SI values by :class:`Quantity`; ``comparisons`` the rows computed / published; ``notes`` sentences
    that the report prints under its table (where a prediction misses and why).
    """

    case: Case
    static_curve: StaticCurve | None = None
    modal_result: ModalResult | None = None
    solutions: tuple[Solution, ...] = ()
    quantities: Mapping[Quantity, float] = field(default_factory=dict)
    comparisons: tuple[Comparison, ...] = ()
    notes: tuple[str, ...] = ()
    provenance: Provenance = field(default_factory=lambda: Provenance("", ""))
    static_stress: StaticStress | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "quantities", MappingProxyType(dict(self.quantities)))
        for name in ("solutions", "comparisons", "notes"):
            object.__setattr__(self, name, tuple(getattr(self, name)))

    @property
    def engine_speeds(self) -> tuple[float, ...]:
        """Crank speeds (rad/s) that were run, ascending."""
        return tuple(sorted({solution.engine_speed for solution in self.solutions}))

    @property
    def models(self) -> tuple[str, ...]:
        """Names of the spring models that were run, in order of first appearance."""
        return tuple(dict.fromkeys(solution.model for solution in self.solutions))

    def solution(self, model: str, engine_speed: float) -> Solution | None:
        """The run of ``model`` at ``engine_speed`` (rad/s), or None."""
        for solution in self.solutions:
            if solution.model == model and abs(solution.engine_speed - engine_speed) < 1e-6 * max(1.0, engine_speed):
                return solution
        return None
