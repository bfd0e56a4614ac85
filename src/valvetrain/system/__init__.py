"""The assembled spring or train: its equations, its state at rest and the problem that is solved."""

from valvetrain.lazy import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
