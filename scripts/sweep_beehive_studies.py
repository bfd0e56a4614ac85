"""Peak force of the beehive from 4000 to 16 000 rpm over the draws of two identifications:
docs/pictures/beehive-sweep.svg, a table.

python scripts/sweep_beehive_studies.py BLIND JOINT      folders of `valvetrain identify`; some ten
minutes on two cores
python scripts/sweep_beehive_studies.py                  picture and table anew from
docs/data/beehive/sweep.json
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from valvetrain.explore.draws import even_draws
from valvetrain.explore.evaluate import evaluate_points
from valvetrain.explore.identification_file import Request, read_request
from valvetrain.explore.point import Point, Wanted
from valvetrain.report import theme
from valvetrain.report.chart import Chart, Layer, Line, Panel, Rule
from valvetrain.report.svg_chart import svg
from valvetrain.solution.atomic import write_text

Array = NDArray[np.float64]
ROOT = Path(__file__).resolve().parents[1]
DATA, PICTURE, PAGE = (
    Path("data/beehive/sweep.json"),
    Path("pictures/beehive-sweep.svg"),
    Path("beehive.md"),
)
BEGIN, END = "<!-- sweep -->\n", "<!-- end of sweep -->"
STUDIES = ("blind", "joint")
FORCE, ENERGY = "peak_spring_force", "clash_energy"
#: Engine speeds (rpm), draws of each study, percentiles that are shown.
SPEEDS, DRAWS, PERCENTILES = np.arange(4000.0, 16001.0, 250.0), 40, (5.0, 50.0, 95.0)
#: Speeds (rpm) of the table, where the source's sequel reports its jump, and the force (N) between
#: its 900 before and 1500 to 1800 after.
SHOWN, JUMP, AFTER = (4000, 6000, 7000, 8000, 9000, 10000, 12000, 14000, 16000), 7800.0, 1200.0


def values_of_draws(request: Request, folder: Path, count: int = DRAWS) -> Array:
    """Values (draws, quantities), SI, of about ``count`` draws chosen evenly by weight."""
    with xr.open_dataset(folder / "draws.nc") as data:
        columns = {
            str(one.attrs["long_name"]): one.values
            for label, one in data.items()
            if str(label).startswith("quantity_")
        }
        weights = data["weight"].values
    places, _ = even_draws(weights, count, 1)
    return np.stack([columns[one.name][places] for one in request.unknowns], axis=1)


def forces_of(request: Request, draws: Array, speeds: Array = SPEEDS) -> tuple[Array, Array]:
    """Peak spring force (N) and clash energy (J) of each draw at each speed (draws, speeds); not a
    number where a run failed.
    """
    wanted = Wanted((FORCE, ENERGY))
    points = [
        Point(
            request.case,
            tuple(
                (key, float(value))
                for row, value in zip(request.varied, draw, strict=True)
                for key in row
            ),
            float(speed) * np.pi / 30,
            "finite-element",
            "",
            wanted,
        )
        for draw in draws
        for speed in speeds
    ]
    found = evaluate_points(points)
    told = [
        [one.values.get(name, np.nan) if one.status.completed else np.nan for one in found]
        for name in (FORCE, ENERGY)
    ]
    force, energy = (np.array(one).reshape(len(draws), len(speeds)) for one in told)
    return force, energy


def jumps(force: Array, speeds: Array = SPEEDS) -> Array:
    """Speed (rpm) of each draw at which its peak force first passes :data:`AFTER`, between the
    speeds of the grid by a straight line; not a
    number where it never does."""
    found = np.full(len(force), np.nan)
    for place, row in enumerate(force):
        known = np.flatnonzero(~np.isnan(row))
        above = known[row[known] > AFTER]
        if len(above):
            last = known[known < above[0]]
            found[place] = (
                speeds[above[0]]
                if not len(last)
                else np.interp(AFTER, row[[last[-1], above[0]]], speeds[[last[-1], above[0]]])
            )
    return found


def summary(force: Array, energy: Array, speeds: Array = SPEEDS) -> dict[str, Any]:
    """What is kept of one study: percentiles by speed, of the jump's speed, and runs that failed."""
    at = jumps(force, speeds)
    return {
        "draws": len(force),
        "failed_runs": int(np.isnan(force).sum()),
        "peak_spring_force_N": {f"{p:g} %": _over_draws(force, p, 1) for p in PERCENTILES},
        "clash_energy_mJ": {f"{p:g} %": _over_draws(1e3 * energy, p, 3) for p in PERCENTILES},
        "never_jumps": int(np.isnan(at).sum()),
        "jump_rpm": {
            f"{p:g} %": _rpm(
                float(np.percentile(np.where(np.isnan(at), np.inf, at), p, method="nearest"))
            )
            for p in PERCENTILES
        },
    }


def _over_draws(values: Array, percentile: float, digits: int) -> list[float | None]:
    """A percentile over the draws that came to their end, by speed; None where none did."""
    return [
        round(float(np.percentile(known, percentile)), digits)
        if len(known := one[~np.isnan(one)])
        else None
        for one in values.T
    ]


def _rpm(speed: float) -> int | None:
    return round(speed) if np.isfinite(speed) else None


def chart(kept: Mapping[str, Any]) -> Chart:
    """Median and 5 to 95 % of the peak force over the engine speed, of both studies."""
    speeds, layers = np.array(kept["engine_speed_rpm"]), list[Layer]()
    for place, name in enumerate(STUDIES):
        low, middle, high = (
            np.array(kept[name][FORCE + "_N"][f"{p:g} %"], dtype=float) for p in PERCENTILES
        )
        colour = theme.SERIES[place]
        layers.append(Line(speeds, middle, f"{name}, median", colour, 2.2))
        layers += [
            Line(speeds, one, f"{name}, 5 and 95 %", colour, 1.2, "dash", in_legend=one is low)
            for one in (low, high)
        ]
    panel = Panel(
        "engine speed (rpm)",
        "peak spring force (N)",
        tuple(layers),
        rules=(Rule("x", JUMP, "sequel: jump"),),
        x_step=2000,
    )
    return Chart(
        "beehive-sweep",
        "Peak force of the beehive over speed, draws of two identifications",
        "",
        (panel,),
        1,
        420,
    )


def table(kept: Mapping[str, Any]) -> str:
    """A row per speed: median and 5 to 95 % of the peak force of each study; last the speed of the
    jump.
    """
    lines = [
        "| engine speed | " + " | ".join(f"{name}, peak spring force" for name in STUDIES) + " |",
        "|---" * (len(STUDIES) + 1) + "|",
    ]
    for speed in SHOWN:
        place = kept["engine_speed_rpm"].index(speed)
        lines.append(
            f"| {speed} rpm | "
            + " | ".join(_cell(kept[n][FORCE + "_N"], place, "N") for n in STUDIES)
            + " |"
        )
    jump = " | ".join(
        _cell({key: [one] for key, one in kept[n]["jump_rpm"].items()}, 0, "rpm") for n in STUDIES
    )
    runs = len(kept["engine_speed_rpm"])
    failed = " and ".join(
        f"{kept[n]['failed_runs']} of {kept[n]['draws'] * runs} runs of the {n} study"
        for n in STUDIES
    )
    left = f"{failed} did not come to their end, by a stress that no steel carries, and are left out: the highest speeds show what remains."
    said = "; ".join(f"the {n} study {_where(kept[n]['jump_rpm'])}" for n in STUDIES)
    told = f"The sequel's {JUMP:.0f} rpm beside the 5 to 95 % of the speed at which the draws pass {AFTER:.0f} N: {said}."
    return "\n".join([*lines, f"| passes {AFTER:.0f} N at | {jump} |", "", told, "", left])


def _where(jump: Mapping[str, float | None]) -> str:
    low, high = (
        np.inf if (one := jump[f"{p:g} %"]) is None else one
        for p in (PERCENTILES[0], PERCENTILES[-1])
    )
    return "jumps earlier" if high < JUMP else "jumps later" if low > JUMP else "holds it"


def _cell(rows: Mapping[str, Sequence[float | None]], place: int, unit: str) -> str:
    none = "never" if unit == "rpm" else "–"
    low, middle, high = (
        none if (one := rows[f"{p:g} %"][place]) is None else f"{one:.0f}" for p in PERCENTILES
    )
    if {low, middle, high} == {none}:
        return none if unit == "rpm" else "no run to its end"
    return f"{middle} ({low} to {high}) {unit}"


def main(folders: Sequence[str], docs: Path = ROOT / "docs") -> None:
    """Compute where folders are given; write data, picture and table."""
    if len(folders) not in (0, len(STUDIES)):
        raise SystemExit(__doc__)
    if folders:
        found: dict[str, Any] = {"engine_speed_rpm": SPEEDS.tolist()}
        for name, folder in zip(STUDIES, folders, strict=True):
            request = read_request(ROOT / "examples" / f"identify-beehive-{name}.toml")
            found[name] = summary(*forces_of(request, values_of_draws(request, Path(folder))))
        write_text(docs / DATA, json.dumps(found, indent=1) + "\n")
    kept = json.loads((docs / DATA).read_text(encoding="utf-8"))
    page = (docs / PAGE).read_text(encoding="utf-8")
    before, begin, rest = page.partition(BEGIN)
    if not begin or END not in rest:
        raise SystemExit(
            f"docs/{PAGE} lacks the marks {BEGIN.strip()} and {END}; put them where the table belongs"
        )
    write_text(docs / PAGE, f"{before}{begin}{table(kept)}\n{END}{rest.partition(END)[2]}")
    write_text(docs / PICTURE, svg(chart(kept)))


if __name__ == "__main__":
    main(sys.argv[1:])
