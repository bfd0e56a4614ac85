"""Files stay short, public functions are typed and documented, and quantities carry their full
names.
"""

from __future__ import annotations

import ast
import tomllib
from collections.abc import Callable, Iterator
from functools import cache

import pytest

from architecture.layout import ROOT, modules, tree_of

#: Lines of the longest file that is let in: 400 are meant; a page with its charts, or a table of what every page says, is one idea.
MAX_FILE = {"src": 600, "tests": 750, "examples": 400, "benchmarks": 450}
#: One quantity, one name: say engine_speed or cam_speed, cam_angle or crank_angle, cam_lift or
#: valve_lift, natural_frequency ...
BARE_NAMES = {"speed", "speeds", "angle", "angles", "lift", "frequency", "frequencies", "rpm"}

Function = ast.FunctionDef | ast.AsyncFunctionDef


def public_functions(tree: ast.Module) -> Iterator[tuple[str, Function, bool]]:
    """(qualified name, function, is a method) of each function that other files may use."""
    for node in tree.body:
        if isinstance(node, Function) and not node.name.startswith("_"):
            yield node.name, node, False
        elif isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            for member in node.body:
                if isinstance(member, Function) and not member.name.startswith("_"):
                    yield f"{node.name}.{member.name}", member, True


def arguments_of(function: Function, is_method: bool) -> list[ast.arg]:
    """All arguments, without self or cls."""
    given = function.args
    every = [
        *given.posonlyargs,
        *given.args,
        *given.kwonlyargs,
        *filter(None, (given.vararg, given.kwarg)),
    ]
    static = any(
        isinstance(mark, ast.Name) and mark.id == "staticmethod" for mark in function.decorator_list
    )
    return every[1:] if is_method and not static else every


@cache
def protocol_methods() -> frozenset[str]:
    """Names of methods that a Protocol declares: it documents them once for all its classes."""
    names = set()
    for path in modules().values():
        for node in ast.walk(tree_of(path)):
            if isinstance(node, ast.ClassDef) and any(
                "Protocol" in ast.unparse(base) for base in node.bases
            ):
                names |= {member.name for member in node.body if isinstance(member, Function)}
    return frozenset(names)


def bare_names(tree: ast.Module) -> list[str]:
    """``place: name`` of each argument and each field of a class that bears a forbidden name."""
    found = []
    for name, function, is_method in public_functions(tree):
        found += [
            f"{name}({argument.arg})"
            for argument in arguments_of(function, is_method)
            if argument.arg in BARE_NAMES
        ]
    for node in tree.body:
        if isinstance(node, ast.ClassDef):
            fields = [member.target for member in node.body if isinstance(member, ast.AnnAssign)]
            found += [
                f"{node.name}.{field.id}"
                for field in fields
                if isinstance(field, ast.Name) and field.id in BARE_NAMES
            ]
    return found


def untyped(tree: ast.Module) -> list[str]:
    """Public functions that leave an argument or the result without a type; numba types compiled
    kernels itself.
    """
    found = []
    for name, function, is_method in public_functions(tree):
        if any("njit" in ast.unparse(mark) for mark in function.decorator_list):
            continue
        missing = [
            argument.arg
            for argument in arguments_of(function, is_method)
            if argument.annotation is None
        ]
        if missing or function.returns is None:
            found.append(f"{name}({', '.join(missing)})" + ("" if function.returns else " -> ?"))
    return found


def undocumented(tree: ast.Module) -> list[str]:
    """Public classes and functions without a docstring of their own or of the Protocol they fulfil."""
    classes = [
        node
        for node in tree.body
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_")
    ]
    found = [node.name for node in classes if not ast.get_docstring(node)]
    for name, function, is_method in public_functions(tree):
        if not ast.get_docstring(function) and not (
            is_method and function.name in protocol_methods()
        ):
            found.append(name)
    return found


def everywhere(rule: Callable[[ast.Module], list[str]]) -> set[str]:
    """Findings of a rule in the whole package, each with its module."""
    return {
        f"{module}: {finding}"
        for module, path in modules().items()
        for finding in rule(tree_of(path))
    }


def debts(rule: str) -> set[str]:
    """Findings that were there before the rule."""
    lines = (ROOT / "tests" / "architecture" / "debts.txt").read_text(encoding="utf-8").splitlines()
    return {line.removeprefix(f"{rule} ") for line in lines if line.startswith(f"{rule} ")}


def relaxed_modules() -> list[str]:
    """Modules of the package whose functions mypy lets be untyped, from pyproject.toml."""
    overrides = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"][
        "mypy"
    ]["overrides"]
    relaxed = [
        module
        for entry in overrides
        if entry.get("disallow_untyped_defs") is False
        for module in entry["module"]
    ]
    return [module for module in relaxed if module.startswith("valvetrain")]


def test_types_are_strict_but_for_compiled_kernels():
    """mypy is strict everywhere; in the modules that are let off, every function without types is
    one that numba compiles.
    """
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["mypy"]
    assert settings["strict"] is True
    assert not {key for key, value in settings.items() if value is False} - {
        "disallow_untyped_decorators"
    }
    found = []
    for module in relaxed_modules():
        assert module in modules(), f"{module} in pyproject.toml is no module"
        for node in ast.walk(tree_of(modules()[module])):
            if isinstance(node, Function) and node.returns is None:
                found += (
                    [f"{module}: {node.name}"]
                    if not is_compiled(node, tree_of(modules()[module]))
                    else []
                )
    assert not found


def is_compiled(function: Function, tree: ast.Module) -> bool:
    """Whether numba compiles a function: by its decorator, or because the module hands it to a
    compiler by name.
    """
    if any("njit" in ast.unparse(mark) for mark in function.decorator_list):
        return True
    calls = (
        node
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and "compiled" in ast.unparse(node.func)
    )
    return any(
        isinstance(given, ast.Name) and given.id == function.name
        for call in calls
        for given in call.args
    )


def test_files_stay_short():
    paths = [
        *modules().values(),
        *(ROOT / "tests").rglob("*.py"),
        *(ROOT / "examples").rglob("*.py"),
        *(ROOT / "benchmarks").rglob("*.py"),
    ]
    lengths = {
        str(path.relative_to(ROOT)): len(path.read_text(encoding="utf-8").splitlines())
        for path in paths
    }
    assert not {
        path: length for path, length in lengths.items() if length > MAX_FILE[path.split("/")[0]]
    }


@pytest.mark.parametrize(
    "rule", [bare_names, untyped, undocumented], ids=lambda rule: rule.__name__
)
def test_every_public_name_keeps_the_rule(rule):
    """Debts of the past stand in debts.txt; that list may only shrink."""
    found, owed = everywhere(rule), debts(rule.__name__)
    assert not sorted(found - owed), f"{rule.__doc__}\n" + "\n".join(sorted(found - owed))
    assert not sorted(owed - found), "paid, so remove from debts.txt:\n" + "\n".join(
        sorted(owed - found)
    )
