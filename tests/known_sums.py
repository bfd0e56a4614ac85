"""Long tables of numbers in two sums each, so that a golden file stays short and still notices any
number that moved or changed places.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

#: Below this nothing is told from rounding.
NOISE = 1e-13
NUMBER = re.compile(r"[-+]?\d+\.?\d*(?:e[-+]?\d+)?", re.IGNORECASE)


def sums(values: Any) -> list[float]:
    """Count, sum, sum with a weight of each place, and the size that these are measured by; what is
    no number is counted apart.
    """
    found = np.asarray(values, dtype=float).ravel()
    known = np.isfinite(found)
    kept, place = np.where(known, found, 0.0), np.arange(len(found))
    return [
        len(found),
        int(known.sum()),
        float(kept.sum()),
        float(kept @ np.cos(1.0 + 0.7 * place)),
        float(np.abs(kept).sum()),
    ]


def deck_sums(text: str) -> dict[str, list[float]]:
    """Keyword line of an input deck (numbered) -> sums of the numbers below it."""
    found: dict[str, list[float]] = {}
    for number, block in enumerate(re.split(r"(?m)^(?=\*)", text)):
        head, _, rest = block.partition("\n")
        words = " ".join(re.sub(NUMBER, "", rest).replace(",", " ").split())
        found[f"{number} {head} {words[:40]}".strip()] = sums(
            [float(one) for one in NUMBER.findall(rest)]
        )
    return found


def same(told: dict[str, Any], kept: dict[str, Any], room: float, where: str = "") -> list[str]:
    """What differs between two trees of sums, by their places; a quantity may be new."""
    if where.endswith("/quantities"):
        told = {key: value for key, value in told.items() if key in kept}
    if told.keys() != kept.keys():
        return [f"{where}: {sorted(told.keys() ^ kept.keys())}"]
    wrong = []
    for key, value in told.items():
        place = f"{where}/{key}"
        if isinstance(value, dict):
            wrong += same(value, kept[key], room, place)
        elif isinstance(value, list):
            allowed = room * max(abs(value[-1]), abs(kept[key][-1])) + NOISE
            if value[:2] != kept[key][:2] or any(
                abs(a - b) > allowed for a, b in zip(value[2:], kept[key][2:], strict=True)
            ):
                wrong.append(f"{place}: {value} for {kept[key]}")
        elif isinstance(value, float):
            if value != pytest.approx(kept[key], rel=room, abs=NOISE, nan_ok=True):
                wrong.append(f"{place}: {value} for {kept[key]}")
        elif value != kept[key]:
            wrong.append(f"{place}: {value!r} for {kept[key]!r}")
    return wrong


def read(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))


def write(path: Path, told: Any) -> None:
    """One line per entry of the second level, so that a difference can be read."""
    lines = [
        f" {json.dumps(name)}: {{\n"
        + ",\n".join(f"  {json.dumps(key)}: {json.dumps(value)}" for key, value in entries.items())
        + "\n }"
        for name, entries in told.items()
    ]
    path.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
