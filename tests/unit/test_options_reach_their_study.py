"""What a command is told on the terminal is what its study is asked: every option of a study,
stated and left out.
"""

from __future__ import annotations

import math
from typing import Any

import pytest
from typer.testing import CliRunner

from valvetrain.cli.main import app
from valvetrain.errors import InputError

RPM = math.pi / 30
#: Command -> module of the function that it calls, and the options of its own with what they
#: become.
STUDIES: dict[str, tuple[str, list[str], dict[str, Any]]] = {
    "run": ("run.run_study", ["--rpm", "2100"], {"engine_speeds": (2100 * RPM,)}),
    "compare": ("compare.compare_study", ["--rpm", "2100 rpm"], {"engine_speeds": (2100 * RPM,)}),
    "sweep": ("run.sweep_study", ["--rpm", "2000:2200:100 rpm"], {"engine_speeds": (2000 * RPM, 2100 * RPM, 2200 * RPM)}),
    "run-up": ("run_up.run_up_study", ["--from", "2000 rpm", "--to", "2400 rpm", "--duration", "0.5 s"],
               {"ramp": (2000 * RPM, 2400 * RPM, 0.5)}),
}  # fmt: skip
SHARED = ["--model", "massless", "--spring-set", "stock", "--workers", "2", "--limit", "7 h, 3 GB", "--implausible"]  # fmt: skip


@pytest.fixture(params=STUDIES)
def asked(request, monkeypatch, tmp_path):
    place, own, wanted = STUDIES[request.param]

    def call(*options: str) -> tuple[Any, Any]:
        seen: list[Any] = []

        def study(*given: Any) -> Any:
            seen.extend(given)
            raise InputError("this is as far as it goes")

        monkeypatch.setattr(f"valvetrain.runs.{place}", study)
        output = ["--output", str(tmp_path / "out")]
        said = CliRunner().invoke(app, [request.param, "tdi-pushrod", *own, *options, *output])
        assert "as far as it goes" in said.output, said.output
        return tuple(seen)

    return call, wanted


def test_every_option_that_is_stated_reaches_the_study(asked):
    call, wanted = asked
    request, watch = call(*SHARED)
    assert request.case.name == "tdi-pushrod"
    assert request.models == ("massless",) and request.spring_sets == ("stock",)
    assert request.workers == 2 and request.implausible is True
    assert callable(watch.progress) and callable(watch.finished) and watch.created_at[:2] == "20"
    for name, value in wanted.items():
        assert getattr(request, name) == pytest.approx(value, rel=1e-9), name
    assert (request.limit.seconds, request.limit.bytes) == (7 * 3600.0, 3e9)


def test_what_is_left_out_is_left_to_the_study(asked):
    call, _ = asked
    request, _ = call()
    assert request.models == () == request.spring_sets and request.implausible is False
    assert (request.limit.seconds, request.limit.bytes) == (600.0, 2e9)
