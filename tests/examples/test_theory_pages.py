"""The pages of docs/theory and the glossary point at what is there: modules, tests, sources,
chapters of the validation book, pages.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from valvetrain.citations import references

ROOT = Path(__file__).resolve().parents[2]
THEORY = sorted((ROOT / "docs" / "theory").glob("*.md"))
PAGES = [*THEORY, ROOT / "docs" / "glossary.md"]
KEY = re.compile(r"\b(?:[a-z]{3,}\d{4}|multibody4b17|en\d{5}-\d)\b")
BOOK = (ROOT / "docs" / "validation.md").read_text(encoding="utf-8")


def text_of(path: Path) -> str:
    return path.read_text(encoding="utf-8")


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.stem)
def test_links_lead_somewhere(path):
    links = [link for link in re.findall(r"\]\(([^)#]+)\)", text_of(path)) if "://" not in link]
    written = {"quantities.md", "plausible.md", "defaults.md", "error-bars.md"}  # by the build
    lost = [link for link in links if not (path.parent / link).exists()]
    assert not [link for link in lost if Path(link).name not in written]


@pytest.mark.parametrize("path", THEORY, ids=lambda path: path.stem)
def test_modules_and_tests_that_a_page_names_are_there(path):
    named = [
        name
        for name in re.findall(r"`([\w/.-]+/[\w/.-]*)`", text_of(path))
        if not name.startswith(("src/", "valvetrain/"))
    ]
    assert not [
        name
        for name in named
        if not ((ROOT / "src" / "valvetrain" / name).exists() or (ROOT / name).exists())
    ]


@pytest.mark.parametrize("path", THEORY, ids=lambda path: path.stem)
def test_sources_that_a_page_cites_are_known(path):
    assert not set(KEY.findall(text_of(path))) - set(references())


@pytest.mark.parametrize("path", THEORY, ids=lambda path: path.stem)
def test_chapters_of_the_validation_book_are_there(path):
    lists = re.findall(r"[Cc]hapters? ([A-Z][\w ]+?)(?: of|\)| \()", text_of(path))
    named = {chapter.strip() for words in lists for chapter in words.split(" and ")}
    assert not [chapter for chapter in named if f"\n## {chapter}\n" not in BOOK]
