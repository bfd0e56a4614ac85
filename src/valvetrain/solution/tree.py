"""Results as a tree of plain JSON and a list of arrays, and back: fields of dataclasses by name, floats
and arrays to the bit. No code is stored.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from functools import partial
from importlib import import_module
from pathlib import Path
from types import FunctionType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import FrozenMapping, InputError, NamedNumbers
from valvetrain.registry import find
from valvetrain.solution.channels import Variable
from valvetrain.solution.quantity import Quantities
from valvetrain.solution.result import Solution

PACKAGE = __name__.partition(".")[0]
_NAME = re.compile(r"valvetrain(\.[a-z_0-9]+)+:[A-Za-z_][A-Za-z_0-9]*")
#: Kinds of mappings that a result may hold.
_MAPPINGS: dict[str, type] = {"dict": dict, "view": FrozenMapping, "numbers": NamedNumbers}


class UnsavedFunction:
    """The function of a study that was read: its name, which is all of it that a file holds."""

    def __init__(self, name: str) -> None:
        self.__name__ = str(name)

    def __call__(self, **_: float) -> float:
        raise InputError(
            f"the function '{self.__name__[:60]}' is not in the file of its study; give it again"
        )


class Trunk:
    """A tree being written: the ``arrays`` that it has so far, each once, but for those of the ``labelled`` variables,
    which the file holds by their names.
    """

    def __init__(self, labelled: Mapping[str, Variable] = {}) -> None:
        self.arrays: list[NDArray[Any]] = []
        self._places: dict[int, int] = {}
        self._labels = {id(one.values): name for name, one in labelled.items()}

    def of(self, item: Any, path: str = "") -> Any:
        """JSON of ``item``. Raises :class:`InputError` for a part that no file holds."""
        if item is None or isinstance(item, (bool, str)):
            return item
        if isinstance(item, (int, float)) and not hasattr(item, "_fields"):
            return float(item) if isinstance(item, float) else int(item)
        if isinstance(item, np.ndarray) and item.dtype.kind in "biufc":
            if label := self._labels.get(id(item)):
                return {"variable": label, "dtype": item.dtype.str}
            return {"array": self._place(item)}
        if isinstance(item, np.generic) and item.dtype.kind in "biuf":
            return item.item()
        if isinstance(item, np.ndarray) and item.dtype.kind == "U":
            return {"texts": item.ravel().tolist(), "shape": list(item.shape)}
        if isinstance(item, Path):
            return {"path": str(item)}
        if isinstance(item, Mapping) and not isinstance(item, Quantities):
            kind = next((name for name, one in _MAPPINGS.items() if type(item) is one), "dict")
            within = {key: f"{path}.{key}" if isinstance(key, str) else path for key in item}
            pairs = [[self.of(key, path), self.of(one, within[key])] for key, one in item.items()]
            return {"mapping": kind, "pairs": pairs}
        return self._compound(item, path)

    def _compound(self, item: Any, path: str) -> Any:
        kind = type(item)
        if kind in (tuple, list):
            every = [self.of(one, f"{path}[{index}]") for index, one in enumerate(item)]
            return every if kind is tuple else {"list": every}
        if isinstance(item, Quantities):
            return {"quantities": self.of(dict(item))}
        if kind.__module__.partition(".")[0] == PACKAGE:
            if kind.__name__ == "SamplerSpec":
                return {"sampler": item.word}
            if named := _parts(item):
                parts = {name: self.of(one, f"{path}.{name}") for name, one in named.items()}
                return {"type": f"{kind.__module__}:{kind.__qualname__}", "fields": parts}
        if path.endswith("outputs.function"):
            return {"function": getattr(item, "__name__", kind.__name__)}
        what = "a function" if isinstance(item, (FunctionType, partial)) else f"a {kind.__name__}"
        owner = re.sub(r"^\.", "", path) or "it"
        remedy = "save its arrays and numbers, such as those of to_xarray() or to_pandas()"
        if path.endswith(".process"):
            remedy = "save the study of its points without it, and fit it again"
        raise InputError(f"{what} ({owner}) cannot be stored in a file; {remedy}")

    def _place(self, array: NDArray[Any]) -> int:
        if id(array) not in self._places:  # the list keeps it alive, so that its id stays its own
            self._places[id(array)] = len(self.arrays)
            self.arrays.append(array)
        return self._places[id(array)]


def _parts(item: Any) -> dict[str, Any]:
    """The fields of a dataclass, a named tuple or a table of options; the items of another tuple."""
    if is_dataclass(item):
        # channels as plain arrays: to label them would load xarray
        plain = {"channels": "arrays"} if isinstance(item, Solution) else {}
        names = [one.name for one in fields(item)]
        return {name: getattr(item, plain.get(name, name)) for name in names} or {"": None}
    if hasattr(item, "_fields"):
        return dict(item._asdict())
    if isinstance(item, tuple):
        return {"": tuple(item)}
    if hasattr(type(item), "model_fields"):
        return {name: getattr(item, name) for name in type(item).model_fields} or {"": None}
    return {}


def grown(tree: Any, arrays: list[NDArray[Any]], variables: Mapping[str, NDArray[Any]] = {}) -> Any:
    """The item of a tree, with its ``arrays`` by number and its ``variables`` by name.

    Raises :class:`InputError`, KeyError, TypeError or ValueError for a tree that this version did not write.
    """

    def of(part: Any) -> Any:
        return grown(part, arrays, variables)

    if isinstance(tree, list):
        return tuple(map(of, tree))
    if not isinstance(tree, dict):
        return tree
    if "variable" in tree:
        return variables[tree["variable"]].astype(tree["dtype"], copy=False)
    if "array" in tree:
        return arrays[tree["array"]]
    if "texts" in tree:
        return np.array(tree["texts"], dtype=str).reshape(tree["shape"])
    if "path" in tree:
        return Path(tree["path"])
    if "list" in tree:
        return list(map(of, tree["list"]))
    if "quantities" in tree:
        return Quantities(of(tree["quantities"]))
    if "function" in tree:
        return UnsavedFunction(tree["function"])
    if "sampler" in tree:
        return find("samplers", tree["sampler"])
    if "mapping" in tree:
        pairs = {of(key): of(one) for key, one in tree["pairs"]}
        return _MAPPINGS[tree["mapping"]](pairs)
    return _made(tree["type"], {name: of(one) for name, one in tree["fields"].items()})


def _made(reference: str, parts: dict[str, Any]) -> Any:
    """An object of a class of this package from its fields, as they were."""
    if not _NAME.fullmatch(reference):
        raise ValueError(f"'{reference[:60]}' is no class of results")
    module, _, name = reference.partition(":")
    try:
        kind = getattr(import_module(module), name)
    except (ImportError, AttributeError):
        raise InputError(
            f"holds a '{reference[:80]}', which this version of valvetrain does not have; read it with the version that wrote it"
        ) from None
    items = parts.pop("", None)
    if not isinstance(kind, type) or kind.__module__ != module:
        raise ValueError(f"'{reference[:60]}' is no class of results")
    if kind is Solution or hasattr(kind, "_fields"):
        return kind(**parts)
    if issubclass(kind, tuple):
        return kind(items)
    if hasattr(kind, "model_construct"):
        return kind.model_construct(**parts)
    if not is_dataclass(kind):
        raise ValueError(f"'{reference[:60]}' is no class of results")
    return _filled(kind, parts)


def _filled(kind: Any, parts: dict[str, Any]) -> Any:
    known = {one.name for one in fields(kind)}
    if parts.keys() != known:
        odd = ", ".join(sorted(parts.keys() ^ known))
        raise InputError(
            f"holds a {kind.__name__} of another version of valvetrain ({odd[:80]}); read it with the version that wrote it"
        )
    made: Any = object.__new__(kind)
    for name, one in parts.items():
        object.__setattr__(made, name, one)
    return made
