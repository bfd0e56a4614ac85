"""Quantities that a published study names, as rows of the table of quantities."""

from __future__ import annotations

import tomllib
from pathlib import Path

from valvetrain.solution.definition import QuantityRow, row

#: Tables of a study's file that are about its names.
NAMES = ("quantities", "systems")
#: Folder of the files of published studies that ship with the package.
SOURCES = Path(__file__).parents[1] / "parameters" / "library"


def angle_of(name: str) -> str:
    """Name of the cam angle of a quantity.

    >>> angle_of("stage_2_peak_force"), angle_of("node_2_rebound_velocity")
    ('stage_2_peak_cam_angle', 'node_2_rebound_velocity_cam_angle')
    """
    return f"{name.removesuffix('_force')}_cam_angle"


def rows_of(path: Path) -> tuple[QuantityRow, ...]:
    """The rows of the table ``[quantities]`` of a study's file; with ``cam_angle`` one of that angle too.

    >>> [one.name for one in rows_of(SOURCES / "gu2021.source")[4:6]]
    ['stage_2_peak_force', 'stage_2_peak_cam_angle']
    """
    tree = tomllib.loads(path.read_text(encoding="utf-8"))
    found: list[QuantityRow] = []
    for name, given in tree["quantities"].items():
        values = {"systems": tuple(tree["systems"])} | given
        angle, label = values.pop("cam_angle", False), values["label"]
        found.append(row(name, **values))
        if angle:
            words = f"{label.removesuffix(' force')}, cam angle"
            found.append(
                row(angle_of(name), words, f"Cam angle of the {label}.", systems=found[-1].systems)
            )
    return tuple(found)


GU2021, MULTIBODY4B17 = (rows_of(SOURCES / f"{key}.source") for key in ("gu2021", "multibody4b17"))
