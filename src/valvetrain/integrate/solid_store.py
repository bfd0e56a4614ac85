"""Finished runs of solids next to the compiled kernels: a request that was stopped or killed continues
after them, and one that is repeated reads them.
"""

from __future__ import annotations

import hashlib
import os
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from valvetrain.compiled import program_digest
from valvetrain.continuum import time_kernels
from valvetrain.errors import ValvetrainError
from valvetrain.solution.netcdf import load_netcdf, save_netcdf
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.result import Solution
from valvetrain.springs.solid.model import SolidModel

#: Runs that stay on disk (some 5 MB each); the oldest go.
ON_DISK = 24


def run_key(model: SolidModel, *motion: ArrayLike | str) -> str:
    """Digest of all that a run's numbers follow from; empty where a law of contact of one's own takes
    part, whose code is not known.
    """
    if model.contact.law.kernel is not None:
        return ""
    wire, points = model.wire, model.wire.contact_points
    digest = hashlib.blake2b(digest_size=16)
    spring = model.definition
    texts = (
        model.size,
        model.contact,
        model.dynamics,
        model.seats,
        model.time_step,
        spring.material,
    )
    program = program_digest(
        "continuum/*.py", "springs/solid/*.py", "integrate/solid_*.py", "integrate/clash*.py"
    )
    digest.update(repr((texts, model.precompression, spring.total_coils, program)).encode())
    for part in (
        wire.grid, wire.coil, points.distance, points.stiffness, *wire.seat_planes[:-2], *motion,
    ):  # fmt: skip
        digest.update(repr(part).encode() if isinstance(part, str) else np.asarray(part).tobytes())
    return digest.hexdigest()


def _folder() -> Path | None:
    """With the compiled kernels; None where those are not stored."""
    kernels = getattr(time_kernels.integrate_solid, "_cache", None)
    place = getattr(kernels, "cache_path", None)
    return None if place is None else Path(place) / "solid-runs"


def read_run(key: str, provenance: Provenance) -> Solution | None:
    """The run of a key as one of ``provenance``; None where none is stored whole."""
    folder = _folder()
    if not key or folder is None or not (path := folder / f"{key}.nc").exists():
        return None
    try:
        found = load_netcdf(path)
    except (ValvetrainError, OSError, ValueError, KeyError):
        return None
    return replace(found, channels=found.arrays, provenance=provenance)


def write_run(key: str, run: Solution) -> None:
    """Store a run, if the disk takes it, and remove the oldest beyond the number that stays."""
    folder = _folder()
    if not key or folder is None:
        return
    with suppress(OSError, ValvetrainError):
        folder.mkdir(parents=True, exist_ok=True)
        save_netcdf(run, folder / f"{key}.nc")
        by_age = sorted(folder.glob("*.nc"), key=os.path.getmtime)
        for old in by_age[:-ON_DISK]:
            old.unlink(missing_ok=True)
