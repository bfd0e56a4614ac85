"""Puts the identifications of the beehive side by side: docs/pictures/beehive-studies.svg and the
table of docs/beehive.md.

valvetrain identify examples/identify-beehive-blind.toml --limit "5 d" --output BLIND        (and so
on; 10 to 60 min each on two cores)
python scripts/write_beehive_studies.py BLIND JOINT BANDS ANGLES WITHOUT-4200 WITHOUT-5600
WITHOUT-8000   (a dash: what is kept)
python scripts/write_beehive_studies.py      picture and table anew from
docs/data/beehive/studies.json
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from beehive_sentences import (
    ANGLES,
    BANDS,
    TARGETS,
    conflicts,
    in_unit,
    listed,
    measured_of,
    searches,
    sentences,
    words_of,
)
from numpy.typing import NDArray

from valvetrain.explore.identification_file import Request, read_request
from valvetrain.explore.posterior import Outcome, Posterior
from valvetrain.explore.solve import read_points
from valvetrain.report import theme
from valvetrain.report.chart import Chart, Layer, Line, Marks, Panel, Rule
from valvetrain.report.svg_chart import svg
from valvetrain.solution.atomic import write_text
from valvetrain.solution.definition import shown

DOCS = Path(__file__).resolve().parents[1] / "docs"
PAGE, PICTURE, KEPT = "beehive.md", "beehive-studies.svg", Path("data") / "beehive" / "studies.json"
STUDIES = (
    "blind",
    "joint",
    BANDS,
    ANGLES,
    "without 4200 rpm",
    "without 5600 rpm",
    "without 8000 rpm",
)
#: Stands for a folder of which what is kept stays.
KEEP = "-"
BEGIN, END = "<!-- three studies -->\n", "<!-- end of three studies -->"
#: Computed over published value at which the picture ends.
EDGE = 2.0


@dataclass(frozen=True)
class Row:
    """One published value as a study tells it, SI: 2.5, 50 and 97.5 % over its draws, the
    ``percentile`` at which the value lies.
    """

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
        one["key"]: Row(
            *(one[name]["value"] for name in ("low", "middle", "high")),
            one["percentile"],
            one["fitted"],
        )
        for one in answer["measurements"]
        if not speed or one["key"].startswith(f"{speed}, ")
    }


def three_studies(
    blind: Mapping[str, Any],
    joint: Mapping[str, Any],
    angles: Mapping[str, Any],
    without: Mapping[str, Mapping[str, Any]],
) -> tuple[Beside, ...]:
    """The three studies, the joint one without and with ``angles``; of the former the answer that
    holds its bands.

    ``without``: engine speed that was left out -> its answer, of which the rows of that speed alone
    are kept.
    """
    left_out = {
        key: row
        for speed, answer in without.items()
        for key, row in rows_of(answer, speed).items()
        if key in measured_of(joint)
    }
    fitted = [key for key, row in left_out.items() if row.fitted]
    if fitted:
        raise SystemExit(
            f"{fitted[0]} was fitted in the study that should leave it out; give the folders in the order of the use above"
        )
    whole = tuple(
        Beside(name, rows_of(one))
        for name, one in (("blind", blind), ("joint", joint), (ANGLES, angles))
    )
    return *whole, Beside("each speed from the other two", left_out)


def chart(studies: Sequence[Beside], measured: Mapping[str, tuple[float, float]]) -> Chart:
    """Computed over published of every value, the interval of each study about its median; filled
    where the study was fitted to it.
    """
    height = {key: float(len(measured) - place) for place, key in enumerate(measured)}
    layers: list[Layer] = []
    for place, study in enumerate(studies):
        colour, shift = theme.SERIES[place], 0.24 * (len(studies) - 1) / 2 - 0.24 * place
        at = np.array([height[key] + shift for key in study.rows])
        ends = np.array(
            [
                [getattr(row, name) / measured[key][0] for name in ("low", "middle", "high")]
                for key, row in study.rows.items()
            ]
        )
        gap = np.full(len(at), np.nan)
        x, y = (
            np.stack([ends[:, 0], ends[:, 2], gap], 1).ravel(),
            np.stack([at, at, gap], 1).ravel(),
        )
        layers.append(Line(x, y, study.words, colour, 2.4))
        for fitted in (True, False):
            here = np.array([row.fitted is fitted for row in study.rows.values()])
            if here.any():
                layers.append(
                    Marks(
                        ends[here, 1],
                        at[here],
                        study.words,
                        colour,
                        size=7.0,
                        filled=fitted,
                        in_legend=False,
                    )
                )
    scatter = np.array(
        [
            [key_height, deviation / abs(value)]
            for (key_height, (value, deviation)) in zip(
                height.values(), measured.values(), strict=True
            )
        ]
    )
    gap = np.full(len(scatter), np.nan)
    x = np.stack([1 - scatter[:, 1], 1 + scatter[:, 1], gap], 1).ravel()
    y = np.stack([scatter[:, 0] + 0.4, scatter[:, 0] + 0.4, gap], 1).ravel()
    layers.append(Line(x, y, "scatter that was allowed", theme.RULE, 5.0))
    panel = Panel(
        "computed / published",
        "",
        tuple(layers),
        rules=(Rule("x", 1.0),),
        x_range=(0.0, EDGE),
        y_range=(0.3, len(measured) + 0.7),
        y_words=tuple(
            (height[key], words_of(key).replace("largest ", "")) for key in measured
        ),  # the room on the left
    )
    return Chart(
        "beehive-studies",
        "The beehive by its identifications",
        "",
        (panel,),
        1,
        110 + 34 * len(measured),
    )


def beyond(studies: Sequence[Beside], measured: Mapping[str, tuple[float, float]]) -> str:
    """A sentence on medians that lie beyond the edge of the picture, empty where there are none."""
    found = [
        f"{words_of(key)} ({study.words}, {row.middle / measured[key][0]:.1f} times the published value)"
        for study in studies
        for key, row in study.rows.items()
        if row.middle / measured[key][0] > EDGE
    ]
    return f"\n\nBeyond the right edge of the picture: {listed(found)}." if found else ""


def table(studies: Sequence[Beside], measured: Mapping[str, tuple[float, float]]) -> str:
    """A row per published value: median, interval, the percentile at which the published value
    lies, whether the study was fitted to it.
    """
    lines = [
        "| | published | " + " | ".join(study.words for study in studies) + " |",
        "|---" * (len(studies) + 2) + "|",
    ]
    for key, (value, scatter) in measured.items():
        name = key.rpartition(": ")[2]
        unit = shown(name, 1.0)[1]
        cells = [_cell(study.rows.get(key), name) for study in studies]
        lines.append(
            f"| {words_of(key)} | {in_unit(name, value)} ± {in_unit(name, scatter)} {unit} | "
            + " | ".join(cells)
            + " |"
        )
    return "\n".join(lines)


def _cell(row: Row | None, name: str) -> str:
    if row is None:
        return "–"
    told = "" if row.percentile is None else f", {row.percentile:.0f} %"
    return f"{in_unit(name, row.middle)} ({in_unit(name, row.low)} to {in_unit(name, row.high)}{told}{', fitted' if row.fitted else ''})"


def kept_of(answer: Mapping[str, Any]) -> dict[str, Any]:
    """What the page stands on, of the answer of one identification: rows, quantities of the
    likeliest branch, warnings, count of points.
    """
    names = (
        "key",
        "measured",
        "scatter",
        "fitted",
        "computed",
        "low",
        "middle",
        "high",
        "percentile",
    )
    return {
        "method": answer["method"],
        "points": answer["evaluations"] + answer["kept_from_before"],
        "warnings": answer["warnings"],
        "branches": len(answer["branches"]),
        "misfit": answer["branches"][0]["misfit"],
        "quantities": {
            name: {key: value for key, value in one.items() if key in ("best", "low", "high")}
            for name, one in answer["branches"][0]["quantities"].items()
        },
        "told": answer["branches"][0]["told"],
        "measurements": [{name: row[name] for name in names} for row in answer["measurements"]],
        "conflicts": answer["conflicts"],
    }


def targets_of(
    points: Sequence[tuple[NDArray[np.float64], Outcome]], request: Request
) -> dict[str, Any]:
    """How many of the computed points of a search meet all of :data:`TARGETS` at once, and the one
    that lies farthest inside them.
    """
    posterior = Posterior(request.unknowns, request.data, lambda values: [None] * len(values))
    aims = [
        (one, share)
        for _, names, share in TARGETS
        for one in posterior.used
        if one.key.rpartition(": ")[2] in names
    ]
    if not aims:
        raise SystemExit(
            "a joint search was fitted to none of what it aims at; give the folders in the order of the use above"
        )
    possible = [
        (values, outcome)
        for values, outcome in points
        if outcome is not None and posterior.residuals(outcome) is not None
    ]
    worst = [
        max(abs(outcome[one.key] / one.value - 1) / share for one, share in aims)
        for _, outcome in possible
    ]
    found: dict[str, Any] = {
        "aims": len(aims),
        "points": len(possible),
        "meet_all": int(np.sum(np.array(worst) <= 1)),
    }
    if found["meet_all"]:
        values, outcome = possible[int(np.argmin(worst))]
        off, pulls = (
            posterior.residuals(outcome),
            posterior.pulls(posterior.work_of(values[None, :])[0]),
        )
        found["inside"] = {
            "misfit": float(off @ off + pulls @ pulls),
            "quantities": dict(
                zip((one.name for one in request.unknowns), values.tolist(), strict=True)
            ),
            "computed": {one.key: outcome[one.key] for one in posterior.used},
        }
    return found


def read_folders(folders: Sequence[str], docs: Path) -> dict[str, Any]:
    """What is kept of the folders, for :data:`KEEP` what was kept before. Raises
    :class:`SystemExit` where one was cut short.
    """
    kept = (
        json.loads((docs / KEPT).read_text(encoding="utf-8"))
        if KEEP in folders
        else dict.fromkeys(STUDIES)
    )
    for name, folder in zip(STUDIES, folders, strict=True):
        if folder != KEEP:
            answer = json.loads((Path(folder) / "run.json").read_text(encoding="utf-8"))
            if not answer["whole"]:
                raise SystemExit(
                    f"the identification in '{folder}' was cut short; start it again, it goes on"
                )
            kept[name] = kept_of(answer)
    for name in ("joint", BANDS, ANGLES):
        folder = folders[STUDIES.index(name)]
        if folder != KEEP:
            request = read_request(Path(folder) / "identification.toml")
            kept[name]["targets"] = targets_of(
                read_points(Path(folder) / "points.jsonl", len(request.unknowns)), request
            )
    return {name: kept[name] for name in STUDIES}


def read_kept(docs: Path = DOCS) -> tuple[tuple[Beside, ...], dict[str, tuple[float, float]]]:
    """The three studies and the published values from what is kept."""
    kept = json.loads((docs / KEPT).read_text(encoding="utf-8"))
    without = {
        name.removeprefix("without "): one
        for name, one in kept.items()
        if name.startswith("without ")
    }
    return three_studies(kept["blind"], kept[BANDS], kept[ANGLES], without), measured_of(
        kept["blind"]
    )


def main(folders: Sequence[str], docs: Path = DOCS) -> None:
    """Write what is kept where folders are given, then picture, sentences and table."""
    if len(folders) not in (0, len(STUDIES)):
        raise SystemExit(__doc__)
    if folders:
        found = read_folders(folders, docs)
        (docs / KEPT).parent.mkdir(parents=True, exist_ok=True)
        write_text(docs / KEPT, json.dumps(found, indent=1) + "\n")
    studies, measured = read_kept(docs)
    kept = json.loads((docs / KEPT).read_text(encoding="utf-8"))
    said = "\n".join(f"{number}. {words}" for number, words in enumerate(sentences(kept), 1))
    page = (docs / PAGE).read_text(encoding="utf-8")
    before, begin, rest = page.partition(BEGIN)
    if not begin or END not in rest:
        raise SystemExit(
            f"docs/{PAGE} lacks the marks {BEGIN.strip()} and {END}; put them where the table belongs"
        )
    told = f"{said}\n\n{table(studies, measured)}\n\n{searches(kept)}\n\n{conflicts(kept)}{beyond(studies, measured)}\n"
    write_text(docs / PAGE, f"{before}{begin}{told}{END}{rest.partition(END)[2]}")
    write_text(docs / "pictures" / PICTURE, svg(chart(studies, measured)))


if __name__ == "__main__":
    main(sys.argv[1:])
