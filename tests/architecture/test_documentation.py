"""The pages of the documentation hold together: each is reached from the first, links and anchors
lead somewhere, commands exist.
"""

from __future__ import annotations

import re
import shlex
import sys
from functools import cache
from pathlib import Path

import pytest
import typer

from architecture.layout import ROOT
from valvetrain.cli.main import app

DOCS = ROOT / "docs"
#: Pages that a build writes.
WRITTEN = {"quantities", "plausible", "defaults", "error-bars"}
BUILT = {"commands", "api/index", "gallery/index", "notebooks/index", *WRITTEN}
PAGES = sorted(
    path for path in DOCS.rglob("*.md") if "_site" not in path.parts and path.stem not in WRITTEN
)
ALL = [*PAGES, *(ROOT / name for name in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md"))]
CODE = re.compile(r"^```(?P<language>\w+)\n(?P<code>.*?)^```$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"(?<!\\)\]\(([^()\s]+)\)")
TREE = re.compile(
    r"^```\{toctree\}\n(?P<options>(?::.*\n)*)\n(?P<pages>.*?)^```$", re.MULTILINE | re.DOTALL
)
identity = pytest.mark.parametrize("path", ALL, ids=lambda path: str(path.relative_to(ROOT)))


@cache
def text_of(path: Path) -> str:
    return path.read_text(encoding="utf-8")


def parts():
    """The module of the site that makes its tree."""
    sys.path.insert(0, str(DOCS / "_site"))
    try:
        import page_tree
    finally:
        sys.path.pop(0)
    return page_tree


def anchors(path: Path) -> set[str]:
    """Anchors of the headings of a page, as code hosts and the site make them; and targets that are
    named.
    """
    found: dict[str, int] = {}
    plain = CODE.sub("", text_of(path))
    for heading in re.findall(r"^#{1,4} (.*)$", plain, re.MULTILINE):
        words = re.sub(r"[`*]|\[([^]]*)\]\([^)]*\)", r"\1", heading.strip()).lower()
        slug = re.sub(r"[^\w\- ]", "", words).replace(" ", "-")
        count = found.get(slug, 0)
        found[slug] = count + 1
        if count:
            found[f"{slug}-{count}"] = 1
    return set(found) | set(re.findall(r"^\(([\w-]+)\)=$", plain, re.MULTILINE))


def below(page: str) -> set[str]:
    """Pages that stand below a page in the tree of the site."""
    text = text_of(DOCS / f"{page}.md")
    tree = parts()
    folder = (DOCS / page).parent
    named = {
        line.strip()
        for match in TREE.finditer(text)
        for line in match["pages"].splitlines()
        if line.strip()
    }
    named |= set(tree.children(page, text, DOCS)) if page in tree.PARENTS else set()
    named = {re.sub(r".*<(.*)>", r"\1", name) for name in named}
    return {str((folder / name).resolve().relative_to(DOCS)) for name in named}


def test_every_page_is_reached_from_the_first():
    reached, open_pages = {"index"}, ["index"]
    while open_pages:
        page = open_pages.pop()
        if page not in BUILT:
            new = below(page) - reached
            reached |= new
            open_pages += sorted(new)
    pages = {str(path.relative_to(DOCS).with_suffix("")) for path in PAGES}
    assert not pages - reached, (
        "add a link to the page that lists such pages (docs/user-guide.md, docs/reference.md, ...)"
    )
    assert not reached - pages - BUILT


def lost_links(path: Path) -> list[str]:
    """Links of a page to a file or an anchor that is not there."""
    lost = []
    for target in LINK.findall(CODE.sub("", text_of(path))):
        place, _, anchor = target.partition("#")
        file = (path.parent / place).resolve() if place else path
        if (
            re.match(r"[a-z]+:", place)
            or str(file.relative_to(ROOT)).removeprefix("docs/").rpartition(".")[0] in BUILT
        ):
            continue
        if not file.exists() or (anchor and file.suffix == ".md" and anchor not in anchors(file)):
            lost.append(target)
    return lost


@identity
def test_links_lead_somewhere(path):
    assert not lost_links(path)


@cache
def commands():
    """Name -> the options and the number of arguments of every command."""
    return dict(typer.main.get_command(app).commands)


def refused(line: str) -> str:
    """What is wrong with a command line of a page, empty for nothing."""
    words = shlex.split(line, comments=True)
    if len(words) < 2 or words[1].startswith("-") or words[1] == "COMMAND":
        return ""
    command = commands().get(words[1])
    if command is None:
        return f"no command {words[1]}: {line}"
    known = {flag for one in command.params for flag in (*one.opts, *one.secondary_opts)} | {
        "--help"
    }
    given = [word.partition("=")[0] for word in words[2:] if re.match(r"--[a-z]", word)]
    return "; ".join(
        f"{words[1]} has no option {flag}: {line}" for flag in given if flag not in known
    )


def lines_of_commands(text: str) -> list[str]:
    """Command lines in blocks of a shell, in indented lines and within sentences."""
    blocks = [
        code
        for language, code in CODE.findall(text)
        if language in ("bash", "sh", "shell", "console")
    ]
    lines = [line for code in blocks for line in code.replace("\\\n", " ").splitlines()]
    lines += re.findall(r"^    (valvetrain .*)$", text, re.MULTILINE)
    lines += re.findall(r"`(valvetrain [a-z][^`\n]*)`", CODE.sub("", text))
    return [
        line.strip().removeprefix("$ ")
        for line in lines
        if line.strip().removeprefix("$ ").startswith("valvetrain ")
    ]


@identity
def test_commands_of_a_page_exist_with_their_options(path):
    text = text_of(path)
    added = {
        f"valvetrain {word}"
        for word in re.findall(r'^([\w-]+) = "\w+:register"$', text, re.MULTILINE)
    }
    lines = [line for line in lines_of_commands(text) if " ".join(line.split()[:2]) not in added]
    assert not [words for words in map(refused, lines) if words]


@identity
def test_python_of_a_page_compiles(path):
    for language, code in CODE.findall(text_of(path)):
        if language == "python" and ">>> " not in code:
            compile(code, str(path), "exec")
