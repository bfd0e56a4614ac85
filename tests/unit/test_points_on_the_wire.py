"""Unit: a case says at which coils the points of its published study are read, and everything that
speaks of them follows.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import valvetrain as vt
from valvetrain.cli.case_facts import case_facts
from valvetrain.explore.case_paths import vary
from valvetrain.explore.space import Varied
from valvetrain.quantities.cycle import reported_cycle


def beehive(**points):
    return vt.load_case(
        "gu2021-beehive-blind", {f"points.{name}": coil for name, coil in points.items()}
    )


def test_points_are_told_by_file_program_and_varied_quantity_alike():
    told = beehive(node_2=1.9)
    assert dict(told.points) == {"node_2": 1.9} and told.record().points == (("node_2", 1.9),)
    assert (
        vary(vt.load_case("gu2021-beehive-blind"), {Varied("points.node_2"): 1.9}).points
        == told.points
    )
    assert vary(told, {Varied("points.node_2", operation="offset"): 0.25}).points[
        "node_2"
    ] == pytest.approx(2.15)
    assert told.replace(points={"node_2": 1.8}).points["node_2"] == 1.8
    assert vt.load_case("gu2021-beehive-blind").replace(points={"node_2": 1.8}).points == {
        "node_2": 1.8
    }
    assert vt.load_case("gu2021-beehive-blind").points == {} and told != vt.load_case(
        "gu2021-beehive-blind"
    )
    assert ("points on the wire", "node 1 at coil 1, node 2 at coil 1.9") in case_facts(
        beehive(node_1=1, node_2=1.9)
    )


def test_a_written_case_keeps_its_points(tmp_path):
    path = tmp_path / "own.toml"
    path.write_text(beehive(node_2=1.9).text)
    assert vt.load_case(path).points == {"node_2": 1.9}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"points.node_3": 2.0}, "points.node_3: study 'gu2021' reads no point 'node_3'; .*node_2"),
        ({"points.node_2": 7.5}, "points.node_2: coil 7.5 is beyond the wire of 7 coils"),
        ({"points.node_2": -0.1}, "points.node_2: '-0.1' is too small"),
        ({"points.node_2": "2 mm"}, "points.node_2"),
        (
            {"points.node_2": 2.0, "study": ""},
            "points: the points are those that a published study reads",
        ),
        ({"points.node_2": 2.0, "study": "vasilyev2016"}, "reads no point 'node_2'; it names none"),
    ],
)
def test_points_that_nobody_reads_are_refused(changes, words):
    with pytest.raises(vt.InputError, match=words):
        vt.load_case("gu2021-beehive-blind", changes)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"points": {"node_3": 2.0}},
            "points.node_3: study 'gu2021' reads no point 'node_3'; .*node_2",
        ),
        ({"points": {"node_2": 7.5}}, "points.node_2: coil 7.5 is beyond the wire of 7 coils"),
        ({"points": {"node_2": -0.1}}, "points.node_2: coil -0.1 is beyond the wire"),
        ({"points": {"node_2": math.nan}}, "points.node_2: nan is no coil number"),
        ({"points": {"node_2": "near the tip"}}, "points.node_2: 'near the tip' is no coil number"),
        ({"points": {"node_2": True}}, "points.node_2: True is no coil number"),
        (
            {"points": {"node_2": 2.0}, "study": ""},
            "points: the points are those that a published study reads",
        ),
        (
            {"points": {"node_2": 2.0}, "study": "vasilyev2016"},
            "reads no point 'node_2'; it names none",
        ),
    ],
)
def test_points_set_in_a_program_are_refused_alike(changes, words):
    with pytest.raises(vt.InputError, match=words):
        vt.load_case("gu2021-beehive-blind").replace(**changes)


def test_numbers_of_nodes_are_read_where_the_case_says():
    """Of one run (same channels, same bits): node 2 is the channel at its coil, everything else is
    untouched.
    """
    coarse = {
        "spring.options.finite-element.elements_per_coil": 8,
        "operation.engine_speeds": "8000 rpm",
    }
    runs = {}
    for coil, points in ((2.0, {}), (1.9, {"points.node_2": 1.9})):
        case = vt.load_case("gu2021-beehive-blind", coarse | points)
        (runs[coil],) = vt.simulate(case, models=["finite-element"], workers=1).solutions
    for coil, run in runs.items():
        cycle = reported_cycle(run)
        gap, velocity = cycle.at_coil("coil_gap", coil), cycle.at_coil("axial_velocity", coil)
        first = cycle.cam_angle < np.radians(127.0)
        assert run.quantities["node_2_maximum_displacement"] == float(gap.max())
        assert run.quantities["node_2_stage_1_minimum_velocity"] == float(velocity[first].min())
    usual, moved = (dict(runs[coil].quantities) for coil in (2.0, 1.9))
    assert usual["node_2_maximum_displacement"] > 1.2 * moved["node_2_maximum_displacement"]
    untouched = {name for name in usual if not name.startswith("node_2")}
    assert "node_1_peak_acceleration" in untouched
    assert {name: usual[name] for name in untouched} == {name: moved[name] for name in untouched}
