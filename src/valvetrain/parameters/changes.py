"""Copies of frozen parameter sets with values changed by key path, and the differences between two
of them.
"""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from inspect import signature
from typing import Any

from valvetrain import registry
from valvetrain.errors import InputError
from valvetrain.parameters.lift_law import FrozenMapping, LiftLawParameters


def nearest(name: str, valid: list[str] | tuple[str, ...]) -> str:
    """A clause that names the valid name(s) nearest to ``name``, or lists them all when none is
    near.
    """
    close = difflib.get_close_matches(name[:60], valid, n=3, cutoff=0.6)
    if close:
        return "did you mean " + " or ".join(close) + "?"
    return (
        "valid names are " + ", ".join(sorted(valid)) if valid else "there are no valid names here"
    )


def changed(target: Any, changes: Mapping[str, Any], where: str = "") -> Any:
    """A copy of the dataclass ``target`` with the dotted paths in ``changes`` set; raises
    :class:`InputError` for unknown paths.

    Places in a tuple are numbers (``springs.0.precompression``); a path may lead through a mapping.
    """
    direct: dict[str, Any] = {}
    nested: dict[str, dict[str, Any]] = {}
    for path, value in changes.items():
        head, _, rest = path.partition(".")
        _check_name(target, head, where)
        if rest:
            nested.setdefault(head, {})[rest] = value
        else:
            direct[head] = value
    for head, inner in nested.items():
        base = direct.get(head, _part(target, head))
        if not is_dataclass(base) and not isinstance(base, (tuple, Mapping)):
            raise InputError(f"{where}{head} has no parts to set; it is {base!r}")
        direct[head] = changed(base, inner, f"{where}{head}.")
    if isinstance(target, tuple):
        return tuple(direct.get(str(place), item) for place, item in enumerate(target))
    if isinstance(target, Mapping):
        return FrozenMapping({**target, **direct})
    own = getattr(target, "replace", None)
    # Case.replace comes back here, so only parts use their own replace.
    return own(**direct) if own is not None and where else replace(target, **direct)


def _part(target: Any, head: str) -> Any:
    if isinstance(target, tuple):
        return target[int(head)]
    return (
        target.get(head, FrozenMapping())
        if isinstance(target, Mapping)
        else getattr(target, head, None)
    )


def _check_name(target: Any, name: str, where: str) -> None:
    if isinstance(target, tuple):
        names = [str(place) for place in range(len(target))]
    elif isinstance(target, Mapping):
        # Options and points that the case does not give may be set; those that nothing uses are
        # refused where the part is made.
        names = [*target, name] if "options." in where or where == "points." else list(target)
    else:
        names = [field.name for field in fields(target)]
        values = getattr(target, "values", None)
        names += list(values) if isinstance(values, Mapping) else []
        names += _numbers_of_law(target.kind) if isinstance(target, LiftLawParameters) else []
    if name not in names:
        raise InputError(f"there is no value '{where}{name}'; {nearest(name, names)}")


def _numbers_of_law(kind: str) -> list[str]:
    """Numbers that a lift law of the kind can be given, also those that it need not have."""
    return list(signature(registry.find("lifts", kind).make).parameters)


def differences(first: Any, second: Any, path: str = "") -> dict[str, tuple[Any, Any]]:
    """Key path -> (value in ``first``, value in ``second``) of everything that differs."""
    if is_dataclass(first) and type(first) is type(second):
        names = [field.name for field in fields(first) if field.compare]
        parts = [
            differences(getattr(first, name), getattr(second, name), f"{path}.{name}".lstrip("."))
            for name in names
        ]
        return {key: value for part in parts for key, value in part.items()}
    if isinstance(first, Mapping) and isinstance(second, Mapping):
        names = list(dict.fromkeys([*first, *second]))
        parts = [differences(first.get(name), second.get(name), f"{path}.{name}") for name in names]
        return {key: value for part in parts for key, value in part.items()}
    if (
        isinstance(first, tuple)
        and isinstance(second, tuple)
        and len(first) == len(second)
        and any(is_dataclass(item) for item in first)
    ):
        parts = [
            differences(one, other, f"{path}.{place}")
            for place, (one, other) in enumerate(zip(first, second, strict=True))
        ]
        return {key: value for part in parts for key, value in part.items()}
    return {} if _same(first, second) else {path: (first, second)}


def _same(first: Any, second: Any) -> bool:
    try:
        return bool(first == second)
    except ValueError:  # arrays
        return False
