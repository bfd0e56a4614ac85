"""Whatever bytes, names and words reach the workbench, the answer is a case or one sentence, and
nothing leaves its folder.

Evidence: property; drawn bytes, names and values, and what lies on disk afterwards.
"""

from __future__ import annotations

import asyncio
import tempfile
from pathlib import Path

from hypothesis import example, given, settings
from hypothesis import strategies as st

from valvetrain.errors import InputError
from valvetrain.workbench.edits import read_change, with_value
from valvetrain.workbench.form import CaseForm
from valvetrain.workbench.pages.guard import Guard
from valvetrain.workbench.settings import ServeSettings
from valvetrain.workbench.store import case_name, inside
from valvetrain.workbench.supervisor import read_progress
from valvetrain.workbench.workspace import Workspace
from workbench_parts import SMALL

WORDS = st.text(max_size=60)
HEADS = ["host", "origin", "cookie", "content-length", "sec-fetch-site", "accept", "x"]
#: Bytes of any kind, and a case with some of its bytes cut out or changed.
CONTENT = st.one_of(
    st.binary(max_size=300),
    st.builds(
        lambda start, length, put: SMALL.encode()[:start] + put + SMALL.encode()[start + length :],
        st.integers(0, len(SMALL)),
        st.integers(0, 30),
        st.binary(max_size=5),
    ),
)
KEYS = st.sampled_from(
    [
        "spring.mass",
        "spring",
        "lift_law.kind",
        "operation.engine_speeds",
        "title",
        "spring.options.multi-mass.elements",
        "a.b.c",
        "spring.0",
    ]
)


@given(name=WORDS)
@example(name="..")
@example(name="a/../b")
@example(name="\ud800")
def test_no_name_leads_out(name):
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder).resolve()
        for make in (
            lambda: inside(root, name),
            lambda: inside(root, "a", name),
            lambda: inside(root, case_name(name), "case.toml"),
        ):
            try:
                found = make()
            except InputError as error:
                assert str(error)
                continue
            assert found.parent in (root, root / "a") or found.parent.parent == root
            assert found.resolve().is_relative_to(root) and found != root


@settings(max_examples=25, deadline=None)
@given(content=CONTENT, name=WORDS)
@example(content=b"[spring]\n" * 1000, name="x")
@example(content=b"a." * 5000 + b"b = 1", name="x")
def test_what_is_uploaded_is_a_case_or_refused(content, name):
    with tempfile.TemporaryDirectory() as folder:
        workspace = Workspace(Path(folder) / "bench")
        try:
            made = workspace.upload(name, content)
        except InputError as error:
            assert str(error) and not workspace.cases()
            assert not list(workspace.jobs_folder.iterdir())
            return
        assert workspace.read(made) and [card.name for card in workspace.cases()] == [made]
        assert {path.name for path in workspace.folder.iterdir()} <= {
            "cases",
            "runs",
            "jobs",
            "workbench.sqlite",
            "workbench.sqlite-wal",
            "workbench.sqlite-shm",
        }
        CaseForm(workspace.text(made))


@settings(max_examples=50, deadline=None)
@given(
    key=st.one_of(KEYS, WORDS),
    value=st.one_of(
        WORDS, st.sampled_from(["42 g", "4", "[1, 2]", "{ a = 1 }", "", "1e400 g", "nan", "'"])
    ),
)
@example(key="spring.mass", value="\ud800")
@example(key="title", value='"""')
@example(key="title", value="0")
@example(key="spring." * 40 + "mass", value="1 g")
def test_a_value_is_taken_or_refused_in_words_and_taken_alike_by_the_text(key, value):
    try:
        path, given_value, _ = read_change(SMALL, key, value)
    except InputError as error:
        assert str(error)
        return
    text = with_value(SMALL, path, given_value)
    assert not value.strip() or read_change(text, "operation.cycles", "2"), "it reads in the file"


@given(line=st.binary(max_size=80))
def test_progress_of_any_bytes(line):
    told = read_progress(line)
    assert told is None or isinstance(told[1], str)


@given(
    heads=st.lists(st.tuples(st.sampled_from(HEADS), WORDS), max_size=5),
    path=WORDS,
    query=st.binary(max_size=40),
    kind=st.sampled_from(["http", "websocket"]),
)
def test_any_request_gets_one_answer(heads, path, query, kind):
    sent = []

    async def inner(scope, receive, send):
        raise AssertionError("nothing but its own host and origin comes so far")

    async def receive():
        return {"type": f"{kind}.connect"}

    async def send(message):
        sent.append(message)

    listed = [
        (name.encode(), value.encode("utf-8", "replace"))
        for name, value in heads
        if "127.0.0.1" not in value
    ]
    scope = {
        "type": kind,
        "method": "GET",
        "path": path,
        "query_string": query,
        "headers": listed,
        "scheme": "http",
    }
    asyncio.run(Guard(inner, ServeSettings(token="x" * 20))(scope, receive, send))
    assert (sent and sent[0].get("status", 403) in (401, 403, 413)) or sent[0][
        "type"
    ] == "websocket.close"
