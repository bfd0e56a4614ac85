"""Files beside a case and tests over a run: put there, listed, handed out and taken away over the
addresses of the server, all guarded.

Evidence: what stands on disk afterwards, the reader of case files on it, contract of HTTP as
browsers keep it, names and bytes of any kind.
"""

from __future__ import annotations

import asyncio
import os
import zipfile
from typing import Any

import pytest

from valvetrain.errors import InputError
from valvetrain.runs.saved_runs import find_run, list_saved_runs
from valvetrain.workbench.jobs import Jobs
from valvetrain.workbench.saved_runs import (
    MAX_TESTS,
    keep_test,
    remove_test,
    saved_test,
    saved_tests,
)
from valvetrain.workbench.side_files import MAX_FILES, check_bounds
from valvetrain.workbench.workspace import Workspace
from workbench_parts import BAD_NAMES, SMALL, SPRING, TABLE, kept, lifts

OWN = "http://127.0.0.1:8420"
OURS = {"origin": OWN}


async def in_parts() -> Any:
    """More than may be sent, whose length is not told before."""
    yield b'--x\r\nContent-Disposition: form-data; name="file"; filename="a.toml"\r\n\r\n'
    for _ in range(2):
        yield b"x" * 150_000


@pytest.fixture
def workspace(tmp_path):
    return Workspace(tmp_path / "bench")


class Browser:
    """What asks an application as a page of its own would, unless told otherwise by ``headers``."""

    def __init__(self, app: Any) -> None:
        self.app = app

    def ask(
        self, method: str, path: str, headers: dict[str, str] | None = None, **more: Any
    ) -> Any:
        """The answer to one request."""
        import httpx

        async def answer() -> Any:
            async with httpx.AsyncClient(
                transport=httpx.ASGITransport(app=self.app), base_url=OWN
            ) as line:
                return await line.request(
                    method, path, headers=OURS if headers is None else headers, **more
                )

        return asyncio.run(answer())

    def get(self, path: str) -> Any:
        """The answer to a link."""
        return self.ask("GET", path)

    def post(self, path: str, **more: Any) -> Any:
        """What is answered to something sent."""
        return self.ask("POST", path, **more)


@pytest.fixture
def client(workspace):
    """A browser before the addresses of parts and files, with the guard between."""
    pytest.importorskip("nicegui")
    from fastapi import FastAPI

    from valvetrain.workbench.pages import files
    from valvetrain.workbench.pages.desk import Desk
    from valvetrain.workbench.pages.guard import Guard
    from valvetrain.workbench.settings import ServeSettings

    app, bounds = FastAPI(), ServeSettings(most_body=200_000)
    with Jobs(workspace) as jobs:
        files.register(app, Desk(workspace, jobs, bounds))
        app.add_middleware(Guard, settings=bounds)
        yield Browser(app)


def test_a_table_is_sent_named_handed_out_and_removed(workspace, client):
    case = workspace.upload("small.toml", SMALL.encode())
    assert client.post(f"/upload/file?case={case}&name=lift.txt", content=lifts()).json() == {
        "file": "lift.txt"
    }
    (file,) = workspace.side_files(case)
    assert (file.name, file.size, file.is_named) == ("lift.txt", len(lifts()), False)
    answer = client.get(f"/case-file/{case}/lift.txt")
    assert answer.content == lifts() and answer.headers["content-disposition"].startswith(
        "attachment"
    )
    assert answer.headers["content-type"] == "application/octet-stream"
    path = workspace.case_folder(case) / "case.toml"
    path.write_text(SPRING + TABLE)
    assert workspace.side_files(case)[0].is_named
    with pytest.raises(InputError, match="names this file, so it stays"):
        workspace.detach(case, "lift.txt")
    assert workspace.read(case).lift_law is not None
    path.write_text(SMALL)
    workspace.detach(case, "lift.txt")
    assert (
        workspace.side_files(case) == ()
        and client.get(f"/case-file/{case}/lift.txt").status_code == 404
    )


def test_another_content_of_a_named_file_is_taken_only_where_the_case_still_reads(
    workspace, client
):
    case = workspace.upload("small.toml", (SPRING + TABLE).encode(), {"lift.txt": lifts()})
    refused = client.post(f"/upload/file?case={case}&name=lift.txt", content=b"no table").json()[
        "refusal"
    ]
    assert "lift.txt" in refused and workspace.files(case) == {"lift.txt": lifts()}
    before = workspace.read(case).lift_law
    assert client.post(f"/upload/file?case={case}&name=lift.txt", content=lifts(8.0)).json() == {
        "file": "lift.txt"
    }
    assert workspace.read(case).lift_law != before


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("case.toml", "case file"),
        ("CASE.TOML", "case file"),
        ("other.toml", "case file"),
        ("answer.json", "for its own"),
        *((name, "") for name in BAD_NAMES),
    ],
)
def test_no_file_takes_the_place_of_another_or_lies_elsewhere(workspace, client, name, words):
    case = workspace.upload("small.toml", SMALL.encode())
    before = sorted(path for path in workspace.folder.rglob("*") if "sqlite" not in path.name)
    answers = [
        client.post("/upload/file", params={"case": one, "name": other}, content=b"x")
        for one, other in ((case, name), (name, "a.csv"))
    ]
    refusals = [
        answer.json()["refusal"] if answer.status_code == 200 else answer.text for answer in answers
    ]
    assert all(refusals) and words in refusals[0]
    assert (
        sorted(path for path in workspace.folder.rglob("*") if "sqlite" not in path.name) == before
    )
    assert workspace.text(case) == SMALL


@pytest.mark.parametrize(
    "name",
    [
        "case.toml",
        "../../workbench.sqlite",
        "..%2f..%2fworkbench.sqlite",
        "%2e%2e",
        ".hidden",
        "linked.csv",
        "a\\b",
        "none.csv",
    ],
)
def test_nothing_but_a_file_beside_the_case_is_handed_out_or_removed(workspace, client, name):
    case = workspace.upload("small.toml", SMALL.encode())
    os.symlink("/etc/hostname", workspace.case_folder(case) / "linked.csv")
    (workspace.case_folder(case) / ".hidden").write_text("x")
    assert client.get(f"/case-file/{case}/{name}").status_code in (403, 404)
    assert client.get(f"/case-file/{name}/case.toml").status_code in (403, 404)
    with pytest.raises(InputError):
        workspace.detach(case, name)
    assert workspace.text(case) == SMALL and workspace.side_files(case) == ()


@pytest.mark.parametrize(
    ("method", "path"),
    [
        ("POST", "/upload/file?case=small&name=a.csv"),
        ("POST", "/upload/case"),
        ("POST", "/upload/test?run=small/x&name=a.csv"),
        ("GET", "/case-file/small/a.csv"),
        ("GET", "/part-test/small/x/a.csv"),
    ],
)
def test_every_address_of_files_is_guarded(workspace, client, method, path):
    """As each request: another site, a foreign name, nothing told, and more than may be sent."""
    case = workspace.upload("small.toml", SMALL.encode())
    workspace.attach(case, "a.csv", b"1")
    for heads in (
        {"origin": "http://evil.example"},
        OURS | {"host": "evil.example:8420"},
        OURS | {"sec-fetch-site": "cross-site"},
    ):
        assert client.ask(method, path, heads, content=b"x").status_code == 403
    if method == "POST":
        form = OURS | {"content-type": "multipart/form-data; boundary=x"}
        assert client.ask("POST", path, {}, content=b"x").status_code == 403
        assert client.ask("POST", path, form, content=b"x" * 200_001).status_code == 413
        assert client.ask("POST", path, form, content=in_parts()).status_code == 413
    assert workspace.files(case) == {"a.csv": b"1"} and len(workspace.cases()) == 1


def test_files_beside_a_case_are_bounded(workspace, client):
    case = workspace.upload("small.toml", SMALL.encode())
    for place in range(MAX_FILES):
        assert client.post(f"/upload/file?case={case}&name=f{place}.csv", content=b"1").json() == {
            "file": f"f{place}.csv"
        }
    assert (
        f"at most {MAX_FILES} files"
        in client.post(f"/upload/file?case={case}&name=g.csv", content=b"1").json()["refusal"]
    )
    assert client.post(f"/upload/file?case={case}&name=f0.csv", content=b"2").json() == {
        "file": "f0.csv"
    }, "in the place of an earlier one"
    with pytest.raises(InputError, match="20 MB"):
        check_bounds({"a.csv": bytes(10_000_001), "b.csv": bytes(10_000_000)}, "a.csv")


def test_a_case_and_the_table_it_names_are_sent_together(workspace, client):
    case, table = ("file", ("mine.toml", SPRING + TABLE)), ("file", ("lift.txt", lifts()))
    alone = client.post("/upload/case", files=[case]).json()["refusal"]
    assert "'lift.txt', which was not sent with it" in alone and "together" in alone
    assert client.post("/upload/case", files=[table, case]).json() == {"open": "/case/mine"}
    assert (
        workspace.files("mine") == {"lift.txt": lifts()}
        and workspace.read("mine").lift_law is not None
    )
    assert (
        "of which 0 are case files"
        in client.post("/upload/case", files=[table, table]).json()["refusal"]
    )
    assert (
        "of which 2 are case files"
        in client.post("/upload/case", files=[case, case, table]).json()["refusal"]
    )
    assert client.post("/upload/case", files=[case, ("file", ("../lift.txt", lifts()))]).json()[
        "refusal"
    ]
    assert client.post("/upload/case", files=[case] * (MAX_FILES + 2)).json()["refusal"]
    assert client.post("/upload/case", content=b"plain").json()["refusal"]
    broken = {
        "content": b"--x\r\nbroken",
        "headers": OURS | {"content-type": "multipart/form-data; boundary=x"},
    }
    assert client.post("/upload/case", **broken).json()["refusal"]
    assert [card.name for card in workspace.cases()] == ["mine"]


def test_a_test_stays_with_its_run_and_is_none_of_its_results(workspace, client):
    run_id = kept(workspace, quantities_csv="a\n1\n")
    before, run = find_run(run_id, workspace.runs_folder).answer, workspace.run(run_id)
    one = keep_test(run, "cycles-no-2.csv", b"a;b")
    assert one.name == "cycles-no-2.csv" and one.path.read_bytes() == b"a;b"
    assert keep_test(run, one.name, b"a;b;c").size == 5 and len(saved_tests(run)) == 1
    assert (
        find_run(run_id, workspace.runs_folder).answer == before
        and len(list_saved_runs(root=workspace.runs_folder)) == 1
    )
    assert [other.run_id for other in workspace.runs()] == [run_id]
    for kind, names in (
        ("data", {"case.toml", "run.json", "quantities.csv"}),
        ("csv", {"quantities.csv"}),
    ):
        with zipfile.ZipFile(workspace.download(run_id, kind)) as archive:
            assert {name.rpartition("/")[2] for name in archive.namelist()} == names
    assert saved_tests(Workspace(workspace.folder).run(run_id)) == saved_tests(run), (
        "another server finds it"
    )
    for place in range(MAX_TESTS - 1):
        keep_test(run, f"t{place}.csv", b"1")
    with pytest.raises(InputError, match=f"at most {MAX_TESTS} tests"):
        keep_test(run, "more.csv", b"1")
    for name in (*BAD_NAMES, "../quantities.csv", "none.csv"):
        with pytest.raises(InputError):
            remove_test(run, name)
    for found in saved_tests(run):
        remove_test(run, found.name)
    assert not (run.folder / "laid-over").exists()
    with pytest.raises(InputError, match="25 MB"):
        keep_test(run, "large.csv", bytes(25_000_001))


def test_tests_over_a_run_lead_nowhere_else(workspace, client, tmp_path):
    run_id = kept(workspace)
    run = workspace.run(run_id)
    os.symlink(tmp_path, run.folder / "laid-over")
    (tmp_path / "secret.csv").write_text("x")
    assert saved_tests(run) == []
    with pytest.raises(InputError, match="link"):
        keep_test(run, "a.csv", b"1")
    (run.folder / "laid-over").unlink()
    keep_test(run, "a.csv", b"1")
    os.symlink(tmp_path / "secret.csv", run.folder / "laid-over" / "linked.csv")
    with pytest.raises(InputError):
        saved_test(run, "linked.csv")
    for name in ("linked.csv", "../run.json", "%2e%2e%2frun.json", "none.csv"):
        assert client.get(f"/part-test/{run_id}/{name}").status_code in (403, 404)
    answer = client.get(f"/part-test/{run_id}/a.csv")
    assert answer.status_code == 404 and answer.text, "a run without curves says so"
    for name in BAD_NAMES:
        assert client.post(
            "/upload/test", params={"run": name, "name": "a.csv"}, content=b"1"
        ).json()["refusal"]
