"""One job of this package in its own process: ``python -m benchmarks.own '{"job": "T", ...}'``
prints a RESULT line like the peers.
"""

from __future__ import annotations

import json
import resource
import statistics
import sys
import time
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from benchmarks.standard import (
    CAM_SPEED,
    DAMPING,
    INTERVAL,
    PER_TURN,
    PRECOMPRESSION,
    REVOLUTIONS,
    lift,
    motion,
    rod,
    spring_c,
    spring_t,
    transient,
)
from valvetrain.cosserat.buffer import RodDynamics
from valvetrain.cosserat.transient import RodTransient

T = TypeVar("T")
Array = NDArray[np.float64]


def timed(work: Callable[[], T], repeats: int) -> tuple[float, float, T]:
    """Median wall and CPU time (s) after one call that may compile, and the last result."""
    result = work()
    walls, cpus = [], []
    for _ in range(repeats):
        started = time.perf_counter(), time.process_time()
        result = work()
        walls.append(time.perf_counter() - started[0])
        cpus.append(time.process_time() - started[1])
    return statistics.median(walls), statistics.median(cpus), result


def job_transient(job: str, per_coil: int, damping: str, repeats: int) -> dict[str, Any]:
    """T or C: mesh, installed state and time integration."""

    def whole() -> RodTransient:
        return transient(
            *rod(spring_t() if job == "T" else spring_c(), per_coil, damping, job == "C")
        )

    wall, cpu, run = timed(whole, repeats)
    return {
        "wall": wall,
        "cpu": cpu,
        "trace": run.seat_force.tolist(),
        "steps": run.steps,
        "elements": 6 * per_coil,
    }


def job_static(per_coil: int, repeats: int) -> dict[str, Any]:
    """S: 24 steps to 12 mm."""
    from valvetrain.cosserat.static import RodStatics, compress

    mesh, _, _ = rod(spring_t(), per_coil, "mass", False)
    wall, cpu, path = timed(
        lambda: compress(RodStatics(mesh), np.linspace(0.5e-3, 12e-3, 24).tolist()), repeats
    )
    return {"wall": wall, "cpu": cpu, "trace": [point.retainer_force for point in path]}


def job_modes(per_coil: int, repeats: int) -> dict[str, Any]:
    """M: first six frequencies at 0 and at 7 mm."""
    from valvetrain.cosserat.modes import natural_modes
    from valvetrain.cosserat.state import free_state
    from valvetrain.cosserat.static import RodStatics

    mesh, _, installed = rod(spring_t(), per_coil, "mass", False)

    def both() -> list[Array]:
        return [
            natural_modes(RodStatics(mesh), state, 6).natural_frequency
            for state in (free_state(mesh), installed)
        ]

    wall, cpu, found = timed(both, repeats)
    return {"wall": wall, "cpu": cpu, "trace": np.concatenate(found).tolist()}


def job_batch(per_coil: int, variants: int, workers: int) -> dict[str, Any]:
    """B: CPU seconds per variant, side by side and one by one, and the wall time over ``workers``
    threads.
    """
    from valvetrain.cosserat.batch import RodBatch, simulate_batch
    from valvetrain.cosserat.buffer import stable_time_step

    built = [
        rod(spring_c(factor), per_coil, "stiffness", True)
        for factor in 1 + 0.02 * np.linspace(-1, 1, variants)
    ]
    meshes, starts, dynamics = [item[0] for item in built], [item[2] for item in built], built[0][1]
    step = min(stable_time_step(mesh, dynamics) for mesh in meshes)
    samples = REVOLUTIONS * PER_TURN

    def batch(count: int, threads: int) -> RodBatch:
        return simulate_batch(
            meshes[:count], starts[:count], motion, INTERVAL, samples, dynamics, step, threads
        )

    batch(1, 1)
    few = min(variants, 16)

    def one_by_one() -> list[Array]:
        return [
            transient(mesh, dynamics, start, step).seat_force
            for mesh, start in zip(meshes[:few], starts[:few], strict=True)
        ]

    _, alone_cpu, runs = timed(one_by_one, 3)
    _, side_cpu, _ = timed(lambda: batch(few, 1), 3)
    started = time.perf_counter()
    result = batch(variants, 1)
    one = time.perf_counter() - started
    started = time.perf_counter()
    batch(variants, workers)
    spread = time.perf_counter() - started
    difference = max(float(np.abs(result.seat_force[k] - runs[k]).max()) for k in range(few))
    return {
        "wall": spread,
        "cpu": side_cpu / few,
        "trace": [],
        "per_variant_alone": alone_cpu / few,
        "gain": alone_cpu / side_cpu,
        "efficiency": one / (workers * spread),
        "difference": difference,
        "completed": bool(result.completed.all()),
    }


def job_chain(repeats: int) -> dict[str, Any]:
    """The 30 ms of C by the chain of masses with clash."""
    from valvetrain.springs.multi_mass import MultiMassSpring

    return _job_of_model(
        MultiMassSpring.from_definition(
            spring_c(),
            PRECOMPRESSION,
            masses_per_coil=8,
            contact_stiffness=2e10,
            stiffness_damping=DAMPING["stiffness"][1],
        ),
        repeats,
    )


def job_reduced(repeats: int) -> dict[str, Any]:
    """The 30 ms of C by the spring reduced from its rod, with the time that its tables take."""
    from valvetrain.springs.finite_element import FiniteElementRod
    from valvetrain.springs.reduced_rod import ReducedRod

    largest = float(np.max(lift(np.linspace(0.0, 2 * np.pi / CAM_SPEED, 721))))
    dynamics = RodDynamics(stiffness_damping=DAMPING["stiffness"][1])
    model = ReducedRod(FiniteElementRod(spring_c(), PRECOMPRESSION, dynamics=dynamics), largest)
    begun = time.process_time()
    tables = model._made()
    made = time.process_time() - begun
    model.__dict__["tables"] = tables
    return _job_of_model(model, repeats) | {"tables": made}


def job_beehive(repeats: int) -> dict[str, Any]:
    """Two revolutions of the beehive at 4200, 5600 and 8000 rpm by the reduced rod and by its rod in turn, channels read
    later as in a run: median CPU times and median ratio of the pairs.
    """
    from valvetrain.integrate.contract import Cycles
    from valvetrain.integrate.run import run
    from valvetrain.springs.reduced_rod import ReducedRod
    from valvetrain.system.build import build
    from valvetrain.system.prescribed import PrescribedSpring

    system = build("gu2021-beehive-blind", spring_models=("reduced-rod",)).members[0].system()
    assert isinstance(system, PrescribedSpring)
    (reduced,) = system.springs
    assert isinstance(reduced, ReducedRod)
    models: tuple[Any, ...] = (reduced.rod, reduced)
    for model in models:  # compiles, and makes the tables
        run(PrescribedSpring((model,), system.valve_lift), 4200 * np.pi / 60, Cycles(2))
    found: dict[str, Any] = {"cpus": [], "ratios": []}
    for rpm in (4200.0, 5600.0, 8000.0):
        pairs = []
        for _ in range(repeats):
            taken = []
            for model in models:
                alone = PrescribedSpring((model,), system.valve_lift)
                begun = time.process_time()
                run(alone, rpm * np.pi / 60, Cycles(2))
                taken.append(time.process_time() - begun)
            pairs.append(taken)
        found["cpus"].append([statistics.median(side) for side in zip(*pairs, strict=True)])
        found["ratios"].append(statistics.median(rod / own for rod, own in pairs))
    return found


def _job_of_model(model: Any, repeats: int) -> dict[str, Any]:
    """Time and trace of a spring model driven by the motion of C."""
    from numba import njit

    duration = REVOLUTIONS * 2 * np.pi / CAM_SPEED
    steps = int(np.ceil(duration / (0.9 * model.stable_time_step())))
    model = model.with_time_step(duration / steps)
    at = np.linspace(0.0, duration, steps + 1)
    place = lift(at)
    velocity = np.gradient(place, at)
    kernel = model.kernel

    @njit
    def integrate_in_time(parameters, integers, state, place, velocity, dt, forces):
        for n in range(len(place)):
            forces[n] = kernel(parameters, integers, state, place[n], velocity[n], dt)[1]

    parameters, integers, forces = model.parameters(), model.integers(), np.zeros(steps + 1)

    def whole() -> Array:
        integrate_in_time(
            parameters,
            integers,
            model.initial_state(0.0),
            place,
            velocity,
            duration / steps,
            forces,
        )
        return forces

    wall, cpu, trace = timed(whole, repeats)
    sampled = np.interp(INTERVAL * np.arange(REVOLUTIONS * PER_TURN + 1), at, trace)
    return {"wall": wall, "cpu": cpu, "trace": sampled.tolist(), "steps": steps}


def main(options: dict[str, Any]) -> None:
    """Run one job and print its result."""
    job, repeats = options["job"], options.get("repeats", 3)
    if job in ("T", "C"):
        result = job_transient(job, options["per_coil"], options["damping"], repeats)
    elif job == "B":
        result = job_batch(options["per_coil"], options["variants"], options["workers"])
    else:
        result = {
            "S": lambda: job_static(24, repeats),
            "M": lambda: job_modes(24, repeats),
            "chain": lambda: job_chain(repeats),
            "reduced": lambda: job_reduced(repeats),
            "beehive": lambda: job_beehive(repeats),
        }[job]()
    result["memory_mb"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print("RESULT " + json.dumps(result))


if __name__ == "__main__":
    main(json.loads(sys.argv[1]))
