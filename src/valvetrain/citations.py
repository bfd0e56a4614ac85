"""The works behind a result: plain text for people, BibTeX for papers."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from importlib import resources

from valvetrain.errors import InputError

_ENTRY = re.compile(
    r"^@(?P<kind>\w+)\{(?P<key>[\w-]+),\n(?P<body>.*?)^\}$", re.MULTILINE | re.DOTALL
)
_FIELD = re.compile(r"^  (?P<name>\w+) = \{(?P<value>.*)\},$", re.MULTILINE)


@dataclass(frozen=True)
class Reference:
    """One entry of references.bib: ``kind`` (article, book, ...), ``key`` and its fields in order."""

    kind: str
    key: str
    fields: tuple[tuple[str, str], ...]

    def field(self, name: str) -> str:
        """Value of a field, empty where the entry has none."""
        return dict(self.fields).get(name, "")

    def text(self) -> str:
        """The reference in one line: authors, title, where, year."""
        place = [
            self.field(name)
            for name in ("journal", "howpublished", "publisher", "institution")
            if self.field(name)
        ]
        place += [self.field(name) for name in ("volume", "number", "pages") if self.field(name)]
        edition = f" ({self.field('edition')} edition)" if self.field("edition") else ""
        doi = f". doi:{self.field('doi')}" if self.field("doi") else ""
        return f"{_people(self.field('author'))}: {self.field('title')}{edition}. {', '.join(place)} ({self.field('year')}){doi}".strip()

    def bibtex(self) -> str:
        """The reference as a BibTeX entry."""
        lines = [f"  {name} = {{{value}}}," for name, value in self.fields if name != "topic"]
        return "\n".join([f"@{self.kind}{{{self.key},", *lines, "}"])


@cache
def references() -> dict[str, Reference]:
    """All references by key, in the order of references.bib."""
    text = resources.files("valvetrain").joinpath("references.bib").read_text(encoding="utf-8")
    return parse_references(text)


def parse_references(text: str) -> dict[str, Reference]:
    """References by key from text in the layout of references.bib; :class:`InputError` for an entry
    that is read twice.
    """
    found: dict[str, Reference] = {}
    for match in _ENTRY.finditer(text):
        key = match["key"]
        if key in found:
            raise InputError(
                f"reference '{key}' occurs twice; rename or remove one", "references.bib"
            )
        found[key] = Reference(
            match["kind"],
            key,
            tuple((field["name"], field["value"]) for field in _FIELD.finditer(match["body"])),
        )
    return found


def cite(keys: str | Iterable[str]) -> str:
    """Plain-text references, one per line.

    Parameters
    ----------
    keys : one key of references.bib or several; each work is given once

    Raises
    ------
    InputError : an unknown key; the sentence names the nearest

    Examples
    --------
    >>> cite("gu2021")[:30]
    'Zewen Gu, Xiaonan Hou, Elspeth'
    """
    return "\n".join(reference.text() for reference in _chosen(keys))


def bibtex(keys: str | Iterable[str]) -> str:
    """BibTeX entries, an empty line between them.

    Parameters
    ----------
    keys : one key of references.bib or several; each work is given once

    Raises
    ------
    InputError : an unknown key; the sentence names the nearest

    Examples
    --------
    >>> bibtex("gu2021").startswith("@article{gu2021,")
    True
    """
    return "\n\n".join(reference.bibtex() for reference in _chosen(keys))


def _chosen(keys: str | Iterable[str]) -> list[Reference]:
    known = references()
    keys = dict.fromkeys([keys] if isinstance(keys, str) else keys)
    for key in keys:
        if key not in known:
            near = difflib.get_close_matches(key[:60], known, n=1)
            hint = f"did you mean '{near[0]}'?" if near else f"known are {', '.join(known)}"
            raise InputError(f"reference '{key[:40]}' is unknown; {hint}")
    return [known[key] for key in keys]


def _people(authors: str) -> str:
    names = []
    for author in authors.replace("{", "").replace("}", "").split(" and "):
        family, _, given = author.partition(", ")
        names.append(f"{given} {family}".strip())
    if len(names) < 2:
        return "".join(names)
    return f"{', '.join(names[:-1])} and {names[-1]}"
