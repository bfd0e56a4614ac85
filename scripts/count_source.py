"""Size of the package by folder: files, lines, tokens, statements (without imports and docstrings),
functions and classes; then bytes of scripts, styles and templates, lines of tests and words of pages.

Use: python scripts/count_source.py [CHECKOUT]      the table, of another checkout too
     python scripts/count_source.py --check         fails where a figure of budget.toml is exceeded
     python scripts/count_source.py --lower         lowers the figures of budget.toml to what is reached
     python scripts/count_source.py --entered run gu2021-beehive     functions that a command enters
"""

from __future__ import annotations

import ast
import contextlib
import io
import os
import re
import sys
import threading
import tokenize
import tomllib
from collections import Counter, defaultdict
from collections.abc import Iterable
from inspect import CO_OPTIMIZED
from pathlib import Path
from types import CodeType, FrameType

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = "src/valvetrain"
#: Tokens without meaning of their own: comments, ends of lines, indentation.
SILENT = {"COMMENT", "NL", "NEWLINE", "INDENT", "DEDENT", "ENCODING", "ENDMARKER"}
#: File of numba that a kernel comes through that is compiled, or whose machine code is read.
COMPILER = os.path.join("numba", "core", "dispatcher.py")
HEAD = ("files", "lines", "tokens", "statements", "functions", "classes")
#: Endings of scripts, styles and templates of pages.
PAGE_ENDINGS = {".js", ".css", ".html", ".j2"}
#: Folders of a checkout that hold its pages of text; those at its root count too.
TEXT_FOLDERS = ("docs", "examples", "packaging")


def meaningful(kinds: Iterable[str]) -> int:
    """Number of tokens with a meaning, by the names of their kinds. An f-string is one token: up to
    Python 3.11 the tokenizer says so, later ones split it.
    """
    count = depth = 0
    for kind in kinds:
        count += depth == 0 and kind not in SILENT
        depth += (kind == "FSTRING_START") - (kind == "FSTRING_END")
    return count


def tokens_of(path: Path) -> int:
    """Number of tokens with a meaning in a file."""
    with path.open("rb") as stream:
        tokens = tokenize.tokenize(stream.readline)
        return meaningful(tokenize.tok_name[token.type] for token in tokens)


def _is_head(node: ast.stmt) -> bool:
    """Whether a statement is an import or a docstring."""
    return isinstance(node, ast.Import | ast.ImportFrom) or (
        isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
    )


def count(path: Path) -> Counter[str]:
    """Counts of one file."""
    text = path.read_text(encoding="utf-8")
    nodes = list(ast.walk(ast.parse(text)))
    functions = (ast.FunctionDef, ast.AsyncFunctionDef)
    return Counter(
        files=1,
        lines=len(text.splitlines()),
        tokens=tokens_of(path),
        statements=sum(isinstance(node, ast.stmt) and not _is_head(node) for node in nodes),
        functions=sum(isinstance(node, functions) for node in nodes),
        classes=sum(isinstance(node, ast.ClassDef) for node in nodes),
    )


def by_folder(root: Path) -> dict[str, list[Path]]:
    """Python files of the package of a checkout by folder; those outside of one under ``top``."""
    folders: dict[str, list[Path]] = defaultdict(list)
    for path in sorted((root / PACKAGE).rglob("*.py")):
        below = path.relative_to(root / PACKAGE).parts
        folders[below[0] if len(below) > 1 else "top"].append(path)
    return folders


def page_bytes(root: Path) -> int:
    """Bytes of scripts, styles and templates in the package."""
    paths = (root / PACKAGE).rglob("*")
    return sum(path.stat().st_size for path in paths if path.suffix in PAGE_ENDINGS)


def show(root: Path) -> None:
    """Prints a row per folder, their sum, and what is counted beside Python."""
    folders = {
        name: sum(map(count, paths), Counter[str]()) for name, paths in by_folder(root).items()
    }
    rows = sorted(folders.items(), key=lambda item: -item[1]["tokens"])
    print(f"{'folder':16s}" + "".join(f"{name:>12s}" for name in HEAD))
    for name, row in [*rows, ("sum", sum(folders.values(), Counter[str]()))]:
        print(f"{name:16s}" + "".join(f"{row[column]:12d}" for column in HEAD))
    tests = [path.read_text(encoding="utf-8") for path in (root / "tests").rglob("*.py")]
    pages = [*root.glob("*.md")]
    pages += [path for folder in TEXT_FOLDERS for path in (root / folder).rglob("*.md")]
    words = sum(len(path.read_text(encoding="utf-8").split()) for path in pages)
    print(f"{page_bytes(root):12d} bytes of scripts, styles and templates in the package")
    print(f"{sum(len(text.splitlines()) for text in tests):12d} lines of tests")
    print(f"{words:12d} words in Markdown pages")


def figures(root: Path) -> dict[str, int]:
    """What ``budget.toml`` bounds, as reached: tokens of each folder, and ``page_bytes``."""
    tokens = {name: sum(map(tokens_of, paths)) for name, paths in by_folder(root).items()}
    return dict(sorted(tokens.items())) | {"page_bytes": page_bytes(root)}


def complaints(bounds: dict[str, int], total: int, reached: dict[str, int]) -> list[str]:
    """A sentence for each figure of the budget that is exceeded or missing."""
    sentences = []
    for name, value in reached.items():
        what = "bytes of scripts, styles and templates" if name == "page_bytes" else "tokens"
        if name not in bounds:
            sentences.append(
                f"{name} has {value} {what} and no figure in budget.toml: give it one, and lower another."
            )
        elif value > bounds[name]:
            sentences.append(
                f"{name} has {value} {what}, budget.toml allows {bounds[name]}: shorten it, or lower another "
                "figure by as much as this one rises."
            )
    tokens = sum(bounds.values()) - bounds.get("page_bytes", 0)
    if tokens > total:
        sentences.append(
            f"The figures of the folders in budget.toml add up to {tokens}, its sum is {total}: lower one of them."
        )
    return sentences


def budget(lower: bool) -> int:
    """Checks the budget of this checkout, or lowers its figures to the next hundred above what is
    reached; 1 where a figure is exceeded.
    """
    path = ROOT / "budget.toml"
    text = path.read_text(encoding="utf-8")
    table, reached = tomllib.loads(text), figures(ROOT)
    if lower:
        tight = {
            name: min(bound, -(-reached.get(name, 0) // 100) * 100)
            for name, bound in table["figures"].items()
        }
        total = sum(tight.values()) - tight["page_bytes"]
        rows = "".join(f"{name} = {bound}\n" for name, bound in tight.items() if bound)
        text = re.sub(r"^sum = .*$", f"sum = {min(table['sum'], total)}", text, flags=re.MULTILINE)
        path.write_text(text[: text.index("[figures]")] + "[figures]\n" + rows, encoding="utf-8")
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    sentences = complaints(table["figures"], table["sum"], reached)
    print("\n".join(sentences or ["Every folder is within budget.toml."]))
    return int(bool(sentences))


def _compiles(frame: FrameType | None) -> bool:
    """Whether a frame belongs to the compilation of a kernel, or to reading its stored machine code."""
    while frame is not None:
        if frame.f_code.co_filename.endswith(COMPILER):
            return True
        frame = frame.f_back
    return False


def entered(arguments: list[str]) -> set[CodeType]:
    """Code of every function of the package that ``valvetrain ARGUMENTS`` enters in any thread of
    this process, imports included; what only the compilation of kernels enters is left out.
    """
    codes: set[CodeType] = set()
    folder = f"{ROOT / PACKAGE}{os.sep}"

    def note(frame: FrameType, event: str, _: object) -> None:
        code = frame.f_code
        # modules and class bodies are not optimised code; comprehensions and lambdas have names in
        # angle brackets
        if (
            event == "call"
            and code.co_flags & CO_OPTIMIZED
            and code.co_name[0] != "<"
            and code.co_filename.startswith(folder)
            and code not in codes
            and not _compiles(frame.f_back)
        ):
            codes.add(code)

    sys.path.insert(0, str(ROOT / "src"))
    sys.argv = ["valvetrain", *arguments]
    threading.setprofile(note)
    sys.setprofile(note)
    try:
        from valvetrain.cli.main import main as command

        with contextlib.redirect_stdout(io.StringIO()):
            command()
    except SystemExit as end:
        if end.code:
            raise
    finally:
        sys.setprofile(None)
        threading.setprofile(None)
    return codes


def show_entered(arguments: list[str]) -> None:
    """Prints how many functions of each folder a command enters."""
    codes = entered(arguments)
    folders = Counter(
        Path(code.co_filename).relative_to(ROOT / PACKAGE).parts[0].removesuffix(".py")
        for code in codes
    )
    for name, number in folders.most_common():
        print(f"{number:6d}  {name}")
    print(f"{len(codes):6d}  functions in {len({code.co_filename for code in codes})} files")


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["--check"]:
            sys.exit(budget(lower=False))
        case ["--lower"]:
            sys.exit(budget(lower=True))
        case ["--entered", *command]:
            show_entered(command)
        case [checkout]:
            show(Path(checkout).resolve())
        case _:
            show(ROOT)
