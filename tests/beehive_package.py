"""The package in examples/beehive as an environment has it: its entry points on the path."""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path

import pytest

from valvetrain import registry

FOLDER = Path(__file__).resolve().parents[1] / "examples" / "beehive"


@pytest.fixture
def beehive_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Folder of the package, found by the registry during a test."""
    project = tomllib.loads((FOLDER / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    info = tmp_path / f"{project['name'].replace('-', '_')}-{project['version']}.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(
        f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n"
    )
    lines = [
        line
        for group, members in project["entry-points"].items()
        for line in (f"[{group}]", *(f"{name} = {place}" for name, place in members.items()))
    ]
    (info / "entry_points.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    registry.places.cache_clear()
    yield FOLDER
    sys.path.remove(str(tmp_path))
    registry.places.cache_clear()
