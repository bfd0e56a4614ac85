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
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.winding import EndCoil
from valvetrain.solution.atomic import write_text
from valvetrain.spring_card.fit import forces_at

#: Turns and pitch (mm) of the progressive spring behind ``tester.csv``: 4 mm wire, 28 mm outer
#: diameter, 8 turns.
TURNS = (0.0, 0.75, 1.25, 2.5, 4.5, 6.75, 7.25, 8.0)
PITCHES = (4.0, 4.0, 5.2, 6.2, 9.0, 9.0, 4.0, 4.0)
#: Standard deviation of the force of a station, as a share of it.
FORCE_NOISE = 2e-3


def progressive_spring() -> SpringDefinition:
    """The spring behind ``tester.csv``."""
    end = EndCoil("closed-ground", 1.0, 0.5)
    pitch = PiecewiseLinear(TURNS, tuple(1e-3 * value for value in PITCHES))
    return SpringDefinition(
        4e-3,
        24e-3,
        pitch,
        total_coils=8.0,
        material=material_by_name("EN 10270-2 VDSiCr"),
        lower_end=end,
        upper_end=end,
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


def stations_of_lobe() -> list[tuple[str, ...]]:
    """Cam angles (deg) and valve lifts (in) as a dial gauge on a degree wheel gives them: every 5 degrees, read to 0.001 in.

    The lobe is 9 (1 - u^2)^3 (1 + 1.2 u^2) mm over 60 degrees on either side of 130.3.
    """
    angles = np.arange(40.0, 221.0, 5.0)
    square = np.minimum(((angles - 130.3) / 60) ** 2, 1.0)
    lifts = 9.0 * (1 - square) ** 3 * (1 + 1.2 * square) / 25.4
    return [(f"{angle:.0f}", f"{lift:.3f}") for angle, lift in zip(angles, lifts, strict=True)]


def main(folder: Path) -> None:
    """Write both tables."""
    folder.mkdir(parents=True, exist_ok=True)
    tables = {
        "lobe.csv": ("Cam deg,valve lift (in)", stations_of_lobe()),
        "tester.csv": (
            "height [mm],force [N]",
            [tuple(f"{value:.4f}" for value in row) for row in stations_of_tester()],
        ),
    }
    for name, (head, rows) in tables.items():
        write_text(
            folder / name,
            "\n".join([head, *map(",".join, rows)]) + "\n",
        )


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
