"""Springs from 3-D scans: wire axis, section and curves of a point cloud, compared with the design.

Begin in ``reconstruct.py``: `spring_from_scan` reads the cloud (``clouds.py``), finds the axis, follows the wire (``axis.py``,
``tube.py``), fits curves (``fit.py``, ``definition.py``); ``compare.py`` compares with the design, ``rules.py`` and ``answer.py`` show.
"""

from valvetrain.lazy import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
