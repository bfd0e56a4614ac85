"""Measured valve lifts: figures of a measured lift, and what its noise does to forces and float speed.

Begin in ``figures.py``; ``band.py`` carries the noise through runs, ``files.py`` writes what a lift leaves, and ``answer.py``
shows it by the findings of ``rules.py``. Reading and smoothing belong to ``valvetrain.measured``, which lift laws share.
"""

from valvetrain.lazy import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
