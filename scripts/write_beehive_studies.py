"""Puts the identifications of the beehive side by side: docs/pictures/beehive-studies.svg and the table of docs/beehive.md.

valvetrain identify examples/identify-beehive-blind.toml --limit "5 d" --output BLIND        (and so on; 10 to 60 min each on two cores)
python scripts/write_beehive_studies.py BLIND JOINT WITHOUT-4200 WITHOUT-5600 WITHOUT-8000      a dash keeps what is kept of a study
python scripts/write_beehive_studies.py      picture and table anew from docs/data/beehive/studies.json
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
from numpy.typing import NDArray

from valvetrain.identification.file import Request, read_request
from valvetrain.identification.journal import read_points
from valvetrain.identification.posterior import Outcome, Posterior
from valvetrain.parameters.words import number
from valvetrain.report import theme
from valvetrain.report.chart import Chart, Layer, Line, Marks, Panel, Rule
from valvetrain.report.svg_chart import svg
from valvetrain.solution.atomic import write_text
from valvetrain.solution.definition import label_of, shown

DOCS = Path(__file__).resolve().parents[1] / "docs"
PAGE, PICTURE, KEPT = "beehive.md", "beehive-studies.svg", Path("data") / "beehive" / "studies.json"
STUDIES = ("blind", "joint", "without 4200 rpm", "without 5600 rpm", "without 8000 rpm")
#: Stands for a folder of which what is kept stays.
KEEP = "-"
BEGIN, END = "<!-- three studies -->\n", "<!-- end of three studies -->"
#: Computed over published value at which the picture ends.
EDGE = 2.0
#: What the joint study aims at: words, quantities, share of the published value.
TARGETS = (
    ("Stage II peaks", ("stage_2_peak_force", "stage_2_first_peak_force", "stage_2_second_peak_force"), 0.05),
    ("spikes of Stage III", ("stage_3_every_instant_peak_force",), 0.2),
    ("displacements of node 2", ("node_2_maximum_displacement",), 0.1),
)
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
    left_out = {key: row for speed, answer in without.items() for key, row in rows_of(answer, speed).items() if key in measured_of(joint)}
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
        "computed / published", "", tuple(layers), rules=(Rule("x", 1.0),), x_range=(0.0, EDGE), y_range=(0.3, len(measured) + 0.7),
        y_words=tuple((height[key], words_of(key).replace("largest ", "")) for key in measured),  # the room on the left
    )  # fmt: skip
    return Chart("beehive-studies", "The beehive by three identifications", "", (panel,), 1, 110 + 34 * len(measured))


def beyond(studies: Sequence[Beside], measured: Mapping[str, tuple[float, float]]) -> str:
    """A sentence on medians that lie beyond the edge of the picture, empty where there are none."""
    found = [
        f"{words_of(key)} ({study.words}, {row.middle / measured[key][0]:.1f} times the published value)"
        for study in studies for key, row in study.rows.items() if row.middle / measured[key][0] > EDGE
    ]  # fmt: skip
    return f"\n\nBeyond the right edge of the picture: {_list(found)}." if found else ""


def table(studies: Sequence[Beside], measured: Mapping[str, tuple[float, float]]) -> str:
    """A row per published value: median, interval, the percentile at which the published value lies, whether the study was fitted to it."""
    lines = ["| | published | " + " | ".join(study.words for study in studies) + " |", "|---" * (len(studies) + 2) + "|"]
    for key, (value, scatter) in measured.items():
        name = key.rpartition(": ")[2]
        unit = shown(name, 1.0)[1]
        cells = [_cell(study.rows.get(key), name) for study in studies]
        lines.append(f"| {words_of(key)} | {_in(name, value)} ± {_in(name, scatter)} {unit} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _in(name: str, value: float) -> str:
    told, unit = shown(name, value)
    return number(float(told), 4 if unit == "deg" else 3)


def _cell(row: Row | None, name: str) -> str:
    if row is None:
        return "–"
    told = "" if row.percentile is None else f", {row.percentile:.0f} %"
    return f"{_in(name, row.middle)} ({_in(name, row.low)} to {_in(name, row.high)}{told}{', fitted' if row.fitted else ''})"


def sentences(kept: Mapping[str, Any]) -> tuple[str, ...]:
    """What the data tell and what not, in five sentences, every number and verdict from what is kept."""
    blind, joint = kept["blind"], kept["joint"]
    ahead = [row for row in blind["measurements"] if not row["fitted"]]
    told = measured_of(joint)
    without = [
        row for name, one in kept.items() if name.startswith("without ") for row in one["measurements"]
        if row["key"].startswith(f"{name.removeprefix('without ')}, ") and row["key"] in told
    ]  # fmt: skip
    earlier = mirrored(kept)
    known = sorted((name for name, share in blind["told"].items() if share > 0.5), key=lambda name: -blind["told"][name])
    open_ = [name for name, share in blind["told"].items() if share < 0.1]
    short = unfinished(kept)
    never = [row for row in joint["measurements"] if _apart(row) > 0]
    return (
        f"From statics, modes and 4200 rpm alone {_inside(ahead)} of the {len(ahead)} values published at 5600 and 8000 rpm lie within "
        f"the central 95 % of the draws{_outside(ahead)}.",
        f"Those data determine {_named(known)} (more than half of the variance of the prior is gone) and say next to nothing of "
        f"{_named(open_)} (less than a tenth).",
        _fitted(joint),
        _contradictions(kept, never),
        f"Each speed from the other two{earlier}: {_inside(without)} of {len(without)} values lie within the central 95 %"
        + _outside(without)
        + (f". The searches {_list(short)} did not come to their end, so that their misses prove nothing." if short else "."),
    )  # fmt: skip


def _fitted(joint: Mapping[str, Any]) -> str:
    """How near the joint study comes to what it aims at, by its likeliest point and by any."""
    rows = joint["measurements"]
    met = ", ".join(_met(rows, *target) for target in TARGETS)
    return f"Fitted to all three speeds, the likeliest spring and lift have {met}{_beside(rows)}{_all_at_once(joint)}."


def _contradictions(kept: Mapping[str, Any], never: Sequence[Mapping[str, Any]]) -> str:
    """Of what the joint study misses, what a search meets once a speed is left out, and what none meets that was fitted to it."""
    if not never:
        return "The central 95 % of the joint study come within two scatters of every published value: no contradiction is shown."
    missed = f"The central 95 % of the joint study miss {_list([_missed(row) for row in never])} by more than two scatters"
    if mirrored(kept):
        return f"{missed}; what else is lost where they are met stands in the last table."
    freed: dict[str, list[str]] = {}
    for row in never:
        meets = [name for name, one in kept.items() if name.startswith("without ") and any(
            other["key"] == row["key"] and other["fitted"] and _apart(other) <= 0 for other in one["measurements"]
        )]  # fmt: skip
        freed.setdefault(" or ".join(meets), []).append(words_of(row["key"]))
    told = [
        f"{_list(words)} {'are' if len(words) > 1 else 'is'} " + (f"met {name}" if name else "met by no search that was fitted to them")
        for name, words in freed.items()
    ]  # fmt: skip
    return f"{missed}: {'; '.join(told)}."


def mirrored(kept: Mapping[str, Any]) -> str:
    """Words where the searches that leave a speed out have lifts mirrored about their nose, which the joint one has not: they tell less."""
    own = "event_end" in kept["joint"]["quantities"]
    earlier = [name for name, one in kept.items() if name.startswith("without ") and own and "event_end" not in one["quantities"]]
    return ", under lifts mirrored about their nose and fitted to heights alone" if earlier else ""


def searches(kept: Mapping[str, Any]) -> str:
    """A row per search: its method, the points it computed, the misfit it ends at and what it says of itself."""
    lines = ["| study | method | points | least misfit | what the search says of itself |", "|---|---|---|---|---|"]
    for name, one in kept.items():
        lines.append(f"| {name} | {one['method']} | {one['points']} | {one['misfit']:.1f} | {_said(kept, name)} |")
    return "\n".join(lines)


def conflicts(kept: Mapping[str, Any]) -> str:
    """What the likeliest spring of the joint study misses, what meeting it costs and what is missed instead."""
    rows = kept["joint"]["conflicts"]
    if not rows:
        return "The likeliest spring and lift of the joint study miss no published value by more than two scatters."
    lines = [
        "| missed by the likeliest spring and lift of the joint study | by, in scatters | computed points that meet it | misfit of the "
        "likeliest of them, above the least | it misses instead |",
        "|---|---|---|---|---|",
    ]
    for row in rows:
        instead = [f"{words_of(one['key'])} ({one['scatters']:+.1f})" for one in row["missed_instead"]]
        lines.append(
            f"| {words_of(row['key'])} | {row['scatters']:+.1f} | {row['points_that_meet_it']} | "
            + (f"{row['cost']:.1f} | {_list(instead) if instead else 'nothing more'} |" if row["points_that_meet_it"] else "– | – |")
        )
    return "\n".join(lines)


def unfinished(kept: Mapping[str, Any]) -> list[str]:
    """Searches that leave a speed out and end above the joint one, which meets their data and more: they have not come to their end."""
    if mirrored(kept):  # other data, other quantities
        return []
    return [name for name, one in kept.items() if name.startswith("without ") and one["misfit"] > kept["joint"]["misfit"]]


def _said(kept: Mapping[str, Any], name: str) -> str:
    """Warnings of a search, those of single quantities and of combinations counted."""
    warnings = kept[name]["warnings"]
    hardly, apart = (sum(words in one for one in warnings) for words in ("hardly tell", "cannot tell"))
    own = [one for one in warnings if "hardly tell" not in one and "cannot tell" not in one]
    own += (
        [f"not at its end: the joint study meets these data and more at {kept['joint']['misfit']:.1f}"] if name in unfinished(kept) else []
    )
    own += [f"{hardly} quantities are hardly told"] if hardly else []
    own += [f"{apart} combinations are not told apart"] if apart else []
    return "; ".join(own) or "nothing"


def _inside(rows: Sequence[Mapping[str, Any]]) -> int:
    return sum(row["low"]["value"] <= row["measured"]["value"] <= row["high"]["value"] for row in rows)


def _outside(rows: Sequence[Mapping[str, Any]]) -> str:
    """Values outside their interval by speed, in words: their numbers stand in the table."""
    found: dict[str, list[str]] = {}
    for row in rows:
        if not row["low"]["value"] <= row["measured"]["value"] <= row["high"]["value"]:
            speed, _, words = words_of(row["key"]).partition(": ")
            found.setdefault(speed, []).append(words)
    return "; outside: " + "; ".join(f"at {speed} {_list(words)}" for speed, words in found.items()) if found else ""


def _missed(row: Mapping[str, Any]) -> str:
    name = row["key"].rpartition(": ")[2]
    low, high = (_in(name, row[end]["value"]) for end in ("low", "high"))
    return f"{words_of(row['key'])} ({low} to {high}, published {_in(name, row['measured']['value'])} {shown(name, 1.0)[1]})"


def _apart(row: Mapping[str, Any]) -> float:
    """By how much the interval misses the published value and two of its scatters."""
    value, room = row["measured"]["value"], 2 * row["scatter"]["value"]
    return float(max(row["low"]["value"] - (value + room), value - room - row["high"]["value"]))


def _met(rows: Sequence[Mapping[str, Any]], words: str, names: Sequence[str], share: float) -> str:
    here = _aimed_at(rows, names)
    return f"{len(here) - len(_far(here, share))} of {len(here)} {words} within {100 * share:.0f} %"


def _beside(rows: Sequence[Mapping[str, Any]]) -> str:
    """What the likeliest spring and lift have of each value that lies outside its target."""
    far = [row for _, names, share in TARGETS for row in _far(_aimed_at(rows, names), share)]
    told = [
        f"{words_of(row['key'])} ({_in(row['key'].rpartition(': ')[2], row['computed']['value'])}, published "
        f"{_in(row['key'].rpartition(': ')[2], row['measured']['value'])} {shown(row['key'].rpartition(': ')[2], 1.0)[1]})" for row in far
    ]  # fmt: skip
    return f"; outside: {_list(told)}" if told else ""


def _all_at_once(joint: Mapping[str, Any]) -> str:
    """Whether a computed point has all of it at once."""
    told = joint["targets"]
    if not told["meet_all"]:
        return f"; none of the {told['points']} springs that the search computed has all {told['aims']} at once"
    above = told["inside"]["misfit"] - joint["misfit"]
    return (
        f"; {told['meet_all']} of the {told['points']} springs that the search computed have all {told['aims']} at once, the one farthest "
        f"inside them ([beehive-joint.toml](../examples/beehive-joint.toml)) at a misfit {above:.1f} above the least"
    )


def _aimed_at(rows: Sequence[Mapping[str, Any]], names: Sequence[str]) -> list[Mapping[str, Any]]:
    return [row for row in rows if row["key"].rpartition(": ")[2] in names]


def _far(rows: Sequence[Mapping[str, Any]], share: float) -> list[Mapping[str, Any]]:
    return [row for row in rows if abs(row["computed"]["value"] / row["measured"]["value"] - 1) > share]


def _named(names: Sequence[str]) -> str:
    return _list([name.replace("_", " ") for name in names]) if names else "none of the quantities"


def _list(words: Sequence[str]) -> str:
    return " and ".join([", ".join(words[:-1]), words[-1]]) if len(words) > 1 else words[0]


def kept_of(answer: Mapping[str, Any]) -> dict[str, Any]:
    """What the page stands on, of the answer of one identification: rows, quantities of the likeliest branch, warnings, count of points."""
    names = ("key", "measured", "scatter", "fitted", "computed", "low", "middle", "high", "percentile")
    return {
        "method": answer["method"], "points": answer["evaluations"] + answer["kept_from_before"], "warnings": answer["warnings"],
        "branches": len(answer["branches"]), "misfit": answer["branches"][0]["misfit"],
        "quantities": {
            name: {key: value for key, value in one.items() if key in ("best", "low", "high")}
            for name, one in answer["branches"][0]["quantities"].items()
        },
        "told": answer["branches"][0]["told"],
        "measurements": [{name: row[name] for name in names} for row in answer["measurements"]],
        "conflicts": answer["conflicts"],
    }  # fmt: skip


def targets_of(points: Sequence[tuple[NDArray[np.float64], Outcome]], request: Request) -> dict[str, Any]:
    """How many of the computed points of a search meet all of :data:`TARGETS` at once, and the one that lies farthest inside them."""
    posterior = Posterior(request.unknowns, request.data, lambda values: [None] * len(values))
    aims = [(one, share) for _, names, share in TARGETS for one in posterior.used if one.key.rpartition(": ")[2] in names]
    if not aims:
        raise SystemExit("the joint search was fitted to none of what it aims at; give the folders in the order of the use above")
    possible = [(values, outcome) for values, outcome in points if outcome is not None and posterior.residuals(outcome) is not None]
    worst = [max(abs(outcome[one.key] / one.value - 1) / share for one, share in aims) for _, outcome in possible]
    found: dict[str, Any] = {"aims": len(aims), "points": len(possible), "meet_all": int(np.sum(np.array(worst) <= 1))}
    if found["meet_all"]:
        values, outcome = possible[int(np.argmin(worst))]
        off, pulls = posterior.residuals(outcome), posterior.pulls(posterior.work_of(values[None, :])[0])
        found["inside"] = {
            "misfit": float(off @ off + pulls @ pulls),
            "quantities": dict(zip((one.name for one in request.unknowns), values.tolist(), strict=True)),
            "computed": {one.key: outcome[one.key] for one in posterior.used},
        }
    return found


def read_folders(folders: Sequence[str], docs: Path) -> dict[str, Any]:
    """What is kept of five folders, for :data:`KEEP` what was kept before. Raises :class:`SystemExit` where one was cut short."""
    kept = json.loads((docs / KEPT).read_text(encoding="utf-8")) if KEEP in folders else dict.fromkeys(STUDIES)
    for name, folder in zip(STUDIES, folders, strict=True):
        if folder != KEEP:
            answer = json.loads((Path(folder) / "run.json").read_text(encoding="utf-8"))
            if not answer["whole"]:
                raise SystemExit(f"the identification in '{folder}' was cut short; start it again, it goes on")
            kept[name] = kept_of(answer)
    joint = Path(folders[STUDIES.index("joint")])
    if str(joint) == KEEP:
        return kept
    request = read_request(joint / "identification.toml")
    kept["joint"]["targets"] = targets_of(read_points(joint / "points.jsonl", len(request.unknowns)), request)
    return kept


def read_kept(docs: Path = DOCS) -> tuple[tuple[Beside, ...], dict[str, tuple[float, float]]]:
    """The three studies and the published values from what is kept."""
    kept = json.loads((docs / KEPT).read_text(encoding="utf-8"))
    without = {name.removeprefix("without "): one for name, one in kept.items() if name.startswith("without ")}
    return three_studies(kept["blind"], kept["joint"], without), measured_of(kept["blind"])


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
        raise SystemExit(f"docs/{PAGE} lacks the marks {BEGIN.strip()} and {END}; put them where the table belongs")
    told = f"{said}\n\n{table(studies, measured)}\n\n{searches(kept)}\n\n{conflicts(kept)}{beyond(studies, measured)}\n"
    write_text(docs / PAGE, f"{before}{begin}{told}{END}{rest.partition(END)[2]}")
    write_text(docs / "pictures" / PICTURE, svg(chart(studies, measured)))


if __name__ == "__main__":
    main(sys.argv[1:])
