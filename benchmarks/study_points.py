"""``python -m benchmarks.study_points``: wall time of 1 000 chains and of 64 finite-element rods of
the beehive at 8000 rpm, two workers.

Targets on two quiet cores: 20 s and 15 s. The kernels are compiled before.
"""

from __future__ import annotations

import tempfile
import time

import valvetrain as vt

STUDY = """
case = "gu2021-beehive-blind"
engine_speeds = "8000 rpm"
spring_models = ["{model}"]
outputs = ["peak_spring_force", "clash_count", "clash_energy"]
points = {{ sampler = "latin-hypercube", count = {count}, seed = 4 }}
vary = [
  {{ key = "spring.wire_diameter", low = "3.85 mm", high = "3.89 mm" }},
  {{ key = "spring.precompression", low = "6.8 mm", high = "7.2 mm" }},
]
"""
#: Spring model -> points, and the target (s).
STUDIES = {"multi-mass": (1000, 20.0), "finite-element": (64, 15.0)}


def wall_time(model: str, count: int, workers: int = 2) -> float:
    """Seconds of a study with a store of its own; every point must be completed."""
    with tempfile.TemporaryDirectory() as folder:
        begun = time.perf_counter()
        found = vt.study(
            STUDY.format(model=model, count=count), workers=workers, output=folder, limit="1 h"
        )
        taken = time.perf_counter() - begun
    assert {status.code for status in found.statuses} == {"completed"}
    return taken


def main() -> None:
    """Print a line per study."""
    for model, (count, target) in STUDIES.items():
        wall_time(model, 2, 1)
        print(
            f"{count} points, {model}: {wall_time(model, count):.1f} s (target {target:g} s)",
            flush=True,
        )


if __name__ == "__main__":
    main()
