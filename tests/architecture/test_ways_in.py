"""The ways in: README, Makefile, CI and pins keep their promises."""

from __future__ import annotations

import re
import tomllib

import pytest

from architecture.layout import DATA_FLOW, ROOT

README = (ROOT / "README.md").read_text(encoding="utf-8") if (ROOT / "README.md").exists() else ""
MAKEFILE = (ROOT / "Makefile").read_text(encoding="utf-8")


def pinned(path: str) -> dict[str, str]:
    """Package -> version of a requirements file."""
    return dict(re.findall(r"^([\w.-]+)==(\S+) \\$", (ROOT / path).read_text(encoding="utf-8"), re.MULTILINE))


def test_the_readme_begins_with_the_data_flow_and_the_two_commands():
    assert README.splitlines()[:3] == ["# valvetrain", "", DATA_FLOW]
    first_block = re.search(r"^```\w*\n(.*?)^```", README, re.MULTILINE | re.DOTALL)
    assert first_block
    assert re.findall(r"^make \w+", first_block[1], re.MULTILINE) == ["make run", "make test"]


def test_every_make_command_of_the_documents_exists():
    texts = [README, *((ROOT / name).read_text(encoding="utf-8") for name in ("CONTRIBUTING.md",)), MAKEFILE.split("help:")[1]]
    promised = {target for text in texts for target in re.findall(r"(?:^|[`\"])make ([a-z]+)", text, re.MULTILINE)}
    targets = set(re.findall(r"^([a-z-]+):", MAKEFILE, re.MULTILINE))
    assert {"run", "test"} <= promised <= targets


def test_every_link_of_the_readme_leads_to_a_file():
    links = [link.split("#")[0] for link in re.findall(r"\]\(([^)\s]+)\)", README) if "://" not in link]
    assert links
    assert not [link for link in links if not (ROOT / link).exists()]


def test_ci_runs_the_tests_by_the_same_command():
    assert re.search(r"^exec make test$", (ROOT / ".ci" / "run").read_text(encoding="utf-8"), re.MULTILINE)


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
    for declared, pins in ((project["dependencies"], run), (project["optional-dependencies"]["dev"], development)):
        names = {re.split(r"[<>=!~\[; ]", requirement)[0] for requirement in declared}
        assert names <= set(pins)
