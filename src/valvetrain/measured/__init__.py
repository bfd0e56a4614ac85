"""Measured data that lift laws and tools share: tables, lift files, cycles over the cam angle,
sensors.
"""

from valvetrain.lazy import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
