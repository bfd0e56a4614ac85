"""Motion of coils in high-speed films of a spring, compared with a model.

Begin in ``motion.py``: `coil_motion` reads the frames (``frames.py``), draws the line over time (``space_time.py``),
follows the coils (``tracks.py``), finds cycles and surge lines; ``model.py`` compares, ``tables.py`` lists, ``page.py`` shows.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from valvetrain.lazy import lazy_names

#: Public name -> module of this package.
_HOMES = {
    "coil_motion": "motion",
    "CoilMotion": "result",
    "FilmSetup": "setup",
    "film_over_model": "model",
    "FilmedModel": "model",
}

__all__ = ["coil_motion", "CoilMotion", "FilmSetup", "film_over_model", "FilmedModel"]

if TYPE_CHECKING:
    from valvetrain.film.model import FilmedModel as FilmedModel
    from valvetrain.film.model import film_over_model as film_over_model
    from valvetrain.film.motion import coil_motion as coil_motion
    from valvetrain.film.result import CoilMotion as CoilMotion
    from valvetrain.film.setup import FilmSetup as FilmSetup
else:
    __getattr__ = lazy_names(__name__, _HOMES)
