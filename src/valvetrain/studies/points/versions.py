"""What besides a point's own input can move its numbers: this package's own text, Python, and the
libraries that compute.
"""

from __future__ import annotations

import hashlib
import platform
from functools import cache
from pathlib import Path

from valvetrain.solution.provenance import collect_provenance

#: Packages of this one that show and ask, and compute nothing.
_SHOW = ("cli", "report", "validation")


@cache
def versions_digest() -> str:
    """A digest of all that computes: source text, versions of Python and of the libraries, kind of
    machine.
    """
    root = Path(__file__).parents[2]
    origin = collect_provenance("", "")
    told = hashlib.blake2b(digest_size=16)
    for words in (
        origin.package_version,
        origin.python_version,
        *map(str, sorted(origin.dependencies.items())),
        platform.machine(),
    ):
        told.update(words.encode() + b"\0")
    for path in sorted(root.rglob("*.py")):
        if path.relative_to(root).parts[0] not in _SHOW:
            told.update(path.read_bytes() + b"\0")
    return told.hexdigest()
