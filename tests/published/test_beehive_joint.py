"""Published: spring and lift of examples/beehive-joint.toml have all that the joint study aims at,
at three speeds and on a finer mesh.
"""

from __future__ import annotations

import json

import numpy as np
import pytest

import valvetrain as vt
from architecture.layout import ROOT
from valvetrain.quantities.cycle import reported_cycle

#: What the joint study aims at: quantities and the largest relative difference from the published
#: value.
TARGETS = (
    (("stage_2_peak_force", "stage_2_first_peak_force", "stage_2_second_peak_force"), 0.05),
    (("stage_3_every_instant_peak_force",), 0.2), (("node_2_maximum_displacement",), 0.1),
)  # fmt: skip

#: Printed by the source: engine speed (rpm), quantity, value (SI); of two values (solid finite
#: elements, engine head) their middle.
PRINTED = (
    (4200, "stage_2_peak_force", 812.0), (5600, "stage_2_peak_force", 870.0), (8000, "stage_2_first_peak_force", 918.0),
    (8000, "stage_2_second_peak_force", 1125.0), (4200, "stage_3_every_instant_peak_force", 315.0),
    (5600, "stage_3_every_instant_peak_force", 620.0), (8000, "stage_3_every_instant_peak_force", 1430.0),
    (4200, "node_2_maximum_displacement", 0.05e-3), (5600, "node_2_maximum_displacement", 0.28e-3),
    (8000, "node_2_maximum_displacement", 0.68e-3),
)  # fmt: skip
#: What was not fitted and stands elsewhere than published (254.5 and 243 degrees, -2.685 m/s), as
#: docs/beehive.md says: SI, room.
ELSEWHERE = (
    (8000, "stage_3_peak_cam_angle", (np.radians(230.0), 0.03)), (8000, "node_2_maximum_displacement_cam_angle", (np.radians(221.0), 0.03)),
    (8000, "node_2_stage_3_minimum_velocity", (-4.0, 0.3)), (8000, "stage_3_below_20_khz_peak_force", (621.0, 30.0)),
)  # fmt: skip
SPEEDS = (4200, 5600, 8000)


@pytest.fixture(scope="module", params=[24, pytest.param(32, marks=pytest.mark.long)])
def found(request, tmp_path_factory):
    """Elements per coil, and each printed quantity as the rod computes it."""
    text = (ROOT / "examples" / "beehive-joint.toml").read_text(encoding="utf-8")
    assert text.count("\n[lift_law]\n") == 1
    place = tmp_path_factory.mktemp("joint") / "joint.toml"
    place.write_text(
        text.replace(
            "[lift_law]",
            f"[spring.options.finite-element]\nelements_per_coil = {request.param}\n\n[lift_law]",
        )
    )
    study = vt.simulate(
        str(place),
        [f"{speed} rpm" for speed in SPEEDS],
        spring_models=["finite-element"],
        workers=1,
    )
    runs = {
        speed: study.solution(study.labels[0], speed * np.pi / 30).quantities for speed in SPEEDS
    }
    fast = reported_cycle(study.solution(study.labels[0], 8000 * np.pi / 30))
    nodes = {
        (8000, coil): float(fast.at_coil("coil_gap", coil).max()) for coil in (1.83, 1.93, 2.0)
    }
    return request.param, {
        (speed, name): runs[speed][name] for speed, name, _ in (*PRINTED, *ELSEWHERE)
    } | nodes


def test_all_that_is_aimed_at_is_met_at_once(found):
    shares = {name: share for names, share in TARGETS for name in names}
    assert not {
        (speed, name): value
        for speed, name, value in PRINTED
        if abs(found[1][speed, name] / value - 1) > shares[name]
    }


def test_the_page_names_the_same_values(found):
    """The file holds its numbers to four or five digits; a finer mesh moves spikes by some 5 %,
    peaks by less than 1 %.
    """
    elements, values = found
    computed = json.loads(
        (ROOT / "docs" / "data" / "beehive" / "studies.json").read_text(encoding="utf-8")
    )["joint"]["targets"]["inside"]["computed"]
    for speed, name, _ in PRINTED:
        value = values[speed, name]
        room = 0.02 if elements == 24 else 0.02 if "stage_2" in name else 0.1
        assert value == pytest.approx(computed[f"{speed} rpm, finite-element: {name}"], rel=room), (
            speed,
            name,
        )


def test_its_angles_are_not_the_published_ones_as_the_page_says(found):
    for speed, name, (value, room) in ELSEWHERE:
        assert found[1][speed, name] == pytest.approx(value, abs=room), name
    page = (ROOT / "docs" / "beehive.md").read_text(encoding="utf-8")
    for coil, millimetres in ((1.83, 0.48), (1.93, 0.68), (2.0, 0.80)):
        assert found[1][8000, coil] == pytest.approx(
            millimetres * 1e-3, rel=0.06
        ) and f" {millimetres:.2f} mm" in page.replace("\n", " ")
    assert all(
        words in page
        for words in (
            "at 230 cam degrees",
            "221 degrees (243)",
            "4.0 m/s (2.7)",
            "621 of the\n1400 N",
        )
    )
