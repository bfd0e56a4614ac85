"""Unit: what is shipped. The wheel holds every file of the package, and recipe, container and
citation say what the project file says.
"""

from __future__ import annotations

import email
import re
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

import valvetrain

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    copy = folder / "source"  # a build leaves folders behind, so it is made of a copy
    for name in ("src/valvetrain", "pyproject.toml", "README.md", "LICENSE"):
        (copy / name).parent.mkdir(parents=True, exist_ok=True)
        subprocess.run(["cp", "-r", ROOT / name, copy / name], check=True)
    command = [
        sys.executable,
        "-m",
        "pip",
        "wheel",
        "-q",
        "--no-deps",
        "--no-build-isolation",
        "--no-index",
        "-w",
        str(folder),
        str(copy),
    ]
    subprocess.run(command, check=True, capture_output=True, timeout=120)
    (found,) = folder.glob("*.whl")
    return found


def test_the_wheel_holds_every_file_of_the_package(wheel):
    """A template or a script of the page that is missing shows only where the package was
    installed.
    """
    listed = subprocess.run(
        ["git", "ls-files", "-co", "--exclude-standard", "src/valvetrain"],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    if listed.returncode:
        pytest.skip("not a git clone, so nothing says which files belong to the package")
    wanted = {
        name.removeprefix("src/") for name in listed.stdout.splitlines() if (ROOT / name).exists()
    }
    assert len(wanted) > 300
    with zipfile.ZipFile(wheel) as archive:
        assert wanted - set(archive.namelist()) == set()


def test_the_wheel_says_what_the_project_file_says(wheel):
    with zipfile.ZipFile(wheel) as archive:
        (name,) = (name for name in archive.namelist() if name.endswith(".dist-info/METADATA"))
        told = email.message_from_string(archive.read(name).decode())
        assert any(name.endswith("/licenses/LICENSE") for name in archive.namelist())
        entries = archive.read(name.replace("METADATA", "entry_points.txt")).decode()
    assert (
        told["Version"] == valvetrain.__version__ and told["License-Expression"] == "BSD-3-Clause"
    )
    assert (
        set(told.get_all("Provides-Extra"))
        == set(PROJECT["optional-dependencies"])
        >= {"studies", "measure", "serve", "film", "mesh", "docs"}
    )
    assert "valvetrain = valvetrain.__main__:main" in entries


def test_the_container_copies_what_exists_and_asks_for_extras_that_exist():
    text = (ROOT / "packaging/Containerfile").read_text(encoding="utf-8")
    copied = [
        word
        for line in re.findall(r"^COPY (?!--from)(.+)$", text, re.MULTILINE)
        for word in line.split()[:-1]
    ]
    assert copied and all((ROOT / word).exists() for word in copied)
    assert {"pyproject.toml", "src", "requirements.txt", "LICENSE", "README.md"} <= set(copied)
    assert all(
        extra in PROJECT["optional-dependencies"] for extra in re.findall(r"\.\[(\w+)\]", text)
    )
    assert "USER engineer" in text
