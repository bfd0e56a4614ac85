"""Writes what the program prints into docs/tutorial.md, and draws its pictures: ``python
scripts/write_tutorial.py``.

Every block of bash is run as it stands, in one folder and in order; the block of text after it
becomes what it prints. A block of TOML is
put at the end of the case file, as the page asks for.
"""

from __future__ import annotations

import contextlib
import csv
import os
import re
import shlex
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "tutorial.md"
PICTURES = ROOT / "docs" / "pictures"
#: A command with what it prints, or an addition to the case file.
STEP = re.compile(
    r"^```bash\n(?P<command>.*?)^```\n\n```text\n(?P<printed>.*?)^```$|^```toml\n(?P<added>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)
BLUE, RED = "#1f5aa6", "#a33b53"


def printed_by(command: str) -> str:
    """What a command prints on a terminal of 88 columns. Raises RuntimeError where it fails."""
    from typer.testing import CliRunner

    from valvetrain.cli.main import app

    done = CliRunner(env={"COLUMNS": "88"}).invoke(
        app, shlex.split(command)[1:], prog_name="valvetrain"
    )
    if done.exit_code:
        raise RuntimeError(f"{command}\n{done.output}")
    return "\n".join(line.rstrip() for line in done.stdout.strip("\n").splitlines()) + "\n"


def run_page(
    text: str, wanted: Callable[[str], bool] = lambda command: True
) -> Iterator[tuple[re.Match[str], str]]:
    """Each command of the page that is ``wanted``, with what it prints, in this folder."""
    for step in STEP.finditer(text):
        if step["added"]:
            file = Path("my-train.toml")
            file.write_text(
                f"{file.read_text(encoding='utf-8')}\n{step['added']}", encoding="utf-8"
            )
        elif wanted(step["command"]):
            yield step, printed_by(step["command"])


def pictures(folder: Path) -> dict[str, str]:
    """File name -> SVG of the three pictures, from what the commands wrote."""
    import valvetrain as vt
    from valvetrain.report.chart import Chart, Line, Marks, Panel
    from valvetrain.report.svg_chart import svg

    spring = vt.load_case(folder / "spring" / "spring.toml").springs[0]
    curve = vt.static_curve(spring, "22 mm", spring_model="multi-mass")
    height = 1e3 * (spring.wire.free_length - curve.compression)
    loads = Marks(np.array([1.8, 1.2]) * 25.4, np.array([140.0, 375.0]) * 4.4482216, "card", RED)
    force = Panel("height (mm)", "force (N)", (Line(height, curve.force, "spring", BLUE), loads))

    run = vt.load_netcdf(next((folder / "run").glob("*.nc")))
    angle = np.degrees(run.cam_angle - run.cam_angle[0])
    lift = Panel(
        "cam angle (deg)",
        "valve lift (mm)",
        (Line(angle, 1e3 * run.channel("valve_lift"), "", BLUE),),
        x_range=(0, 360),
        x_step=45,
    )
    cam = Panel(
        "cam angle (deg)",
        "force on the cam (N)",
        (Line(angle, run.channel("cam_contact_force"), "", RED),),
        x_range=(0, 360),
        x_step=45,
    )

    speeds, least, above_rigid = swept(folder / "sweep" / "sweep-mine.csv")
    below = Panel(
        "engine speed (rpm)",
        "least force on the cam, valve open (N)",
        (Line(speeds, least, "", RED),),
    )
    above = Panel(
        "engine speed (rpm)",
        "lift above the rigid one (mm)",
        (Line(speeds, above_rigid, "", BLUE),),
    )
    return {
        "tutorial-spring.svg": svg(
            Chart("spring", "The spring of the card", "", (force,), height=300)
        ),
        "tutorial-run.svg": svg(
            Chart("run", "The train at 6500 rpm", "", (lift, cam), height=460, legend=False)
        ),
        "tutorial-sweep.svg": svg(
            Chart(
                "sweep",
                "The train over engine speed",
                "",
                (below, above),
                columns=2,
                height=320,
                legend=False,
            )
        ),
    }


def swept(file: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Engine speeds (rpm), least force on the cam with the valve open (N) and lift above the rigid
    one (mm) from the table of a sweep.
    """
    with file.open(encoding="utf-8", newline="") as lines:
        rows = list(csv.DictReader(lines))
    names = (
        "engine speed [rpm]",
        "least cam contact force while open [N]",
        "lift above the rigid one [mm]",
    )
    first, second, third = (np.array([float(row[name]) for row in rows]) for name in names)
    return first, second, third


def main() -> None:
    """Run the page, then write it and its pictures."""
    text = PAGE.read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as name, contextlib.chdir(name):
        os.environ["COLUMNS"] = "88"
        new, end = "", 0
        for step, printed in run_page(text):
            start, stop = step.span("printed")
            new, end = f"{new}{text[end:start]}{printed}", stop
        drawn = pictures(Path(name))
    PAGE.write_text(new + text[end:], encoding="utf-8")
    for file, picture in drawn.items():
        (PICTURES / file).write_text(picture, encoding="utf-8")


if __name__ == "__main__":
    main()
