"""References: found, printed whole, and refused with the nearest key."""

from __future__ import annotations

import re
from importlib import resources

import pytest

from valvetrain.citations import bibtex, cite, parse_references, references
from valvetrain.errors import InputError


def test_every_entry_of_the_file_is_read_with_what_a_reader_needs():
    text = resources.files("valvetrain").joinpath("references.bib").read_text(encoding="utf-8")
    assert list(references()) == re.findall(r"^@\w+\{([\w-]+),$", text, re.MULTILINE)
    for reference in references().values():
        assert all(reference.fields.get(name) for name in ("author", "title", "year", "topic")), (
            reference.key
        )
        assert len(reference.fields) == len(
            re.findall(
                r"^  \w+ =", text.split(f"{{{reference.key},")[1].split("\n}")[0], re.MULTILINE
            )
        )


def test_a_work_cited_twice_is_printed_once_and_order_is_kept():
    assert cite(["wahl1963", "gu2021", "wahl1963"]).splitlines() == [
        cite("wahl1963"),
        cite("gu2021"),
    ]
    assert cite([]) == ""


def test_bibtex_is_read_back_without_loss():
    again = parse_references(bibtex(references()))
    assert list(again) == list(references())
    for key, reference in references().items():
        assert again[key].kind == reference.kind
        shown = [one for one in reference.fields.items() if one[0] != "topic"]
        assert list(again[key].fields.items()) == shown


def test_an_unknown_key_is_refused_with_the_nearest():
    with pytest.raises(InputError, match="did you mean 'gu2021'"):
        cite("gu2012")
    with pytest.raises(InputError, match="known are gu2021"):
        bibtex("???")


def test_a_key_that_stands_twice_is_refused():
    with pytest.raises(InputError, match="'wahl1963' occurs twice"):
        parse_references(f"{bibtex('wahl1963')}\n\n{bibtex('wahl1963')}")
