"""Writes small tests to compare models with, all but one SYNTHETIC and marked so: computed, with
scatter drawn, never measured.

``spring-force.csv``: cycles of the spring force of the case job-t at 3000 rpm, by the
finite-element rod with scatter that follows its
neighbours along the angle. ``coils-lash-0.csv``, ``coils-lash-0.1.csv``: repeats of the largest
displacement of four sections of the outer
spring of the case vaz-ohc, as an adequacy study by film would have them, by the finite-element rod
with reading errors.
``engine-head.csv``: the values that Gu, Hou, Keating and Ye (2021) print of their engine head test,
with scatters that are assumed, for
the paper states none.

Use: python scripts/sample_test_cycles.py FOLDER
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from valvetrain.compare_test.compare import active_wire
from valvetrain.measured.cycles import MeasuredCycles, write_cycles
from valvetrain.measured.sensor import Sensor
from valvetrain.parameters.loading import load_case
from valvetrain.quantities.traces import trace_of
from valvetrain.runs.api import simulate
from valvetrain.solution.atomic import write_text
from valvetrain.system.build import build

Array = NDArray[np.float64]
#: Scatter of a cycle of the force (N), and harmonics of the turn up to which it reaches.
FORCE_SCATTER, HARMONICS = 6.0, 40
#: Bandwidth (Hz) of the force sensor that is made up.
BANDWIDTH = 8e3
#: Sections of the active wire, repeats, reading error of one (mm), and the share by which all
#: sections of a repeat move together.
SECTIONS, REPEATS, READING, SHARED = (0.2, 0.4, 0.6, 0.8), 10, 0.06, 0.004
#: What is assumed of the engine head's values: share of a force, and cam degrees of an angle, those
#: "about" a value apart.
FORCE_SHARE, ANGLE, ABOUT = "1 %", 0.5, 2.0


def scatter(cycles: int, cam_angle: Array, seed: int) -> Array:
    """Scatter of ``cycles`` (cycles, angles) of unit variance, its harmonics of equal power."""
    drawn = np.random.default_rng(seed).standard_normal((cycles, 2, HARMONICS)) / np.sqrt(HARMONICS)
    turned = np.outer(np.arange(1, HARMONICS + 1), cam_angle)
    found: Array = drawn[:, 0] @ np.cos(turned) + drawn[:, 1] @ np.sin(turned)
    return found


def force_cycles(cycles: int = 12, angles: int = 720, seed: int = 3) -> MeasuredCycles:
    """Cycles of the spring force of job-t at 3000 rpm of the crank."""
    run = simulate("job-t", "3000 rpm", models=["finite-element"], workers=1).solutions[0]
    cam_angle = np.arange(angles) * 2 * np.pi / angles
    mean = trace_of(run, "spring_force").through(Sensor(bandwidth=BANDWIDTH)).at(cam_angle)
    values = np.round(mean + FORCE_SCATTER * scatter(cycles, cam_angle, seed), 2)
    note = "finite-element rod through a gauge of 8 kHz with scatter drawn; a synthetic test, no engine was run"
    return MeasuredCycles(
        "spring_force",
        "N",
        cam_angle,
        values,
        run.engine_speed / 2,
        "sample_test_cycles.py",
        True,
        (note,),
    )


def coil_table(lash: str, seed: int) -> str:
    """Repeats of the largest displacements (mm) of sections of the outer spring at a lash, as a
    table of values.
    """
    case = load_case("vaz-ohc", {"train.lash": lash})
    models, sets = ("finite-element",), ("nested",)
    run = simulate(case, models=models, spring_sets=sets, workers=1).solutions[0]
    active = active_wire(build(case, spring_models=models, spring_set=sets))[run.label]
    names = [f"outer_section_{place:g}_displacement" for place in SECTIONS]
    peaks = 1e3 * np.array([trace_of(run, name, active).values.max() for name in names])
    drawn = np.random.default_rng(seed)
    repeats = peaks * (
        1 + SHARED * drawn.standard_normal((REPEATS, 1))
    ) + READING * drawn.standard_normal((REPEATS, len(peaks)))
    lines = [
        "# synthetic: yes", "# source: sample_test_cycles.py", f"# cam speed: {run.engine_speed / 2 * 30 / np.pi:.10g} rpm",
        f"# note: finite-element rod at lash {lash} with reading errors drawn; synthetic repeats, no film was taken",
        ",".join(["quantity", "unit", *(f"repeat {place}" for place in range(1, REPEATS + 1))]),
    ]  # fmt: skip
    lines += [
        ",".join([f"peak_{name}", "mm", *(f"{value:.3f}" for value in row)])
        for name, row in zip(names, repeats.T, strict=True)
    ]
    return "\n".join(lines) + "\n"


def engine_head_table() -> str:
    """The engine head's printed values; bounds ("as high as") are no values and are left out."""
    lines = [
        "# source: Gu, Hou, Keating and Ye (2021), engine head test, values printed in sections 4.1 to 4.3",
        f"# note: the source states no scatter; the table assumes {FORCE_SHARE} of a force, {ANGLE:g} deg of an angle, "
        f"{ABOUT:g} deg where it says about",
        "quantity,unit,value,scatter,engine speed [rpm]",
    ]  # fmt: skip
    for one in build(load_case("gu2021-beehive-blind")).record.published:
        if one.model != "engine head test" or one.relation == "at-most" or one.engine_speed is None:
            continue
        angle = one.quantity.endswith("_angle")
        value = np.degrees(one.value) if angle else one.value
        spread = f"{ABOUT if one.relation == 'about' else ANGLE:g}" if angle else FORCE_SHARE
        lines.append(
            f"{one.quantity},{'deg' if angle else 'N'},{value:.6g},{spread},{one.engine_speed * 30 / np.pi:.6g}"
        )
    return "\n".join(lines) + "\n"


def main(folder: Path) -> None:
    """Write all four."""
    folder.mkdir(parents=True, exist_ok=True)
    write_cycles(folder / "spring-force.csv", force_cycles())
    for lash, seed in (("0 mm", 11), ("0.1 mm", 12)):
        write_text(folder / f"coils-lash-{lash.split()[0]}.csv", coil_table(lash, seed))
    write_text(folder / "engine-head.csv", engine_head_table())


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
