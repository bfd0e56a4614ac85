"""A workbench as a process of its own on a disk of its own, and requests to it over real sockets."""

from __future__ import annotations

import http.client
import json
import os
import random
import resource
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from valvetrain.workbench.job_process import write_inputs
from valvetrain.workbench.jobs import JobRequest
from valvetrain.workbench.requests import STORED
from valvetrain.workbench.workspace import Workspace
from workbench_parts import SMALL, wait_for

PAGE = {"accept": "text/html"}
#: What a text of this begins with, and what is repeated in it -> kept from costing more than its length.
PATHOLOGICAL = {
    "deep": "[" + ".".join("a" * 100_000) + "]\n",
    "speeds": SMALL.replace('"4000 rpm"', '"' + "4000," * 600_000 + '4000 rpm"'),
    "tables": "[[a]]\n" * 500_000,
    "dotted": "".join(f"a{row}.{'.'.join('b' * 30)} = 1\n" for row in range(9_000)),
    "escapes": 'a = "' + "\\n" * 2_000_000 + '"\n',
}


class Server:
    """A server in ``folder``.

    Parameters
    ----------
    folder : its workspace
    options : further words of the command
    descriptors : files and sockets that it may have open
    variables : further variables of its environment
    """

    def __init__(
        self,
        folder: Path,
        *options: str,
        descriptors: int = 1024,
        variables: dict[str, str] | None = None,
    ) -> None:
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        plain = {
            name: value
            for name, value in os.environ.items()
            if not name.startswith(("PYTEST_", "NICEGUI_"))
        }
        plain |= {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
        self.log = folder.with_name(f"{folder.name}-log.txt")
        words = ("--folder", str(folder), "--port", str(self.port), "--no-open", *options)
        with self.log.open("wb") as stream:
            self.process = subprocess.Popen(
                [sys.executable, "-m", "valvetrain", "serve", *words],
                env=plain | (variables or {}),
                start_new_session=True,
                stderr=stream,
                preexec_fn=lambda: resource.setrlimit(
                    resource.RLIMIT_NOFILE, (descriptors, descriptors)
                ),
            )
        wait_for(lambda: f":{self.port}/" in self.told or self.process.poll() is not None)
        assert self.process.poll() is None, self.told

    @property
    def told(self) -> str:
        """What it has printed."""
        return self.log.read_text("utf-8", "replace")

    @property
    def memory(self) -> float:
        """Memory that it holds (bytes)."""
        pages = Path(f"/proc/{self.process.pid}/statm").read_text("ascii").split()[1]
        return int(pages) * os.sysconf("SC_PAGE_SIZE")

    @property
    def spent(self) -> float:
        """Processor time that it has taken (s)."""
        stat = Path(f"/proc/{self.process.pid}/stat").read_text("ascii").rpartition(")")[2].split()
        return sum(map(int, stat[11:13])) / os.sysconf("SC_CLK_TCK")

    def get(
        self, path: str, heads: dict[str, str] | None = None
    ) -> tuple[int, dict[str, str], str]:
        """Status, headers and text of an answer."""
        return self._visit("GET", path, None, heads or {})

    def post(self, path: str, body: bytes, kind: str) -> tuple[int, dict[str, str], str]:
        """The same, of an upload by a page of the server."""
        origin = f"http://127.0.0.1:{self.port}"
        return self._visit("POST", path, body, {"content-type": kind, "origin": origin})

    def _visit(
        self, method: str, path: str, body: bytes | None, heads: dict[str, str]
    ) -> tuple[int, dict[str, str], str]:
        visit = http.client.HTTPConnection("127.0.0.1", self.port, timeout=30)
        try:
            visit.request(method, path, body, heads)
            answer = visit.getresponse()
            text = answer.read().decode("utf-8", "replace")
            return answer.status, {name.lower(): value for name, value in answer.getheaders()}, text
        finally:
            visit.close()

    def seconds(self, path: str = "/") -> float:
        """How long a page takes that is answered."""
        begun = time.monotonic()
        status, _, body = self.get(path, {"accept": "text/html"})
        assert status == 200, (status, body[:300], self.told[-2000:])
        return time.monotonic() - begun

    def door(self) -> socket.socket:
        """A connection on which nothing has been said."""
        return socket.create_connection(("127.0.0.1", self.port), timeout=10)

    def pour(self, begin: bytes, piece: bytes, most: int) -> int:
        """Send ``begin`` and then pieces without an end; the bytes that were taken."""
        sent = 0
        with self.door() as door:
            try:
                door.sendall(begin)
                while sent < most:
                    door.sendall(piece)
                    sent += len(piece)
            except OSError:
                pass
        return sent

    def end(self) -> int:
        """End it as the system does; its exit code."""
        self.process.send_signal(signal.SIGTERM)
        return self.process.wait(30)


@contextmanager
def served(folder: Path, *options: str, **more: object) -> Iterator[Server]:
    """A server that ends with the block."""
    server = Server(folder, *options, **more)  # type: ignore[arg-type]
    try:
        yield server
    finally:
        if server.process.poll() is None:
            os.killpg(server.process.pid, signal.SIGKILL)
            server.process.wait(10)


@contextmanager
def disk(folder: Path, size: str) -> Iterator[Path]:
    """A file system of its own at ``folder``."""
    folder.mkdir()
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "none", folder], check=True)
    try:
        yield folder
    finally:
        subprocess.run(["umount", "-l", folder], check=True)


def may_mount() -> bool:
    """Whether this process may mount file systems."""
    return (
        hasattr(os, "getuid")
        and os.getuid() == 0
        and subprocess.run(["unshare", "-m", "true"], capture_output=True).returncode == 0
    )


def filled(folder: Path) -> Path:
    """Fill the disk of a folder; the file that holds all of it."""
    path = folder / "filler"
    with path.open("wb", buffering=0) as stream:
        for size in (1 << 20, 1 << 12, 1):
            try:
                while True:
                    stream.write(b"x" * size)
            except OSError:
                continue
    return path


def queue(folder: Path, name: str) -> None:
    """Put a job into the queue, as a page does."""
    workspace, request = Workspace(folder), JobRequest("run", "small", {"models": ["massless"]})
    write_inputs(workspace, name, request, workspace.text("small"))
    with workspace.store.connected() as base:
        base.execute(
            "INSERT INTO jobs (id, case_name, kind, request, state, created_at) VALUES (?, ?, ?, ?, 'queued', ?)",
            (name, request.case, request.kind, STORED.dump_json(request).decode(), time.time()),
        )


def job(server: Server) -> dict[str, object]:
    """The newest job of the small case."""
    status, _, body = server.get("/job/small")
    assert status == 200, (status, body[:200], server.told[-2000:])
    return json.loads(body) or {}


def case_in(folder: Path, name: str | bytes, content: bytes = SMALL.encode()) -> Path:
    """A case that somebody put there."""
    path = os.path.join(os.fsencode(folder), b"cases", os.fsencode(name))
    os.makedirs(path)
    with open(os.path.join(path, b"case.toml"), "wb") as stream:
        stream.write(content)
    return Path(os.fsdecode(path))


def damaged_answer(text: str, seed: int) -> bytes:
    """A damaged ``run.json``, by a series of kinds."""
    dice = random.Random(seed)
    answer = json.loads(text)
    answer.pop("checksum", None)
    kinds = (
        lambda: text[: dice.randrange(len(text))].encode(),
        lambda: text.encode("utf-16"),
        lambda: bytes(dice.randrange(256) for _ in range(300)),
        lambda: b"[" * 100_000,
        lambda: b"[]" * (seed % 2),
        lambda: text.replace("small", "other").encode(),
        lambda: json.dumps(answer | {dice.choice([*answer]): dice.choice(VALUES)}).encode(),
        lambda: json.dumps(answer | {dice.choice(OTHER): dice.choice(VALUES)}).encode(),
    )
    return kinds[seed % len(kinds)]()


#: What a damaged entry holds, and entries that a run may lack.
VALUES = (None, 7, -1e308, "x", "\ud800", "<b>", [], [None], {}, {"a": [1]}, True, "a" * 3000, [{}])
OTHER = (
    "runs", "quantities", "quantities_by_label", "failures", "title", "verdict", "choices", "files", "command", "created_at",
)  # fmt: skip
