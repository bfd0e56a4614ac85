"""What a command holds and gives back when it ends, however it ends."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager

_HELD: list[ExitStack] = []


@contextmanager
def giving_back() -> Iterator[None]:
    """Give back at the end of the block what :func:`at_end` was told within it."""
    with ExitStack() as held:
        _HELD.append(held)
        try:
            yield
        finally:
            _HELD.remove(held)


def at_end(release: Callable[[], None]) -> None:
    """Call ``release`` when the command ends."""
    _HELD[-1].callback(release)
