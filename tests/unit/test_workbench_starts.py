"""Tables that a case gets on its page: second spring, guide, gas load, crank, lift law of another
kind.

Evidence: the reader of case files, geometry of nested springs (closed form), and that what is taken
away again leaves the case as it was.
"""

from __future__ import annotations

import tomllib

import numpy as np
import pytest

from valvetrain.errors import InputError
from valvetrain.parameters.loading import LIBRARY, library_names, parse_case
from valvetrain.parameters.overrides import REMOVED, split_notes
from valvetrain.parameters.templates import KINDS, template_text
from valvetrain.runs.api import simulate
from valvetrain.workbench.edits import with_law, with_table, with_value
from valvetrain.workbench.form import CaseForm
from valvetrain.workbench.starts import first_values
from valvetrain.workbench.workspace import Workspace
from workbench_parts import SMALL

TEXTS = {name: (LIBRARY / f"{name}.toml").read_text("utf-8") for name in library_names()} | {
    kind: template_text(kind) for kind in KINDS
}
LIFTS = b"\n".join(
    b"%d %.4f" % (place * 10, max(0.0, 9 - abs(place - 18)) ** 2 / 9) for place in range(36)
)


def read(text):
    return parse_case(text, "case", LIBRARY)


def at(tree, key):
    for head in key.split("."):
        tree = tree[int(head)] if isinstance(tree, list) else tree[head]
    return tree


def with_addition(text, key):
    tree = split_notes(tomllib.loads(text))[0]
    return with_table(text, key, first_values(read(text), tree, key))


@pytest.mark.parametrize("name", TEXTS)
def test_every_table_that_is_offered_is_taken_shown_and_removed_again(name):
    text = TEXTS[name]
    before = tomllib.loads(text)
    keys = [one.key for one in CaseForm(text).additions]
    assert len(set(keys)) == len(keys)
    for key in keys:
        made = with_addition(text, key)
        assert read(made)
        form = CaseForm(made)
        group = next(group for group in form.groups if group.key == key)
        assert group.removable and key not in [one.key for one in form.additions]
        given = [field for field in group.fields if field.text]
        assert given and all(field.source.startswith("assumed") for field in given)
        lines = made.splitlines()
        assert [line for line in text.splitlines() if "#" in line and line not in lines] == []
        back = tomllib.loads(with_value(made, key, REMOVED))
        whole, _, last = key.rpartition(".")
        if last == "1" and isinstance(at(before, whole), dict):
            assert at(back, whole) == [at(before, whole)]
        else:
            assert back == before


def test_a_gas_load_that_was_just_added_changes_nothing():
    text = TEXTS["direct"]
    pair = (read(text), read(with_addition(text, "train.gas")))
    runs = [simulate(one, ["3000 rpm"], models=["massless"]).solutions[0] for one in pair]
    assert runs[0].quantities and dict(runs[0].quantities) == pytest.approx(
        dict(runs[1].quantities), rel=0, abs=0, nan_ok=True
    )


@pytest.mark.parametrize(
    "key",
    ["", "train.gas", "spring", "spring.2", "spring.1.guide", "published", "../x", "lift_law"],
)
def test_no_other_table_is_added(tmp_path, key):
    workspace = Workspace(tmp_path)
    name = workspace.upload("small.toml", SMALL.encode())
    with pytest.raises(InputError, match="no table that this case may get"):
        workspace.add_table(name, key)
    assert workspace.text(name) == SMALL
    workspace.add_table(name, "spring.1")
    assert len(workspace.read(name).springs) == 2


@pytest.mark.parametrize("kind", ["table", "spline", "measured"])
def test_a_table_beside_the_case_becomes_its_lift_law(tmp_path, kind):
    workspace = Workspace(tmp_path)
    name = workspace.upload("small.toml", SMALL.encode())
    with pytest.raises(InputError, match="below 'Files of this case'"):
        workspace.change_law(name, kind)
    workspace.attach(name, "lift.txt", LIFTS)
    workspace.change_law(name, kind)
    law = workspace.read(name).lift_law
    lifts, angles = law.values["lifts"], law.values["cam_angles"]
    assert max(lifts) == pytest.approx(9e-3, rel=1e-3) and angles[
        np.argmax(lifts)
    ] == pytest.approx(np.pi)
    tree = tomllib.loads(workspace.text(name))["lift_law"]
    workspace.add_table(name, "spring.1")
    assert (
        "# weighed" in workspace.text(name)
        and tomllib.loads(workspace.text(name))["lift_law"] == tree
    ), "the file stays named"
    assert tree["file"] == "lift.txt" and tree["lift_unit"] == {
        "value": "mm",
        "status": "assumed",
        "source": "to begin with; put your own",
    }


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        ("stations", "'cam_angles' is missing"),
        ("table", "below 'Files of this case'"),
        ("nonsense", "unknown"),
        ("", "unknown"),
    ],
)
def test_a_kind_whose_values_cannot_be_told_is_refused_and_changes_nothing(tmp_path, kind, words):
    workspace = Workspace(tmp_path)
    name = workspace.upload("small.toml", SMALL.encode())
    with pytest.raises(InputError, match=words) as refused:
        workspace.change_law(name, kind)
    assert refused.value.where == "lift_law.kind"
    assert workspace.text(name) == SMALL
    with pytest.raises(InputError):
        with_law(TEXTS["uniform-spring"], "polynomial")
