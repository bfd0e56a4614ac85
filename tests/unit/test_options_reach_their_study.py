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
    "run": ("run.run_study", ["--engine-speed", "2100 rpm"], {"engine_speeds": (2100 * RPM,)}),
    "compare": ("compare.compare_study", ["--engine-speed", "2100 rpm"], {"engine_speeds": (2100 * RPM,)}),
    "sweep": ("run.sweep_study", ["--engine-speed", "2000:2200:100 rpm"], {"engine_speeds": (2000 * RPM, 2100 * RPM, 2200 * RPM)}),
    "run-up": ("run_up.run_up_study", ["--from", "2000 rpm", "--to", "2400 rpm", "--duration", "0.5 s"],
               {"ramp": (2000 * RPM, 2400 * RPM, 0.5)}),
}  # fmt: skip
SHARED = [
    "--spring",
    "massless",
    "--spring-set",
    "stock",
    "--workers",
    "2",
    "--limit",
    "7 h, 3 GB",
    "--implausible",
]


@pytest.fixture(params=STUDIES)
def asked(request, monkeypatch, tmp_path):
    place, own, wanted = STUDIES[request.param]

    def call(*options: str) -> tuple[dict[str, Any], str]:
        seen: dict[str, Any] = {}

        def study(*given: Any, **named: Any) -> Any:
            seen.update(named, given=given)
            raise InputError("this is as far as it goes")

        monkeypatch.setattr(f"valvetrain.runs.{place}", study)
        arguments = [
            request.param,
            "tdi-pushrod",
            *own,
            *options,
            "--output",
            str(tmp_path / "out"),
        ]
        said = CliRunner().invoke(app, arguments)
        assert "as far as it goes" in said.output, said.output
        return seen, request.param

    return call, wanted


def approximately(found: Any, wanted: Any) -> bool:
    return [float(one) for one in found] == pytest.approx(list(wanted), rel=1e-9)


def test_every_option_that_is_stated_reaches_the_study(asked):
    call, wanted = asked
    seen, command = call(*SHARED)
    case, *rest = seen["given"]
    assert (
        case.name == "tdi-pushrod"
        and seen["spring_models"] == ("massless",)
        and seen["spring_sets"] == ("stock",)
    )
    assert (
        seen["workers"] == 2
        and seen["implausible"] is True
        and callable(seen["progress"])
        and seen["created_at"][:2] == "20"
    )
    for name, value in wanted.items():
        assert approximately(seen.get(name) or rest[0], value), name
    if "limits" in seen:
        assert (seen["limits"].seconds, seen["limits"].bytes) == (7 * 3600.0, 3e9)
    assert ("limits" in seen) == (command != "run-up")


def test_what_is_left_out_is_left_to_the_study(asked):
    call, _ = asked
    seen, _ = call()
    assert seen["spring_models"] == () == seen["spring_sets"] and seen["implausible"] is False
    if "limits" in seen:
        assert (seen["limits"].seconds, seen["limits"].bytes) == (600.0, 2e9)
