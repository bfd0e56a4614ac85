"""The ways in: README, Makefile, CI and pins keep their promises."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tomllib

import pytest

from architecture.layout import ROOT

README = (ROOT / "README.md").read_text(encoding="utf-8") if (ROOT / "README.md").exists() else ""
MAKEFILE = (ROOT / "Makefile").read_text(encoding="utf-8")


def pinned(path: str) -> dict[str, str]:
    """Package -> version of a requirements file."""
    return dict(
        re.findall(
            r"^([\w.-]+)==(\S+) \\$", (ROOT / path).read_text(encoding="utf-8"), re.MULTILINE
        )
    )


def test_the_readme_shows_the_two_commands_first():
    first_block = re.search(r"^```\w*\n(.*?)^```", README, re.MULTILINE | re.DOTALL)
    assert first_block
    assert re.findall(r"^make \w+", first_block[1], re.MULTILINE) == ["make run", "make test"]


def test_every_make_command_of_the_documents_exists():
    texts = [
        README,
        *((ROOT / name).read_text(encoding="utf-8") for name in ("CONTRIBUTING.md",)),
        MAKEFILE.split("help:")[1],
    ]
    promised = {
        target
        for text in texts
        for target in re.findall(r"(?:^|[`\"])make ([a-z]+)", text, re.MULTILINE)
    }
    targets = set(re.findall(r"^([a-z-]+):", MAKEFILE, re.MULTILINE))
    assert {"run", "test"} <= promised <= targets


def test_everything_that_make_and_the_documents_start_exists():
    """Scripts, modules and folders of tests in the commands of the Makefile, and scripts that a
    page or the package names.
    """
    assert not [
        name
        for name in re.findall(r"(?<!/)\b(?:scripts|tests)/[\w./-]+", MAKEFILE)
        if not (ROOT / name).exists()
    ]
    modules = set(re.findall(r"-m (benchmarks|faults|mutants)\b", MAKEFILE))
    assert modules == {"benchmarks", "faults", "mutants"} and all(
        (ROOT / name / "__main__.py").exists() for name in modules
    )
    pages = [
        path
        for folder in ("docs", "src")
        for ending in ("*.md", "*.py")
        for path in (ROOT / folder).rglob(ending)
    ]
    texts = {
        str(path.relative_to(ROOT)): path.read_text(encoding="utf-8")
        for path in pages
        if "decisions" not in path.parts
    }
    named = {
        (page, name)
        for page, text in texts.items()
        for name in re.findall(r"\bscripts/\w+\.(?:py|sh)", text)
    }
    assert named and not [(page, name) for page, name in named if not (ROOT / name).exists()]


def test_every_link_of_the_readme_leads_to_a_file():
    links = [
        link.split("#")[0] for link in re.findall(r"\]\(([^)\s]+)\)", README) if "://" not in link
    ]
    assert links
    assert not [link for link in links if not (ROOT / link).exists()]


def test_ci_runs_the_tests_by_the_same_command():
    steps = (ROOT / ".ci" / "run").read_text(encoding="utf-8").splitlines()
    assert (
        steps[-1] == "make test"
        and "set -euo pipefail" in steps
        and "make lint" in steps
        and any(step.startswith("make test-processor") for step in steps)
    )


@pytest.mark.parametrize("path", ["requirements.txt", "requirements-dev.txt"])
def test_pins_are_versions_and_hashes_and_nothing_else(path):
    lines = (ROOT / path).read_text(encoding="utf-8").splitlines()
    allowed = re.compile(r"[\w.-]+==[\w.!+]+ \\|    --hash=sha256:[0-9a-f]{64}( \\)?")
    assert lines and not [line for line in lines if not allowed.fullmatch(line)]
    assert {"setuptools", "numpy", "numba"} <= set(pinned(path))


def test_both_files_of_pins_agree_and_hold_every_dependency():
    run, development = pinned("requirements.txt"), pinned("requirements-dev.txt")
    assert run.items() <= development.items()
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    for declared, pins in (
        (project["dependencies"], run),
        (project["optional-dependencies"]["dev"], development),
    ):
        names = {re.split(r"[<>=!~\[; ]", requirement)[0] for requirement in declared}
        assert names <= set(pins)


def test_the_lowest_versions_are_those_of_the_project():
    """``make test LOWEST=1`` installs exactly the bounds that pyproject.toml promises, one of each
    dependency.
    """
    command = [sys.executable, str(ROOT / "scripts" / "lowest_versions.py")]
    pins = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    assert len(pins) == len(set(pins)) > 15
    assert not [pin for pin in pins if f'"{pin.replace("==", ">=")}"' not in text]
    project = tomllib.loads(text)["project"]
    assert {re.split("[<>=]", one)[0] for one in project["dependencies"]} <= {
        pin.partition("==")[0] for pin in pins
    }


@pytest.mark.parametrize(
    ("variables", "folder"),
    [
        ((), ".venv"),
        (("PYTHON=python3.12",), ".venv-python3.12"),
        (("PYTHON=/opt/bin/python3.13",), ".venv-python3.13"),
        (("LOWEST=1",), ".venv-lowest"),
    ],
)
def test_each_interpreter_and_the_lowest_versions_have_their_own_environment(variables, folder):
    clean = {
        name: value
        for name, value in os.environ.items()
        if name not in ("PYTHON", "VENV", "LOWEST", "MAKEFLAGS", "MAKELEVEL")
    }
    told = subprocess.run(
        ["make", "-n", "run", *variables],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
        env=clean,
    )
    assert f"\n{folder}/bin/valvetrain run" in f"\n{told.stdout}"
