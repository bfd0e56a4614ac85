"""Copies of the repository in which faults are seeded; the working tree is read only."""

from __future__ import annotations

import ast
import hashlib
import os
import shutil
import subprocess
from collections.abc import Iterable
from functools import cache
from pathlib import Path

from valvetrain import compiled

ROOT = Path(__file__).resolve().parents[1]
PLACE = ROOT / "build" / "mutants"


def files() -> list[str]:
    """Files of the working tree that git knows or would add."""
    listed = subprocess.run(
        ["git", "ls-files", "-co", "--exclude-standard"],
        cwd=ROOT,
        check=True,
        capture_output=True,
        text=True,
    )
    return [name for name in listed.stdout.splitlines() if (ROOT / name).is_file()]


@cache
def tree_digest() -> str:
    """Digest of every file that a sample and its verdicts depend on: sources, tests, examples and
    this tool.
    """
    found = hashlib.sha256()
    for name in sorted(
        name for name in files() if name.startswith(("src/", "tests/", "examples/", "mutants/"))
    ):
        found.update(name.encode() + b"\0" + (ROOT / name).read_bytes())
    return found.hexdigest()[:16]


def renew(name: str) -> Path:
    """The copy of that name, equal to the working tree, with the tree's compiled kernels; times are
    kept, by which kernels are stamped.
    """
    copy = PLACE / name
    kernels = [str(path.relative_to(ROOT)) for path in (ROOT / "src").rglob("*.nb[ic]")]
    wanted = {*files(), *kernels}
    copy.mkdir(parents=True, exist_ok=True)
    for path in [
        path for path in copy.rglob("*") if path.is_file() and "__pycache__" not in path.parts
    ]:
        if str(path.relative_to(copy)) not in wanted and "runs" not in path.parts:
            path.unlink()
    for file in wanted:
        source, target = ROOT / file, copy / file
        if not target.exists() or source.stat().st_mtime_ns != target.stat().st_mtime_ns:
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(source, target)
    _hold_stamp(copy)
    return copy


def _hold_stamp(copy: Path) -> None:
    """Makes the copy's kernels valid whatever fault its sources hold.

    The package stamps each compiled kernel by the text of all sources of kernels, so that one fault
    would compile them all again. In the
    copy the stamp is that of the working tree; the tool itself deletes what a fault can reach
    (:func:`drop_kernels`).
    """
    source = Path(compiled.__file__)
    target = copy / source.relative_to(ROOT)
    times, stamp = source.stat(), compiled.sources_digest(compiled.PACKAGE)
    lines = (
        "of_sources = sources_digest",
        f"sources_digest = cache(lambda package: {stamp!r} if package == PACKAGE else of_sources(package))",
    )
    target.write_text("\n".join((source.read_text(encoding="utf-8"), *lines, "")), encoding="utf-8")
    os.utime(target, ns=(times.st_atime_ns, times.st_mtime_ns))


def twin_of(base: Path, name: str) -> Path:
    """A copy of ``base`` with its compiled kernels (times kept, so that they stay valid)."""
    twin = PLACE / name
    shutil.rmtree(twin, ignore_errors=True)
    shutil.copytree(base, twin, symlinks=True, copy_function=shutil.copy2)
    return twin


def restore_kernels(base: Path, twin: Path, dropped: Iterable[Path]) -> None:
    """Puts back the compiled kernels of ``base`` for the files in ``dropped``; those made by a
    seeded fault go.
    """
    for folder in {path.parent for path in dropped}:
        for old in folder.glob("*.nb[ic]"):
            old.unlink()
        for kept in (base / folder.relative_to(twin)).glob("*.nb[ic]"):
            shutil.copy2(kept, folder / kept.name)


def drop_kernels(copy: Path, module: str) -> list[Path]:
    """Deletes the compiled kernels that may hold code of ``module`` (path below src): its own and
    those built upon it.
    """
    gone: list[Path] = []
    for file in built_upon(module):
        path = copy / "src" / file
        for cached in (path.parent / "__pycache__").glob(f"{path.stem}.*.nb[ic]"):
            cached.unlink()
            gone.append(cached)
    return gone


@cache
def imports() -> dict[str, set[str]]:
    """Module file -> files of the package that it imports by name."""
    source = ROOT / "src"
    found: dict[str, set[str]] = {}
    for path in source.rglob("*.py"):
        names = set()
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.module:
                names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
            elif isinstance(node, ast.Import):
                names |= {alias.name for alias in node.names}
        paths = {
            name.replace(".", os.sep) + ".py" for name in names if name.startswith("valvetrain")
        }
        found[str(path.relative_to(source))] = {name for name in paths if (source / name).exists()}
    return found


@cache
def compiles(file: str) -> bool:
    """Whether a file of the package holds compiled kernels."""
    path = ROOT / "src" / file
    return path.exists() and any(
        word in path.read_text(encoding="utf-8") for word in ("njit", "compiled(")
    )


def built_upon(file: str) -> set[str]:
    """Kernel files that import ``file`` straight or through other kernel files, and the file
    itself.
    """
    found, rest = {file}, [file]
    while rest:
        one = rest.pop()
        more = {user for user, used in imports().items() if one in used and compiles(user)} - found
        found |= more
        rest += more
    return found
