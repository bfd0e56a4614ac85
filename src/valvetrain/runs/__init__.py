"""Runs of a case: one, several side by side, over engine speed, on workers, with error bars."""

from valvetrain.lazy import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
