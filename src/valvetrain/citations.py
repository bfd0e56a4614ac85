"""The works behind a result: plain text for people, BibTeX for papers."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources

from valvetrain.errors import InputError

_ENTRY = re.compile(
    r"^@(?P<kind>\w+)\{(?P<key>[\w-]+),\n(?P<body>.*?)^\}$", re.MULTILINE | re.DOTALL
)
_FIELD = re.compile(r"^  (?P<name>\w+) = \{(?P<value>.*)\},$", re.MULTILINE)
#: Fields that say where a work is found, in the order in which they are printed.
PLACE = ("journal", "howpublished", "publisher", "institution", "volume", "number", "pages")


@dataclass(frozen=True)
class Reference:
    """One entry of references.bib: ``kind`` (article, book, ...), ``key`` and its fields in order."""

    kind: str
    key: str
    fields: Mapping[str, str]

    def text(self) -> str:
        """The reference in one line: authors, title, where, year."""
        fields = self.fields
        names = []
        for author in re.sub("[{}]", "", fields.get("author", "")).split(" and "):
            family, _, given = author.partition(", ")
            names.append(f"{given} {family}".strip())
        people = " and ".join(filter(None, (", ".join(names[:-1]), names[-1])))
        place = ", ".join(fields[name] for name in PLACE if name in fields)
        edition = f" ({fields['edition']} edition)" if "edition" in fields else ""
        doi = f". doi:{fields['doi']}" if "doi" in fields else ""
        title, year = fields.get("title", ""), fields.get("year", "")
        return f"{people}: {title}{edition}. {place} ({year}){doi}".strip()

    def bibtex(self) -> str:
        """The reference as a BibTeX entry."""
        shown = (one for one in self.fields.items() if one[0] != "topic")
        lines = [f"  {name} = {{{value}}}," for name, value in shown]
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
            {field["name"]: field["value"] for field in _FIELD.finditer(match["body"])},
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
