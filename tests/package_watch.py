"""Functions and classes of the package that tests replace are put back: one left behind fails tests
of other files, by their order.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from inspect import isfunction
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent


def callables() -> dict[tuple[str, str], object]:
    """Functions, classes and their methods, of the modules of the package that are imported by now,
    by module and name.
    """
    found: dict[tuple[str, str], object] = {}
    for name, module in list(sys.modules.items()):
        if name.partition(".")[0] == "valvetrain" and module is not None:
            for attribute, value in list(vars(module).items()):
                if callable(value):
                    found[name, attribute] = value
                if isinstance(value, type) and value.__module__ == name:
                    found |= {
                        (name, f"{attribute}.{method}"): one
                        for method, one in list(vars(value).items())
                        if isfunction(one)
                    }
    return found


def replaced(before: dict[tuple[str, str], object]) -> list[str]:
    """What now is another, told as ``module.name``; of modules imported since, what a test put
    there.
    """
    now = callables()
    changed = {key for key, value in before.items() if now.get(key) is not value}
    placed = {key for key in now.keys() - before.keys() if from_tests(now[key])}
    return sorted(f"{module}.{name}" for module, name in changed | placed)


def from_tests(value: object) -> bool:
    """Whether a function is written in the tests or the faults; watches that stay for the whole
    session are not meant.
    """
    value = getattr(value, "func", value)  # of a partial
    if type(value).__module__ == "unittest.mock":
        return True
    folder = Path(getattr(getattr(value, "__code__", None), "co_filename", "/")).parent
    return HERE in folder.parents or folder == HERE.parent / "faults"


@pytest.fixture(autouse=True, scope="module")
def package_stays_whole() -> Iterator[None]:
    """An error after the last test of a file that leaves a function, class or method of the package
    replaced.
    """
    before = callables()
    yield
    left = replaced(before)
    assert not left, f"{left}: left replaced by the tests of this file"
