"""Requests of strangers to a workbench, and what happens to its disk: one fault does not stop it."""

from __future__ import annotations

import http.client
import os
import shutil
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from random import Random
from urllib.parse import quote

from faults import inputs
from server_parts import (
    PAGE,
    PATHOLOGICAL,
    Server,
    case_in,
    damaged_answer,
    filled,
    job,
    queue,
)
from valvetrain.workbench.workspace import Workspace
from workbench_parts import damaged_page, kept, wait_for

#: Longest time of a page (s), longest text in the log and most memory (bytes) for one attack.
PATIENCE, LOG, MEMORY = 5.0, 3000, 200e6
PLACES = ("/", "/runs", "/compare", "/case/small", "/job/small", "/part/small/x", "/upload/case", "/download/x/data", "/_nicegui/x")  # fmt: skip


class Bench:
    """A workbench as a process of its own, on a disk of its own."""

    def __init__(self, disk: Path) -> None:
        self.folder, self.jobs = disk / "bench", 0
        self.space = Workspace(self.folder)
        case_in(self.folder, "small")
        self.server = Server(self.folder)
        self.server.seconds()

    def trial(self, chance: Random) -> tuple[str, list[str]]:
        """One attack, and what it broke."""
        attack: Callable[[Bench, Random], None] = chance.choice(ATTACKS)
        before, memory, broken = len(self.server.told), self.server.memory, []
        try:
            attack(self, chance)
            if (seconds := self.server.seconds()) > PATIENCE:
                broken.append(f"the start page took {seconds:.1f} s")
            if self.server.memory - memory > MEMORY:
                broken.append(f"memory grew by {(self.server.memory - memory) / 1e6:.0f} MB")
        except (AssertionError, OSError, http.client.HTTPException) as error:
            broken.append(f"{type(error).__name__}: {str(error)[:500]}")
        told = self.server.told[before:]
        if "Traceback" in told or len(told) > LOG:
            broken.append(f"the log has {len(told)} characters: {told[:1000]}")
        if not told.replace("\n", "").isprintable():
            broken.append("the log has what a terminal obeys")
        if self.server.process.poll() is not None:
            broken.append(f"it ended with {self.server.process.returncode}")
            self.server = Server(self.folder)
        return (attack.__doc__ or "").rstrip("."), broken

    def runs_a_job(self) -> None:
        """Start a job and wait for its end."""
        self.jobs += 1
        name = f"20260101-000000-{self.jobs:08d}"
        queue(self.folder, name)
        wait_for(lambda: job(self.server).get("state") == "finished", 90)


@contextmanager
def bench_on(disk: Path) -> Iterator[Bench]:
    """A workbench that ends with the block."""
    bench = Bench(disk)
    try:
        yield bench
    finally:
        bench.server.end()


def _visit(bench: Bench, path: str) -> None:
    status, _, body = bench.server.get(path, PAGE)
    assert status < 500, f"{path}: {status} {body[:200]}"


def strange(bench: Bench, chance: Random) -> None:
    """A request of any method, path, header and body"""
    words = [chance.choice(inputs.TEXTS + inputs.NUMBERS) for _ in range(3)]
    path, value, body = (word.encode("utf-8", "surrogatepass") for word in words)
    place = f"{chance.choice(PLACES)}{chance.choice(('', '/', '?a=', '?token='))}{quote(path)}"
    method = chance.choice(("GET", "GET", "POST", "PUT", "HEAD", "OPTIONS", "DELETE"))
    head = chance.choice(("cookie", "origin", "host", "content-type", "range", "accept", "upgrade"))
    with bench.server.door() as door, suppress(ConnectionError):
        begin = f"{method} {place} HTTP/1.1\r\nconnection: close\r\ncontent-length: {len(body)}\r\n{head}: "  # fmt: skip
        door.sendall(begin.encode() + value + b"\r\n\r\n" + body)
        answer = door.recv(100)
        assert not answer.startswith(b"HTTP/1.1 5"), (begin, value, answer)


def silent(bench: Bench, chance: Random) -> None:
    """Hundreds of connections that say nothing"""
    doors = []
    try:
        for _ in range(chance.randint(100, 1100)):
            doors.append(bench.server.door())
        assert bench.server.seconds() < PATIENCE, "the start page waits"
    finally:
        for door in doors:
            door.close()


def endless(bench: Bench, chance: Random) -> None:
    """A head without an end"""
    begin = chance.choice((b"GET / HTTP/1.1\r\nhost: x\r\na: ", b"GET /", b"", b"POST / HTTP/1.1\r\n"))  # fmt: skip
    piece = chance.choice((b"a", b"a: b\r\n", b"\r\n", b"\0", b"\xff")) * 20_000
    assert bench.server.pour(begin, piece, 60_000_000) < 20_000_000, "all of it is taken"


def folder(bench: Bench, chance: Random) -> None:
    """A folder of any name with a damaged case"""
    name = chance.choice(inputs.TEXTS)[:60].encode("utf-8", "surrogatepass")
    name = name.replace(b"/", b"").replace(b"\0", b"").strip(b".") or b"caf\xe9"
    texts = (inputs.case_mutant(chance), chance.choice(list(PATHOLOGICAL.values())).encode())
    made = case_in(bench.folder, name, chance.choice(texts))
    try:
        for path in ("/", *(f"/{place}/{quote(name)}" for place in ("case", "job", "download-case"))):  # fmt: skip
            _visit(bench, path)
    finally:
        shutil.rmtree(os.fsencode(made))


def saved_run(bench: Bench, chance: Random) -> None:
    """A saved run that is damaged"""
    text = chance.choice(
        ("<p>\xe4", "\xff\xfe", "<script>", damaged_page(chance.randrange(10**6)).decode())
    )
    run_id = kept(bench.space, report_html=text)
    path = bench.space.runs_folder / run_id / "run.json"
    path.write_bytes(damaged_answer(path.read_text("utf-8"), chance.randrange(10**6)))
    try:
        pages = (f"/{place}/{run_id}" for place in ("run", "part", "download"))
        for page in ("/runs", "/compare", f"/part-compare?a={run_id}&b={run_id}", *pages):
            _visit(bench, page)
    finally:
        shutil.rmtree(bench.space.runs_folder)


def upload(bench: Bench, chance: Random) -> None:
    """A damaged case that is uploaded"""
    content = chance.choice((inputs.case_mutant(chance), PATHOLOGICAL["deep"].encode()))
    head = b'--x\r\nContent-Disposition: form-data; name="a"; filename="x.toml"\r\n\r\n'
    body, begun = head + content[:4_900_000] + b"\r\n--x--\r\n", bench.server.spent
    status, _, answer = bench.server.post("/upload/case", body, "multipart/form-data; boundary=x")
    assert status < 500, f"{status} {answer[:200]}"
    assert bench.server.spent - begun < PATIENCE, "it takes too long"


def full_disk(bench: Bench, chance: Random) -> None:
    """A disk that is full, or may not be written, while a job runs"""
    name, disk = f"full-{chance.randrange(10**6)}", bench.folder.parent
    queue(bench.folder, f"20260101-000000-{name}")
    time.sleep(chance.uniform(0, 3))
    read_only = chance.random() < 0.3
    if read_only:
        again = ["mount", "-o", "remount,ro", str(disk)]
        read_only = subprocess.run(again, capture_output=True).returncode == 0
    filler = None if read_only else filled(disk)
    try:
        for page in ("/", "/case/small", "/runs"):
            _visit(bench, page)
        time.sleep(chance.uniform(0, 3))
    finally:
        if filler is None:
            subprocess.run(["mount", "-o", "remount,rw", disk], check=True)
        else:
            filler.unlink()
    wait_for(lambda: job(bench.server).get("state") not in ("queued", "running"), 90)
    bench.runs_a_job()


ATTACKS = (strange, strange, strange, silent, endless, folder, folder, saved_run, saved_run, upload, full_disk)  # fmt: skip
