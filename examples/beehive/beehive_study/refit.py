"""Rewrite the identified values of the beehive case and their spread from its identification
(examples/beehive/identify.toml).

Hours of work; ``valvetrain identify examples/beehive/identify.toml`` shows the same search without
touching the library.

    python -m beehive_study.refit FOLDER [--workers 2] [--draws 48]

FOLDER keeps every point as it is computed: started again with the same folder, the search goes on
where it was cut.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from importlib import resources
from pathlib import Path

import numpy as np

from beehive_study.identification import case_values
from beehive_study.rewrite import write_case_values
from valvetrain.errors import InputError
from valvetrain.explore.execution import Execution
from valvetrain.explore.identification_file import IdentificationPlan
from valvetrain.explore.identified import Identified
from valvetrain.explore.identify import run_identification
from valvetrain.explore.requests import Identify
from valvetrain.parameters.loading import load_case
from valvetrain.runs.api import simulate
from valvetrain.runs.cost import Limits
from valvetrain.solution.atomic import digest, write_text

FILE = Path(__file__).resolve().parents[1] / "identify.toml"


def method_digest(request: IdentificationPlan) -> str:
    """Fingerprint of priors and data: what a spread depends on beside the case."""
    priors = [
        (one.name, one.prior.low, one.prior.high, one.prior.centre, one.prior.spread)
        for one in request.unknowns
    ]
    data = [(one.key, one.value, one.scatter) for one in request.data]
    return digest(repr((priors, data)).encode())[:16]


#: Quantities whose spread over the posterior is worth telling, with the unit they are told in.
SPREADS = (
    "stage_1_minimum_force", "stage_1_maximum_force", "stage_2_peak_force", "stage_2_peak_cam_angle", "stage_2_first_peak_force",
    "stage_2_valley_force", "stage_2_second_peak_force", "stage_3_peak_force", "stage_3_peak_cam_angle", "node_2_maximum_displacement",
    "node_2_stage_3_minimum_velocity", "node_2_peak_acceleration", "clash_interval_cam_angle",
)  # fmt: skip


def predict(
    elements_per_coil: int, names: Sequence[str], values: Sequence[float]
) -> dict[str, float]:
    """All three speeds of one draw of the unknowns: named quantities, keyed ``rpm quantity``; empty
    for an impossible spring.
    """
    try:
        changes = case_values(dict(zip(names, map(float, values), strict=True)))
        case = load_case("gu2021-beehive-blind", changes)
        spring = case.springs[0].with_options("finite-element", elements_per_coil=elements_per_coil)
        study = simulate(case.replace(springs=(spring,)), models=("finite-element",), workers=1)
    except (InputError, ValueError, np.linalg.LinAlgError, RuntimeError):
        return {}
    found = study.quantities.items()
    return {
        f"{round(q.engine_speed * 30 / np.pi)} {q.name}": value
        for q, value in found
        if q.engine_speed and q.name in SPREADS
    }


def tell_spread(
    found: Identified, request: IdentificationPlan, elements: int, workers: int, count: int
) -> str:
    """TOML text: 5, 50 and 95 % of each quantity over ``count`` draws of the posterior (SI)."""
    with ProcessPoolExecutor(workers) as pool:
        outcomes = [
            o for o in pool.map(partial(predict, elements, found.names), found.values[:count]) if o
        ]
    lines = [
        "# Spread of the beehive's results over what its calibration data leave open; written by beehive_study.refit.",
        f"# Percentiles 5, 50, 95 over {len(outcomes)} draws of the linearised posterior, {elements} elements per coil, SI units.",
        "", "[case]", f'digest = "{load_case("gu2021-beehive-blind").record().digest}"', f'identification = "{method_digest(request)}"',
    ]  # fmt: skip
    for rpm in (4200, 5600, 8000):
        lines += ["", f'["{rpm} rpm"]']
        for name in SPREADS:
            values = [
                o[f"{rpm} {name}"] for o in outcomes if np.isfinite(o.get(f"{rpm} {name}", np.nan))
            ]
            if len(values) >= 0.5 * len(outcomes):
                lines.append(
                    f"{name} = [{', '.join(f'{v:.6g}' for v in np.percentile(values, (5, 50, 95)))}]"
                )
    return "\n".join(lines) + "\n"


def main() -> None:
    """Identify, rewrite the case library, then compute the spread."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--draws", type=int, default=48)
    options = parser.parse_args()
    request = Identify.read({"file": FILE}).plan
    request = replace(request, search=replace(request.search, draws=options.draws))
    found = run_identification(
        request, Execution(output=options.folder, workers=options.workers, limit=Limits(1e9, 1e12))
    )
    print(found)
    path = resources.files("valvetrain") / "parameters" / "library" / "gu2021-beehive-blind.toml"
    write_case_values(str(path), case_values(found.best))
    print(f"rewrote the identified values of {path.name}; write_uncertainty.py comes next")
    spread = tell_spread(found, request, 16, options.workers, options.draws)
    write_text(str(path).replace(".toml", ".spread"), spread)
    print(spread)


if __name__ == "__main__":
    main()
