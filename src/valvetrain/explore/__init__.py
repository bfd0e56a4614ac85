"""Study, optimise, identify: one engine behind three commands.

Begin in ``experiment.py``: an `Experiment` evaluates `Outputs` (``outputs.py``) of a case over a `Space` (``space.py``) by ``engine.py``,
which stores finished points in ``store.py``; ``study.py``, ``optimise.py`` and ``identify.py`` read a file and call it.
"""

from valvetrain.lazy import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
