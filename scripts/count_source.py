"""Size of the package by room (folder of src/valvetrain): files, lines, tokens, statements
(without imports and docstrings), functions, classes.

Use: python scripts/count_source.py [FOLDER]      of another checkout's package folder, too
"""

from __future__ import annotations

import ast
import sys
import tokenize
from collections import Counter, defaultdict
from pathlib import Path

#: Tokens without meaning of their own: comments, ends of lines, indentation.
SILENT = {
    tokenize.COMMENT,
    tokenize.NL,
    tokenize.NEWLINE,
    tokenize.INDENT,
    tokenize.DEDENT,
    tokenize.ENCODING,
    tokenize.ENDMARKER,
}
HEAD = ("files", "lines", "tokens", "statements", "functions", "classes")


def _is_head(node: ast.stmt) -> bool:
    """Whether a statement is an import or a docstring."""
    return isinstance(node, ast.Import | ast.ImportFrom) or (
        isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
    )


def count(path: Path) -> Counter[str]:
    """Counts of one file."""
    text = path.read_text(encoding="utf-8")
    nodes = list(ast.walk(ast.parse(text)))
    with path.open("rb") as stream:
        tokens = sum(token.type not in SILENT for token in tokenize.tokenize(stream.readline))
    kinds: dict[str, type | tuple[type, ...]] = {
        "functions": (ast.FunctionDef, ast.AsyncFunctionDef),
        "classes": ast.ClassDef,
    }
    found = {name: sum(isinstance(node, kind) for node in nodes) for name, kind in kinds.items()}
    found["statements"] = sum(isinstance(node, ast.stmt) and not _is_head(node) for node in nodes)
    return Counter(found | {"files": 1, "lines": len(text.splitlines()), "tokens": tokens})


def main(folder: Path) -> None:
    """Prints a row per room and their sum."""
    rooms: dict[str, Counter[str]] = defaultdict(Counter)
    for path in sorted(folder.rglob("*.py")):
        below = path.relative_to(folder)
        rooms[below.parts[0] if len(below.parts) > 1 else "(top)"] += count(path)
    print(f"{'room':16s}" + "".join(f"{name:>12s}" for name in HEAD))
    for name, row in [
        *sorted(rooms.items(), key=lambda item: -item[1]["tokens"]),
        ("sum", sum(rooms.values(), Counter[str]())),
    ]:
        print(f"{name:16s}" + "".join(f"{row[one]:12d}" for one in HEAD))


if __name__ == "__main__":
    main(
        Path(sys.argv[1])
        if len(sys.argv) > 1
        else Path(__file__).resolve().parents[1] / "src" / "valvetrain"
    )
