"""Public names of a package that load their modules on first use."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module


def lazy_names(package: str, homes: Mapping[str, str]) -> Callable[[str], object]:
    """A module's ``__getattr__`` that imports ``homes[name]`` of ``package`` when a name is used.

    Parameters
    ----------
    package : str
        Dotted name of the package, its ``__name__``.
    homes : mapping
        Public name -> module of the package that defines it.
    """

    def load(name: str) -> object:
        if name not in homes:
            raise AttributeError(f"module '{package}' has no name '{name}'")
        return getattr(import_module(f"{package}.{homes[name]}"), name)

    return load
