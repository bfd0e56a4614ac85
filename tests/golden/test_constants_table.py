"""Golden: every constant of every module, every value of an argument and of a field where it is
left out; ``constants/`` holds them.

``python tests/golden/test_constants_table.py`` writes the files anew; read the difference before it
is kept. Limits, tolerances, steps and
tables steer what nobody asks for by name: none of them may move unsaid.
"""

from __future__ import annotations

import ast
import hashlib
import inspect
import re
import sys
from collections.abc import Iterator, Mapping
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any, Literal, get_origin

import pytest

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[1]))

import valvetrain
from made_watch import are_same

SOURCE = Path(valvetrain.__file__).parent
CONSTANTS = Path(__file__).parent / "constants"
#: Longest line; what is longer ends in a digest of the whole.
MOST = 220
#: Names of modules whose values are those of the machine or of this process, or hang together by
#: the order of imports.
LEFT = re.compile(r"\.(_KEPT|_AHEAD|CASES|app|_turn|_count|_lock)$")


def said(value: Any, depth: int = 0) -> str:
    """A value in words that are the same in every process."""
    if get_origin(value) is Annotated:
        return said([given(one) for one in value.__metadata__])
    if get_origin(value) not in (None, Literal):
        return "a type"
    if isinstance(value, Mapping):
        return (
            "{"
            + ", ".join(f"{said(key)}: {said(one, depth + 1)}" for key, one in value.items())
            + "}"
        )
    if isinstance(value, set | frozenset):
        return "{" + ", ".join(sorted(map(said, value))) + "}"
    if isinstance(value, list | tuple) and depth < 8:
        return "(" + ", ".join(said(one, depth + 1) for one in value) + ")"
    if isinstance(value, re.Pattern):
        return f"/{value.pattern}/{value.flags}"
    if inspect.isroutine(value) or inspect.isclass(value) or inspect.ismodule(value):
        return getattr(value, "__qualname__", getattr(value, "__name__", type(value).__name__))
    if hasattr(value, "py_func"):
        return f"compiled {value.py_func.__name__}"
    if hasattr(value, "tolist"):
        return said(value.tolist(), depth + 1)
    if hasattr(value, "__dataclass_fields__") and depth < 8:
        parts = (
            f"{name}={said(getattr(value, name, None), depth + 1)}"
            for name in value.__dataclass_fields__
        )
        return f"{type(value).__name__}({', '.join(parts)})"
    text = repr(value).replace(str(SOURCE), "PACKAGE").replace(sys.executable, "PYTHON")
    return re.sub(r"0x[0-9a-f]{6,}", "0x", text)


def given(option: Any) -> Any:
    """What an option of the command line is told of itself."""
    if type(option).__module__ != "typer.models":
        return option
    return {
        key: value
        for key, value in vars(option).items()
        if not (value is None or value is False or value == () or value is True)
    }


def line(name: str, value: Any) -> str:
    text = " ".join(f"{name} = {said(value)}".split())
    return (
        text
        if len(text) <= MOST
        else f"{text[: MOST - 12]}... {hashlib.sha256(text.encode()).hexdigest()[:8]}"
    )


def begins_empty(value: ast.expr | None) -> bool:
    """Whether a value is filled while the package is used: an empty list or table."""
    if isinstance(value, ast.Call):
        made = value.func.value if isinstance(value.func, ast.Subscript) else value.func
        return isinstance(made, ast.Name) and made.id in (
            "list",
            "dict",
            "set",
            "OrderedDict",
            "deque",
            "WeakKeyDictionary",
        )
    return isinstance(value, ast.Dict | ast.List) and not (
        value.keys if isinstance(value, ast.Dict) else value.elts
    )


def assigned(tree: ast.Module) -> Iterator[str]:
    """Names that a module assigns outside functions and classes, in order, each once."""
    found: dict[str, None] = {}
    for node in tree.body:
        if isinstance(node, ast.Assign | ast.AnnAssign) and begins_empty(node.value):
            continue
        targets = (
            node.targets
            if isinstance(node, ast.Assign)
            else [node.target]
            if isinstance(node, ast.AnnAssign) and node.value
            else []
        )
        for target in targets:
            found |= dict.fromkeys(one.id for one in ast.walk(target) if isinstance(one, ast.Name))
    return iter(found)


def left_out(name: str, function: Any) -> Iterator[str]:
    """Values of arguments that are left out."""
    try:
        arguments = inspect.signature(getattr(function, "py_func", function)).parameters.values()
    except (TypeError, ValueError):
        return
    given = [
        (one.name, one.default) for one in arguments if one.default is not inspect.Parameter.empty
    ]
    yield from (line(f"{name}({argument})", value) for argument, value in given)


def constants(path: Path) -> list[str]:
    """All of one module, a line each."""
    place = ".".join(path.relative_to(SOURCE).with_suffix("").parts).removesuffix(".__init__")
    module = import_module(f"valvetrain.{place}" if place != "__init__" else "valvetrain")
    tree = ast.parse(path.read_text(encoding="utf-8"))
    found = [
        line(name, getattr(module, name))
        for name in assigned(tree)
        if hasattr(module, name) and not LEFT.search(f".{name}")
    ]
    for node in tree.body:
        one = getattr(module, getattr(node, "name", ""), None)
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            found += left_out(node.name, one)
        elif isinstance(node, ast.ClassDef):
            fields = getattr(one, "model_fields", None)
            if fields is not None:
                told = (
                    (name, (field.default, field.default_factory, field.metadata))
                    for name, field in fields.items()
                )
                found += [line(f"{node.name}.{name}", value) for name, value in told]
            else:
                found += left_out(node.name, one)
            bare = [
                name for name in assigned(ast.Module(node.body, [])) if not name.startswith("__")
            ]
            known = getattr(one, "__dataclass_fields__", {})
            found += [
                line(f"{node.name}.{name}", vars(one)[name])
                for name in bare
                if fields is None and name in vars(one).keys() - known
            ]
            for inside in node.body:
                if isinstance(inside, ast.FunctionDef | ast.AsyncFunctionDef):
                    method = inspect.unwrap(
                        getattr(vars(one).get(inside.name), "__func__", vars(one).get(inside.name))
                    )
                    found += (
                        left_out(f"{node.name}.{inside.name}", method)
                        if inspect.isfunction(method)
                        else ()
                    )
    return [f"  {one}" for one in found if " at 0x" not in one and not one.endswith("= a type")]


@cache
def told(folder: str) -> str:
    """All modules of a folder of the package; of the package itself for a dot."""
    place = SOURCE / folder
    paths = sorted(place.glob("*.py") if folder == "." else place.rglob("*.py"))
    blocks = [(path, constants(path)) for path in paths if path.name != "__main__.py"]
    return "".join(
        "\n".join([str(path.relative_to(SOURCE)), *lines]) + "\n" for path, lines in blocks if lines
    )


FOLDERS = [".", *sorted(one.name for one in SOURCE.iterdir() if any(one.glob("*.py")))]


@pytest.mark.skipif(not are_same(), reason="kept with other versions of Python or of libraries")
@pytest.mark.parametrize("folder", FOLDERS)
def test_no_constant_moved(folder):
    assert told(folder) == (CONSTANTS / f"{folder.replace('.', 'package')}.txt").read_text(
        encoding="utf-8"
    )


if __name__ == "__main__":
    for folder in FOLDERS:
        (CONSTANTS / f"{folder.replace('.', 'package')}.txt").write_text(
            told(folder), encoding="utf-8"
        )
