"""One fault does not stop a workbench: a full disk, a disk that may not be written, connections
without an end, folders and files as people and strangers leave them.

Evidence: servers in processes of their own, on a disk of their own, met over real sockets.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import socket
import subprocess
import time
from pathlib import Path
from urllib.parse import quote

import pytest

from server_parts import (
    PAGE,
    PATHOLOGICAL,
    case_in,
    damaged_answer,
    disk,
    filled,
    job,
    may_mount,
    queue,
    served,
)
from valvetrain.parameters.loading import LIBRARY
from valvetrain.workbench.workspace import Workspace
from workbench_parts import SMALL, damaged_page, kept, page_with, wait_for
from yardstick import slowness

pytest.importorskip("nicegui")
pytestmark = pytest.mark.skipif(
    os.name != "posix" or not may_mount(), reason="makes disks of its own, which takes root"
)
#: Longest time of a page while others do what they can (s), on a machine that does other things too.
PATIENCE = 3.0


@pytest.fixture(scope="module")
def room(tmp_path_factory):
    """A disk of its own with a workspace and one case."""
    with disk(tmp_path_factory.mktemp("faults") / "disk", "64m") as made:
        Workspace(made / "bench")
        case_in(made / "bench", "small")
        yield made


@pytest.fixture(scope="module")
def server(room):
    """A server of 1 024 descriptors on that disk."""
    with served(room / "bench") as one:
        one.seconds()
        yield one


@pytest.mark.slow
def test_a_disk_that_fills_while_a_job_runs_costs_that_job_alone(room, server):
    """The slot stayed taken for ever, pages failed, and tracebacks were written by the megabyte."""
    queue(room / "bench", "20260101-000000-00000001")
    wait_for(lambda: job(server).get("state") == "running")
    filler, before = filled(room), len(server.told)
    try:
        wait_for(lambda: job(server)["state"] not in ("queued", "running"))
        for page in ("/", "/case/small", "/runs"):
            server.seconds(page)
    finally:
        filler.unlink()
    queue(room / "bench", "20260101-000000-00000002")
    wait_for(lambda: job(server).get("state") == "finished", 60)
    with Workspace(room / "bench").store.connected() as base:
        states = [row["state"] for row in base.execute("SELECT state FROM jobs ORDER BY id")]
    assert states[0] in ("failed", "finished") and states[1] == "finished", "written again later"
    assert len(server.told) - before < 2000 and "Traceback" not in server.told


def test_connections_that_say_nothing_take_nothing_from_others(room, server):
    """1 100 of them took every descriptor, and the thread that starts jobs ended."""
    idle = []
    try:
        for _ in range(1100):
            try:
                idle.append(server.door())
            except OSError:
                break
        assert len(idle) > 1000
        assert server.seconds() < PATIENCE
        queue(room / "bench", "20260101-000000-00000003")
        closed = [one for one in idle if is_closed(one)]
        assert len(closed) > 800, "few wait at a time"
        wait_for(lambda: all(map(is_closed, idle)), 30)
        wait_for(lambda: job(server).get("state") == "finished", 60)
    finally:
        for one in idle:
            one.close()
    assert "Traceback" not in server.told


def is_closed(door: socket.socket) -> bool:
    """Whether the other end is gone."""
    door.setblocking(False)
    try:
        return door.recv(1) == b""
    except BlockingIOError:
        return False
    except OSError:
        return True


@pytest.mark.parametrize(
    ("begin", "piece"),
    [
        (b"GET / HTTP/1.1\r\nhost: x\r\na: ", b"a" * 100_000),
        (b"GET /", b"a" * 100_000),
        (b"GET / HTTP/1.1\r\nhost: x\r\n", b"a: b\r\n" * 20_000),
        (b"", b"\r\n" * 50_000),
    ],
    ids=["one header", "address", "many headers", "blank lines"],
)
def test_a_head_without_an_end_is_ended(server, begin, piece):
    """800 MB of it were taken, and as much memory three times."""
    before = server.memory
    assert server.pour(begin, piece, 60_000_000) < 20_000_000
    assert server.seconds() < PATIENCE and server.memory - before < 50e6


def test_what_a_terminal_obeys_is_not_logged(server):
    """Any site can send a browser here by a redirect."""
    for sign in ("%1b]0;owned%07", "a%0ab", "%c2%9b31m", "%e2%80%ae", "%7f", "a" * 5000):
        assert server.get(f"/{sign}", PAGE)[0] in (403, 404)
        assert server.get(f"/case/{sign}", PAGE)[0] < 500
    assert all(sign.isprintable() or sign == "\n" for sign in server.told)
    assert max(map(len, server.told.splitlines())) < 1000


def test_folders_as_people_make_them_are_listed_with_what_is_wrong(room, server):
    """Each of them failed the start page for everybody."""
    odd = {
        "thing (copy)": SMALL.encode(),
        "my spring": SMALL.encode(),
        "a&b": SMALL.encode(),
        b"caf\xe9": SMALL.encode(),
        "latin": ("# Länge\n" + SMALL).encode("latin-1"),
        "wide": SMALL.encode("utf-16"),
        "torn": b"[spring\n",
        "empty": b"",
        "script": b"title = '<script>alert(1)</script>'\n[spring",
    }
    odd |= {f"slow-{name}": text.encode() for name, text in PATHOLOGICAL.items()}
    folders = [case_in(room / "bench", name, content) for name, content in odd.items()]
    (room / "bench" / "cases" / "folder" / "case.toml").mkdir(parents=True)
    (room / "bench" / "cases" / "linked").symlink_to(folders[0])
    try:
        before = server.spent
        server.seconds()
        assert (server.spent - before) / slowness() < 2.0
        _, _, body = server.get("/", PAGE)
        for name in ("thing (copy)", "my spring", "caf", "latin", "wide", "torn", "slow-deep"):
            assert name in body, name
        assert "UTF-8" in body and "no name of a file" in body
        for name in odd:
            place = f"/case/{quote(name)}"
            begun = server.spent
            for path in (place, f"/job/{quote(name)}", f"/download-case/{quote(name)}"):
                assert server.get(path, PAGE)[0] < 500, path
            assert (server.spent - begun) / slowness() < 2.0, name
    finally:
        for folder in (*folders, room / "bench" / "cases" / "folder"):
            shutil.rmtree(os.fsencode(folder))
        (room / "bench" / "cases" / "linked").unlink()


@pytest.mark.parametrize("name", PATHOLOGICAL)
def test_a_text_that_is_no_case_is_refused_before_it_is_read(server, name):
    """200 kB of one header held a core for 15 s."""
    mark, content = "--end", PATHOLOGICAL[name].encode()[:4_900_000]
    head = f'--{mark}\r\nContent-Disposition: form-data; name="a"; filename="x.toml"\r\n\r\n'
    body = head.encode() + content + f"\r\n--{mark}--\r\n".encode()
    begun = server.spent
    status, _, answer = server.post("/upload/case", body, f"multipart/form-data; boundary={mark}")
    assert status == 200 and "refusal" in answer, answer[:300]
    assert (server.spent - begun) / slowness() < 1.0


def test_scripts_in_the_report_of_a_stranger_do_not_run(room, server):
    """Texts stay texts, and what holds them is no page."""
    strange = '<script>document.title = "run"</script>'
    report = page_with({"text": strange, "next_step": strange}, {"data-x": strange})
    run_id = kept(Workspace(room / "bench"), report_html=report)
    for place in (f"/part/{run_id}", f"/part-compare?a={run_id}&b={run_id}"):
        _, heads, body = server.get(place, PAGE)
        assert heads["content-type"].startswith(("application/json", "text/plain"))
        assert "sha256" not in heads["content-security-policy"]
        assert heads["x-content-type-options"] == "nosniff"
        assert "<script" not in body
    assert "document.title" in server.get(f"/part/{run_id}")[2], "it is shown"
    shutil.rmtree(room / "bench" / "runs")


def test_damaged_runs_are_listed_and_say_so(room, server):
    """They were missing without a word, or failed the page."""
    bench = Workspace(room / "bench")
    for seed in range(48):
        run_id = kept(bench, created=f"2026-01-01T00:00:{seed:02}+00:00", report_html="<p>\xe4")
        path = bench.runs_folder / run_id / "run.json"
        path.write_bytes(damaged_answer(path.read_text("utf-8"), seed))
        report = path.with_name("report.html")
        report.write_bytes((b"", b"\xff\xfe" * 9, damaged_page(seed))[seed % 3])
        for place in ("run", "part"):
            status, _, body = server.get(f"/{place}/{run_id}", PAGE)
            assert status < 500, (seed, place, body[:300], server.told[-1500:])
    for page in ("/", "/runs", "/compare", "/case/small"):
        server.seconds(page)
    assert server.get("/runs", PAGE)[2].count("damaged: ") >= 24
    runs = [run.run_id for run in bench.runs()]
    for run_id in runs[:12]:
        status, _, body = server.get(f"/part-compare?a={run_id}&b={runs[-1]}", PAGE)
        assert status < 500, body[:300]
    shutil.rmtree(bench.runs_folder)


def test_a_missing_file_of_a_run_is_named(room, server):
    bench = Workspace(room / "bench")
    run_id = kept(bench)
    path = bench.runs_folder / run_id / "run.json"
    answer = json.loads(path.read_text("utf-8"))
    del answer["checksum"]
    for name in ("run-0001.nc", "../../../other.nc"):
        path.write_text(json.dumps(answer | {"files": [name]}))
        (bench.folder / "other.nc").write_bytes(b"")
        _, _, body = server.post(f"/upload/test?run={run_id}&name=a.csv", b"1,2\n", "text/csv")
        assert "missing" in body and name.rpartition("/")[2] in body
    shutil.rmtree(bench.runs_folder)


def test_no_archive_is_written_through_a_link(room, server):
    bench, elsewhere = Workspace(room / "bench"), room / "elsewhere"
    elsewhere.mkdir()
    run_id = kept(bench, report_html="<p>")
    shutil.rmtree(bench.jobs_folder / "downloads", ignore_errors=True)
    (bench.jobs_folder / "downloads").symlink_to(elsewhere)
    status, _, body = server.get(f"/download/{run_id}/data")
    assert status == 404 and "link" in body and not list(elsewhere.iterdir())
    (bench.jobs_folder / "downloads").unlink()
    assert server.get(f"/download/{run_id}/data")[0] == 200


def test_a_damaged_database_is_named_on_the_page(room, server):
    """Every page failed, and each look of an open page wrote a traceback."""
    path, before = room / "bench" / "workbench.sqlite", len(server.told)
    content, state = path.read_bytes(), job(server).get("state")
    path.write_bytes(b"x" * len(content))
    try:
        assert server.get("/", PAGE)[0] == 200, "the lists of cases and runs need no database"
        for page in ("/case/small", "/job/small") * 10:
            assert "workbench.sqlite" in server.get(page, PAGE)[2]
        assert server.get("/runs", PAGE)[0] == 200
        assert "Traceback" not in server.told and len(server.told) - before < 2000
    finally:
        path.write_bytes(content)
    wait_for(lambda: job(server).get("state") == state)


@pytest.mark.slow
def test_a_workspace_that_becomes_read_only_is_shown_and_ended_well(room, server):
    """The last test of this server: it ends here."""
    bench = room / "bench"
    queue(bench, "20260101-000000-00000009")
    subprocess.run(["mount", "--bind", bench, bench], check=True)
    try:
        subprocess.run(["mount", "-o", "remount,bind,ro", bench], check=True)
        server.seconds("/")
        server.seconds("/case/small")
        time.sleep(6)
        assert server.get("/job/small")[0] == 200
        assert (
            server.end() == 0 and "Traceback" not in server.told and "fault in" not in server.told
        )
        again = subprocess.run(
            [*server.process.args[:3], "serve", "--folder", bench, "--port", "0", "--no-open"],
            capture_output=True, text=True, timeout=60, env=os.environ | {"PYTHONPATH": str(Path("src").absolute())},
        )  # fmt: skip
        assert again.returncode == 2 and re.search("read-?only", again.stderr), again.stderr
    finally:
        subprocess.run(["umount", "-l", bench], check=True)


def test_the_token_is_nobody_elses_and_400_cases_are_listed_in_a_second(tmp_path):
    """It is not in the list of processes nor in the address of one who is known, and the right one
    is taken after any number of wrong ones."""
    token, large = "a-token-of-this-test", (LIBRARY / "gu2021-beehive.toml").read_bytes()
    for place in range(400):
        case_in(tmp_path / "bench", f"case-{place}", large)
    with served(tmp_path / "bench", variables={"VALVETRAIN_TOKEN": token}) as server:
        words = Path(f"/proc/{server.process.pid}/cmdline").read_bytes()
        assert token.encode() not in words and server.get("/")[0] == 401
        assert [server.get(f"/?token=wrong-{n}")[0] for n in range(25)][-1] == 429
        status, heads, _ = server.get(f"/?token={token}")
        assert status == 303
        cookie = {"cookie": heads["set-cookie"].partition(";")[0]}
        status, heads, _ = server.get(f"/runs?token={token}&a=1", cookie)
        assert status == 303 and heads["location"] == "/runs?a=1"
        assert server.get("/", cookie)[0] == 200
        before = server.spent
        assert server.get("/", cookie)[2].count("/case/case-") >= 400
        assert (server.spent - before) / slowness() < 1.0
