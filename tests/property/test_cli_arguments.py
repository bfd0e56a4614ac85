"""Whatever is typed, and however a case file is broken: an exit code that is documented, one
sentence, never a traceback.
"""

from __future__ import annotations

import json
import os
import random
from unittest.mock import patch

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from unit.cli_parts import SMALL, call, typed
from valvetrain.parameters.loading import LIBRARY

FEW = settings(
    max_examples=600 if os.environ.get("VALVETRAIN_LONG") == "1" else 30,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
WORDS = st.one_of(
    st.text(max_size=30),
    st.sampled_from(
        (
            *typed("run compare sweep static modes runs compare-runs new cases check"),
            *typed("--json --quiet --limit --kind --set --rpm --to --steps --count"),
            *typed("--compression --model --workers --output --no-report"),
            *typed("job-c uniform-spring '4200 rpm' '7 mm' 8 -- - '' 'spring.pitch=7 mm'"),
            *typed("spring.total_coils=1e400 lift_law.power={a=1} published.0.role=x"),
            *typed("spring.options.finite-element.elements_per_coil=true spring=[[["),
            *typed("'spring.precompression=nan mm' operation.cycles=1979-05-27"),
            *typed("'1e308:1e309:1 rpm' /dev/null .."),
            "title=\ud800",
        )
    ),
)
TEXTS = (
    SMALL,
    *(
        (LIBRARY / f"{name}.toml").read_text()
        for name in ("gu2021-beehive-blind", "tdi-pushrod", "job-c")
    ),
)
COMMANDS, CASES = (
    st.sampled_from(["run", "compare", "sweep", "static", "modes", "check"]),
    st.sampled_from(["job-c", "gu2021-beehive-blind"]),
)


def assert_civil(result) -> None:
    """0 with output, or 2 with one sentence on standard error alone."""
    assert result.exit_code in (0, 2), (result.exit_code, result.stderr)
    assert "Traceback" not in result.output and "fault in valvetrain" not in result.stderr
    if result.exit_code == 2:
        assert len(result.stderr.splitlines()) == 1 and result.stderr.startswith("error: ")
        assert result.stdout == "" or set(json.loads(result.stdout)["error"]) == {
            "message",
            "where",
            "code",
        }


@pytest.fixture(autouse=True)
def nothing_is_computed(tmp_path, monkeypatch):
    """Reading and checking only; the results of valid commands are other tests' business."""
    monkeypatch.chdir(tmp_path)
    patches = [
        patch(f"valvetrain.cli.{name}.answer_study", lambda *_, **__: None)
        for name in ("run", "static")
    ]
    for one in patches:
        one.start()
    yield
    for one in patches:
        one.stop()


@FEW
@given(st.lists(WORDS, max_size=6))
@example(["cases", "\udcff"])
@example(["check", "x" * 300])
@example(["check", "a\nb.toml"])
@example(["check", "job-c", "--set", "spring.material.density=" + "[" * 3000])
def test_any_arguments(arguments):
    assert_civil(call(*arguments))


@FEW
@given(COMMANDS, CASES, st.text(max_size=40), st.text(max_size=20))
def test_any_setting(command, case, path, value):
    assert_civil(call(command, case, f"--set={path}={value}", "--json"))


@FEW
@given(
    st.sampled_from(["run", "compare", "sweep"]),
    st.sampled_from(
        [
            "--rpm",
            "--workers",
            "--model",
            "--spring-set",
            "--output",
            "--limit",
        ]
    ),
    st.text(max_size=30),
)
def test_any_option_of_a_study(command, option, value):
    assert_civil(call(command, "job-c", f"{option}={value}"))


@FEW
@given(
    st.sampled_from(TEXTS),
    st.integers(0, 2**32 - 1),
    st.sampled_from(["cut", "drop", "double", "swap", "noise"]),
)
def test_any_damaged_case_file(tmp_path, text, seed, damage):
    path = tmp_path / "damaged.toml"
    path.write_bytes(damaged(text, random.Random(seed), damage))
    assert_civil(call("check", str(path)))


def damaged(text: str, chance: random.Random, damage: str) -> bytes:
    """The file cut short, without a line, with a line twice, with two values exchanged, or with
    stray bytes.
    """
    lines = text.splitlines(keepends=True)
    place, other = chance.randrange(len(lines)), chance.randrange(len(lines))
    if damage == "cut":
        return text.encode()[: chance.randrange(len(text))]
    if damage == "drop":
        del lines[place]
    elif damage == "double":
        lines.insert(other, lines[place])
    elif damage == "swap" and "=" in lines[place] and "=" in lines[other]:
        (key, _, value), (key_2, _, value_2) = (
            lines[place].partition("="),
            lines[other].partition("="),
        )
        lines[place], lines[other] = f"{key}={value_2}", f"{key_2}={value}"
    elif damage == "noise":
        raw = bytearray("".join(lines).encode())
        for _ in range(chance.randint(1, 8)):
            raw[chance.randrange(len(raw))] = chance.randrange(256)
        return bytes(raw)
    return "".join(lines).encode()
