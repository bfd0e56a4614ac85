"""Views of a result: rows, tables, figures, terminal, page, JSON."""

from valvetrain.lazy import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
