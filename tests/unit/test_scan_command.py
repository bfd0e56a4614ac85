"""Unit: the command ``scan``: files, page and JSON of a spring out of a cloud, its design beside
it, and what is refused.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

from unit.cli_parts import call as invoke
from unit.cli_parts import typed
from valvetrain.errors import InputError
from valvetrain.parameters.loading import load_case
from valvetrain.scan.reconstruct import spring_from_scan, turned_over
from valvetrain.views.page import data_of

sys.path.insert(0, str(Path(__file__).parents[2] / "scripts"))
from sample_scan import Scanner, cloud, ply, springs, surface

#: The spring of the shipped job T, open ends and clamped, as the design that a cloud is made of.
DESIGN = "job-t"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with clouds of a left-handed spring and of the design."""
    place = tmp_path_factory.mktemp("scans")
    points, _ = cloud(springs()["conical"], 3000, Scanner(noise=0.03e-3, seed=4))
    (place / "conical.ply").write_bytes(ply(points))
    points, _ = cloud(load_case(DESIGN).springs[0].wire, 3000, Scanner(noise=0.03e-3, seed=6))
    np.savetxt(place / "design.xyz", 1e3 * points, fmt="%.4f")
    return place


@pytest.fixture(scope="module")
def answer(folder):
    """What the command says of the left-handed spring, and the folder it wrote."""
    found = invoke(
        "scan",
        str(folder / "conical.ply"),
        *typed("--name inner --json --output"),
        str(folder / "out"),
    )
    return json.loads(found.stdout), folder / "out"


def test_a_scan_gives_a_spring_that_a_case_takes(answer):
    data, out = answer
    assert (
        data["completed"]
        and data["hand"] == "left"
        and data["unit"] == "mm"
        and data["form"] == "PLY"
    )
    assert {path.rsplit("/")[-1] for path in data["files"]} >= {
        "spring.toml",
        "curves.csv",
        "report.html",
        "run.json",
    }
    assert data["findings"][0]["code"] == "Y113" and "verdict" not in data
    assert data["findings"][0]["step"].endswith(str(out / "spring.toml"))
    spring = load_case(str(out / "spring.toml")).springs[0]
    assert spring.name == "inner" and spring.wire.hand == "left"
    assert spring.wire.total_coils == pytest.approx(data["total_coils"]["value"])
    assert spring.wire.free_length == pytest.approx(data["free_length"]["value"], abs=3e-6)
    assert spring.wire.lower_end.kind == "closed-ground" == data["ends"]["lower"]["kind"]


def test_the_design_stands_beside_the_scan(folder):
    found = invoke(
        "scan",
        str(folder / "design.xyz"),
        *typed("--unit mm --design"),
        DESIGN,
        "--json",
        "--output",
        str(folder / "beside"),
    )
    data = json.loads(found.stdout)
    assert data["findings"][0]["code"] == "Y112"
    compared = {one["quantity"]: one for one in data["compared"]}
    assert compared["preload"]["scanned"] == pytest.approx(compared["preload"]["design"], rel=0.02)
    assert compared["mode_1_frequency"]["scanned"] == pytest.approx(
        compared["mode_1_frequency"]["design"], rel=0.02
    )
    page = (folder / "beside" / "report.html").read_text()
    assert {"data-curves", "data-force", "data-cloud"} <= set(data_of(page))
    spring = load_case(str(folder / "beside" / "spring.toml")).springs[0]
    assert spring.installed_height == pytest.approx(
        load_case(DESIGN).springs[0].installed_height, abs=5e-6
    )
    assert spring.seats == "clamps"


def test_turned_over_twice_is_the_same(folder, answer):
    scan = answer[0]
    other = spring_from_scan(folder / "conical.ply", turn_over=True)
    flipped = turned_over(other)
    assert flipped.curves.mean_diameter == pytest.approx(scan["curves"]["mean_diameter"], rel=1e-9)
    assert flipped.curves.height == pytest.approx(scan["curves"]["height"], abs=1e-9)
    assert flipped.curves.centre_line == pytest.approx(
        np.array(scan["curves"]["centre_line"]), abs=1e-9
    )
    assert other.definition.free_length == pytest.approx(flipped.definition.free_length, abs=1e-7)
    assert turned_over(flipped).curves.pitch == pytest.approx(other.curves.pitch, rel=1e-12)
    assert other.axis_direction == pytest.approx([-one for one in scan["axis"]["direction"]])
    assert other.hand == scan["hand"]


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ((), "does not say the unit of its length"),
        (("--unit", "kg"), "no unit of length"),
        (("--unit", "m"), "which no valve spring is"),
        (("--unit", "mm", "--points", "10"), "--points: 10 is outside 1500"),
        (("--unit", "mm", "--design", "job-t", "--turn-over"), "leave --turn-over out"),
        (
            ("--unit", "mm", "--design", "job-t", "--material", "OTEVA 90 SC"),
            "leave --material out",
        ),
        (("--unit", "mm", "--design", "tdi-pushrod"), "is a valvetrain; give a case"),
        (("--unit", "mm", "--material", "cheese"), "not in the library"),
    ],
)
def test_open_questions_and_contradictions_are_refused_in_one_sentence(
    folder, tmp_path, monkeypatch, more, words
):
    monkeypatch.chdir(tmp_path)
    shown = invoke("scan", str(folder / "design.xyz"), *more)
    assert (
        shown.exit_code == 2
        and words in " ".join(shown.output.split())
        and not list(tmp_path.iterdir())
    )


@pytest.mark.parametrize("kind", ["ball", "noise", "straight wire", "one turn"])
def test_clouds_that_show_no_spring_are_refused_in_one_sentence(tmp_path, kind):
    draw = np.random.default_rng(2)
    turn, around = draw.uniform(0, 1, 1800), draw.uniform(0, 2 * np.pi, 1800)
    points = {
        "ball": 15
        * (lambda one: one / np.linalg.norm(one, axis=1, keepdims=True))(
            draw.normal(size=(1800, 3))
        ),
        "noise": draw.uniform(-20, 20, (1800, 3)),
        "straight wire": np.column_stack([2 * np.cos(around), 2 * np.sin(around), 60 * turn]),
        "one turn": np.column_stack(
            [
                (12 + 2 * np.cos(around)) * np.cos(6.28 * turn),
                (12 + 2 * np.cos(around)) * np.sin(6.28 * turn),
                5 * turn + 2 * np.sin(around),
            ]
        ),
    }[kind]
    np.savetxt(tmp_path / "scan.xyz", points + draw.normal(0, 0.03, points.shape), fmt="%.4f")
    with pytest.raises(InputError) as refused:
        spring_from_scan(tmp_path / "scan.xyz", unit="mm")
    assert len(str(refused.value)) < 300


def one_sided(spring, first, width, count=9_000):
    """A cloud (mm) that a fixed scanner sees: no point in a sector of ``width`` degrees."""
    draw = np.random.default_rng(4)
    points = surface(spring, count, Scanner(), draw)
    points += draw.normal(0.0, 0.03e-3, points.shape)
    turn = np.mod(np.degrees(np.arctan2(points[:, 1], points[:, 0])) - first, 360.0)
    return 1e3 * draw.permutation(points[turn > width])


@pytest.mark.parametrize(
    ("name", "first"),
    [("conical", 200.0), pytest.param("cylindrical", 67.0, marks=pytest.mark.long)],
)
def test_a_sector_that_no_coil_shows_is_bridged_and_told_of(name, first, tmp_path):
    np.savetxt(tmp_path / "side.xyz", one_sided(springs()[name], first, 60.0), fmt="%.4f")
    found = spring_from_scan(tmp_path / "side.xyz", unit="mm")
    assert found.total_coils[0] == pytest.approx(springs()[name].total_coils, abs=0.05)
    assert np.degrees(found.coverage.sector) == pytest.approx(60.0, abs=3.1)


def test_what_cannot_be_bridged_is_named(tmp_path):
    """Half of the turn is not seen: no smooth curve tells how the coils go on behind it."""
    np.savetxt(tmp_path / "half.xyz", one_sided(springs()["cylindrical"], 67.0, 200.0), fmt="%.4f")
    with pytest.raises(InputError, match=r"sector of (19|20). degrees about the axis; scan that"):
        spring_from_scan(tmp_path / "half.xyz", unit="mm")
