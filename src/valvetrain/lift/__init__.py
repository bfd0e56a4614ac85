"""Measured valve lifts: figures of a measured lift, and what its noise does to forces and float speed.

Begin in ``figures.py``; ``band.py`` carries the noise through runs, ``page.py`` and ``command.py`` show both. Reading and
smoothing belong to ``valvetrain.measured``, which lift laws share.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from valvetrain.lazy import lazy_names

#: Public name -> module of this package.
_HOMES = {
    "lift_figures": "figures",
    "lift_band_study": "band",
}

__all__ = ["lift_figures", "lift_band_study"]

if TYPE_CHECKING:
    from valvetrain.lift.band import lift_band_study as lift_band_study
    from valvetrain.lift.figures import lift_figures as lift_figures
else:
    __getattr__ = lazy_names(__name__, _HOMES)
