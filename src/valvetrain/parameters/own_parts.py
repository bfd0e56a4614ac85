"""Parts given in Python: a function, class or instance gets a name, by which a case, a run and a
study speak of it. The name ends in a digest of its content and carries the part to other processes.
"""

from __future__ import annotations

import copy
import dis
import hashlib
import inspect
import pickle
import re
import sys
from collections import namedtuple
from collections.abc import Iterator, Mapping
from numbers import Number
from types import CodeType, FunctionType, MethodType, ModuleType
from typing import Any

import numpy as np

from valvetrain import registry
from valvetrain.errors import InputError

#: Longest name before its digits.
MAX_LENGTH = 40


class OwnName(str):
    """Name of a part given in Python; sent to another process, it brings the part along."""

    def __reduce__(self) -> Any:
        part = registry.OWN[self]
        try:
            return _received, (str(self), pickle.dumps(part) if _is_library(part) else _sent(part))
        except Exception as error:
            raise InputError(
                f"'{registry.plain_name(self)}' cannot be sent to other processes ({error}); take workers=1"
            ) from error

    def __copy__(self) -> OwnName:
        return self

    def __deepcopy__(self, memo: Any) -> OwnName:
        return self


def own_name(part: Any) -> OwnName:
    """The name of a function, class or instance, under which this process now knows it.

    >>> from math import sqrt
    >>> registry.plain_name(own_name(sqrt))
    'sqrt'
    """
    known = str(getattr(part, "word", "") or getattr(part, "__name__", type(part).__name__))
    plain = re.sub(r"[^A-Za-z0-9]+", "-", known).strip("-")[:MAX_LENGTH] or "own"
    name = OwnName(f"{plain}-{part_digest(part)[:8]}")
    if name not in registry.OWN:
        registry.OWN[name] = copy.deepcopy(part)  # what is changed later is another part
    return name


def part_digest(part: Any) -> str:
    """Hexadecimal digest of what decides the numbers of a function, class or instance."""
    return hashlib.sha256(b"\0".join(_content(part, {}))).hexdigest()


def carrying(word: str) -> str:
    """``word``, as :class:`OwnName` where it names a part given in Python."""
    return OwnName(word) if word in registry.OWN else word


def _sent(part: Any) -> bytes:
    try:
        from cloudpickle import dumps
    except ImportError:
        return pickle.dumps(part)
    content: bytes = dumps(part)
    return content


def _received(word: str, content: bytes) -> OwnName:
    if word not in registry.OWN:
        registry.OWN[word] = pickle.loads(content)
    return OwnName(word)


def _is_library(item: Any) -> bool:
    """Whether an object is code of an installed package, or an instance of such a class; its name
    says what that computes.
    """
    kind: Any = item if isinstance(item, (FunctionType, type)) else type(item)
    module: Any = sys.modules.get(kind.__module__ or "")
    found = module
    for name in kind.__qualname__.split("."):
        found = getattr(found, name, None)
    if found is not kind:
        return False
    top, file = kind.__module__.partition(".")[0], getattr(module, "__file__", None) or ""
    standard = top in sys.stdlib_module_names and top != "__main__"
    return standard or top == "valvetrain" or "site-packages" in file


def _content(item: Any, seen: dict[int, Any]) -> Iterator[bytes]:
    """What decides the numbers of a part: code with the values that it uses, values to the last bit."""
    if isinstance(item, (bool, int, float, complex, str, bytes, type(None), type(...))):
        yield repr(item).encode()
        return
    if isinstance(item, (np.ndarray, np.generic)) and item.dtype != object:
        yield f"{item.dtype} {item.shape}".encode() + item.tobytes()
        return
    item = getattr(item, "py_func", item)  # compiled by numba
    if isinstance(item, (tuple, list)):
        for one in item:
            yield from _content(one, seen)
        yield b"]"
    elif isinstance(item, (set, frozenset)):
        yield from sorted(b"\0".join(_content(one, seen)) for one in item)
    elif isinstance(item, Mapping):
        for key, value in item.items():
            yield repr(key).encode()
            yield from _content(value, seen)
        yield b"}"
    elif isinstance(item, CodeType):
        yield item.co_code + repr((item.co_names, item.co_varnames)).encode()
        yield from _content(item.co_consts, seen)
    elif isinstance(item, ModuleType):
        yield item.__name__.encode()
    elif id(item) in seen:
        yield f"@{list(seen).index(id(item))}".encode()
    else:
        seen[id(item)] = item  # and so its id stays its own
        yield from _object(item, seen)


def _object(item: Any, seen: dict[int, Any]) -> Iterator[bytes]:
    """The content of a function, a class or an instance."""
    if isinstance(item, (FunctionType, type)) and _is_library(item):
        yield f"{item.__module__}.{item.__qualname__}".encode()
    elif isinstance(item, FunctionType):
        cells = [cell.cell_contents for cell in item.__closure__ or ()]
        used = sorted(set(_names(item.__code__)) & set(item.__globals__))
        values = {name: item.__globals__[name] for name in used}
        yield from _content(
            (item.__code__, item.__defaults__, item.__kwdefaults__, cells, values), seen
        )
    elif isinstance(item, MethodType):
        yield from _content((item.__func__, item.__self__), seen)
    elif isinstance(item, (staticmethod, classmethod)):
        yield from _content(item.__func__, seen)
    elif isinstance(item, property):
        yield from _content(item.fget, seen)
    elif isinstance(item, type):
        for base in item.__mro__[:-1]:
            own = {} if _is_library(base) else dict(vars(base))
            parts = {key: one for key, one in own.items() if key[:2] != "__" or callable(one)}
            yield from _content((base.__qualname__, parts), seen)
    else:
        yield from _content(type(item), seen)
        try:
            state = item.__reduce_ex__(2)
        except Exception:  # it holds something open, which no other part has
            state = id(item)
        if isinstance(state, tuple):
            state = [*state[1:3], *map(list, filter(None, state[3:5]))]
        yield from _content(state, seen)


def _names(code: CodeType) -> Iterator[str]:
    """Global names that code reads."""
    for one in dis.get_instructions(code):
        if one.opname in ("LOAD_GLOBAL", "LOAD_NAME"):
            yield one.argval
    for one in code.co_consts:
        if isinstance(one, CodeType):
            yield from _names(one)


def argument_count(function: Any, allowed: tuple[int, ...], label: str, needs: str) -> int:
    """The first of the ``allowed`` numbers of arguments with which a function can be called. Raises
    :class:`InputError` where there is none.
    """
    try:
        signature = inspect.signature(getattr(function, "py_func", function))
    except (TypeError, ValueError):  # compiled elsewhere
        return allowed[0]
    for count in allowed:
        try:
            signature.bind(*range(count))
        except TypeError:
            continue
        return count
    raise InputError(f"{label} takes {signature}; give a function of {needs}")


def compiled_number(
    function: Any, counts: tuple[int, ...], label: str, needs: str, tried: tuple[float, ...]
) -> tuple[Any, int]:
    """A function of numbers that gives a number, compiled, and how many it takes. Raises
    :class:`InputError` where its arguments, what it gives at ``tried`` or numba refuses it.
    """
    if not callable(function) or isinstance(function, type):
        raise InputError(f"{label} is no function; give a function of {needs}")
    count = argument_count(function, counts, label, needs)
    try:
        found = function(*tried[:count])
        number = np.asarray(found, dtype=float)
    except Exception as error:
        raise InputError(f"{label} fails ({type(error).__name__}: {error}); correct it") from error
    if number.shape != () or not np.isfinite(number):
        what = f"an array of shape {number.shape}" if number.shape else f"{found}"
        raise InputError(f"{label} gives {what}; it should give one finite number")
    try:
        compiled = for_numba(function)
        compiled(*tried[:count])
    except Exception as error:
        lines = [line.strip() for line in str(error).splitlines() if line.strip()]
        reason = next((line for line in lines if "Failed in" not in line), type(error).__name__)
        raise InputError(
            f"{label} cannot be compiled by numba ({reason[:120]}); write it with numbers, arrays of numpy and functions of math alone"
        ) from error
    return compiled, count


def for_numba(function: Any) -> Any:
    """A function compiled by numba when it is first called; of a method, ``self`` holds the numbers
    and arrays of its instance.
    """
    import numba

    if hasattr(function, "py_func"):
        return function
    if not isinstance(function, MethodType):
        return numba.njit(function)
    owner, values = function.__self__, {}
    for name in dir(owner):
        if not name.startswith("_"):
            value = getattr(owner, name)
            if isinstance(value, (Number, np.ndarray)) or (isinstance(value, tuple) and value):
                values[name] = value
    numbers: Any = namedtuple("numbers", values)(**values) if values else 0.0
    method = numba.njit(function.__func__)

    @numba.njit
    def bound(*arguments: Any) -> Any:
        return method(numbers, *arguments)

    return bound
