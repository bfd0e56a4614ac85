"""Springs, trains, materials and cases as frozen data, read from tables with units and checked."""

from valvetrain.lazy import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
