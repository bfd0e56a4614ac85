"""``valvetrain serve``: what it refuses before it serves, the token it prints, and its end.

Evidence: what the command prints, the settings that reach the pages, and ports of this machine.
"""

from __future__ import annotations

import os
import re
import signal
import socket
import subprocess
import sys
import time

import pytest

from unit.cli_parts import call, hear_interrupts, sentence
from valvetrain.workbench import command, pages
from valvetrain.workbench.workspace import Workspace


@pytest.fixture
def started(monkeypatch, tmp_path):
    """What reached the pages, which end at once as by Ctrl-C."""
    seen = []

    def start(workspace, jobs, settings, listening):
        seen.append((workspace, jobs, settings))
        listening()
        raise KeyboardInterrupt

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(pages, "start", start)
    monkeypatch.setattr(command, "find_spec", lambda _: True)
    return seen


def test_it_listens_on_this_machine_alone_and_ends_cleanly(started, tmp_path):
    result = call("serve", "--no-open", "--port", "0", "--most-running", "2", "--limit", "30 min")
    assert result.exit_code == 0, result.stderr
    workspace, jobs, settings = started[0]
    assert (
        settings.host == "127.0.0.1"
        and settings.port > 0
        and not settings.token
        and not settings.open_page
    )
    assert (
        f"workbench 'workbench' at http://127.0.0.1:{settings.port}/" in result.stderr
        and "has ended" in result.stderr
    )
    assert workspace.folder == tmp_path / "workbench" and (
        jobs.most_running,
        jobs.limits.seconds,
        jobs.limits.bytes,
    ) == (2, 1800.0, 4e9)
    assert call("serve", "--no-open", "--port", "0").exit_code == 0, "the workspace was given back"


def test_the_address_is_printed_when_it_answers_and_not_before(started, monkeypatch):
    """Contract: it was printed 1.7 to 2.7 s before anything listened; a server that never does prints none."""

    def start(workspace, jobs, settings, listening):
        raise KeyboardInterrupt

    monkeypatch.setattr(pages, "start", start)
    told = call("serve", "--no-open", "--port", "0", "--host", "0.0.0.0").stderr
    assert "http://" not in told and "token" not in told and "has ended" in told


def test_another_address_gets_a_random_token_that_is_printed_once(started, monkeypatch):
    result = call("serve", "--no-open", "--port", "0", "--host", "0.0.0.0", "--quiet")
    assert result.exit_code == 0
    token = started[0][2].token
    assert (
        len(token) >= 32
        and result.stderr.count(token) == 1
        and re.search(r"http://127.0.0.1:\d+/\?token=", result.stderr)
    )
    assert (
        call("serve", "--no-open", "--port", "0", "--host", "0.0.0.0").exit_code == 0
        and started[1][2].token != token
    )
    monkeypatch.setenv("VALVETRAIN_TOKEN", "x" * 20)
    assert call("serve", "--no-open", "--port", "0").exit_code == 0
    assert started[2][2].token == "x" * 20 and "VALVETRAIN_TOKEN" not in os.environ
    assert call("serve", "--no-open", "--port", "0", "--token").exit_code == 0
    assert len(started[3][2].token) >= 32


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--host", "nowhere.invalid"), "is no address"),
        (("--host", "192.0.2.1"), "with port 8420 cannot be used"),
        (("--port", "70000"), "is outside"),
        (("--limit", "3 x"), "is no bound"),
        (("--most-running", "0"), "is outside"),
        (("--folder", ""), "empty"),
        (("--host", ""), "is no address"),
    ],
)
def test_what_cannot_be_served_is_refused_in_one_sentence(started, words, told):
    result = call("serve", "--no-open", *words)
    assert result.exit_code == 2 and told in sentence(result) and not started


def test_a_short_token_is_refused(started, monkeypatch):
    monkeypatch.setenv("VALVETRAIN_TOKEN", "short")
    result = call("serve", "--no-open", "--port", "0")
    assert result.exit_code == 2 and "VALVETRAIN_TOKEN" in sentence(result) and not started


def test_a_taken_port_and_a_held_workspace_are_refused(started, tmp_path):
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = str(other.getsockname()[1])
        assert f"port {port} cannot be used" in sentence(call("serve", "--no-open", "--port", port))
    release = Workspace(tmp_path / "held").hold()
    result = call("serve", "--no-open", "--port", "0", "--folder", "held")
    release()
    assert result.exit_code == 2 and "another server works in" in sentence(result) and not started
    (tmp_path / "file").write_text("")
    assert "cannot be used" in sentence(
        call("serve", "--no-open", "--port", "0", "--folder", "file")
    )


def test_without_nicegui_the_sentence_names_the_extra(started, monkeypatch):
    monkeypatch.setattr(command, "find_spec", lambda _: None)
    result = call("serve", "--no-open", "--port", "0")
    assert (
        result.exit_code == 2
        and 'pip install "valvetrain[serve]"' in sentence(result)
        and not started
    )


@pytest.mark.skipif(os.name != "posix", reason="servers are ended by signals")
@pytest.mark.parametrize("name", ["SIGINT", pytest.param("SIGHUP", marks=pytest.mark.long)])
def test_a_signal_ends_a_server_without_a_traceback(tmp_path, name):
    """A real server in a process of its own: it raises the signal again within its loop when it has
    ended.
    """
    pytest.importorskip("uvicorn")
    code = (
        "import sys, uvicorn; from valvetrain.workbench import command, pages; from valvetrain.cli import main\n"
        "async def app(scope, receive, send):\n"
        "    while (await receive())['type'] != 'lifespan.startup': pass\n"
        "    print('serves', flush=True)\n"
        "    await send({'type': 'lifespan.startup.complete'}); await receive(); await send({'type': 'lifespan.shutdown.complete'})\n"
        "pages.start = lambda workspace, jobs, settings, listening: uvicorn.run(app, port=settings.port, log_level='error')\n"
        "command.find_spec = lambda _: True\n"
        "sys.argv = ['valvetrain', 'serve', '--no-open', '--port', '0']; main.main()"
    )
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "preexec_fn": hear_interrupts}
    server = subprocess.Popen([sys.executable, "-c", code], cwd=tmp_path, text=True, **pipes)
    assert server.stdout is not None and server.stdout.readline() == "serves\n"
    time.sleep(0.2)  # until it listens
    server.send_signal(getattr(signal, name))
    told = server.communicate(timeout=60)[1]
    assert (
        server.returncode == 0
        and "Traceback" not in told
        and told.splitlines()[-1] == "the server has ended"
    )


def test_it_opens_a_case_and_makes_no_second_copy_of_it(started, tmp_path):
    assert call("new", "mine", "--kind", "pushrod").exit_code == 0
    for case, opened in (("mine.toml", "mine"), ("mine.toml", "mine"), ("job-t", "job-t")):
        told = call("serve", case, "--no-open", "--port", "0")
        assert told.exit_code == 0 and f"/case/{opened};" in told.stderr
    assert {one.name for one in Workspace(tmp_path / "workbench").cases()} == {"mine", "job-t"}
    assert call("serve", "none.toml").exit_code == 2


def test_a_word_of_the_workbench_is_answered_with_its_command():
    assert "see 'valvetrain serve'" in call("workbench").stderr
