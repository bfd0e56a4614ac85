"""Runs the tests that a change of one room (folder of the package) can break, in about a minute:
``make test-fast ROOM=springs``.

    python scripts/test_fast.py springs                  the tests nearest to the room, up to a
    minute of processor time per core
    python scripts/test_fast.py springs --seconds 30 --list     what would run and what would not,
    nothing is run
    python scripts/test_fast.py --changed main           of the modules changed against a commit, in
    place of a room
    python scripts/test_fast.py springs -- -x -n 0       options of pytest after two dashes

Which tests: the import graph of the package, the tests and their helper modules, read from their
syntax trees. A test file that
imports a module of the room, or takes a public name whose home is there, has distance 0; one that
imports a module which imports the
room has distance 1, and so on. Tests of contracts have distance 1 at most. The nearest files run
first, of equal ones those that use
little besides, then the quickest.
Tests marked slow, long, chromium or calculix are left out, so are single tests known to take longer
than MAX_TEST_SECONDS. Seconds are
those of the last runs (``build/tests/*.xml``, written by this script and by ``make test``).
"""

from __future__ import annotations

import argparse
import ast
import os
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SOURCE, TESTS = ROOT / "src" / "valvetrain", ROOT / "tests"
#: Folders, besides src, from which a test imports its helpers.
HELPERS = (TESTS, ROOT / "scripts", ROOT)
#: Tests that say nothing of one room, or whose subject is the text of the repository.
NO_ROOM = ("tests/architecture/", "tests/example_package/")
RECORDS = ROOT / "build" / "tests"
MARKS = "not slow and not long and not chromium and not calculix"
#: Single tests longer than this (s) are left out.
MAX_TEST_SECONDS = 6.0
#: A test that was never timed counts as much (s), a file a little more for its imports.
UNKNOWN_TEST, FILE_START = 0.4, 0.5
FAR = 99


@dataclass(frozen=True)
class Chosen:
    """A test file: steps of imports to the change, share of it in what the file uses, seconds, and
    its single tests that are too long.
    """

    file: str
    distance: int
    share: float
    seconds: float
    too_long: tuple[str, ...]


@cache
def package_modules() -> dict[str, Path]:
    """Dotted name -> file of every module of the package."""
    found = {}
    for path in SOURCE.rglob("*.py"):
        parts = path.relative_to(SOURCE.parent).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


@cache
def public_homes() -> dict[str, str]:
    """Public name of the package and its folders -> module that holds it."""
    found: dict[str, str] = {}
    for stub in SOURCE.rglob("__init__.pyi"):
        for line in stub.read_text(encoding="utf-8").splitlines():
            if line.startswith("from ") and not line.startswith("from valvetrain import"):
                _, module, _, name, *_ = line.split()
                found[name] = module
    return found


@cache
def names_in(path: Path) -> tuple[frozenset[str], frozenset[str]]:
    """Dotted names that a file imports, anywhere in it, and attributes that it takes of the package
    (``vt.simulate``).
    """
    tree = ast.parse(path.read_text(encoding="utf-8"))
    imported: set[str] = set()
    package: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            imported |= {alias.name for alias in node.names}
            package |= {
                alias.asname or "valvetrain" for alias in node.names if alias.name == "valvetrain"
            }
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            imported |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    taken = {
        one.attr
        for one in ast.walk(tree)
        if isinstance(one, ast.Attribute) and ast.unparse(one.value).split(".")[0] in package
    }
    taken |= {name.rpartition(".")[2] for name in imported if name.startswith("valvetrain.")}
    return frozenset(imported), frozenset(taken)


@cache
def used_by(path: Path) -> frozenset[str]:
    """Modules of the package that a file uses by name; a test with those that its helper modules
    use.
    """
    found: set[str] = set()
    seen: set[Path] = set()
    rest = [path]
    while rest:
        one = rest.pop()
        seen.add(one)
        imported, taken = names_in(one)
        found |= imported & package_modules().keys()
        found |= (
            {public_homes()[name] for name in taken & public_homes().keys()}
            if SOURCE not in one.parents
            else set()
        )
        if SOURCE not in path.parents:
            near = (
                base / f"{name.replace('.', '/')}.py"
                for name in imported
                for base in (*HELPERS, one.parent)
            )
            rest += {helper for helper in near if helper.exists()} - seen - set(rest)
    return frozenset(found - {"valvetrain"})


def distances(targets: Iterable[str]) -> dict[str, int]:
    """Module of the package -> steps of imports from it to one of the targets."""
    importers: dict[str, set[str]] = defaultdict(set)
    for name, path in package_modules().items():
        for used in used_by(path):
            importers[used].add(name)
    found = dict.fromkeys(targets, 0)
    ring, step = set(found), 0
    while ring:
        step += 1
        ring = {user for one in ring for user in importers[one]} - found.keys()
        found |= dict.fromkeys(ring, step)
    return found


def rooms() -> list[str]:
    """Folders of the package, and modules that lie beside them."""
    return sorted(
        path.stem
        for path in SOURCE.iterdir()
        if (path.is_dir() and any(path.glob("*.py"))) or path.suffix == ".py"
    )


def modules_of(room: str) -> set[str]:
    """Modules of a room (``springs``, ``springs/solid``)."""
    name = f"valvetrain.{room.strip('/').replace('/', '.')}"
    return {one for one in package_modules() if one == name or one.startswith(f"{name}.")}


def modules_changed(base: str) -> set[str]:
    """Modules that differ between a commit and the working tree."""
    listed = subprocess.run(
        ["git", "diff", "--name-only", base, "--", "src"],
        cwd=ROOT,
        check=True,
        capture_output=True,
        text=True,
    )
    files = {ROOT / name for name in listed.stdout.split()}
    return {name for name, path in package_modules().items() if path in files}


@cache
def known_seconds() -> dict[str, dict[str, float]]:
    """Test file -> test -> seconds, of the last run that recorded it."""
    found: dict[str, dict[str, float]] = defaultdict(dict)
    for record in sorted(RECORDS.glob("*.xml"), key=lambda path: path.stat().st_mtime):
        for case in ElementTree.parse(record).iter("testcase"):
            if case.get("file") and not case.findall("skipped"):
                found[case.attrib["file"]][case.attrib["name"]] = float(case.get("time", 0.0))
    return found


def test_files() -> Iterator[str]:
    """Test files of the repository that can break with a room."""
    for path in sorted(TESTS.rglob("test_*.py")):
        if not (name := str(path.relative_to(ROOT))).startswith(NO_ROOM):
            yield name


def order(targets: Iterable[str]) -> list[Chosen]:
    """Test files that the targets can break, the nearest first."""
    wanted = set(targets)
    near, found = distances(wanted), []
    for file in test_files():
        path = ROOT / file
        used = used_by(path)
        steps = [near[name] for name in used if name in near]
        share = round(len(used & wanted) / max(len(used), 1), 1)
        distance = min(steps, default=FAR)
        if file.startswith("tests/contracts/"):
            distance = min(distance, 1)
        if distance < FAR:
            known = known_seconds().get(file, {})
            tests = len(re.findall(r"^def test_", path.read_text(encoding="utf-8"), re.MULTILINE))
            too_long = tuple(name for name, seconds in known.items() if seconds > MAX_TEST_SECONDS)
            seconds = FILE_START + (
                sum(one for one in known.values() if one <= MAX_TEST_SECONDS)
                if known
                else UNKNOWN_TEST * tests
            )
            found.append(Chosen(file, distance, share, seconds, too_long))
    return sorted(found, key=lambda one: (one.distance, -one.share, one.seconds))


def select(
    targets: Iterable[str], seconds: float, without: tuple[str, ...] = ()
) -> tuple[list[Chosen], list[Chosen]]:
    """Test files that fit into ``seconds`` and those left out; none from folders in ``without``."""
    taken, left, spent = [], [], 0.0
    for one in order(targets):
        if not one.file.startswith(without) and spent + one.seconds <= seconds:
            taken.append(one)
            spent += one.seconds
        else:
            left.append(one)
    return taken, left


def pytest_options(chosen: Iterable[Chosen]) -> list[str]:
    """Options of pytest that run the chosen files without their long tests."""
    files = list(chosen)
    long = [f"--deselect={one.file}::{name}" for one in files for name in one.too_long]
    return ["-q", "-p", "no:cacheprovider", "-m", MARKS, *long, *(one.file for one in files)]


def main() -> int:
    """Chooses, says what is left out, runs."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "room", nargs="?", help=f"one of {', '.join(rooms())}, or a folder below one"
    )
    parser.add_argument(
        "--changed",
        metavar="COMMIT",
        help="the modules changed since this commit, in place of a room",
    )
    parser.add_argument(
        "--seconds",
        type=float,
        default=50.0,
        help="estimated seconds of the chosen tests, per process",
    )
    parser.add_argument("--without-net", action="store_true", help="leave tests/net out")
    parser.add_argument("--list", action="store_true", help="print what would run, run nothing")
    parser.add_argument("pytest", nargs="*", help="options of pytest, after --")
    own, _, more = " ".join(sys.argv[1:]).partition(" -- ")
    given = parser.parse_args(own.split())
    targets = modules_changed(given.changed) if given.changed else modules_of(given.room or "")
    if not targets:
        parser.error(f"no module of the package is meant; rooms are {', '.join(rooms())}")
    options = more.split()
    processes = 1 if "-n 0" in more else min(os.cpu_count() or 1, 8)
    taken, left = select(
        targets, given.seconds * processes, ("tests/net/",) if given.without_net else ()
    )
    name = given.changed or (given.room or "").replace("/", "-")
    for title, some in (("run", taken if given.list else []), ("left out", left)):
        for one in some:
            print(f"{title}: distance {one.distance}, {one.seconds:5.1f} s  {one.file}")
    print(
        f"{len(taken)} test files, some {sum(one.seconds for one in taken):.0f} s on {processes} processes; {len(left)} left out",
        flush=True,
    )
    if given.list or not taken:
        return 0
    record = ["-o", "junit_family=xunit1", f"--junitxml={RECORDS / f'fast-{name}.xml'}"]
    workers = ["-n", "auto", "--maxprocesses", "8", "--dist", "loadfile"]
    return subprocess.run(
        [sys.executable, "-m", "pytest", *workers, *pytest_options(taken), *record, *options],
        cwd=ROOT,
    ).returncode


if __name__ == "__main__":
    sys.exit(main())
