"""Values of a result that are computed when they are first read."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator, Mapping
from threading import RLock
from typing import Any, Generic, TypeVar, overload

T = TypeVar("T")
Other = TypeVar("Other")


class Later(Generic[T]):
    """``compute(*given)``, once, when ``value`` is first read; sent to another process unread, it
    is computed there.

    >>> total = Later(sum, [1, 2])
    >>> total.value, total.then(str).value
    (3, '3')
    """

    def __init__(self, compute: Callable[..., T], *given: Any) -> None:
        self._compute, self._given, self._lock = compute, given, RLock()

    @property
    def value(self) -> T:
        """The value; what it was made of is released."""
        with self._lock:
            if "_value" not in self.__dict__:
                self._value = self._compute(*self._given)
                del self._compute, self._given
            return self._value

    def then(self, function: Callable[[T], Other]) -> Later[Other]:
        """What ``function`` makes of the value, later as well."""
        return Later(_applied, function, self)

    def __getstate__(self) -> dict[str, Any]:
        with self._lock:
            return {name: one for name, one in self.__dict__.items() if name != "_lock"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state, _lock=RLock())


def _applied(function: Callable[[Any], T], before: Later[Any]) -> T:
    return function(before.value)


class LaterField(Generic[T]):
    """Field of a frozen dataclass that takes a value or a :class:`Later` and gives the value;
    without either that of ``default()``.
    """

    def __init__(self, default: Callable[[], T]) -> None:
        self.default, self.make = Later(default), default

    def __set_name__(self, owner: type, name: str) -> None:
        self.slot = f"_{name}"

    @overload
    def __get__(self, owner: None, kind: type) -> Later[T]: ...

    @overload
    def __get__(self, owner: Any, kind: type) -> T: ...

    def __get__(self, owner: Any, kind: type) -> Later[T] | T:
        if owner is None:
            return self.default
        found = owner.__dict__[self.slot]
        if isinstance(found, Later):
            found = owner.__dict__[self.slot] = found.value
        return found  # type: ignore[no-any-return]

    def __set__(self, owner: Any, value: T | Later[T]) -> None:
        owner.__dict__[self.slot] = self.make() if value is self.default else value


class LaterMapping(Mapping[str, T]):
    """Values by name: those ``known`` at once, then those of ``between`` and of ``every``, each
    computed when a name that the one before lacks is read.

    >>> numbers = LaterMapping({"peak": 2.0}, Later(dict, {"peak": 2.0, "preload": 1.0}))
    >>> numbers["peak"], numbers["preload"], list(numbers)
    (2.0, 1.0, ['peak', 'preload'])
    """

    def __init__(
        self,
        known: Mapping[str, T],
        every: Later[Mapping[str, T]],
        between: Later[Mapping[str, T]] | None = None,
    ) -> None:
        self.known, self.every, self.between = dict(known), every, between

    def __getitem__(self, name: str) -> T:
        return self._of(name)[name]

    def __contains__(self, name: object) -> bool:
        return name in self._of(name)

    def _of(self, name: object) -> Mapping[str, T]:
        if name in self.known:
            return self.known
        if self.between is not None and name in self.between.value:
            return self.between.value
        return self.every.value

    def __iter__(self) -> Iterator[str]:
        return iter(self.every.value)

    def __len__(self) -> int:
        return len(self.every.value)

    def __or__(self, other: Mapping[str, T]) -> dict[str, T]:
        return {**self, **other}

    def __ror__(self, other: Mapping[str, T]) -> dict[str, T]:
        return {**other, **self}

    def __repr__(self) -> str:
        return repr(dict(self))


def replaced(result: T, **changes: Any) -> T:
    """A frozen result with other fields, as :func:`dataclasses.replace`; what is computed later stays
    so.
    """
    made = copy.copy(result)
    for name, value in changes.items():
        object.__setattr__(made, name, value)
    return made


def is_computed(result: object, name: str) -> bool:
    """Whether the field ``name`` of ``result`` has its value, so that reading it costs nothing."""
    found = vars(result).get(f"_{name}")
    return not isinstance(found, Later) or "_value" in vars(found)
