"""Springs of a problem under prescribed motion: their runs over threads, and the springs at rest, solved meanwhile."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from concurrent.futures import Executor, Future
from dataclasses import replace

import numpy as np

from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.quantities.statics import buckling_quantities, rest_quantities, solid_quantities
from valvetrain.runs.prepared import (
    FAILURES,
    Plan,
    PreparedRun,
    integrate_point,
    law_lift,
    prepare,
    provenance_of,
    unfinished,
    with_quantities,
)
from valvetrain.runs.stopping import noted
from valvetrain.runs.train_runs import STOPPED, WORKER_LOST, Finished
from valvetrain.runs.workers import (
    CLUSTER,
    Lost,
    Progress,
    as_they_come,
    result_of,
    return_memory,
    threads,
)
from valvetrain.solution.result import Solution
from valvetrain.solution.static import SpringAtRest
from valvetrain.solution.status import reason
from valvetrain.system.problem import Member, Problem

#: Engine speed (rad/s) below which the arrays of a run are large enough to be given back at once.
SLOW = 125.0


def run_springs(
    problem: Problem,
    engine_speeds: tuple[float, ...],
    plan: Plan,
    workers: int,
    progress: Progress | None,
    finished: Finished | None,
    rest: bool,
) -> tuple[tuple[Solution, ...], dict[InstalledSpring, SpringAtRest], tuple[str, ...], bool]:
    """Prescribed motion, over threads; the springs at rest during the first runs, without ``rest`` those
    alone that a model needs.

    The solutions, the springs at rest in the order of the problem, a sentence per spring that failed, and whether
    stopped. Raises what refuses all of them.
    """
    source = problem.record.study
    points = [(member, speed) for member in problem.members for speed in engine_speeds]
    done: dict[int, Solution] = {}
    refused: set[int] = set()
    at_rest: dict[InstalledSpring, SpringAtRest] = {}
    failed: dict[InstalledSpring, Exception] = {}
    needed = tuple(member for member in problem.members if rest or member.model.needs_rest)

    def tell(text: str) -> None:
        if progress is not None:
            under_way = sum(share for share in list(shares.values()) if share < 1.0)
            progress(min(1.0, (1 + len(done) + under_way) / (1 + len(points))), text)

    shares: dict[tuple[Member, float], float] = {}
    cluster = CLUSTER.get()

    def integrate(ready: PreparedRun, speed: float) -> Solution:
        provenance = provenance_of(problem, ready.member, speed, plan.created_at)
        if cluster is not None:
            found = cluster.call(integrate_point, ready, speed, plan, provenance)
            lost = isinstance(found, Lost)
            return unfinished(problem, ready.member, speed, plan, WORKER_LOST) if lost else found

        def watch(share: float) -> bool:
            """Show how far a long run is, until it is stopped."""
            shares[ready.member, speed] = share
            if progress is not None and not noted():
                tell(f"{ready.member.label} at {speed * 30 / np.pi:.6g} rpm, {share:.0%}")
            return not noted()

        return integrate_point(ready, speed, replace(plan, watch=watch), provenance)

    def start(pool: Executor, members: Mapping[Member, PreparedRun]) -> dict[Future[Solution], int]:
        return {
            pool.submit(integrate, members[member], speed): index
            for index, (member, speed) in enumerate(points)
            if member in members
        }

    ready: dict[Member, PreparedRun] = {
        m: prepare(problem, m, {}, source) for m in problem.members if not m.model.needs_rest
    }
    try:
        with threads(workers) as pool:
            jobs = start(pool, ready)
            springs = dict.fromkeys(one for m in needed for one in m.springs)
            solve_at_rest(problem, springs, pool, at_rest, failed)
            tell("springs at rest")
            late = {
                member: prepare(problem, member, at_rest, source)
                for member in problem.members
                if member not in ready
            }
            ready |= late
            jobs |= start(pool, late)
            results = as_they_come(jobs)
            del jobs
            for index, solution in results:
                member, speed = points[index]
                if solution.status.code == "refused":
                    refused.add(index)
                done[index] = with_quantities(ready[member], solution, plan, at_rest)
                if finished is not None:
                    finished(index, done[index])
                del solution
                if not plan.whole and speed < SLOW:
                    return_memory()
                tell(f"{member.label} at {speed * 30 / np.pi:.6g} rpm")
        stopped = False
    except KeyboardInterrupt:
        stopped = True
        if not done and not at_rest:
            raise
    refusals = [error for error in failed.values() if isinstance(error, InputError)]
    if refused == done.keys() and refusals and not at_rest:
        raise refusals[0]  # nothing came out at all: the case cannot be run
    gaps = tuple(f"spring '{one.name}' at rest: {reason(error)}" for one, error in failed.items())
    solutions = (
        done.get(index) or unfinished(problem, *point, plan, STOPPED)
        for index, point in enumerate(points)
    )
    ordered = {one: at_rest[one] for one in problem.springs if one in at_rest}
    return tuple(solutions), ordered, gaps, stopped


def solve_at_rest(
    problem: Problem,
    springs: Iterable[InstalledSpring],
    pool: Executor,
    found: dict[InstalledSpring, SpringAtRest],
    failed: dict[InstalledSpring, Exception],
) -> None:
    """Solve ``springs`` at rest by the threads of a ``pool``, each into ``found`` or, with its error, into ``failed``."""
    if not springs:
        return
    from valvetrain.runs.statics import spring_statics  # which most runs do not need

    lift = law_lift(problem)
    jobs = {one: pool.submit(spring_statics, problem, one, lift) for one in springs}
    for spring, job in jobs.items():
        try:
            found[spring] = result_of(job)
        except FAILURES as error:
            failed[spring] = error


def numbers_at_rest(
    problem: Problem, spring: InstalledSpring, rest: SpringAtRest
) -> dict[str, float]:
    """Numbers of one spring that belong to no run."""
    names = [value.quantity for value in problem.record.published]
    return (
        ({} if spring.wire is None else solid_quantities(spring.wire))
        | rest_quantities(rest, names)
        | buckling_quantities(spring, rest, law_lift(problem))
    )
