"""What the tests of the command line share: a spring small enough to run in a second, and two ways
to call the commands.
"""

from __future__ import annotations

import os
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

from typer.testing import CliRunner, Result

from valvetrain.cli.main import app

SOURCE = Path(__file__).resolve().parents[2] / "src"
MODULE = ("-m", "valvetrain")

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
precompression = "2 mm"
seats = "clamps"

[spring.damping]
ratio = 0.02
ratio_frequency = "900 Hz"

[spring.options.finite-element]
elements_per_coil = 6

[lift_law]
kind = "sine-power"
maximum_lift = "4 mm"
opening_start = "100 deg"
closing_end = "260 deg"
power = 4

[operation]
engine_speeds = "9000 rpm"
cycles = 1
output_step = "2 deg"
"""

#: What a source might have said of it.
PUBLISHED = """
[[published]]
model = "solid finite elements"
role = "calibration"
source = "made up"
[published.quantities]
preload = { value = "130 N", tolerance = "50 %" }

[[published]]
model = "finite-element"
role = "prediction"
engine_speed = "9000 rpm"
source = "made up"
[published.quantities]
peak_spring_force = { value = "1 N", tolerance = "1 N" }
seating_velocity = "1 m/s"
peak_spring_force_cam_angle = "181 deg"
"""


def typed(line: str) -> tuple[str, ...]:
    """The words of a command line as a shell parts them."""
    return tuple(shlex.split(line))


def call(*arguments: str) -> Result:
    """The command in this process; exit code, standard output and standard error apart."""
    return CliRunner().invoke(app, list(arguments), prog_name="valvetrain")


def process(*arguments: str, folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """The command as a process of its own in ``folder``."""
    command = [sys.executable, *MODULE, *arguments]
    return subprocess.run(
        command,
        capture_output=True,
        text=True,
        cwd=folder,
        timeout=120,
        env=process_environment(**environment),
    )


def process_environment(**changes: str) -> dict[str, str]:
    """Environment in which a new interpreter finds the package."""
    return {**os.environ, "PYTHONPATH": str(SOURCE), **changes}


def hear_interrupts() -> None:
    """Before a new process becomes the command: let SIGINT and SIGHUP reach it. Tests that a script
    runs in the background, or under
    nohup, have them ignored, and so would what they start, for good: that is how a shell keeps
    Ctrl-C from background jobs."""
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)


def sentence(result: Result | subprocess.CompletedProcess[str]) -> str:
    """The one error sentence; fails when there is more, or a traceback, or anything on standard
    output.

    That kernels are compiled, once on a fresh machine, is told before anything is known to be
    wrong.
    """
    lines = [
        line
        for line in result.stderr.splitlines()
        if not line.startswith("compiling kernels, once")
    ]
    assert len(lines) == 1 and lines[0].startswith("error: "), result.stderr
    assert result.stdout == ""
    return lines[0]


def wait_until(happened: Callable[[], bool], what: str, limit: float = 120.0) -> None:
    """Wait for an event, however busy the machine is; fails after ``limit`` seconds."""
    end = time.monotonic() + limit
    while not happened():
        assert time.monotonic() < end, f"waited {limit:g} s in vain: {what}"
        time.sleep(0.02)


def processor_time(process_id: int) -> float:
    """Processor time (s) that a process has used: it grows while the process works and stands while
    it waits.
    """
    stat = Path(f"/proc/{process_id}/stat")
    if stat.exists():
        fields = stat.read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    told = subprocess.run(
        ["ps", "-o", "cputime=", "-p", str(process_id)], capture_output=True, text=True, check=True
    ).stdout
    parts = [float(part) for part in told.strip().replace("-", ":").split(":")]
    return sum(part * 60**place for place, part in enumerate(reversed(parts)))
