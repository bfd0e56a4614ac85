"""Puts the identifications of the beehive side by side: docs/pictures/beehive-studies.svg and the table of docs/beehive.md.

valvetrain identify examples/identify-beehive-blind.toml --limit "5 d" --output BLIND        (and so on; hours each)
python scripts/write_beehive_studies.py BLIND JOINT WITHOUT-4200 WITHOUT-5600 WITHOUT-8000
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.parameters.words import number
from valvetrain.report import theme
from valvetrain.report.chart import Chart, Layer, Line, Marks, Panel, Rule
from valvetrain.report.svg_chart import svg
from valvetrain.solution.atomic import write_text
from valvetrain.solution.definition import label_of, shown

DOCS = Path(__file__).resolve().parents[1] / "docs"
PAGE, PICTURE = "beehive.md", "beehive-studies.svg"
BEGIN, END = "<!-- three studies -->\n", "<!-- end of three studies -->"
SPEED = re.compile(r"^(\d+) rpm, ")


@dataclass(frozen=True)
class Row:
    """One published value as a study tells it, SI: 2.5, 50 and 97.5 % over its draws, the ``percentile`` at which the value lies."""

    low: float
    middle: float
    high: float
    percentile: float | None
    fitted: bool


@dataclass(frozen=True)
class Beside:
    """One of the studies: its words and its rows by the key of a measurement."""

    words: str
    rows: Mapping[str, Row]


def rows_of(answer: Mapping[str, Any], speed: str = "") -> dict[str, Row]:
    """Rows of an identification's answer, of one engine speed (``4200 rpm``) where it is given."""
    return {
        one["key"]: Row(*(one[name]["value"] for name in ("low", "middle", "high")), one["percentile"], one["fitted"])
        for one in answer["measurements"]
        if not speed or one["key"].startswith(f"{speed}, ")
    }


def measured_of(answer: Mapping[str, Any]) -> dict[str, tuple[float, float]]:
    """Key -> published value and its scatter, SI."""
    return {one["key"]: (one["measured"]["value"], one["scatter"]["value"]) for one in answer["measurements"]}


def three_studies(blind: Mapping[str, Any], joint: Mapping[str, Any], without: Mapping[str, Mapping[str, Any]]) -> tuple[Beside, ...]:
    """The three studies; ``without``: engine speed that was left out -> its answer, of which the rows of that speed alone are kept."""
    left_out = {key: row for speed, answer in without.items() for key, row in rows_of(answer, speed).items()}
    fitted = [key for key, row in left_out.items() if row.fitted]
    if fitted:
        raise SystemExit(f"{fitted[0]} was fitted in the study that should leave it out; give the folders in the order of the use above")
    return Beside("blind", rows_of(blind)), Beside("joint", rows_of(joint)), Beside("each speed from the other two", left_out)


def words_of(key: str) -> str:
    """A measurement in words: ``4200 rpm: stage 2 peak force``."""
    speed = SPEED.match(key)
    return (f"{speed[1]} rpm: " if speed else "at rest: ") + label_of(key.rpartition(": ")[2])


def chart(studies: Sequence[Beside], measured: Mapping[str, tuple[float, float]]) -> Chart:
    """Computed over published of every value, the interval of each study about its median; filled where the study was fitted to it."""
    height = {key: float(len(measured) - place) for place, key in enumerate(measured)}
    layers: list[Layer] = []
    for place, study in enumerate(studies):
        colour, shift = theme.SERIES[place], 0.24 * (len(studies) - 1) / 2 - 0.24 * place
        at = np.array([height[key] + shift for key in study.rows])
        ends = np.array([[getattr(row, name) / measured[key][0] for name in ("low", "middle", "high")] for key, row in study.rows.items()])
        gap = np.full(len(at), np.nan)
        x, y = np.stack([ends[:, 0], ends[:, 2], gap], 1).ravel(), np.stack([at, at, gap], 1).ravel()
        layers.append(Line(x, y, study.words, colour, 2.4))
        for fitted in (True, False):
            here = np.array([row.fitted is fitted for row in study.rows.values()])
            if here.any():
                layers.append(Marks(ends[here, 1], at[here], study.words, colour, size=7.0, filled=fitted, in_legend=False))
    scatter = np.array(
        [[key_height, deviation / abs(value)] for (key_height, (value, deviation)) in zip(height.values(), measured.values(), strict=True)]
    )
    gap = np.full(len(scatter), np.nan)
    x = np.stack([1 - scatter[:, 1], 1 + scatter[:, 1], gap], 1).ravel()
    y = np.stack([scatter[:, 0] + 0.4, scatter[:, 0] + 0.4, gap], 1).ravel()
    layers.append(Line(x, y, "scatter that was allowed", theme.RULE, 5.0))
    panel = Panel(
        "computed / published", "", tuple(layers), rules=(Rule("x", 1.0),), x_range=(0.0, 2.0), y_range=(0.3, len(measured) + 0.7),
        y_words=tuple((height[key], words_of(key)) for key in measured),
    )  # fmt: skip
    return Chart("beehive-studies", "The beehive by three identifications", "", (panel,), 1, 110 + 34 * len(measured))


def table(studies: Sequence[Beside], measured: Mapping[str, tuple[float, float]]) -> str:
    """A row per published value: median, interval and, where the study was not fitted to it, the percentile of the published value."""
    lines = ["| | published | " + " | ".join(study.words for study in studies) + " |", "|---" * (len(studies) + 2) + "|"]
    for key, (value, scatter) in measured.items():
        name = key.rpartition(": ")[2]
        unit = shown(name, 1.0)[1]
        cells = [_cell(study.rows.get(key), name) for study in studies]
        lines.append(f"| {words_of(key)} | {_in(name, value)} ± {_in(name, scatter)} {unit} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _in(name: str, value: float) -> str:
    return number(float(shown(name, value)[0]), 3)


def _cell(row: Row | None, name: str) -> str:
    if row is None:
        return "–"
    told = "" if row.fitted or row.percentile is None else f", {row.percentile:.0f} %"
    return f"{_in(name, row.middle)} ({_in(name, row.low)} to {_in(name, row.high)}{told})"


def main(folders: Sequence[str], docs: Path = DOCS) -> None:
    """Write picture and table."""
    if len(folders) != 5:
        raise SystemExit(__doc__)
    blind, joint, *left = (json.loads((Path(folder) / "run.json").read_text(encoding="utf-8")) for folder in folders)
    short = [folder for folder, answer in zip(folders, (blind, joint, *left), strict=True) if not answer["whole"]]
    if short:
        raise SystemExit(f"the identification in '{short[0]}' was cut short; start it again, it goes on")
    studies, measured = three_studies(blind, joint, dict(zip(("4200 rpm", "5600 rpm", "8000 rpm"), left, strict=True))), measured_of(blind)
    page = (docs / PAGE).read_text(encoding="utf-8")
    before, begin, rest = page.partition(BEGIN)
    if not begin or END not in rest:
        raise SystemExit(f"docs/{PAGE} lacks the marks {BEGIN.strip()} and {END}; put them where the table belongs")
    write_text(docs / PAGE, f"{before}{begin}{table(studies, measured)}\n{END}{rest.partition(END)[2]}")
    write_text(docs / "pictures" / PICTURE, svg(chart(studies, measured)))


if __name__ == "__main__":
    main(sys.argv[1:])
