"""Finds words of the package's own dialect, where plain engineering English has a standard word.

    python scripts/dialect.py                 identifiers and file names with their lines, then
    counts; exit code 1 where there are any
    python scripts/dialect.py --text          docstrings, comments and strings, too
    python scripts/dialect.py --counts        the counts alone

An identifier is split at its underscores and capitals: ``kept_tables`` and ``KeptTables`` hold the
word *kept*.
"""

from __future__ import annotations

import argparse
import ast
import io
import re
import sys
import tokenize
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "src" / "valvetrain"
#: Names of other libraries.
FOREIGN = {"break_long_words"}

#: Words that no identifier holds -> what to write instead.
WORDS = {
    "told": "given, specified, reported", "tells": "reports", "kept": "saved, stored, cached", "asked": "requested, request",
    "sought": "target", "wanted": "requested, outputs", "beside": "next to", "anew": "again", "nobody": "untrusted", "crew": "executor",
    "usual": "DEFAULT_X, typical", "words": "names, labels, text, summary", "blow": "impact", "blows": "impacts", "stands": "is",
}  # fmt: skip
#: First words of constants.
CONSTANTS = {
    "MOST": "MAX_X",
    "FEWEST": "MIN_X",
    "LONGEST": "MAX_X",
    "LARGEST": "MAX_X",
    "USUAL": "DEFAULT_X",
}
#: Whole identifiers, underscores before them left out.
WHOLE = {
    "Ready": "PreparedRun", "make_ready": "prepare", "made_ready": "prepared", "Wanted": "Request", "Held": "CardDeviation",
    "Look": "SpeedSample", "Reach": "ValidSpeedRange", "Seen": "SensorResponse", "Sought": "Target", "Told": "Report", "Found": "Result",
    "Gaps": "PartialFailures", "Asked": "Request", "Kept": "SavedRun", "hand_out": "submit",
}  # fmt: skip
#: First words of identifiers that say nothing without their object.
BEGINNINGS = {"seen_by": "as_measured_by"}
#: Names of files.
FILES = {
    "ready",
    "tested",
    "seen",
    "given",
    "moved",
    "remembered",
    "usual",
    "rig_seen",
    "seen_page",
    "held_folder",
}
#: Words that no text has, except in double backticks, where they name options, keys and arguments.
SENTENCES = re.compile(
    r"\b(told|tells?|telling|anew|besides?|nobody|by (?:itself|themselves)|goes on|go on|the same bits|made ready|makes? ready|"
    r"hands? out|handed (?:out|over)|crew|sought|wanted|stands?|stood|standing|lies|lie|usual|asked|asks|kept|blows?(?! up)|vouch(?:es)?|"
    r"turns? of the cam|cam turns?|what is known of|room to coil bind|held against|so (?:many|few) \w+s)\b",
    re.IGNORECASE,
)
#: Parts of texts that are names: code in backticks, a file name, and a string that is one word, such as a key.
NAMES = re.compile(r"``[^`]*``|\S+\.md\b|^[\"'][a-z_]+[\"']$")
#: Tokens with text; from Python 3.12 the plain parts of an f-string are tokens of their own.
TEXTS = {tokenize.COMMENT, tokenize.STRING, getattr(tokenize, "FSTRING_MIDDLE", tokenize.STRING)}
PARTS = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")


def is_dialect(name: str) -> bool:
    """Whether an identifier is of the dialect."""
    bare = name.strip("_")
    if bare in FOREIGN:
        return False
    first, *_ = bare.split("_")
    if (
        bare in WHOLE
        or bare.startswith(tuple(BEGINNINGS))
        or (bare.isupper() and "_" in bare and first in CONSTANTS)
    ):
        return True
    return any(part.lower() in WORDS for part in PARTS.findall(bare))


def identifiers(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Line and identifier of every name, attribute, argument, keyword, function and class."""
    for node in ast.walk(tree):
        line = getattr(node, "lineno", 0)
        if isinstance(node, ast.Name):
            yield line, node.id
        elif isinstance(node, ast.Attribute):
            yield line, node.attr
        elif isinstance(node, ast.arg | ast.keyword) and node.arg:
            yield line, node.arg
        elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            yield line, node.name


def in_identifiers(folder: Path = PACKAGE) -> Iterator[tuple[str, int, str]]:
    """File, line and identifier (or file name) of the dialect, in all files of a folder."""
    for path in sorted(folder.rglob("*.py")):
        name = str(path.relative_to(folder))
        if path.stem in FILES or is_dialect(path.stem):
            yield name, 0, path.name
        for line, found in identifiers(ast.parse(path.read_text(encoding="utf-8"))):
            if is_dialect(found):
                yield name, line, found


def in_sentences(text: str) -> Iterator[tuple[int, str]]:
    """Line (from 0) and word of the dialect in a text; code in it is left out."""
    plain = NAMES.sub(lambda name: "\n" * name[0].count("\n"), text)
    for number, line in enumerate(plain.splitlines()):
        for match in SENTENCES.finditer(line):
            yield number, match[0].lower()


def in_text(folder: Path = PACKAGE) -> Iterator[tuple[str, int, str]]:
    """File, line and word of the dialect in comments, docstrings and strings."""
    for path in sorted(folder.rglob("*.py")):
        for token in tokenize.generate_tokens(
            io.StringIO(path.read_text(encoding="utf-8")).readline
        ):
            if token.type in TEXTS:
                for number, word in in_sentences(token.string):
                    yield str(path.relative_to(folder)), token.start[0] + number, word


def counts() -> Counter[str]:
    """How often each identifier of the dialect is used in the package."""
    return Counter(found for _, _, found in in_identifiers())


def main() -> int:
    """Prints what is found."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", nargs="?", type=Path, default=PACKAGE)
    parser.add_argument("--text", action="store_true", help="docstrings, comments and strings, too")
    parser.add_argument("--counts", action="store_true", help="counts alone")
    given = parser.parse_args()
    found = [("identifiers", list(in_identifiers(given.folder)))]
    found += [("text", list(in_text(given.folder)))] if given.text else []
    for title, rows in found:
        for file, line, name in [] if given.counts else rows:
            print(f"{file}:{line}: {name}")
        for name, number in Counter(name for _, _, name in rows).most_common():
            print(f"{number:6d}  {name}")
        print(f"{len(rows):6d}  in all ({title})")
    return int(any(rows for _, rows in found))


if __name__ == "__main__":
    sys.exit(main())
