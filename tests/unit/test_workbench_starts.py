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
from valvetrain.parameters.templates import KINDS, template_text
from valvetrain.runs.api import simulate
from valvetrain.workbench.edits import with_value
from valvetrain.workbench.form import fields
from valvetrain.workbench.lift_laws import with_law
from valvetrain.workbench.starts import GAP, additions, removable, with_addition
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


@pytest.mark.parametrize("name", TEXTS)
def test_every_table_that_is_offered_is_taken_shown_and_removed_again(name):
    text = TEXTS[name]
    case, before = read(text), tomllib.loads(text)
    offered = additions(case, text)
    assert len({one.key for one in offered}) == len(offered)
    for one in offered:
        made = with_addition(case, text, one.key)
        found = read(made)
        assert one.key in removable(found, made) and one.key not in [
            other.key for other in additions(found, made)
        ]
        assert any(group.key == one.key for group in fields(made)), "the form has it"
        shown = [
            field
            for group in fields(made)
            for field in group.fields
            if group.key == one.key and field.value_text
        ]
        assert shown and all(field.source.startswith("assumed") for field in shown)
        assert [
            line for line in text.splitlines() if "#" in line and line not in made.splitlines()
        ] == [], "comments stay"
        back = tomllib.loads(with_value(made, one.key, ""))
        whole, _, last = one.key.rpartition(".")
        if last == "1" and isinstance(at(before, whole), dict):
            assert at(back, whole) == [at(before, whole)]
        else:
            assert back == before


@pytest.mark.parametrize(
    "name",
    [*(name for name in TEXTS if name not in ("vaz-ohc", "tdi-pushrod")), "beehive wound left"],
)
def test_a_second_spring_fits_inside_the_first(name):
    """By the definition of a helix: outer diameter of the inner one is the inner diameter of the
    outer one less the gap.
    """
    text = (
        TEXTS["gu2021-beehive-blind"].replace('value = "right"', 'value = "left"', 1)
        if name == "beehive wound left"
        else TEXTS[name]
    )
    case = read(text)
    for key in [one.key for one in additions(case, text) if one.key.endswith(".1")]:
        found = read(with_addition(case, text, key))
        outer, inner = found.springs or found.train.springs[key.split(".")[2]]
        if outer.wire is None:
            assert inner.card.rate == pytest.approx(0.4 * outer.card.rate, rel=1e-2)
            continue
        coil = np.linspace(0.0, outer.wire.total_coils, 257)
        narrowest = np.min(
            outer.wire.mean_diameter.value(coil) - outer.wire.wire_diameter.value(coil)
        )
        widest = inner.wire.mean_diameter.value(0.0) + inner.wire.wire_diameter.value(0.0)
        assert widest == pytest.approx(narrowest - GAP, abs=2e-5)
        assert inner.wire.hand != outer.wire.hand and inner.wire.material == outer.wire.material
        heights = [one.wire.free_length - one.precompression for one in (outer, inner)]
        assert heights[0] == pytest.approx(heights[1], abs=2e-5)


def test_a_gas_load_that_was_just_added_changes_nothing():
    case, text = read(TEXTS["direct"]), TEXTS["direct"]
    pair = (case, read(with_addition(case, text, "train.gas")))
    runs = [simulate(one, ["3000 rpm"], spring_models=["massless"]).solutions[0] for one in pair]
    assert runs[0].quantities and dict(runs[0].quantities) == pytest.approx(
        dict(runs[1].quantities), rel=0, abs=0, nan_ok=True
    )


@pytest.mark.parametrize(
    "text",
    [
        'spring = { preload = "250 N", rate = "32 N/mm", mass = "42 g" }\nlift_law.kind = "zero"',
        'spring = [{ preload = "250 N", rate = "32 N/mm" }]\nlift_law.kind = "zero"',
        'spring.preload = "250 N"\nlift_law.kind = "zero"\nspring.rate = "32 N/mm"',
        '[[spring]]\npreload = "250 N"\nrate = "32 N/mm"\n[lift_law]\nkind = "zero"',
        '[spring.damping]\nmass_damping = "50 1/s"\n[lift_law]\nkind = "zero"\n[spring]\npreload = "250 N"\nrate = "32 N/mm"',
        '[spring]\npreload = "250 N"\nrate = "32 N/mm"\n[lift_law]\nkind = "zero"\n[spring.damping]\nmass_damping = "50 1/s"',
    ],
)
def test_however_a_spring_is_written_it_gets_a_second(monkeypatch, text):
    case = read(text)
    found = read(with_addition(case, text, "spring.1"))
    assert [(one.card.preload, one.card.rate) for one in found.springs] == [
        (250.0, 32e3),
        pytest.approx((100.0, 12.8e3)),
    ]
    assert (found.springs[0].card.mass, found.springs[0].damping) == (
        case.springs[0].card.mass,
        case.springs[0].damping,
    )
    monkeypatch.setattr(
        "valvetrain.workbench.starts.saved", lambda document: text
    )  # a writer that loses what it was given
    with pytest.raises(InputError, match="add it to the case file itself"):
        with_addition(case, text, "spring.1")


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


def test_a_lift_law_of_another_kind_keeps_what_both_know_and_assumes_the_rest(tmp_path):
    workspace = Workspace(tmp_path)
    name = workspace.upload("small.toml", SMALL.encode())
    first = workspace.read(name).lift_law.values
    for kind in ("cycloidal", "modified-sine", "harmonic", "sine-power"):
        workspace.change_law(name, kind)
        law = workspace.read(name).lift_law
        assert law.kind == kind and {
            key: law.values[key] for key in first if key in law.values
        } == {key: first[key] for key in first if key in law.values}
    tree = tomllib.loads(with_law(workspace.text(name), "polynomial", []))[
        "lift_law"
    ]  # the power of a sine has no word for its middle
    assert tree["opening_start"] == "115 deg" and tree["opening_end"]["status"] == "assumed"


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
        ("ramped", "'ramp_lift' is missing"),
        ("three-arc", "'base_radius' is missing"),
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
        with_law(TEXTS["uniform-spring"], "polynomial", [])


@pytest.mark.parametrize(
    ("text", "key"),
    [
        (
            '[[spring]]\npreload = "250 N"\nrate = "32 N/mm"\n[[spring]]\npreload = "100 N"\nrate = "10 N/mm"\n'
            '[rubbing]\ncoefficient = 0.1\nnormal_force = "10 N"\n[lift_law]\nkind = "zero"\n',
            "rubbing",
        ),
        (None, "train.rubbing"),
    ],
)
def test_a_second_spring_goes_after_the_friction_between_both(tmp_path, text, key):
    workspace = Workspace(tmp_path)
    if text is None:
        text = with_addition(
            read(TEXTS["direct"]), TEXTS["direct"], inner := "train.springs.stock.1"
        )
        text += '\n[train.rubbing]\ncoefficient = 0.1\nnormal_force = "10 N"\n'
    else:
        inner = "spring.1"
    name = workspace.upload("nested.toml", text.encode())
    assert {key, inner} <= removable(workspace.read(name), text) and any(
        group.key == key for group in fields(text)
    )
    with pytest.raises(InputError, match="rubbing acts between two nested springs"):
        workspace.set_value(name, inner, "")
    workspace.set_value(name, key, "")
    assert key not in removable(workspace.read(name), workspace.text(name))
    workspace.set_value(name, inner, "")
    assert inner not in removable(workspace.read(name), workspace.text(name))
