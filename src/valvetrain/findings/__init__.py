"""Findings: what a result shows, by a table of rules with stable codes."""

from valvetrain.lazy import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
