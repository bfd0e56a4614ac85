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
from valvetrain.workbench.lift_laws import STORE, law_of, with_law, with_law_of
from valvetrain.workbench.workspace import Workspace
from workbench_parts import SMALL, SPRING

TEXTS = {name: (LIBRARY / f"{name}.toml").read_text("utf-8") for name in library_names()} | {
    kind: template_text(kind) for kind in KINDS
}
WITH_LAW = [name for name, text in TEXTS.items() if "lift_law" in tomllib.loads(text)]
LAW = "kind = 'polynomial'\nmaximum_lift = '8 mm'\nopening_start = '100 deg'\nopening_end = '180 deg'\n"
LAW += "closing_start = '180 deg'\nclosing_end = '250 deg'\n"
DOTTED = "".join(f"lift_law.{line}\n" for line in LAW.splitlines())
LIFTS = b"\n".join(
    b"%d %.4f" % (place * 10, max(0.0, 9 - abs(place - 18)) ** 2 / 9) for place in range(36)
)


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


def test_a_long_law_is_kept_whole(workspace):
    angles = ", ".join(f"{place / 4:.6f}" for place in range(900))
    lifts = ", ".join(f"{max(0.0, 9 - abs(place / 25 - 18)) ** 2 / 9:.9f}" for place in range(900))
    table = f"kind = 'table'\ncam_angles = '{angles} deg'\nlifts = '{lifts} mm'\n"
    case = workspace.upload("mine.toml", f"{SPRING}[lift_law]\n{table}".encode())
    before = workspace.text(case)
    assert len(before) > 15_000
    workspace.change_law(case, "polynomial")
    Workspace(workspace.folder).change_law(case, "table")
    assert workspace.text(case) == before


def test_what_was_set_is_kept_and_what_was_only_begun_is_made_anew(workspace):
    case = workspace.upload("mine.toml", SMALL.encode())
    workspace.change_law(case, "cycloidal")
    workspace.change_law(case, "polynomial")
    workspace.set_value(case, "lift_law.maximum_lift", "10 mm")
    workspace.change_law(case, "cycloidal")
    assert law(workspace, case)["maximum_lift"] == "10 mm", (
        "what both kinds know stays: nobody had set anything of this one"
    )
    workspace.set_value(case, "lift_law.maximum_lift", "11 mm")
    workspace.change_law(case, "polynomial")
    assert law(workspace, case)["maximum_lift"] == "10 mm"
    workspace.change_law(case, "cycloidal")
    assert law(workspace, case)["maximum_lift"] == "11 mm"


def test_notes_stand_over_the_law_that_they_describe(workspace):
    notes = "status = 'published'\nsource = 'key, figure 3'\nzero_of_angle = 'nose at 180'\n"
    case = workspace.upload("mine.toml", f"{SPRING}[lift_law]\n{notes}{LAW}".encode())
    workspace.change_law(case, "cycloidal")
    assert not {"status", "source"} & set(law(workspace, case))
    assert law(workspace, case)["zero_of_angle"] == "nose at 180", "its angles are the same"
    for kind in ("zero", "modified-sine"):
        workspace.change_law(case, kind)
        assert not {"status", "source", "zero_of_angle"} & set(law(workspace, case)), kind
    workspace.attach(case, "lift.txt", LIFTS)
    workspace.change_law(case, "polynomial")
    assert workspace.text(case) == f"{SPRING}[lift_law]\n{notes}{LAW}"
    workspace.change_law(case, "measured")
    assert not {"status", "source", "zero_of_angle"} & set(law(workspace, case))
    workspace.change_law(case, "polynomial")
    assert workspace.text(case) == f"{SPRING}[lift_law]\n{notes}{LAW}"


def test_what_is_kept_of_a_law_is_no_file_of_the_case(workspace):
    case = workspace.upload("mine.toml", SMALL.encode())
    workspace.change_law(case, "zero")
    assert (workspace.case_folder(case) / STORE).is_file()
    assert (
        workspace.files(case) == {}
        and workspace.side_files(case) == []
        and workspace.stamps(case) == ()
    )
    for call in (
        lambda: workspace.side_file(case, STORE),
        lambda: workspace.attach(case, STORE, b"{}"),
        lambda: workspace.detach(case, STORE),
    ):
        with pytest.raises(InputError):
            call()
    copy, renamed = workspace.duplicate(case), workspace.rename(case, "other")
    for one in (copy, renamed):
        workspace.change_law(one, "polynomial")
        assert workspace.text(one) == SMALL
    workspace.delete(renamed)
    assert {path.name for path in workspace.cases_folder.iterdir()} == {copy}


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


@pytest.mark.parametrize("kind", ["table", "spline", "measured"])
def test_the_file_that_reads_becomes_the_lift_law(workspace, kind):
    """It was the first by its name, whatever stood in it."""
    case = workspace.upload("small.toml", SMALL.encode())
    workspace.attach(case, "a-readme.txt", b"hello")
    with pytest.raises(InputError, match=r"a-readme.txt.*download"):
        workspace.change_law(case, kind)
    assert workspace.text(case) == SMALL and not (workspace.case_folder(case) / STORE).exists()
    workspace.attach(case, "b-lift.txt", LIFTS)
    workspace.attach(case, "c-notes.txt", b"a word")
    workspace.change_law(case, kind)
    assert law(workspace, case)["file"] == "b-lift.txt" and max(
        workspace.read(case).lift_law.values["lifts"]
    ) == pytest.approx(9e-3, rel=1e-3)


def test_a_law_whose_file_has_gone_is_made_of_another_or_refused(workspace):
    case = workspace.upload("small.toml", SMALL.encode())
    workspace.attach(case, "lift.txt", LIFTS)
    workspace.change_law(case, "table")
    workspace.set_value(case, "lift_law.degree", "7")
    workspace.change_law(case, "polynomial")
    workspace.detach(case, "lift.txt")
    with pytest.raises(
        InputError, match=r"are no longer readable \(.*lift.txt.*add it below 'Files of this case'"
    ):
        workspace.change_law(case, "table")
    workspace.attach(case, "other.txt", LIFTS)
    workspace.change_law(case, "table")
    assert law(workspace, case)["file"] == "other.txt"
    workspace.change_law(case, "polynomial")
    workspace.attach(case, "lift.txt", LIFTS)
    workspace.change_law(case, "table")
    assert (law(workspace, case)["file"], law(workspace, case)["degree"]) == ("lift.txt", 7), (
        "what was told before was not overwritten"
    )


def test_a_case_that_takes_no_other_law_says_so(monkeypatch):
    monkeypatch.setattr(
        "valvetrain.workbench.lift_laws.saved", lambda document: SMALL
    )  # a writer that loses what it was given
    with pytest.raises(InputError, match="change it in the case file itself"):
        with_law_of(f"{DOTTED}{SPRING}", law_of(SMALL))


def test_a_kind_of_law_that_is_none_is_refused():
    for kind in ("nonsense", "", "__init__"):
        with pytest.raises(InputError, match="unknown"):
            with_law(SMALL, kind, [])
