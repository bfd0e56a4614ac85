"""Writes small tables as a cam analyser and a spring tester make them, from a known lobe and
spring: ``lobe.csv``, ``tester.csv``.

Use: python scripts/sample_measurements.py FOLDER
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from valvetrain.parameters.curves import PiecewiseLinear
from valvetrain.parameters.material import material_by_name
from valvetrain.parameters.spring import EndCoil, SpringDefinition
from valvetrain.solution.atomic import write_text
from valvetrain.spring_card.fit import forces_at

#: Turns and pitch (mm) of the progressive spring behind ``tester.csv``: 4 mm wire, 28 mm outer
#: diameter, 8 turns.
TURNS = (0.0, 0.75, 1.25, 2.5, 4.5, 6.75, 7.25, 8.0)
PITCHES = (4.0, 4.0, 5.2, 6.2, 9.0, 9.0, 4.0, 4.0)
#: Standard deviations of a station: of the lift (mm), and of the force as a share of it.
LIFT_NOISE, FORCE_NOISE = 3e-3, 2e-3


def progressive_spring() -> SpringDefinition:
    """The spring behind ``tester.csv``."""
    end = EndCoil("closed-ground", 1.0, 0.5)
    pitch = PiecewiseLinear(TURNS, tuple(1e-3 * value for value in PITCHES))
    return SpringDefinition(
        4e-3,  # type: ignore[arg-type]
        24e-3,  # type: ignore[arg-type]
        pitch,
        8.0,
        material_by_name("EN 10270-2 VDSiCr"),
        end,
        end,
    )


def stations_of_tester(
    stations: int = 40, noise: float = FORCE_NOISE, seed: int = 1
) -> NDArray[np.float64]:
    """Heights (mm) and forces (N), (stations, 2), of that spring by the finite-element rod, with
    noise.
    """
    spring = progressive_spring()
    heights = np.linspace(
        spring.free_length - 0.5e-3, spring.solid_height + 0.08 * spring.solid_compression, stations
    )
    forces = np.array(forces_at(spring, heights.tolist()))
    return np.column_stack(
        [
            1e3 * heights,
            forces * (1 + noise * np.random.default_rng(seed).standard_normal(stations)),
        ]
    )


def stations_of_lobe(seed: int = 7) -> NDArray[np.float64]:
    """Cam angles (deg) and valve lifts (mm), (181, 2), of a lobe of 9 mm over 120 cam degrees, with
    noise.
    """
    angles = np.arange(90.0, 271.0)
    lifts = 9.0 * np.clip(1 - ((angles - 180) / 60) ** 2, 0, None) ** 3
    return np.column_stack(
        [angles, lifts + np.random.default_rng(seed).normal(0, LIFT_NOISE, len(angles))]
    )


def main(folder: Path) -> None:
    """Write both tables."""
    folder.mkdir(parents=True, exist_ok=True)
    tables = {
        "lobe.csv": ("cam angle [deg],valve lift [mm]", stations_of_lobe()),
        "tester.csv": ("height [mm],force [N]", stations_of_tester()),
    }
    for name, (head, rows) in tables.items():
        write_text(
            folder / name,
            "\n".join([head, *(",".join(f"{value:.4f}" for value in row) for row in rows)]) + "\n",
        )


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
