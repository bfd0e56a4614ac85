"""Digests that tell whether something kept is still true: of functions, of test files with their
helpers, of the whole tree.
"""

from __future__ import annotations

import ast
import hashlib
import re
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

from mutants.copies import ROOT, files

SOURCE = ROOT / "src" / "valvetrain"
MODULE = "<module>"


def digest(parts: Iterable[bytes]) -> str:
    """Short digest of some texts in their order."""
    found = hashlib.sha256()
    for part in parts:
        found.update(hashlib.sha256(part).digest())
    return found.hexdigest()[:16]


@cache
def of_tree() -> str:
    """Of every file that a sample and its verdicts depend on: sources, tests, examples and this
    tool, but for its list of judged faults.
    """
    wanted = [
        name
        for name in sorted(files())
        if name.startswith(("src/", "tests/", "examples/", "mutants/")) and "judged" not in name
    ]
    return digest(part for name in wanted for part in (name.encode(), (ROOT / name).read_bytes()))


@cache
def of_data(folder: str) -> str:
    """Of what the package and the tests of a folder read beside Python: cases, templates, tables,
    golden numbers.
    """
    wanted = [
        name
        for name in sorted(files())
        if name.startswith(("src/", "examples/", f"{folder}/")) and not name.endswith(".py")
    ]
    return digest(part for name in wanted for part in (name.encode(), (ROOT / name).read_bytes()))


@cache
def of_test(name: str) -> str:
    """Of a test file, the modules of the tests that it imports, straight or through one another,
    and the data of its folder.
    """
    seen: dict[str, bytes] = {}
    rest = [ROOT / name, ROOT / "tests" / "conftest.py"]
    while rest:
        path = rest.pop()
        if str(path) not in seen:
            seen[str(path)] = path.read_bytes()
            said = set(
                re.findall(
                    r"^\s*(?:from|import) (\w+)", path.read_text(encoding="utf-8"), re.MULTILINE
                )
            )
            rest += [
                near / f"{word}.py"
                for word in said
                for near in (path.parent, ROOT / "tests")
                if (near / f"{word}.py").exists()
            ]
    return digest(
        [*(seen[place] for place in sorted(seen)), of_data(str(Path(name).parent)).encode()]
    )


def of_places(places: Iterable[str]) -> str:
    """Of the code of all functions of a trail (``file:function``), each with the functions inside
    it.
    """
    whole = sorted({_outermost(place) for place in places})
    return digest(
        part.encode()
        for place in whole
        for part in (place, _of_file(place.split(":", 1)[0]).get(place.split(":", 1)[1], ""))
    )


def _outermost(place: str) -> str:
    file, name = place.split(":", 1)
    name = name.split(".<locals>", 1)[0]
    return f"{file}:{MODULE if '<' in name else name}"


@cache
def _of_file(file: str) -> dict[str, str]:
    """Function or class of a file, as Python qualifies it -> digest of its code; ``<module>`` is
    what stands outside functions.
    """
    path = SOURCE / file
    found: dict[str, list[bytes]] = {}
    if path.exists():
        _collect(ast.parse(path.read_text(encoding="utf-8")), "", found)
    return {name: digest(texts) for name, texts in found.items()}


def _collect(node: ast.AST, prefix: str, found: dict[str, list[bytes]]) -> None:
    for child in ast.iter_child_nodes(node):
        name = f"{prefix}{getattr(child, 'name', '')}"
        if isinstance(child, (ast.FunctionDef, ast.AsyncFunctionDef)):
            found.setdefault(name, []).append(ast.dump(child).encode())
        elif isinstance(child, ast.ClassDef):
            outside = [
                one
                for one in child.body
                if not isinstance(one, (ast.FunctionDef, ast.AsyncFunctionDef))
            ]
            found.setdefault(name, []).extend(ast.dump(one).encode() for one in outside)
            _collect(child, f"{name}.", found)
        elif isinstance(node, ast.Module):
            found.setdefault(MODULE, []).append(ast.dump(child).encode())


def of_trail(name: str, trail: Mapping[str, Any]) -> list[str]:
    """What a trail of a test file depends on, as it is now: the test with its helpers, and every
    function that it entered.
    """
    return [
        of_test(name),
        of_places(
            [
                *trail["import"],
                *(place for one in trail["tests"].values() for place in one["places"]),
            ]
        ),
    ]
