"""The geometrically exact rod: bars that stretch, shear, bend and twist, with contact of coils."""

from valvetrain.lazy import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
