"""An identification is the same for any number of workers, and goes on to the same end after it was
killed.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from typer.testing import CliRunner

import valvetrain as vt
from architecture.layout import PACKAGE
from study_parts import identification_plan
from valvetrain.cli.main import app
from valvetrain.explore.case_paths import vary
from valvetrain.explore.evaluate import evaluate_case
from valvetrain.explore.execution import Execution
from valvetrain.explore.identify import run_identification
from valvetrain.explore.observe import numbers_of
from valvetrain.explore.outputs import Run
from valvetrain.explore.store import FILE as STORED
from valvetrain.quantities.request import PointRequest

CARD = 'title = "card"\n[spring]\npreload = "250 N"\nrate = "32 N/mm"\nmass = "42 g"\n'
FILE = """
case = "card.toml"
[search]
method = "{method}"
live_points = 25
lanes = 4
starts = 6
keep = 2
[quantities.rate]
key = "spring.rate"
prior = "uniform"
low = "25 N/mm"
high = "40 N/mm"
[quantities.mass]
key = "spring.mass"
prior = "normal"
mean = "42 g"
standard_deviation = "6 g"
[measurements.load]
compressions = "12, 16 mm"
forces = "388, 520 N"
scatter = "4 N"
spring_model = "massless"
[measurements.ringing]
frequencies = "430 Hz"
scatter = "6 Hz"
spring_model = "wave-rod"
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "card.toml").write_text(CARD)
    return tmp_path


def bits(found: vt.explore.Identified) -> tuple[object, ...]:
    return (
        found.values.tobytes(),
        found.branch_of.tobytes(),
        repr(found.best),
        repr(found.log_evidence),
        repr(found.predicted),
        repr([branch.information.groups for branch in found.branches]),
        repr(found.note),
    )


@pytest.mark.parametrize(
    "method",
    ["least-squares", pytest.param("nested", marks=pytest.mark.long)],
)
def test_same_bits_for_any_number_of_workers(folder: Path, method: str) -> None:
    request = identification_plan(FILE.format(method=method), "card", folder)
    one, three = (run_identification(request, Execution(workers=count)) for count in (1, 3))
    assert bits(one) == bits(three)
    assert one.evaluations == three.evaluations > 20


def test_the_quick_numbers_at_rest_are_those_of_a_run(folder: Path) -> None:
    """Preload and frequencies by a model alone, beside all its numbers at rest."""
    seat = '[measurements.seat]\nquantity = "preload"\nvalue = "250 N"\nscatter = "1 N"\nspring_model = "wave-rod"\n'
    request = identification_plan(FILE.format(method="nested") + seat, "card", folder)
    case = vary(request.case, dict(zip(request.unknowns, (31e3, 0.044), strict=True)))
    whole = evaluate_case(
        case, Run(), PointRequest(("preload", "mode_1_frequency"), "wave-rod")
    ).values
    for station in dict.fromkeys(
        one.station for one in request.fitted.targets if one.kind == "quantity"
    ):
        quick = numbers_of(case, station, request.fitted.targets)
        assert quick == pytest.approx(
            {f"wave-rod: {name}": value for name, value in whole.items()}, rel=1e-12
        )


SLOW = """
import sys, time
import numpy as np
import valvetrain as vt

def surge(points):
    time.sleep({pause})
    return [{{"load": 7e-3 * rate, "surge": 0.5 * (rate / mass) ** 0.5}} for rate, mass in points]

priors = {{"rate": vt.explore.Prior("uniform", 20e3, 60e3), "mass": vt.explore.Prior("normal", centre=0.05, spread=0.01)}}
data = [vt.explore.Datum("load", 280.0, 2.0), vt.explore.Datum("surge", 447.0, 3.0)]
found = vt.identify(priors, data, surge, search=vt.explore.Search("nested", live_points=25, lanes=4), output=sys.argv[1])
print(found.values.tobytes().hex(), found.log_evidence, found.evaluations, found.reused)
"""


@pytest.mark.long
def test_killed_and_started_again_it_ends_as_if_it_had_not_been(tmp_path: Path) -> None:
    """SIGKILL while it samples; the second start computes only what the first had not, and gives
    the same bits.
    """
    environment = {**os.environ, "PYTHONPATH": str(PACKAGE.parent)}
    slow, fast = (SLOW.format(pause=pause) for pause in (0.005, 0))
    killed = subprocess.Popen([sys.executable, "-c", slow, str(tmp_path / "one")], env=environment)
    points = tmp_path / "one" / STORED
    deadline = time.monotonic() + 60
    while (
        not points.exists() or points.read_bytes().count(b"\n") < 100
    ) and time.monotonic() < deadline:
        time.sleep(0.02)
    killed.send_signal(signal.SIGKILL)
    assert killed.wait() == -signal.SIGKILL
    kept = points.read_bytes().count(b"\n")
    assert kept >= 99
    again, whole = (
        subprocess.run(
            [sys.executable, "-c", fast, str(tmp_path / name)],
            env=environment,
            capture_output=True,
            text=True,
            check=True,
        )
        for name in ("one", "two")
    )
    *first, computed, _ = again.stdout.split()
    *second, every, _ = whole.stdout.split()
    assert first == second
    assert int(computed) == int(every) - kept


def test_what_is_not_asked_for_changes_nothing(folder: Path) -> None:
    """The best point does not move with the number of draws, nor with a measurement that is only
    compared.
    """
    plain = FILE.format(method="least-squares")
    extra = '[measurements.seat]\nquantity = "preload"\nvalue = "260 N"\nscatter = "1 N"\nfit = false\nspring_model = "massless"\n'
    one = run_identification(
        identification_plan(plain, "card", folder),
        Execution(workers=1),
    )
    two = run_identification(
        identification_plan(
            plain.replace("keep = 2", "keep = 2\ndraws = 7") + extra, "card", folder
        ),
        Execution(workers=1),
    )
    assert one.best == two.best and one.branches[0].quantities == two.branches[0].quantities
    assert [one.datum.name for one in two.predicted if not one.datum.used] == ["seat"]


def test_points_of_one_fit_are_not_those_of_another_that_asks_more(folder: Path) -> None:
    """A measurement that was only compared is fitted: the points that are kept lack it, so they lie
    elsewhere.
    """
    seat = '[measurements.seat]\nquantity = "preload"\nvalue = "250 N"\nscatter = "1 N"\nspring_model = "multi-mass"\n'
    plain = FILE.format(method="least-squares")
    other = plain.replace("6 g", "5 g").replace("least-squares", "nested") + seat
    compared, fitted, again = (
        identification_plan(text, "card", folder).fitted.subject
        for text in (plain + seat + "fit = false\n", plain + seat, other)
    )
    assert compared != fitted
    assert again == fitted, "priors and the method leave the outcome of a point as it is"


def test_a_cut_search_with_a_folder_of_its_own_goes_on_there(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The message of the cut says to start the same command again: with ``--output`` too. Another
    command refuses that folder.
    """
    (folder / "card-rate.toml").write_text(FILE.format(method="least-squares"))
    monkeypatch.chdir(folder)
    request = identification_plan((folder / "card-rate.toml").read_text(), "card-rate.toml", folder)
    whole = run_identification(request, Execution(output=folder / "mine" / "points", workers=1))
    stored = folder / "mine" / "points" / STORED
    lines = stored.read_bytes().splitlines(keepends=True)
    stored.write_bytes(b"".join(lines[:20]))
    command = ["identify", "card-rate.toml", "--workers", "1", "--json", "--output", "mine"]
    told = CliRunner().invoke(app, command)
    assert told.exit_code == 0, told.output
    answer = json.loads(told.stdout)
    assert answer["reused"] == 20 and answer["evaluations"] == whole.evaluations - 20
    assert answer["branches"][0]["quantities"]["rate"]["best"] == whole.best["rate"]
    refused = CliRunner().invoke(app, ["run", "card.toml", "--output", "mine"])
    assert refused.exit_code == 2 and stored.exists()


@pytest.mark.slow
def test_the_command_keeps_what_it_found_and_goes_on_after_an_interrupt(folder: Path) -> None:
    """Ctrl-C, then the same command again: it goes on, and its folder holds answer, draws, page and
    points.
    """
    (folder / "card-rate.toml").write_text(
        FILE.format(method="nested").replace("live_points = 25", "live_points = 300")
    )
    command = [
        sys.executable,
        "-m",
        "valvetrain",
        "identify",
        "card-rate.toml",
        "--json",
        "--workers",
        "1",
    ]
    environment = {**os.environ, "PYTHONPATH": str(PACKAGE.parent)}
    started = subprocess.Popen(
        command,
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    deadline, points = time.monotonic() + 60, folder / "runs" / "identify" / "card-rate" / "points"
    while (
        not (points / STORED).exists() or (points / STORED).read_bytes().count(b"\n") < 800
    ) and time.monotonic() < deadline:
        time.sleep(0.02)
    started.send_signal(signal.SIGINT)
    out, said = started.communicate(timeout=60)
    assert started.returncode == 130 and "start the command again to continue" in said
    partial = json.loads(out)
    assert partial["whole"] is False and partial["branches"][0]["quantities"]["rate"]["best"] > 0
    (folder / "card-rate.toml").write_text(
        FILE.format(method="least-squares")
    )  # the points serve another method as well
    done = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, check=True
    )
    answer = json.loads(done.stdout)
    assert answer["completed"] and answer["method"] == "least-squares"
    kept = Path(folder / answer["folder"])
    assert {"report.html", "draws.nc", "identified.toml", "identify.json", "points"} <= {
        path.name for path in kept.iterdir()
    }
