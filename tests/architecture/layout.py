"""What the architecture tests share: the files of the package, read as syntax trees, never
imported.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "src" / "valvetrain"


@dataclass(frozen=True)
class Import:
    """One import statement: the module it names (dotted) and the line it stands on."""

    module: str
    line: int


@cache
def modules() -> dict[str, Path]:
    """Dotted name of every module of the package -> its file."""
    return {_dotted(path): path for path in sorted(PACKAGE.rglob("*.py"))}


@cache
def tree_of(path: Path) -> ast.Module:
    """Syntax tree of a file."""
    return ast.parse(path.read_text(encoding="utf-8"), filename=str(path))


def package_of(module: str) -> str:
    """Package of a dotted module: ``valvetrain.cam.closed_form`` -> ``cam``; empty for the package
    itself and for ``python -m valvetrain``.
    """
    parts = module.split(".")
    return parts[1] if len(parts) > 1 and parts[1] != "__main__" else ""


def imports_of(module: str, tree: ast.Module, is_package: bool) -> Iterator[Import]:
    """Every import of a module, inside functions and under TYPE_CHECKING too; relative ones made
    absolute.

    ``from valvetrain import cam`` counts as ``valvetrain.cam``, ``from valvetrain.cam import zero``
    as ``valvetrain.cam.closed_form``.
    """
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (Import(alias.name, node.lineno) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = _absolute(module, node, is_package)
            names = [f"{base}.{alias.name}" for alias in node.names]
            targets = dict.fromkeys(
                name if base == "valvetrain" or name in modules() else base for name in names
            )
            yield from (Import(target, node.lineno) for target in targets)


@cache
def levels() -> dict[str, int]:
    """Package -> level, read from the drawing in docs/architecture.md; a package may import lower
    levels only.
    """
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    drawing = re.search(
        r"^    arrays, errors, lazy, session\n(?:      <- .*\n)+", text, re.MULTILINE
    )
    assert drawing, "docs/architecture.md lost its drawing of the packages"
    found: dict[str, int] = {}
    for level, line in enumerate(drawing[0].splitlines()):
        for package in re.sub(r"<-|\(.*\)", "", line).split(","):
            found[package.strip()] = level
    return found


def _dotted(path: Path) -> str:
    parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _absolute(module: str, node: ast.ImportFrom, is_package: bool) -> str:
    if not node.level:
        return node.module or ""
    parts = module.split(".")
    base = parts[: len(parts) - node.level + (1 if is_package else 0)]
    return ".".join([*base, *([node.module] if node.module else [])])
