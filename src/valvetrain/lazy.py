"""Public names of a package that load their modules on first use."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path


def names_of_stub(package: str, file: str) -> dict[str, str]:
    """Public name -> module that defines it, of the lines ``from module import name as name`` in
    the ``__init__.pyi`` next to ``file``, which type checkers read as well.

    Parameters
    ----------
    package : str
        Dotted name of the package, its ``__name__``.
    file : str
        Its ``__file__``.
    """
    homes = {}
    text = Path(file).with_name("__init__.pyi").read_text(encoding="utf-8")
    for statement in text.replace("(", " ").replace(")", " ").split("from ")[1:]:
        module, _, names = statement.partition(" import ")
        for alias in names.partition("\n\n")[0].split(","):
            if name := alias.split()[-1:]:
                homes[name[0]] = f"{package}.{name[0]}" if module == package else module
    return homes


def public_names(
    package: str, file: str
) -> tuple[Callable[[str], object], Callable[[], list[str]], list[str]]:
    """``__getattr__``, ``__dir__`` and ``__all__`` of a package whose stub lists its public names.

    Parameters
    ----------
    package : str
        Dotted name of the package, its ``__name__``.
    file : str
        Its ``__file__``.
    """
    homes = names_of_stub(package, file)

    def load(name: str) -> object:
        if name not in homes:
            raise AttributeError(f"module '{package}' has no name '{name}'")
        module = import_module(homes[name])
        return module if homes[name] == f"{package}.{name}" else getattr(module, name)

    return load, lambda: sorted(homes), list(homes)


def module_of(package: str, name: str, file: str) -> object:
    """What a package answers to a name that its stub does not list: a module of it.

    Parameters
    ----------
    package : dotted name of the package
    name : the name that was not found
    file : ``__file__`` of the package

    Raises
    ------
    AttributeError : an unknown name; the sentence has the nearest
    """
    inside = Path(file).parent
    if (inside / f"{name}.py").is_file() or (inside / name / "__init__.py").is_file():
        return import_module(f"{package}.{name}")
    import difflib  # here: a plain import of the package does not pay for it

    paths = {one: one for one in names_of_stub(package, file)}
    for stub in () if name.startswith("_") else sorted(inside.glob("*/__init__.pyi")):
        folder = stub.parent.name
        for one in getattr(import_module(f"{package}.{folder}"), "__all__", ()):
            paths.setdefault(one, f"{folder}.{one}")
    near = difflib.get_close_matches(name, paths, n=1, cutoff=0.6)
    remedy = f"did you mean {paths[near[0]]}?" if near else f"dir({package}) lists the names"
    raise AttributeError(f"module '{package}' has no name '{name}'; {remedy}")
