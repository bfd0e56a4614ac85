"""Examples: every command and every program that a page of the documentation shows is run by a
test, here or by the page's own.

What takes long runs with less to do in every run, and as it stands with ``make test-long``.
"""

from __future__ import annotations

import contextlib
import re
import shlex
import sys
from pathlib import Path

import numpy as np
import pytest

import valvetrain as vt
from unit.cli_parts import call
from valvetrain.cam import build_lift_law
from valvetrain.workbench import command as serve
from valvetrain.workbench import pages

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))

import sample_scan  # noqa: E402

FENCED = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)
#: Page or folder of pages -> the module of tests that runs what stands there.
RUN_BY_ITS_OWN_TEST = {
    "README.md": "test_readme", "docs/public-names.md": "test_readme", "docs/python.md": "test_readme",
    "docs/tutorial.md": "test_tutorial", "docs/clusters.md": "test_clusters_page", "docs/how-to/": "test_how_to", "docs/extend/": "test_add_pages",
    "docs/film.md": "test_film_page", "docs/identification.md": "test_identification_page", "docs/case-files.md": "test_case_file_guide",
    "docs/case-files-trains.md": "test_train_case_guide", "docs/model-against-test.md": "test_model_against_test_page",
    "docs/rig-data.md": "test_rig_data_page", "docs/springs-from-cards.md": "test_springs_from_cards_page",
}  # fmt: skip
#: Those that run the TOML and the Python of their pages, not the commands.
RUN_BUT_FOR_COMMANDS = {
    "docs/motion.md": "test_motion_page",
    "docs/studies.md": "test_studies_page",
    "docs/optimisation.md": "test_optimisation_page",
}
#: Commands of the remaining pages that take up to some seconds, and those that take longer.
QUICK = (
    "valvetrain new my-train --kind pushrod",
    "valvetrain lift lobe.dat --angle-of cam --lift-of tappet --lift-unit mm",
    'valvetrain lift intake.s96 --exhaust exhaust.s96 --lift-of tappet --lift-unit inch --at "0.2 inch"',
    'valvetrain lift --events "IVO 5 after top, IVC 32.5 after bottom, EVO 40 BBDC, EVC 10 ATDC"', "valvetrain lift own.toml",
    'valvetrain lift lobe.dat --angle-of cam --lift-of tappet --lift-unit mm --lobe-centre "108.75 deg"',
    "valvetrain lift contour.csv --follower flat",
    'valvetrain lift lobe.dat --angle-of cam --lift-of tappet --lift-unit mm --follower "roller 10 mm" --base-radius "15 mm"',
    "valvetrain serve", "valvetrain serve --folder head-2027 --port 0 --no-open",
    'valvetrain serve --most-running 2 --limit "30 min" --limit "8 GB"',
)  # fmt: skip
SLOW = (
    "valvetrain branches tdi-pushrod --spring-set stock --rpm 9400:9600:50",
    "valvetrain run my-train.toml --open",
    "valvetrain sweep my-train.toml --rpm 3000:8000:250",
    "valvetrain lift lobe.dat --angle-of cam --lift-of tappet --lift-unit mm --case own.toml "
    '--rpm "6000 rpm" --search "4000:9000:500 rpm"',
    "valvetrain scan FOLDER/beehive-as-made.ply --design gu2021-beehive-blind",
    "valvetrain study examples/studies/beehive-tolerances.toml", "valvetrain study examples/studies/two-quantities.toml",
    "valvetrain study examples/studies/train-seating.toml", "valvetrain optimise examples/optimise-spring-loads.toml",
)  # fmt: skip
#: Commands of an hour or more. What they print stands on their pages, which scripts write; their
#: parts are computed by other tests.
HOURS = {
    "valvetrain optimise examples/optimise-beehive.toml", "valvetrain refine gu2021-beehive-blind [--json]",
    "valvetrain refine tdi-pushrod [--json]",
}  # fmt: skip


def page_texts() -> dict[str, str]:
    """Name of each page with code -> its text."""
    paths = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    return {path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8") for path in paths}


def runs_itself(name: str) -> bool:
    return any(
        name == one or (one.endswith("/") and name.startswith(one)) for one in RUN_BY_ITS_OWN_TEST
    )


def commands_of(text: str) -> list[str]:
    """Commands in blocks and in indented lines, without their comments."""
    lines = [
        line
        for language, code in FENCED.findall(text)
        if language in ("sh", "bash")
        for line in code.splitlines()
    ]
    lines += re.findall(r"^    (valvetrain .*)$", text, re.MULTILINE)
    return [re.sub(r"\s+#.*", "", line).strip() for line in lines if line.startswith("valvetrain ")]


def test_every_command_of_the_documentation_is_run_by_a_test():
    shown = {
        line
        for name, text in page_texts().items()
        if not runs_itself(name)
        for line in commands_of(text)
    }
    assert shown == {*QUICK, *SLOW, *HOURS}
    for name, module in (RUN_BY_ITS_OWN_TEST | RUN_BUT_FOR_COMMANDS).items():
        assert name.rstrip("/").rpartition("/")[2] in (
            Path(__file__).parent / f"{module}.py"
        ).read_text(encoding="utf-8"), name


def test_every_program_and_every_case_of_the_documentation_is_run_by_a_test():
    left = {
        name: kind
        for name, text in page_texts().items()
        if not runs_itself(name) and name not in RUN_BUT_FOR_COMMANDS
        for kind, _ in FENCED.findall(text)
        if kind in ("python", "toml")
    }
    assert left == {"docs/index.md": "python", "docs/measured-lifts.md": "toml"}  # the tests below


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Where a reader of the pages stands: the tables that they name, and the examples."""
    place = tmp_path_factory.mktemp("reader")
    (place / "examples").symlink_to(ROOT / "examples")
    write_lobes(place)
    return place


def write_lobes(place: Path) -> None:
    """A tappet's lift in mm over the cam angle, two in inches at whole degrees, and a train of
    one's own to put it into.
    """
    angle = np.arange(360.0)
    lift = 1.6e3 * build_lift_law(vt.load_case("tdi-pushrod").lift_law).lift(np.deg2rad(angle))
    (place / "lobe.dat").write_text(
        "\n".join(f"{one:g} {value:.5f}" for one, value in zip(angle, lift, strict=True)) + "\n"
    )
    radius = 4 * np.cos(np.deg2rad(angle)) + np.sqrt(18**2 - (4 * np.sin(np.deg2rad(angle))) ** 2)
    rows = (f"{one:g},{value:.6f}" for one, value in zip(angle, radius, strict=True))
    (place / "contour.csv").write_text("\n".join(("angle [deg],radius [mm]", *rows)) + "\n")
    for name in ("intake", "exhaust"):
        around = [*lift, *lift[:36]]
        (place / f"{name}.s96").write_text(
            "\n".join(f"{value / 25.4:.6f}" for value in around) + "\n"
        )
    run(place, "valvetrain new own --kind direct")


def run(folder: Path, line: str) -> str:
    """What a command prints that ends well."""
    with contextlib.chdir(folder):
        done = call(*shlex.split(line)[1:])
    assert done.exit_code == 0, done.output + done.stderr
    return done.stdout


@pytest.fixture
def quiet_rim(monkeypatch) -> list[object]:
    """Neither a browser nor a server starts: what would be shown and served is noted."""
    noted: list[object] = []
    monkeypatch.setattr("webbrowser.open", lambda address, *_: noted.append(address) or True)
    monkeypatch.setattr(
        pages, "start", lambda workspace, jobs, settings, listening: noted.append(settings)
    )
    monkeypatch.setattr(serve, "find_spec", lambda _: True)
    return noted


@pytest.mark.parametrize("line", QUICK)
def test_a_quick_command_of_a_page_runs(folder, quiet_rim, line):
    run(folder, line)
    assert bool(quiet_rim) == (" serve" in line or "--open" in line)


#: What makes a long command short: fewer speeds and points. Everything else of it stays.
SHORTER = (
    ("3000:8000:250", "3000:3500:250"), ("gu2021-beehive-blind --rpm 3000:9000:500", "job-t --rpm 3000:9000:6000"),
    ("2000:9000:500", "2000:9000:7000"), (' --search "4000:9000:500 rpm"', " --draws 4"),
    (" --design gu2021-beehive-blind --rpm \"5600 rpm\"", ""),
)  # fmt: skip
#: The same in the files of studies and searches.
FEWER = (
    (r"^count = \d+", "count = 8"),
    (r"^levels = \d+", "levels = 2"),
    (r"^trials = \d+", "trials = 3"),
)


def shorter(folder: Path, line: str) -> str:
    """The command with less to do; the file that it names is copied with fewer points."""
    for words, short in SHORTER:
        line = line.replace(words, short)
    if found := re.search(r"examples/(\S+)\.toml", line):
        text = (ROOT / found[0]).read_text(encoding="utf-8")
        for count, less in FEWER:
            text = re.sub(count, less, text, flags=re.MULTILINE)
        name = f"{Path(found[1]).name}.toml"
        (folder / name).write_text(text, encoding="utf-8")
        line = line.replace(found[0], name)
    return line


def prepared(folder: Path, line: str, points: int) -> str:
    """The command, once what it needs is there: a cloud, a case or an earlier run."""
    if "FOLDER" in line:
        sample_scan.main(folder, points)
    for name in ("my-train", "my-engine"):
        if name in line and not (folder / f"{name}.toml").exists():
            run(folder, f"valvetrain new {name} --kind pushrod")
    if "latest" in line and not (folder / "runs" / "vaz-ohc").exists():
        run(folder, "valvetrain run vaz-ohc --model massless")
    return line.replace("FOLDER", str(folder))


@pytest.mark.parametrize("line", SLOW)
def test_a_long_command_of_a_page_runs_with_less_to_do(folder, line):
    assert run(folder, prepared(folder, shorter(folder, line), 3000))


@pytest.mark.long
@pytest.mark.parametrize("line", SLOW)
def test_a_long_command_of_a_page_runs_as_it_stands(folder, line):
    assert run(folder, prepared(folder, line, 20_000))


def test_the_program_of_the_first_page_runs():
    (code,) = (
        code for kind, code in FENCED.findall(page_texts()["docs/index.md"]) if kind == "python"
    )
    names: dict[str, object] = {}
    exec(compile(code, "index.md", "exec"), names)
    assert names["study"].solutions[0].status.completed


def test_a_measured_lift_of_the_page_is_a_case_s(folder):
    (block,) = (
        code
        for kind, code in FENCED.findall(page_texts()["docs/measured-lifts.md"])
        if kind == "toml"
    )
    text = re.sub(
        r"^\[lift_law\]\n.*?(?=^\[)",
        block + "\n",
        (folder / "own.toml").read_text(),
        flags=re.MULTILINE | re.DOTALL,
    )
    assert block.splitlines()[1] in text
    (folder / "measured.toml").write_text(text)
    run(folder, "valvetrain check measured.toml")
