"""Names of any kind: files beside a case, tests over a run, cases and what a job writes of them;
none takes the place of another.

Evidence: what stands on disk afterwards, drawn names and bytes, the contract of HTTP.
"""

from __future__ import annotations

import asyncio
from pathlib import Path
from types import SimpleNamespace

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from valvetrain.workbench import saved_runs as saved_tests
from valvetrain.workbench.job_process import study_file, write_inputs
from valvetrain.workbench.jobs import JobRequest, Jobs
from valvetrain.workbench.saved_runs import keep_test, remove_test, saved_name
from valvetrain.workbench.store import checked_name
from valvetrain.workbench.workspace import Workspace
from workbench_parts import SMALL, SPRING, TABLE, kept, lifts


@pytest.fixture
def workspace(tmp_path):
    return Workspace(tmp_path / "bench")


def test_two_tests_never_take_the_place_of_each_other(workspace):
    """Their names differ beyond what a name here may hold, or in what is left out of it."""
    stem = "2027-03-14-head3-beehive-production-batch-A-cycles-at"
    pairs = [
        (f"{stem}-5600-rpm.csv", f"{stem}-5800-rpm.csv"),
        ("a b.csv", "a(b.csv"),
        ("a..b.csv", "a.b.csv"),
        ("-a.csv", "a.csv"),
        ("a.csv\u0301", "a.csv"),
        ("a." + "x" * 20, "a." + "x" * 21),
        ("\u00e9.csv", "e\u0301.csv"),
    ]
    run = workspace.run(kept(workspace))
    for one, other in pairs:
        names = [keep_test(run, one, b"1").name, keep_test(run, other, b"22").name]
        assert (
            len({checked_name(name) for name in names}) == 2
            and len(saved_tests.saved_tests(run)) == 2
        )
        assert (
            keep_test(run, one, b"333").name == names[0] and len(saved_tests.saved_tests(run)) == 2
        )
        assert {test.size for test in saved_tests.saved_tests(run)} == {2, 3}
        for name in names:
            remove_test(run, name)
    assert saved_name("cycles-2.nc") == "cycles-2.nc" and saved_name(
        f"{stem}-5600-rpm.csv"
    ).endswith(".csv")


@pytest.mark.parametrize("name", ["study", "Study", "small"])
def test_a_study_of_any_case_has_two_files(workspace, name):
    case = workspace.upload(f"{name}.toml", SMALL.encode())
    request = JobRequest(
        "study",
        case,
        study="outputs = ['preload']\n[[vary]]\nkey = 'spring.mass'\nvalues = '1, 2 g'\n",
    )
    write_inputs(workspace, "one", request, SMALL)
    folder = workspace.jobs_folder / "one"
    assert (folder / f"{case}.toml").read_text() == SMALL and "outputs" in (
        folder / study_file(case)
    ).read_text()
    assert f'case = "{case}.toml"' in (folder / study_file(case)).read_text()


_PART = b'--x\r\nContent-Disposition: form-data; name="file"; filename="%s"\r\n\r\n%s\r\n'


@pytest.fixture
def served(workspace, monkeypatch):
    """The addresses of files of a workspace with a case and a run; a test that begins with ``a;``
    can be laid over it.
    """
    pytest.importorskip("nicegui")
    httpx = pytest.importorskip("httpx")
    from fastapi import FastAPI

    from valvetrain.workbench.pages import files
    from valvetrain.workbench.pages.desk import Desk
    from valvetrain.workbench.settings import ServeSettings

    app, reached, real = FastAPI(), set(), files.against

    def against(run, name, content):
        reached.add(name)
        return (
            SimpleNamespace(runs=(1,), failures=())
            if content.startswith(b"a;")
            else real(run, name, content)
        )

    def post(path, **more):
        async def answer():
            async with httpx.AsyncClient(
                transport=httpx.ASGITransport(app=app), base_url="http://127.0.0.1"
            ) as line:
                return await line.post(path, **more)

        return asyncio.run(answer())

    def get(path):
        async def answer():
            async with httpx.AsyncClient(
                transport=httpx.ASGITransport(app=app), base_url="http://127.0.0.1"
            ) as line:
                return await line.get(path)

        return asyncio.run(answer())

    monkeypatch.setattr(files, "against", against)
    monkeypatch.setattr(files, "test_part", lambda found: "")
    workspace.upload("small.toml", (SPRING + TABLE).encode(), {"lift.txt": lifts()})
    with Jobs(workspace) as jobs:
        files.register(app, Desk(workspace, jobs, ServeSettings()))
        yield SimpleNamespace(post=post, get=get, run=kept(workspace), reached=reached)


NAMES = st.one_of(
    st.text(max_size=30),
    st.from_regex(r"[\w .+-]{1,70}\.[a-z]{1,4}", fullmatch=True),
    st.sampled_from(["lift.txt", "case.toml"]),
)


@settings(
    max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    name=NAMES,
    content=st.one_of(st.binary(max_size=60), st.binary(max_size=9).map(b"a;".__add__)),
    torn=st.integers(0, 40),
)
def test_whatever_is_sent_is_answered_in_a_sentence(workspace, served, name, content, torn):
    """Names and contents of any kind, whole and torn off, to a case and a run that are there; what
    is no sentence would be raised here.
    """
    body = (
        _PART % (b"a.toml", content)
        + _PART % (name.encode("utf-8", "replace").replace(b"\n", b" "), content)
        + b"--x--\r\n"
    )
    answer = served.post(
        "/upload/case",
        content=body[: len(body) - torn],
        headers={"content-type": "multipart/form-data; boundary=x"},
    )
    assert answer.status_code == 200 and answer.json()["refusal"]
    run = workspace.run(served.run)
    for path, taken, place in (
        ("/upload/file", "file", workspace.case_folder("small")),
        ("/upload/test", "test", run.folder / "laid-over"),
    ):
        answer = served.post(
            path, params={"case": "small", "run": served.run, "name": name}, content=content
        )
        assert answer.status_code == 200
        ((kind, words),) = answer.json().items()
        assert words and kind in (taken, "refusal")
        there = {one.name for one in place.iterdir()} if place.exists() else set()
        assert all(checked_name(one) == one for one in there)
        if kind == taken:
            assert (place / words).read_bytes() == content
            remove_test(run, words) if taken == "test" else workspace.detach("small", words)
    assert workspace.text("small") == SPRING + TABLE and workspace.files("small") == {
        "lift.txt": lifts()
    }
    assert (
        len(workspace.cases()) == 1
        and workspace.read("small")
        and not (run.folder / "laid-over").exists()
    )
    assert Path(name).name in served.reached
