"""``valvetrain rig``: recordings of a test rig as cycles over the cam angle.

``cycles.py`` has the steps from file to result (begin there), each in a file of its own: ``reader.py`` with the
formats, ``channels.py``, ``shaft.py``, ``cutting.py``, ``alignment.py``.
"""

from valvetrain.lazy import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
