"""Unit: progress as lines for whoever started a command."""

from __future__ import annotations

import json
import os

from valvetrain.cli import progress
from valvetrain.cli import progress as compilation


def test_what_is_compiled_first_is_said_until_the_first_share(monkeypatch, capsys):
    """The title of the bar came right after it, so that a first run stood at 0 % for half a minute
    without a word why.
    """
    reading, writing = os.pipe()
    monkeypatch.setenv(progress.PROGRESS_VARIABLE, str(writing))
    monkeypatch.setattr(compilation, "seconds_to_compile", lambda *kinds: 16.0)
    progress.announce_compilation("train")
    with progress.progress_bar("my-train") as report:
        report(0.5, "3000 rpm")
    with progress.progress_bar("the next"):
        pass
    os.close(writing)
    with os.fdopen(reading) as told:
        lines = [json.loads(line) for line in told]
    words = "compiling kernels, once, about 16 s"
    assert [(line["share"], line["text"]) for line in lines] == [
        (None, words),
        (0.0, f"my-train; {words}"),
        (0.5, "3000 rpm"),
        (0.0, "the next"),
    ]
    assert words in capsys.readouterr().err
