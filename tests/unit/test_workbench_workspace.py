"""The workspace: cases put in, changed and taken out, runs found, and no name that leads out of it.

Evidence: what stands on disk afterwards, and the reader of case files on it.
"""

from __future__ import annotations

import json
import os
import zipfile

import pytest

from valvetrain.errors import InputError
from valvetrain.parameters.bounded_file import SIDE_FILES_VARIABLE
from valvetrain.parameters.loading import LIBRARY, parse_case
from valvetrain.runs.saved_runs import collect_inputs, find_run
from valvetrain.workbench.edits import read_change
from valvetrain.workbench.jobs import JobRequest, Jobs
from valvetrain.workbench.workspace import MAX_CASES, Workspace
from workbench_parts import SMALL, kept


@pytest.fixture
def workspace(tmp_path):
    return Workspace(tmp_path / "bench")


def test_every_case_and_template_of_the_library_becomes_a_case_that_reads_the_same(workspace):
    cards = workspace.library()
    assert {card.kind for card in cards} == {"library", "template"} and len(cards) >= 12
    for card in cards:
        name = workspace.new_case(f"my {card.name}", card.name)
        assert name == f"my-{card.name}"
        found = workspace.read(name)
        if card.kind == "library":
            path = LIBRARY / f"{card.name}.toml"
            assert found == parse_case(path.read_text("utf-8"), name, LIBRARY)
    assert {card.name for card in workspace.cases()} == {f"my-{card.name}" for card in cards}


def test_a_value_is_set_as_on_the_command_line_and_comments_stay(workspace):
    name = workspace.upload("small.toml", SMALL.encode())
    workspace.set_value(name, "spring.mass", "45 g")
    text = workspace.text(name)
    assert 'mass = "45 g" # weighed' in text and "drawing 17" in text
    due = parse_case(SMALL, name, changes={"spring.mass": "45 g"})
    assert workspace.read(name).springs == due.springs
    workspace.set_value(name, "spring.installed_height", "35 mm")
    assert "drawing 17" not in workspace.text(name), (
        "the source of the earlier value is none of the new one"
    )
    workspace.set_value(name, "spring.options.multi-mass.elements", "7")
    assert workspace.read(name).springs[0].options["multi-mass"] == {"elements": 7}
    workspace.set_value(name, "title", "24")
    assert workspace.read(name).title == "24"
    workspace.set_value(name, "spring.options.multi-mass.elements", "")
    assert "elements" not in workspace.text(name)


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("spring.mass", "42 mm", "'42 mm' is a length, but a mass is needed here"),
        ("spring.mass", "42", "unit"),
        ("spring.mass", "-1 g", "too small"),
        ("spring.mas", "1 g", "did you mean mass"),
        ("spring.mass.x", "1 g", "spring.mass"),
        ("spring.0.mass", "1 g", "spring"),
        ("lift_law.kind", "polynom", "polynomial"),
        ("lift_law.closing_start", "170 deg", "must come after"),
        ("operation.cycles", "2.5", "integer"),
        ("", "1", "sets nothing"),
    ],
)
def test_a_refused_value_changes_nothing_and_says_what_the_reader_says(
    workspace, key, value, words
):
    name = workspace.upload("small.toml", SMALL.encode())
    with pytest.raises(InputError) as refused:
        workspace.set_value(name, key, value)
    assert words in str(refused.value) and workspace.text(name) == SMALL


@pytest.mark.parametrize("key", ["operation.engine_speeds", "spring.mass", "spring"])
def test_what_a_case_can_do_without_is_taken_away(workspace, key):
    name = workspace.upload("small.toml", SMALL.encode())
    workspace.set_value(name, key, "")
    assert key.rpartition(".")[2] not in workspace.text(name) and workspace.read(name)


def test_what_is_no_case_is_refused_with_the_readers_sentence(workspace):
    for content, words in (
        (b"", "empty"),
        (b"\xff\xfe", "no text file"),
        (b"x = [", "not valid TOML"),
        (b"x = 1", "unknown"),
        (b" " * 5_000_001, "larger than 5 MB"),
    ):
        with pytest.raises(InputError, match=words):
            workspace.upload("a.toml", content)
    assert not workspace.cases() and not list(workspace.jobs_folder.iterdir())
    name = workspace.upload("small.toml", SMALL.encode())
    with pytest.raises(InputError, match="not valid TOML"):
        workspace.parse(name, "x = [")
    assert workspace.text(name) == SMALL


@pytest.mark.parametrize(
    "file", ["/etc/passwd", "../secret.csv", "a/../../b.csv", "..\\b.csv", ".hidden"]
)
def test_a_case_names_no_file_elsewhere(workspace, file):
    """Whatever reads the case later would open it: refused when it comes in, by upload, by text and
    by value.
    """
    table = f"[lift_law]\nkind = 'measured'\nfile = {json.dumps(file)}\n"
    with pytest.raises(InputError, match="not next to the case"):
        workspace.upload("a.toml", table.encode())
    name, law = (
        workspace.upload("small.toml", SMALL.encode()),
        f"{{ kind = 'table', file = {json.dumps(file)} }}",
    )
    study = {"quantity": "lift_law.file", "lowest": file}
    with Jobs(workspace) as jobs:
        for change in (
            lambda: workspace.parse(name, table),
            lambda: workspace.set_value(name, "lift_law.file", file),
            lambda: workspace.set_value(name, "lift_law", law),
            lambda: read_change(SMALL, "lift_law.file", file),
            lambda: jobs.submit(JobRequest("study", name, study)),
        ):
            with pytest.raises(InputError, match="not next to the case"):
                change()


@pytest.mark.parametrize("file", ["/etc/hostname", "../case.toml", "a/b.csv", "linked.csv"])
def test_the_process_of_a_job_opens_no_file_elsewhere(tmp_path, monkeypatch, file):
    """Whatever came past the door, the reader of a job and of a slider opens what lies beside the
    case and nothing else.
    """
    os.symlink("/etc/hostname", tmp_path / "linked.csv")
    text = f"[lift_law]\nkind = 'table'\nfile = {json.dumps(file)}\nangle_of = 'cam'\nangle_unit = 'deg'\nlift_unit = 'mm'\n"
    with pytest.raises(InputError) as opened:
        parse_case(text, "case", tmp_path)
    assert "elsewhere than next to the case" not in str(opened.value)
    monkeypatch.setenv(SIDE_FILES_VARIABLE, "1")
    with pytest.raises(InputError, match="elsewhere than next to the case"):
        parse_case(text, "case", tmp_path)
    with pytest.raises(InputError):
        collect_inputs("case", text, tmp_path, {})


def test_a_table_beside_a_case_is_read_and_goes_with_its_copies(workspace):
    angles = "\n".join(
        f"{place * 10} {max(0.0, 9 - abs(place - 18)) ** 2 / 9:.4f}" for place in range(36)
    )
    table = (
        SMALL.split("[lift_law]")[0]
        + "[lift_law]\nkind = 'table'\nfile = 'lift.txt'\nangle_of = 'cam'\nangle_unit = 'deg'\nlift_unit = 'mm'\nlift_of = 'valve'\n"
    )
    name = workspace.upload("measured.toml", table.encode(), {"lift.txt": angles.encode()})
    copy = workspace.duplicate(name)
    assert workspace.files(copy) == {"lift.txt": angles.encode()}
    assert workspace.read(copy).lift_law == workspace.read(name).lift_law
    with pytest.raises(InputError):
        workspace.attach(name, "../lift.txt", b"x")
    with pytest.raises(InputError, match="at most"):
        workspace.attach(name, "big.txt", b"x" * 20_000_001)


def test_cases_are_copied(workspace):
    name = workspace.upload("small.toml", ("name = 'old'\n" + SMALL).encode())
    assert workspace.read(name).name == "small"
    assert workspace.upload("small.toml", SMALL.encode()) == "small-2"
    assert workspace.duplicate(name) == "small-3"
    assert workspace.read("small-3").name == "small-3"
    with pytest.raises(InputError, match="no case 'other'"):
        workspace.text("other")
    assert {card.name for card in workspace.cases()} == {"small", "small-2", "small-3"}
    assert Workspace(workspace.folder).cases() == workspace.cases(), "another server finds the same"


def test_links_are_not_followed(workspace, tmp_path):
    outside = tmp_path / "outside"
    outside.mkdir()
    (outside / "case.toml").write_text(SMALL)
    os.symlink(outside, workspace.cases_folder / "linked")
    run_id = kept(workspace)
    folder = workspace.runs_folder / run_id
    os.symlink(outside / "case.toml", folder / "report.html")
    os.symlink(outside, folder / "more")
    os.symlink(folder.parent, workspace.runs_folder / "elsewhere")
    assert [card.name for card in workspace.cases() if card.fault] == ["linked"]
    for call in (
        lambda: workspace.text("linked"),
        lambda: workspace.download(run_id, "report"),
        lambda: workspace.run(f"elsewhere/{folder.name}"),
    ):
        with pytest.raises(InputError):
            call()
    with zipfile.ZipFile(workspace.download(run_id, "data")) as archive:
        assert {name.rpartition("/")[2] for name in archive.namelist()} == {"case.toml", "run.json"}
    assert (outside / "case.toml").exists()


def test_runs_are_those_of_the_run_store(workspace, monkeypatch):
    first = kept(workspace, report_html="<html>", quantities_csv="a\n1\n")
    second = kept(workspace, "other", "2026-01-02T00:00:00+00:00")
    assert [run.run_id for run in workspace.runs()] == [second, first]
    assert [run.run_id for run in workspace.runs("small")] == [first]
    run = workspace.run(first)
    assert find_run(first, workspace.runs_folder).answer == run.answer and run.models == (
        "massless",
    )
    assert workspace.download(first, "case").read_text() == SMALL
    assert workspace.download(first, "report") == run.page
    with zipfile.ZipFile(workspace.download(first, "csv")) as archive:
        assert [name.rpartition("/")[2] for name in archive.namelist()] == ["quantities.csv"]
    for kind in ("case", "data", "report", "csv"):
        assert workspace.download(first, kind).resolve().is_relative_to(workspace.folder.resolve())
    with pytest.raises(InputError, match="no report page"):
        workspace.download(second, "report")
    with pytest.raises(InputError, match="none of case"):
        workspace.download(first, "../x")  # type: ignore[arg-type]


def test_a_second_server_and_another_layout_are_refused(workspace):
    release = workspace.hold()
    with pytest.raises(InputError, match="another server works"):
        Workspace(workspace.folder).hold()
    release()
    Workspace(workspace.folder).hold()()
    with workspace.store.connected() as base:
        base.execute("PRAGMA user_version=99")
    with pytest.raises(InputError, match="another version"):
        Workspace(workspace.folder)
    workspace.store.path.write_bytes(b"no database" * 100)
    with pytest.raises(InputError, match="cannot be used"):
        Workspace(workspace.folder)


def test_cases_are_bounded(workspace):
    for place in range(MAX_CASES):
        (workspace.cases_folder / f"c{place}").mkdir()
    with pytest.raises(InputError, match=f"there are {MAX_CASES} cases"):
        workspace.upload("small.toml", SMALL.encode())


def test_a_solid_height_above_what_the_lift_needs_is_refused_as_by_the_command(tmp_path):
    """Contract: the field says what a run would say; a case that is bound already may be mended in steps."""
    workspace = Workspace(tmp_path)
    case = workspace.new_case("own", "pushrod")
    key, before = "train.springs.card.0.solid_height", workspace.text("own")
    with pytest.raises(InputError, match="reaches coil bind"):
        workspace.set_value(case, key, "1.245 in")
    assert workspace.text(case) == before
    workspace.set_value(case, key, "1.0 in")
    assert '"1.0 in"' in workspace.text(case)
    path = workspace.case_folder(case) / "case.toml"
    path.write_text(workspace.text(case).replace('"1.0 in"', '"1.245 in"'), "utf-8")
    workspace.set_value(case, key, "1.24 in")
    assert '"1.24 in"' in workspace.text(case)
