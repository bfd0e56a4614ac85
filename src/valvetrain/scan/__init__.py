"""Springs from 3-D scans: wire axis, section and curves of a point cloud, compared with the design.

Begin in ``reconstruct.py``: `spring_from_scan` reads the cloud (``clouds.py``), finds the axis, follows the wire (``axis.py``,
``tube.py``), fits curves (``fit.py``, ``definition.py``); ``compare.py`` compares with the design, ``page.py`` shows.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from valvetrain.lazy import lazy_names

#: Public name -> module of this package.
_HOMES = {
    "spring_from_scan": "reconstruct",
    "ScannedSpring": "result",
    "compare_scan": "compare",
    "ScanComparison": "compare",
}

__all__ = ["spring_from_scan", "ScannedSpring", "compare_scan", "ScanComparison"]

if TYPE_CHECKING:
    from valvetrain.scan.compare import ScanComparison as ScanComparison
    from valvetrain.scan.compare import compare_scan as compare_scan
    from valvetrain.scan.reconstruct import spring_from_scan as spring_from_scan
    from valvetrain.scan.result import ScannedSpring as ScannedSpring
else:
    __getattr__ = lazy_names(__name__, _HOMES)
