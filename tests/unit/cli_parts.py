"""What the tests of the command line share: a spring small enough to run in a second, and two ways to call the commands."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from typer.testing import CliRunner, Result

from valvetrain.cli.main import app

SOURCE = Path(__file__).resolve().parents[2] / "src"
CODE = "from valvetrain.cli.main import main; main()"

#: Three clamped coils in motion, and published values made up to be met, missed and not computed.
SMALL = """
title = "Small spring in motion"

[spring]
wire_diameter = "3.8 mm"
mean_diameter = "22 mm"
pitch = "7 mm"
total_coils = 3
material = "OTEVA 90 SC"
ends = "open"

[installation]
precompression = "2 mm"
seats = "clamps"

[lift_law]
kind = "sine-power"
maximum_lift = "4 mm"
opening_start = "100 deg"
closing_end = "260 deg"
power = 4

[damping]
ratio = 0.02
ratio_frequency = "900 Hz"

[operation]
engine_speeds = "9000 rpm"
cycles = 1

[rod]
elements_per_coil = 6
output_step = "2 deg"

[[published]]
model = "solid finite elements"
role = "calibration"
source = "made up"
[published.quantities]
preload = { value = "130 N", tolerance = "50 %" }

[[published]]
model = "solid finite elements"
role = "prediction"
engine_speed = "9000 rpm"
source = "made up"
[published.quantities]
stage_2_peak_force = { value = "1 N", tolerance = "1 N" }
node_9_peak_acceleration = "1 m/s^2"
stage_2_peak_cam_angle = "181 deg"
"""


def call(*arguments: str) -> Result:
    """The command in this process; exit code, standard output and standard error apart."""
    return CliRunner().invoke(app, list(arguments), prog_name="valvetrain")


def process(*arguments: str, folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """The command as a process of its own in ``folder``."""
    command = [sys.executable, "-c", CODE, *arguments]
    return subprocess.run(command, capture_output=True, text=True, cwd=folder, timeout=120, env=process_environment(**environment))


def process_environment(**changes: str) -> dict[str, str]:
    """Environment in which a new interpreter finds the package."""
    return {**os.environ, "PYTHONPATH": str(SOURCE), **changes}


def sentence(result: Result | subprocess.CompletedProcess[str]) -> str:
    """The one error sentence; fails when there is more, or a traceback, or anything on standard output."""
    lines = result.stderr.splitlines()
    assert len(lines) == 1 and lines[0].startswith("error: "), result.stderr
    assert result.stdout == ""
    return lines[0]
