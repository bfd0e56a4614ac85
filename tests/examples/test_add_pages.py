"""The pages "add a ..." show code that runs: a package of its own brings each page's file by an
entry point, and it does what it says.
"""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from valvetrain import registry

ROOT = Path(__file__).parents[2]
PAGES = sorted((ROOT / "docs" / "extend").glob("add-a-*.md"))
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
#: Word and place in a line of the registry.
ENTRY = re.compile(r'"([\w-]+)": "([\w.]+):(\w+)"')


def blocks(page: Path, language: str) -> list[str]:
    """Code of a page in one language, in order."""
    return [
        code for name, code in BLOCK.findall(page.read_text(encoding="utf-8")) if name == language
    ]


def entry_points(page: Path) -> dict[str, dict[str, str]]:
    """Entry-point group -> word -> place, as the page writes them for a pyproject.toml."""
    (text,) = blocks(page, "toml")
    return tomllib.loads(text)["project"]["entry-points"]


def install(page: Path, folder: Path) -> None:
    """A package in ``folder`` as an installer would leave it: the page's file and its entry point."""
    groups = entry_points(page)
    (place,) = (place for words in groups.values() for place in words.values())
    (folder / f"{place.partition(':')[0]}.py").write_text(
        blocks(page, "python")[0], encoding="utf-8"
    )
    info = folder / "own_package-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: own-package\nVersion: 1.0\n")
    lines = [
        f"[{group}]\n" + "".join(f"{word} = {at}\n" for word, at in words.items())
        for group, words in groups.items()
    ]
    (info / "entry_points.txt").write_text("".join(lines))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_what_a_page_adds_runs_and_prints_what_the_page_says(page, tmp_path):
    install(page, tmp_path)
    (printed,), commands = blocks(page, "text"), blocks(page, "sh")
    words = ["-m", *shlex.split(commands[0])] if commands else ["-c", blocks(page, "python")[1]]
    paths = os.pathsep.join(map(str, (tmp_path, ROOT / "src")))
    done = subprocess.run(
        [sys.executable, *words], capture_output=True, text=True, cwd=tmp_path, env={**os.environ, "PYTHONPATH": paths}
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stdout == printed


@pytest.mark.parametrize(
    "page", [one for one in PAGES if blocks(one, "diff")], ids=lambda page: page.stem
)
def test_the_line_of_a_page_fits_the_registry(page):
    """The line before it stands in registry.py as shown, the new word is free, and its place is the
    file that the page names.
    """
    (diff,) = blocks(page, "diff")
    before, added = (
        next(line[1:] for line in diff.splitlines() if re.match(rf"{sign} ", line))
        for sign in (" ", r"\+")
    )
    assert (
        before
        in (ROOT / "src" / "valvetrain" / "registry.py").read_text(encoding="utf-8").splitlines()
    )
    (word, module, attribute), (group,) = ENTRY.search(added).groups(), entry_points(page)
    assert (
        f'BUILT_IN["{group.removeprefix("valvetrain.")}"]' in diff
        and word not in registry.names(group.removeprefix("valvetrain."))
    )
    assert f"`src/{module.replace('.', '/')}.py`" in page.read_text(encoding="utf-8")
    assert entry_points(page)[group] == {word: f"{module.rpartition('.')[2]}:{attribute}"}
    code = blocks(page, "python")[0]
    assert re.search(rf"^({attribute} = |def {attribute}\()", code, re.MULTILINE)
