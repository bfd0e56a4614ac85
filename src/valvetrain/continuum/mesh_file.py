"""A mesh of solid elements as a file of other programs, by meshio."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.arrays import Array
from valvetrain.continuum.mesh import SolidMesh
from valvetrain.errors import InputError, MissingExtraError
from valvetrain.solution.atomic import atomic_path

#: File ending -> name of the format in meshio.
FORMATS = {".vtu": "vtu", ".vtk": "vtk", ".msh": "gmsh", ".xdmf": "xdmf", ".med": "med"}
MESHIO_HINT = "export of solid meshes needs the package meshio, which is not installed: install it with 'pip install \"valvetrain[mesh]\"'"


def write_mesh(
    mesh: SolidMesh,
    path: str | os.PathLike[str],
    point_data: Mapping[str, Array] | None = None,
) -> Path:
    """Write ``mesh`` (m) with its coil number and ``point_data`` (one row per node); the file
    ending chooses the format.

    Raises :class:`MissingExtraError` without meshio and :class:`InputError` for an ending or data
    that do not fit.
    """
    meshio = _meshio()
    target = Path(path)
    form = FORMATS.get(target.suffix.lower())
    if form is None:
        raise InputError(
            f"mesh file '{target.name}' has an ending that names no format; use one of {', '.join(FORMATS)}"
        )
    data = {"coil_number": mesh.coil, **(point_data or {})}
    for name, values in data.items():
        if len(values) != len(mesh.coordinates):
            raise InputError(
                f"point data '{name}' has {len(values)} rows for {len(mesh.coordinates)} nodes; give one row per node"
            )
    kind = "hexahedron20" if mesh.quadratic else "hexahedron"
    content = meshio.Mesh(
        mesh.coordinates,
        [(kind, mesh.elements)],
        point_data={k: np.asarray(v, dtype=float) for k, v in data.items()},
    )
    with atomic_path(target) as temporary:
        meshio.write(temporary, content, file_format=form)
    return target


def _meshio() -> Any:
    try:
        import meshio
    except ImportError as error:
        raise MissingExtraError(MESHIO_HINT) from error
    return meshio
