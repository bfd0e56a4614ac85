"""Every work that a shipped case names stands in references.bib."""

from __future__ import annotations

import pytest

import valvetrain
from valvetrain.citations import cite, references


@pytest.mark.parametrize("name", [summary.name for summary in valvetrain.list_cases()])
def test_the_works_of_a_case_are_known(name):
    keys = valvetrain.load_case(name).cite()
    assert set(keys) <= set(references())
    assert len(cite(keys).splitlines()) == len(keys)


def test_the_published_study_names_its_paper():
    assert "105476 (2020)" in cite(valvetrain.load_case("gu2021-beehive-blind").cite())
