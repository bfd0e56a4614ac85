"""Forms: every value of every case that ships stands in its form as the reader takes it, and
refusals are the reader's own.

Evidence: the reader of case files (another path through the tables than the form's), and values
known from the library's files.
"""

from __future__ import annotations

import itertools
import tomllib

import pytest

from valvetrain.errors import InputError
from valvetrain.parameters.loading import LIBRARY, parse_case
from valvetrain.parameters.overrides import split_notes
from valvetrain.parameters.templates import TEMPLATES
from valvetrain.workbench.edits import read_change
from valvetrain.workbench.form import CaseForm
from valvetrain.workbench.form_fields import Field
from workbench_parts import SMALL
from yardstick import quickest

FILES = sorted([*LIBRARY.glob("*.toml"), *TEMPLATES.glob("*.toml")], key=lambda path: path.stem)
#: Tables and lists that a form leaves to the text of the case.
LEFT = ("points", "published", "sources", "remarks", "study", "name")


def flat(text: str) -> dict[str, Field]:
    return {field.key: field for group in CaseForm(text).groups for field in group.fields}


def leaves(item, path=""):
    """Key path -> plain value of a bare tree; a curve, an end or a material is one value."""
    for key, value in item.items():
        here = f"{path}.{key}" if path else key
        if (
            isinstance(value, dict) and not {"formula", "coils", "kind", "name"} & set(value)
        ) or key in ("lift_law", "train"):
            yield from leaves(value, here)
        elif isinstance(value, list) and value and all(isinstance(one, dict) for one in value):
            for place, one in enumerate(value):
                yield from leaves(one, f"{here}.{place}")
        else:
            yield here, value


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_value_of_a_case_stands_in_its_form_and_is_taken_back(path):
    text = path.read_text(encoding="utf-8")
    form = flat(text)
    bare, notes, _ = split_notes(tomllib.loads(text))
    missing = [
        key
        for key, value in leaves(bare)
        if key.split(".")[0] not in LEFT
        and (key not in form or not form[key].text)
        and value != ""
        and not (
            key.startswith("train.variants.") or ".variants." in key or isinstance(value, dict)
        )
    ]
    assert not missing
    for place, field in enumerate(form.values()):
        if (
            field.text and place % 3 == 0
        ):  # each is read from its own table; a third of them is enough here
            read_change(text, field.key, field.text, LIBRARY)
    for key, note in notes.items():
        if key in form and form[key].text:
            assert (note.source in form[key].source) and (
                str(note.status or "") in form[key].source
            )


def test_a_value_keeps_the_unit_it_is_written_in():
    numbers = [
        field
        for field in flat((TEMPLATES / "finger.toml").read_text("utf-8")).values()
        if field.number is not None
    ]
    for field in numbers:
        if field.unit:
            assert field.text.replace(" ", "").startswith(f"{field.number:g}"[:4]), field
        if field.slider is not None:
            assert field.slider[0] <= field.number <= field.slider[1], field
    assert len(numbers) > 30


def test_a_check_is_quick():
    """Under 50 ms of processor time for the largest case that ships; a slider asks for many."""
    text = (LIBRARY / "vaz-ohc.toml").read_text("utf-8")
    masses = itertools.count(126)
    assert (
        quickest(lambda: read_change(text, "train.valve.mass", f"{next(masses)} g", LIBRARY), 5)
        < 0.05
    )


def test_a_form_of_a_text_that_is_none():
    with pytest.raises(InputError, match="not valid TOML"):
        CaseForm("x = [")
    assert [group.key for group in CaseForm("").groups] == ["", "operation", "limits"]
    assert parse_case(SMALL).springs
