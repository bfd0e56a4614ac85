"""A lift law of another kind, and back: nothing that was told is lost, nothing stands over what it
does not describe.

Evidence: the text of the case file before and after, the reader of case files, what stands on disk.
"""

from __future__ import annotations

import tomllib

import pytest

from valvetrain.errors import InputError
from valvetrain.parameters.loading import LIBRARY, library_names
from valvetrain.parameters.templates import KINDS, template_text
from valvetrain.registry import names as registered_names
from valvetrain.workbench.workspace import Workspace
from workbench_parts import SMALL, SPRING

TEXTS = {name: (LIBRARY / f"{name}.toml").read_text("utf-8") for name in library_names()} | {
    kind: template_text(kind) for kind in KINDS
}
WITH_LAW = [name for name, text in TEXTS.items() if "lift_law" in tomllib.loads(text)]
LAW = "kind = 'polynomial'\nmaximum_lift = '8 mm'\nopening_start = '100 deg'\nopening_end = '180 deg'\n"
LAW += "closing_start = '180 deg'\nclosing_end = '250 deg'\n"
DOTTED = "".join(f"lift_law.{line}\n" for line in LAW.splitlines())


@pytest.fixture
def workspace(tmp_path):
    return Workspace(tmp_path / "bench")


def law(workspace, name):
    return tomllib.loads(workspace.text(name))["lift_law"]


@pytest.mark.parametrize("name", WITH_LAW)
def test_every_change_of_the_law_is_taken_back(workspace, name):
    """Of every case and template, also with another server; what both kinds know stays."""
    case = workspace.new_case("mine", name)
    before, kinds, texts = workspace.text(case), [], []
    for kind in (
        registered_names("lifts") if name == "spring" else ("zero", "polynomial", "cycloidal")
    ):
        text = workspace.text(case)
        try:
            workspace.change_law(case, kind)
        except InputError as error:
            assert error.where == "lift_law.kind" and workspace.text(case) == text
        else:
            kinds.append(law(workspace, case)["kind"])
            texts += [text] if workspace.text(case) != text else []
    assert {"zero", "polynomial", "cycloidal"} <= set(kinds) and workspace.read(case)
    again = Workspace(workspace.folder)
    for text in reversed(texts):
        again.undo(case)
        assert again.text(case) == text
    assert again.text(case) == before and again.last_change(case) is None


def test_an_undo_never_takes_what_was_written_otherwise(workspace):
    case = workspace.upload("mine.toml", SMALL.encode())
    with pytest.raises(InputError, match="no change"):
        workspace.undo(case)
    workspace.change_law(case, "zero")
    path = workspace.case_folder(case) / "case.toml"
    written = path.read_text("utf-8") + "\n# by hand\n"
    path.write_text(written, "utf-8")
    assert workspace.last_change(case) is None
    with pytest.raises(InputError, match="no change"):
        workspace.undo(case)
    workspace.set_value(case, "spring.mass", "45 g")
    workspace.undo(case)
    assert workspace.text(case) == written
    assert workspace.last_change(workspace.duplicate(case)) is None


@pytest.mark.parametrize(
    "text",
    [
        f"{SPRING}[lift_law] # of the test\n# read off\n{LAW}\n# what moves it\n[operation]\nengine_speeds = '4000 rpm'\n",
        f"{DOTTED}{SPRING}",
        f"lift_law = {{ {', '.join(LAW.splitlines())} }}\n{SPRING}",
        f"{SPRING}[lift_law]\n{LAW}[lift_law.exponents]\nvalue = '3-4-5'\nstatus = 'assumed'\n",
        f"[lift_law]\n{LAW}{SPRING}",
        f"{SPRING}[lift_law]\n{LAW}".rstrip(),
    ],
    ids=["comments", "dotted", "inline", "table below", "first", "no last line end"],
)
def test_however_a_law_is_written_another_kind_keeps_what_it_knows(workspace, text):
    case = workspace.upload("mine.toml", text.encode())
    told = law(workspace, case)
    workspace.change_law(case, "cycloidal")
    told.pop("exponents", None)
    assert law(workspace, case) == {**told, "kind": "cycloidal"}
    workspace.change_law(case, "zero")
    assert law(workspace, case) == {"kind": "zero"}
    assert "# what moves it" not in text or "# what moves it" in workspace.text(case)
    workspace.undo(case)
    workspace.undo(case)
    assert workspace.text(case) == text
