"""Rows for the jobs on single springs: T, C, S, M, B, the chain, and how cost grows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from benchmarks.processes import own, peer, present
from benchmarks.rows import Row
from benchmarks.standard import Array, relative_rms, rod, spring_t, transient
from valvetrain.cosserat.buffer import RodDynamics
from valvetrain.cosserat.mesh import RodMesh
from valvetrain.cosserat.state import RodState

#: Elements per coil of the converged reference.
REFERENCE = 96
#: Bandwidth (Hz) in which clash traces are compared beside the raw ones.
BANDWIDTH = 5e3
#: Peer, job, damping -> settings tried: elements per coil, step (s).
PEER_RUNS = {
    ("exudyn", "T", "stiffness"): [(12, 2e-5), (12, 1e-5), (24, 2.5e-6)],
    ("exudyn", "T", "mass"): [(12, 2e-5), (24, 5e-6)],
    ("exudyn", "C", "stiffness"): [(24, 1e-5), (24, 4e-6)],
    ("pyelastica", "T", "mass"): [(24, 3.4e-7), (48, 1.7e-7)],
}


def measure(interpreter: str, quick: bool = False) -> list[Row]:
    """All rows; ``interpreter`` is the Python that holds the peers (empty: none)."""
    rows: list[Row] = []
    for job, damping in (("T", "stiffness"), ("T", "mass"), ("C", "stiffness")):
        reference = np.array(
            own({"job": job, "per_coil": REFERENCE, "damping": damping, "repeats": 1})["trace"]
        )
        mine = [
            _transient_row(job, per_coil, damping, reference)
            for per_coil in ((12, 26) if job == "T" else (12, 24, 48))
        ]
        rows += mine
        if not quick:
            rows += _peer_rows(interpreter, job, damping, reference, mine)
    return rows + small_jobs() + beehive() + batch() + growth()


def _transient_row(job: str, per_coil: int, damping: str, reference: Array) -> Row:
    found = own({"job": job, "per_coil": per_coil, "damping": damping, "repeats": 5})
    return Row(
        f"{job}, {damping} damping",
        "valvetrain",
        f"{per_coil} elements per coil, {found['steps']} steps",
        found["wall"],
        found["cpu"],
        found["memory_mb"],
        relative_rms(np.array(found["trace"]), reference),
        note=_filtered(job, found["trace"], reference),
    )


def _filtered(job: str, trace: Sequence[float], reference: Array) -> str:
    if job != "C":
        return ""
    smooth = [_low_pass(values) for values in (trace, reference)]
    return f"{100 * relative_rms(*smooth):.2f} % below {BANDWIDTH / 1e3:.0f} kHz"


def _low_pass(values: ArrayLike) -> Array:
    from benchmarks.standard import INTERVAL
    from valvetrain.quantities.signal import low_pass

    samples = np.asarray(values, dtype=np.float64)
    return low_pass(
        np.asarray(INTERVAL * np.arange(len(samples)), dtype=np.float64), samples, BANDWIDTH
    )


def _peer_rows(
    interpreter: str, job: str, damping: str, reference: Array, mine: list[Row]
) -> list[Row]:
    rows = []
    for (name, its_job, its_damping), settings in PEER_RUNS.items():
        if (its_job, its_damping) != (job, damping):
            continue
        title = f"{job}, {damping} damping"
        if not present(name, interpreter):
            rows.append(
                Row(
                    title,
                    name,
                    "",
                    note="absent: not importable by the interpreter given for peers",
                )
            )
            continue
        results = [
            peer(name, interpreter, {"job": job, "damping": damping, "per_coil": n, "step": step})
            for n, step in settings
        ]
        finest = next(
            (np.array(item["trace"]) for item in reversed(results) if not isinstance(item, str)),
            reference,
        )
        for (per_coil, step), result in zip(settings, results, strict=True):
            setting = f"{per_coil} pieces per coil, step {step:.2g} s"
            if isinstance(result, str):
                rows.append(Row(title, name, setting, note=result))
            else:
                rows.append(_peer_row(Row(title, name, setting), result, reference, mine, finest))
    return rows


def _peer_row(
    blank: Row, result: dict[str, Any], reference: Array, mine: list[Row], finest: Array
) -> Row:
    """Ratio: CPU time over that of this package's cheapest run that is no worse."""
    trace = np.array(result["trace"])
    error = relative_rms(trace, reference)
    equal = [row.cpu for row in mine if row.error <= error] or [mine[-1].cpu]
    note = f"{100 * relative_rms(trace, finest):.2f} % from its own finest run"
    if blank.job.startswith("C"):
        note = _filtered("C", result["trace"], reference) + "; contact at equal angle"
    return replace(
        blank,
        wall=result["wall"],
        cpu=result["cpu"],
        memory=result["memory_mb"],
        error=error,
        ratio=result["cpu"] / min(equal),
        note=note,
    )


def small_jobs() -> list[Row]:
    """S, M, the chain and the reduced rod with clash."""
    texts = {
        "S": ("S, static curve", "24 steps to 12 mm, 24 elements per coil", "target 0.05 s"),
        "M": ("M, six frequencies", "at 0 and at 7 mm, 24 elements per coil", "target 0.1 s"),
        "chain": ("C by the chain of masses", "8 masses per coil, 30 ms", "target 0.005 s"),
        "reduced": (
            "C by the reduced rod",
            "tables of 24 elements per coil, 30 ms",
            "tables apart",
        ),
    }
    rows = []
    for job, (title, setting, note) in texts.items():
        found = own({"job": job, "repeats": 9})
        rows.append(
            Row(
                title,
                "valvetrain",
                setting,
                found["wall"],
                found["cpu"],
                found["memory_mb"],
                note=note,
            )
        )
    return rows


def beehive() -> list[Row]:
    """The beehive by the reduced rod beside its rod, a row a speed."""
    found = own({"job": "beehive", "repeats": 7})
    return [
        Row(
            f"beehive at {rpm} rpm",
            "valvetrain",
            "reduced rod, two revolutions, channels read later",
            cpu=cpu,
            note=f"its rod in turn with it {rod:.3g} s, {ratio:.1f} times as much (target 8)",
        )
        for rpm, (rod, cpu), ratio in zip(
            (4200, 5600, 8000), found["cpus"], found["ratios"], strict=True
        )
    ]


def batch(variants: int = 256, workers: int = 2) -> list[Row]:
    """B at two densities."""
    rows = []
    for per_coil in (12, 24):
        found = own({"job": "B", "per_coil": per_coil, "variants": variants, "workers": workers})
        rows.append(
            Row(
                "B, batch of C",
                "valvetrain",
                f"{variants} variants, {per_coil} elements per coil, {workers} threads",
                found["wall"],
                found["cpu"] * variants,
                found["memory_mb"],
                note=f"{found['gain']:.2f} times the throughput per core of single runs (target 1.5), "
                f"efficiency over cores {found['efficiency']:.2f} (target 0.9), largest difference {found['difference']:.1g} N",
            )
        )
    return rows


def growth() -> list[Row]:
    """Exponents of CPU time over a decade of elements (steps fixed) and over a decade of steps
    (elements fixed).
    """
    import time

    def cpu(
        mesh: RodMesh, dynamics: RodDynamics, start: RodState, step: float, samples: int
    ) -> float:
        from benchmarks.standard import INTERVAL, motion
        from valvetrain.cosserat.transient import simulate

        best = np.inf
        for _ in range(3):
            begun = time.process_time()
            simulate(mesh, start, motion, INTERVAL, samples, dynamics, step)
            best = min(best, time.process_time() - begun)
        return best

    densities, samples = (12, 24, 48, 96, 120), (144, 288, 576, 1440)
    rods = [rod(spring_t(), per_coil, "mass", False) for per_coil in densities]
    transient(*rods[0])
    by_elements = [cpu(*item, 4e-8, 60) for item in rods]
    by_steps = [cpu(*rods[1], 3.7e-7, count) for count in samples]
    return [
        _fit(
            "elements",
            [6 * n for n in densities],
            by_elements,
            "72 to 720 elements, equal number of steps",
        ),
        _fit("steps", list(samples), by_steps, "a decade of steps, 144 elements"),
    ]


def _fit(what: str, sizes: list[int], seconds: list[float], setting: str) -> Row:
    line = np.polynomial.Polynomial.fit(sizes, seconds, 1).convert()
    left = float(np.max(np.abs(line(np.array(sizes)) / np.array(seconds) - 1)))
    exponent = float(np.polyfit(np.log(sizes), np.log(seconds), 1)[0])
    return Row(
        f"growth with {what}",
        "valvetrain",
        setting,
        note=f"exponent {exponent:.2f}; straight line within {100 * left:.0f} %",
    )
