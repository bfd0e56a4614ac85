"""A lift law of another kind, and back: nothing that was told is lost, nothing stands over what it
does not describe.

Evidence: the text of the case file before and after, the reader of case files, what stands on disk.
"""

from __future__ import annotations

import os
import tomllib

import pytest

from valvetrain.errors import InputError
from valvetrain.parameters.loading import LIBRARY, library_names
from valvetrain.parameters.templates import KINDS, template_text
from valvetrain.registry import names as registered_names
from valvetrain.workbench.lift_laws import STORE, with_law
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
def test_a_kind_that_is_chosen_again_has_the_values_it_had(workspace, name):
    """Of every case and template, also with another server; of one, one kind after the other as the
    arrow of a closed list does.
    """
    case = workspace.new_case("mine", name)
    before, kind = workspace.text(case), law(workspace, case)["kind"]
    for other in (
        registered_names("lifts") if name == "spring" else ("zero", "polynomial", "cycloidal")
    ):
        try:
            workspace.change_law(case, other)
        except InputError as error:
            assert error.where == "lift_law.kind"
    assert law(workspace, case)["kind"] not in (kind, "zero") or name == "pushrod", (
        "its card tells the ratio of the lever, too"
    )
    again = Workspace(workspace.folder)
    again.change_law(case, kind)
    assert again.text(case) == before
    again.change_law(case, kind)
    assert again.text(case) == before


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
def test_however_a_law_is_written_it_comes_back(workspace, text):
    case = workspace.upload("mine.toml", text.encode())
    for other in ("cycloidal", "zero", "polynomial"):
        workspace.change_law(case, other)
    assert tomllib.loads(workspace.text(case)) == tomllib.loads(text)
    assert text.startswith("lift_law") or workspace.text(case) == text


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\xff",
        b"[1]",
        b'{"told": 1}',
        b'{"told": {"polynomial": "x = ["}}',
        b'{"told": {"polynomial": 3}}',
        b'{"told": {"polynomial": "[lift_law]\\nkind = 4"}, "begun": {"zero": "="}}',
        b'{"told": {"polynomial": "[lift_law]\\nkind = \'zero\'"}}',
        b'{"told": {"polynomial": "[other]\\nx = 1"}}',
        None,
    ],
)
def test_what_is_kept_may_be_damaged(workspace, tmp_path, content):
    case = workspace.upload("mine.toml", SMALL.encode())
    workspace.change_law(case, "zero")
    path = workspace.case_folder(case) / STORE
    path.unlink()
    (tmp_path / "outside").write_text("{}")
    os.symlink(tmp_path / "outside", path) if content is None else path.write_bytes(content)
    workspace.change_law(case, "polynomial")
    assert law(workspace, case)["maximum_lift"]["status"] == "assumed"
    assert (tmp_path / "outside").read_text() == "{}" and not path.is_symlink()


def test_a_kind_of_law_that_is_none_is_refused():
    for kind in ("nonsense", "", "__init__"):
        with pytest.raises(InputError, match="unknown"):
            with_law(SMALL, kind, [])
