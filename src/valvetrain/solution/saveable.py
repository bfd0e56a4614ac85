"""Results that save themselves."""

from __future__ import annotations

import os
from pathlib import Path


class Saveable:
    """A result with a file of its own."""

    __slots__ = ()

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write it to one NetCDF file (``.nc``), whole or not at all; :func:`valvetrain.load` reads
        an equal one. A solution may be a CSV file (``.csv``) as well.
        """
        from valvetrain.solution.netcdf import save_result

        return save_result(self, path)
