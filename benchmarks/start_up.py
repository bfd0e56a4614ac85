"""What the package costs before it computes: import, warm start of the command line, first
compilation.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping

from benchmarks.rows import Row, rusage_of

#: Everything that the main job compiles, run once at the smallest size that reaches every kernel.
MAIN_JOB = "import valvetrain as vt; vt.simulate('gu2021-beehive-blind', [800.0], workers=1)"
BATCH = (
    "from benchmarks.standard import *; from valvetrain.cosserat.batch import simulate_batch as s; "
    "m, d, e = rod(spring_c(), 12, 'stiffness', True); s([m], [e], motion, INTERVAL, 2, d)"
)
TRAIN = (
    "from valvetrain.runs.run import *; from valvetrain.parameters.loading import load_case as l; "
    "from valvetrain.integrate.train_run import runner; "
    "t = runner(build(l('tdi-pushrod')).members[0].system(), 200.0); t.cycle(t.initial_state())"
)
FIRST_STEP = (
    "from valvetrain.parameters.loading import load_case as l; import valvetrain.cli.main, valvetrain.runs.run; "
    "m = valvetrain.runs.run.build(l('gu2021-beehive-blind'), spring_models=('finite-element',)).members[0].system().springs[0]; "
    "m.installed; m.stable_time_step()"
)


def measure() -> list[Row]:
    """Rows for import, warm start and compilation."""
    nothing = best("pass")
    rows = [
        Row(
            "import",
            "valvetrain",
            "import valvetrain",
            wall=best("import valvetrain") - nothing,
            note="interpreter start taken off",
        ),
        Row(
            "start",
            "valvetrain",
            "process start to first time step, warm",
            wall=best(FIRST_STEP, 3),
            note="target 2 s",
        ),
    ]
    warm = {
        name: run(code)[0]
        for name, code in (("main job", MAIN_JOB), ("batch", BATCH), ("train", TRAIN))
    }
    for name, code in (("main job", MAIN_JOB), ("batch", BATCH), ("train", TRAIN)):
        with tempfile.TemporaryDirectory() as cache:
            wall, cpu, memory = run(code, {"NUMBA_CACHE_DIR": cache})
        note = (
            "target 30 s; cached on disk afterwards"
            if name == "main job"
            else "cached on disk afterwards"
        )
        rows.append(
            Row(
                "compile",
                "valvetrain",
                f"{name}, empty cache",
                wall=wall - warm[name],
                cpu=cpu,
                memory=memory,
                note=note,
            )
        )
    return rows


def run(code: str, extra: Mapping[str, str] | None = None) -> tuple[float, float, float]:
    """Wall, CPU (s) and peak memory (MB) of ``code`` in a new interpreter."""
    started = time.perf_counter()
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", **(extra or {})}
    output = subprocess.run(
        [sys.executable, "-c", rusage_of(code)],
        check=True,
        env=environment,
        capture_output=True,
        text=True,
    ).stdout
    cpu, memory = map(float, output.split()[-2:])
    return time.perf_counter() - started, cpu, memory


def best(code: str, repeats: int = 5) -> float:
    """Median wall time (s) of ``code`` in a new interpreter."""
    return statistics.median(run(code)[0] for _ in range(repeats))
