"""Prints the lowest version of each dependency that pyproject.toml allows, as pins: ``make test
LOWEST=1`` tests with these.
"""

from __future__ import annotations

import re
import sys
import tomllib
from pathlib import Path


def lowest_versions(project_file: Path) -> list[str]:
    """``name==version`` of everything needed to build, run and test; raises ValueError for a
    dependency without a lower bound.
    """
    tree = tomllib.loads(project_file.read_text(encoding="utf-8"))
    project, extras = tree["project"], tree["project"]["optional-dependencies"]
    pins = []
    for requirement in (
        *tree["build-system"]["requires"],
        *project["dependencies"],
        *extras["mesh"],
        *extras["measure"],
        *extras["studies"],
        *extras["film"],
        *extras["serve"],
        *extras["docs"],
        *extras["dev"],
    ):
        bound = re.fullmatch(r"([\w.-]+)>=([\w.]+)", requirement)
        if bound is None:
            raise ValueError(f"'{requirement}' has no lower bound alone, such as 'numpy>=2.0'")
        pins.append(f"{bound[1]}=={bound[2]}")
    return pins


if __name__ == "__main__":
    sys.stdout.write(
        "\n".join(lowest_versions(Path(__file__).parents[1] / "pyproject.toml")) + "\n"
    )
