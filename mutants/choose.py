"""The sample: which faults are seeded, and which tests are asked about each."""

from __future__ import annotations

import ast
import random
import re
import subprocess
from collections import defaultdict
from collections.abc import Iterable
from functools import cache
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

from mutants.copies import ROOT, compiles
from mutants.faults import Fault, faults, seeded

SOURCE = ROOT / "src" / "valvetrain"
#: Folders of the line of physics and of the tools, whose faults make a number wrong.
PHYSICS = (
    "cosserat",
    "springs",
    "contact",
    "cam",
    "mechanism",
    "system",
    "integrate",
    "quantities",
)
TOOLS = ("lift", "spring_card", "scan", "film", "rig", "compare_test", "explore")
#: Files of a tool that compute nothing: pages, charts, sentences, commands.
SHOWN = re.compile(
    r"(page|pages|command|charts?|summary|text|terminal|csv_files|files_page|__init__)\.py$"
)
#: Seconds of tests, as recorded, that are run at most about one fault.
SECONDS = 180.0


def by_line(files: Iterable[str]) -> dict[tuple[str, int], list[Fault]]:
    """File and line -> the faults that can be seeded there."""
    found: dict[tuple[str, int], list[Fault]] = defaultdict(list)
    for file in files:
        for fault in faults(SOURCE, file):
            found[file, fault.line].append(fault)
    return found


def _is_in(file: str, folders: tuple[str, ...]) -> bool:
    """Whether a file belongs to one of the folders; ``algorithms`` are physics and what tools compute."""
    folder = file.split("/")[0]
    if "algorithms" in folders and (
        folder in PHYSICS or (folder in TOOLS and not SHOWN.search(file))
    ):
        return True
    return not folders or folder in folders


def sample(count: int, seed: int, folders: Iterable[str] = ()) -> list[Fault]:
    """``count`` faults, each on another line: lines of all folders drawn alike, then one fault of
    the line.
    """
    rng, some = random.Random(seed), tuple(folders)
    every = (str(path.relative_to(SOURCE)) for path in sorted(SOURCE.rglob("*.py")))
    lines = by_line(file for file in every if _is_in(file, some))
    drawn = (rng.choice(lines[one]) for one in rng.sample(sorted(lines), len(lines)))
    return list(islice(filter(_is_python, drawn), count))


def changed(base: str, count: int, seed: int, folders: Iterable[str] = ()) -> list[Fault]:
    """One fault on each line of the package that differs from a commit, at most ``count``."""
    command = ["git", "diff", "-U0", "--no-color", base, "--", str(SOURCE)]
    rng, some, lines, file = random.Random(seed), tuple(folders), set(), ""
    for line in subprocess.run(
        command, cwd=ROOT, check=True, capture_output=True, text=True
    ).stdout.splitlines():
        if line.startswith("+++ "):
            file = line.removeprefix("+++ b/").removeprefix("src/valvetrain/")
        elif hunk := re.match(r"@@ -\S+ \+(\d+)(?:,(\d+))? @@", line):
            lines |= {(file, int(hunk[1]) + step) for step in range(int(hunk[2] or 1))}
    touched = {
        file for file, _ in lines if (SOURCE / file).suffix == ".py" and (SOURCE / file).exists()
    }
    sites = by_line(sorted(file for file in touched if _is_in(file, some)))
    drawn = (
        next(filter(_is_python, rng.sample(sites[one], len(sites[one]))), None)
        for one in sorted(lines & sites.keys())
    )
    found = [fault for fault in drawn if fault is not None]
    return sorted(
        rng.sample(found, min(count, len(found))), key=lambda fault: (fault.file, fault.line)
    )


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
    """Tests to run, the quickest first: those that enter the function; of compiled ones and of
    tables those whose file says the name too.

    Of a function that trails see, tests that do not enter it can notice nothing, but for what one
    test leaves for the next of its file.
    """
    known = [
        (node, one, file) for file, trail in trails.items() for node, one in trail["tests"].items()
    ]
    entered = {place for _, one, _ in known for place in one["places"]} | {
        place for trail in trails.values() for place in trail["import"]
    }
    here = places(fault, entered)
    inside = definitions()[fault.file].around(fault.line)
    exact = (
        bool(inside)
        and fault.line >= inside[0].body
        and here == {f"{fault.file}:{inside[0].whole}"}
    )
    names = {one.name for one in inside if one.name} or definitions()[fault.file].names_at(
        fault.line
    )
    first = {node for node, one, _ in known if here & set(one["places"])}
    near = {file for node, _, file in known if node in first} | {
        file for file, one in trails.items() if here & set(one["import"])
    }
    if not exact:
        near |= {
            file
            for file in trails
            if set(re.findall(r"\w+", (ROOT / file).read_text(encoding="utf-8"))) & names
        }
    chosen, spent = [], 0.0
    for node, one, file in sorted(
        known, key=lambda item: (_late(item[0]), item[0] not in first, item[1]["seconds"], item[0])
    ):
        if (node in first or file in near) and spent + one["seconds"] <= SECONDS:
            spent += one["seconds"]
            chosen.append(node)
    return chosen


def _late(node: str) -> bool:
    """Golden numbers and printed pages are run last: what only they notice is counted apart."""
    return node.startswith(("tests/net/", "tests/examples/"))
