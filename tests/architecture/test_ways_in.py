"""The ways in: README, Makefile, CI and pins keep their promises."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from importlib.metadata import distributions

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


def test_every_package_runs_on_the_oldest_python_of_the_project():
    """Such as 3.11.0; pins are resolved on a later one."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    oldest = [*map(int, project["requires-python"].removeprefix(">=").split(".")), 0]
    pins = pinned("requirements-dev.txt")
    packages = [each for each in distributions() if each.name.lower() in pins]
    assert len(packages) > 100
    assert not [
        f"{each.name} {each.version}"
        for each in packages
        for bound in re.findall(r">=?\s*([\d.]+\d)", each.metadata.get("Requires-Python", ""))
        if [int(part) for part in bound.split(".")] > oldest
    ]


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
