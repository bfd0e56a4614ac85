"""The sample: which faults are seeded, and which tests are asked about each."""

from __future__ import annotations

import ast
import random
import re
from collections import defaultdict
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from mutants.copies import ROOT, compiles
from mutants.faults import Fault, faults, seeded

SOURCE = ROOT / "src" / "valvetrain"
#: Tests of pages that are written from tables of modules, and of what is left out of calls.
PAGES = ("_page.py", "_table.py", "_guide.py", "_words.py", "_left_out.py")
#: Seconds of tests, as recorded, that are asked at most about one fault: those that enter its
#: function, those whose file says its name,
#: the others of the files of the first, all; those of the first and second whose file is called
#: after the function or its module; golden
#: numbers and printed pages.
SECONDS = (90.0, 40.0, 10.0, 30.0, 60.0, 40.0)


def sample(count: int, seed: int, folders: Iterable[str] = ()) -> list[Fault]:
    """``count`` faults, each on another line: lines of all folders drawn alike, then one fault of
    the line.
    """
    rng = random.Random(seed)
    wanted = tuple(folders)
    by_line: dict[tuple[str, int], list[Fault]] = defaultdict(list)
    for path in sorted(SOURCE.rglob("*.py")):
        file = str(path.relative_to(SOURCE))
        if not wanted or file.split("/")[0] in wanted:
            for fault in faults(SOURCE, file):
                by_line[file, fault.line].append(fault)
    chosen: list[Fault] = []
    for place in rng.sample(sorted(by_line), len(by_line)):
        fault = rng.choice(by_line[place])
        if len(chosen) < count and _is_python(fault):
            chosen.append(fault)
    return chosen


def _is_python(fault: Fault) -> bool:
    try:
        ast.parse(seeded((SOURCE / fault.file).read_text(encoding="utf-8"), fault))
    except SyntaxError:
        return False
    return True


class Function(NamedTuple):
    """A function: first line with decorators, first of what it does, last line, name, name as
    Python qualifies it, names said inside.
    """

    first: int
    body: int
    last: int
    name: str
    whole: str
    words: frozenset[str]


class Definitions:
    """Functions of a file."""

    def __init__(self, path: Path) -> None:
        self.found: list[Function] = []
        self.tree = ast.parse(path.read_text(encoding="utf-8"))
        self._within(self.tree, "")

    def _within(self, node: ast.AST, prefix: str) -> None:
        for child in ast.iter_child_nodes(node):
            below = prefix
            if isinstance(child, (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda)):
                first = min(
                    [child.lineno, *(mark.lineno for mark in getattr(child, "decorator_list", []))]
                )
                name = getattr(child, "name", "")
                whole = f"{prefix}{name or '<lambda>'}"
                body = child.body[0].lineno if isinstance(child.body, list) else first
                self.found.append(
                    Function(first, body, child.end_lineno or first, name, whole, said(child))
                )
                below = f"{whole}.<locals>."
            elif isinstance(child, ast.ClassDef):
                below = f"{prefix}{child.name}."
            self._within(child, below)

    def around(self, line: int) -> list[Function]:
        """Functions about a line, the innermost first."""
        return sorted(
            (one for one in self.found if one.first <= line <= one.last),
            key=lambda one: one.last - one.first,
        )

    def names_at(self, line: int) -> set[str]:
        """What a statement outside functions gives its name to."""
        names = set()
        for node in ast.walk(self.tree):
            if isinstance(node, ast.stmt) and node.lineno <= line <= (node.end_lineno or 0):
                targets = (
                    node.targets
                    if isinstance(node, ast.Assign)
                    else [node.target]
                    if isinstance(node, ast.AnnAssign)
                    else []
                )
                names |= {target.id for target in targets if isinstance(target, ast.Name)}
                names |= {node.name} if isinstance(node, ast.ClassDef) else set()
        return names


def said(node: ast.AST) -> frozenset[str]:
    """Names and attributes that a tree mentions."""
    names = {one.id for one in ast.walk(node) if isinstance(one, ast.Name)}
    return frozenset(names | {one.attr for one in ast.walk(node) if isinstance(one, ast.Attribute)})


@cache
def definitions() -> dict[str, Definitions]:
    """File below the package -> its functions."""
    return {
        str(path.relative_to(SOURCE)): Definitions(path) for path in sorted(SOURCE.rglob("*.py"))
    }


def places(fault: Fault, entered: set[str]) -> set[str]:
    """Functions (as trails name them) whose entering tells that a test may notice the fault."""
    here = definitions()[fault.file]
    around = here.around(fault.line)
    for one in around:
        if f"{fault.file}:{one.whole}" in entered:
            return {f"{fault.file}:{one.whole}"}
    names = {one.name for one in around if one.name} if around else here.names_at(fault.line)
    found = set() if around else {place for place in entered if place.startswith(f"{fault.file}:")}
    return found | _callers(names, entered)


def _callers(names: set[str], entered: set[str]) -> set[str]:
    """Entered functions that mention a name, or that mention a never entered function which does
    (compiled kernels are not seen).
    """
    found: set[str] = set()
    done: set[str] = set()
    while rest := names - done:
        done |= rest
        for file, known in definitions().items():
            for one in known.found:
                if one.words & rest:
                    place = f"{file}:{one.whole}"
                    if place in entered:
                        found.add(place)
                    elif one.name and compiles(f"valvetrain/{file}"):
                        names = names | {one.name}
    return found


def tests_for(fault: Fault, trails: dict[str, dict[str, Any]]) -> list[str]:
    """Tests to ask, the quickest first: those that enter the function, then the others of their
    files; for a table of a module all.

    Of a function that trails see, tests that do not enter it can notice nothing, but for what one
    test leaves ready for the next of its
    file; of a compiled one and of what stands outside functions those are asked too whose file says
    its name.
    """
    known = [
        (node, one, file) for file, trail in trails.items() for node, one in trail["tests"].items()
    ]
    entered = {place for _, one, _ in known for place in one["places"]} | {
        place for trail in trails.values() for place in trail["import"]
    }
    wanted = places(fault, entered)
    inside = definitions()[fault.file].around(fault.line)
    head = bool(inside) and fault.line < inside[0].body  # what is left out of its calls
    exact = bool(inside) and not head and wanted == {f"{fault.file}:{inside[0].whole}"}
    names = {one.name for one in inside if one.name} or definitions()[fault.file].names_at(
        fault.line
    )
    first = {node for node, one, _ in known if wanted & set(one["places"])}
    near = {file for node, _, file in known if node in first} | {
        file for file, one in trails.items() if wanted & set(one["import"])
    }
    spoken = {
        file
        for file in trails
        if set(re.findall(r"\w+", (ROOT / file).read_text(encoding="utf-8"))) & names
    }
    spoken |= set() if inside and not head else {file for file in trails if file.endswith(PAGES)}
    ranks = {
        node: (0 if node in first else 1 if file in spoken else 2 if file in near else 3)
        for node, _, file in known
    }
    seconds = {node: one["seconds"] for node, one, _ in known}
    asked = (0, 2) if exact else (0, 1, 2) if inside else (0, 1, 2, 3)
    spent, chosen = [0.0] * len(SECONDS), []
    said_here = _words("_".join((Path(fault.file).stem, *names)))
    alike = {
        node: len(_words(Path(file).stem) & said_here) if ranks[node] < 2 else 0
        for node, _, file in known
    }
    for node in sorted(
        ranks, key=lambda node: (_late(node), -alike[node], ranks[node], seconds[node], node)
    ):
        purse = (
            len(SECONDS) - 1 if _late(node) else len(SECONDS) - 2 if alike[node] else ranks[node]
        )
        if (
            ranks[node] in asked
            and not (exact and ranks[node] and _late(node))
            and spent[purse] + seconds[node] <= SECONDS[purse]
        ):
            spent[purse] += seconds[node]
            chosen.append(node)
    return chosen


def _words(name: str) -> set[str]:
    """Words of a name, without the ends that make them plural, and without those that say little."""
    return {word.removesuffix("s") for word in name.lower().split("_") if len(word) > 3} - {
        "test",
        "kernel",
        "term",
        "value",
        "every",
    }


def _late(node: str) -> bool:
    """Golden numbers and printed pages are asked last: what only they notice is told apart."""
    return node.startswith(("tests/golden/", "tests/examples/"))
