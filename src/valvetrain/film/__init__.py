"""Motion of coils in high-speed films of a spring, compared with a model.

Begin in ``motion.py``: `coil_motion` reads the frames (``frames.py``), draws the line over time (``space_time.py``),
follows the coils (``tracks.py``), finds cycles and surge lines; ``model.py`` compares, ``rules.py`` and ``answer.py`` show.
"""

from valvetrain.lazy import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
