"""Results rebuilt from what a file holds, after it was made sure that the file holds what it
claims.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from valvetrain.errors import InputError
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.result import Solution

if TYPE_CHECKING:
    import h5py
    import xarray

#: Begin of every sentence about a file whose parts do not fit.
DAMAGED = "is damaged:"
#: The best compression makes of one byte no more than this many; variables this small are read
#: whatever is stored of them.
MOST_EXPANDED, SMALL = 1100, 65_536
#: A result has fewer variables.
MOST_VARIABLES = 5000
_DIMENSION = b"This is a netCDF dimension but not a netCDF variable"


def refuse_claims(path: Path) -> None:
    """Raise :class:`InputError` for a NetCDF file whose variables claim more than is stored, lie in
    another file or are linked.

    Only what the file says of itself is read, so nothing of the claimed size is made. Errors of the
    library pass.
    """
    import h5py

    whole = path.stat().st_size
    with h5py.File(path, "r") as file:
        if len(file) > MOST_VARIABLES:
            raise InputError(
                f"claims {len(file)} variables, more than a result has; write it again", str(path)
            )
        for name in file:
            held = file[name] if isinstance(file.get(name, getlink=True), h5py.HardLink) else None
            if not isinstance(held, h5py.Dataset) or held.is_virtual or held.external:
                raise InputError(
                    f"{DAMAGED} '{name}' is no variable of its own; write it again", str(path)
                )
            label = held.attrs.get("NAME", b"")
            if (label.encode() if isinstance(label, str) else bytes(label)).startswith(_DIMENSION):
                continue  # the length of a dimension, of which nothing is stored or read
            stored = held.id.get_storage_size()
            claimed = max(
                held.nbytes, _chunk_bytes(held) if stored else 0
            )  # one value of a chunk makes room for all of it
            if stored > whole or claimed > max(SMALL, stored * MOST_EXPANDED):
                raise InputError(
                    f"{DAMAGED} '{name}' claims {claimed:.3g} bytes and holds {stored}; write it again",
                    str(path),
                )


def _chunk_bytes(held: h5py.Dataset) -> int:
    """Bytes of one piece of a variable that is stored in pieces; 0 of others."""
    return math.prod(held.chunks) * held.dtype.itemsize if held.chunks else 0


def solution_of(dataset: xarray.Dataset, content: dict[str, Any], where: str) -> Solution:
    """The solution of labelled arrays and the unpacked description.

    Raises :class:`InputError` where channels are no numbers or lack what every channel has.
    """
    for name, variable in dataset.variables.items():
        words_of = (variable.attrs.get(key, "") for key in ("units", "long_name"))
        if variable.dtype.kind not in "biuf" or not all(isinstance(word, str) for word in words_of):
            raise InputError(
                f"{DAMAGED} channel '{name}' holds no numbers, or its unit is no word; write it again",
                where,
            )
    words = (
        content["events"],
        content["status"],
        content["statistics"],
        content["provenance"] or Provenance("", ""),
    )
    try:
        return Solution(dataset, *words, content["quantities"], tuple(content.get("gaps", ())))
    except InputError as error:
        raise InputError(f"{DAMAGED} {error.reason}", where) from error
