"""The springs of a problem under prescribed motion at rest: solved during its runs."""

from __future__ import annotations

from collections.abc import Iterable
from concurrent.futures import Executor
from dataclasses import dataclass

from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.quantities.statics import buckling_quantities, closing_quantities, rest_quantities
from valvetrain.runs.prepared import FAILURES, law_lift
from valvetrain.runs.workers import result_of
from valvetrain.solution.partial_failures import reason
from valvetrain.solution.static import SpringAtRest
from valvetrain.system.problem import Problem


@dataclass(frozen=True, eq=False)
class AtRest:
    """The ``springs`` at rest, in the order of their problem, a sentence per one that failed, and
    what was ``refused`` among these.
    """

    springs: dict[InstalledSpring, SpringAtRest]
    gaps: tuple[str, ...] = ()
    refused: tuple[InputError, ...] = ()


class RestSolver:
    """Solves the springs of a problem at rest, each once; ``found`` holds what is solved."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.found: dict[InstalledSpring, SpringAtRest] = {}
        self.errors: dict[InstalledSpring, Exception] = {}

    def solve(self, springs: Iterable[InstalledSpring], pool: Executor) -> None:
        """Solve those of ``springs`` that are not solved."""
        missing = [one for one in springs if one not in self.found and one not in self.errors]
        if not missing:
            return
        from valvetrain.runs.statics import spring_statics  # which most runs do not need

        lift = law_lift(self.problem)
        jobs = {one: pool.submit(spring_statics, self.problem, one, lift) for one in missing}
        for spring, job in jobs.items():
            try:
                self.found[spring] = result_of(job)
            except FAILURES as error:
                self.errors[spring] = error

    def known(self) -> AtRest:
        """Those that are solved."""
        failed = tuple(self.errors.items())
        return AtRest(
            {one: self.found[one] for one in self.problem.springs if one in self.found},
            tuple(f"spring '{one.name}' at rest: {reason(error)}" for one, error in failed),
            tuple(error for _, error in failed if isinstance(error, InputError)),
        )


def numbers_at_rest(
    problem: Problem, spring: InstalledSpring, rest: SpringAtRest
) -> dict[str, float]:
    """Numbers of one spring that belong to no run."""
    names = [value.quantity for value in problem.record.published]
    return (
        closing_quantities(spring)
        | rest_quantities(rest, names)
        | buckling_quantities(spring, rest, law_lift(problem))
    )
