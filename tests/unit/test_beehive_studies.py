"""Unit: three identifications side by side, from answers of known numbers: each cell, bar and mark
carries what it names.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

from architecture.layout import ROOT
from beehive_parts import assert_written_anew
from valvetrain.explore.solve import Journal

sys.path.insert(0, str(ROOT / "scripts"))
import write_beehive_studies as script
from beehive_sentences import ANGLES, BANDS
from write_beehive_studies import BEGIN, END, chart, main, measured_of, table, three_studies

REST, SLOW, FAST = (
    "preload",
    "4200 rpm, finite-element: stage_2_peak_force",
    "8000 rpm, finite-element: node_2_maximum_displacement",
)


def answer(shift: float, fitted: tuple[str, ...], whole: bool = True) -> dict:
    """Medians ``shift`` times the published value, 10 % of it to either side."""
    rows = []
    for key, value, scatter, unit in (
        (REST, 289.0, 1.5, "N"),
        (SLOW, 812.0, 8.0, "N"),
        (FAST, 0.68e-3, 0.068e-3, "m"),
    ):
        numbers = {
            "measured": value,
            "scatter": scatter,
            "computed": (shift + 0.01) * value,
            "low": (shift - 0.1) * value,
            "middle": shift * value,
            "high": (shift + 0.1) * value,
        }
        rows.append(
            {
                "key": key,
                **{name: {"value": one, "unit": unit} for name, one in numbers.items()},
                "fitted": key in fitted,
                "percentile": 97.0,
            }
        )
    wire = {"best": 3.9e-3, "mean": 3.8e-3, "low": 3.7e-3, "high": 4.0e-3}
    branch = {
        "misfit": 7.5,
        "told": {"wire": 0.9, "flank_control_1": 0.05},
        "quantities": {"wire": {key: {"value": one, "unit": "m"} for key, one in wire.items()}},
    }
    return {
        "measurements": rows,
        "whole": whole,
        "method": "ensemble",
        "evaluations": 7,
        "kept_from_before": 5,
        "warnings": [
            "few",
            "the data hardly tell 'a'",
            *(f"the data cannot tell '{one}' and 'z' apart" for one in "ab"),
        ],
        "branches": [branch, branch],
        "conflicts": [
            {
                "key": SLOW,
                "scatters": -3.25,
                "points_that_meet_it": 7,
                "cost": 4.25,
                "missed_instead": [
                    {"key": REST, "scatters": 2.5},
                    {"key": FAST, "scatters": -2.75},
                ],
            },
            {
                "key": FAST,
                "scatters": 5.0,
                "points_that_meet_it": 3,
                "cost": 0.5,
                "missed_instead": [],
            },
            {
                "key": REST,
                "scatters": 2.1,
                "points_that_meet_it": 0,
                "cost": None,
                "missed_instead": [],
            },
        ],
    }


REQUEST = """
case = "gu2021-beehive"
[quantities.wire]
key = "spring.wire_diameter"
prior = "normal"
mean = "3.8 mm"
standard_deviation = "0.1 mm"
[measurements.rest]
quantity = "preload"
value = "289 N"
scatter = "1.5 N"
[measurements.slow]
quantity = "stage_2_peak_force"
value = "812 N"
scatter = "8 N"
engine_speed = "4200 rpm"
spring_model = "finite-element"
[measurements.fast]
quantity = "node_2_maximum_displacement"
value = "0.68 mm"
scatter = "0.068 mm"
engine_speed = "8000 rpm"
spring_model = "finite-element"
"""


def computed(force: float, displacement: float, preload: float = 1.0) -> dict:
    """A computed point by its ratios to the published values."""
    return {REST: 289.0 * preload, SLOW: 812.0 * force, FAST: 0.68e-3 * displacement}


#: Points of the joint search: both aims met twice (the second farther inside, the first likelier),
#: one each, none, two of no use.
POINTS = [
    ([3.8e-3], computed(1.001, 1.09)), ([3.9e-3], computed(0.96, 1.05)), ([3.7e-3], computed(1.06, 1.0)), ([3.71e-3], computed(1.0, 0.85)),
    ([3.72e-3], computed(2.0, 2.0)), ([3.6e-3], None), ([3.5e-3], {REST: 289.0}),
]  # fmt: skip


def request_of(folder: Path) -> script.Request:
    (folder / "identification.toml").write_text(REQUEST)
    return script.read_request(folder / "identification.toml")


def test_the_points_that_have_all_that_is_aimed_at_are_counted_and_the_one_farthest_inside_is_kept(
    tmp_path,
):
    """0.96 of 5 % and 1.05 of 10 % lie 0.8 of the way to the edge, 1.09 of 10 % lies 0.9."""
    points = [(np.array(values), outcome) for values, outcome in POINTS]
    told = script.targets_of(points, request_of(tmp_path))
    assert {name: told[name] for name in ("aims", "points", "meet_all")} == {
        "aims": 2,
        "points": 5,
        "meet_all": 2,
    }
    assert told["inside"]["quantities"] == {"wire": 3.9e-3} and told["inside"][
        "computed"
    ] == computed(0.96, 1.05)
    off = np.array(
        [0.0, -0.04 * 812 / 8, 0.5, 1.0]
    )  # rest, slow, fast, one deviation from the prior
    assert told["inside"]["misfit"] == pytest.approx(off @ off)
    none = script.targets_of(points[2:], request_of(tmp_path))
    assert none == {"aims": 2, "points": 3, "meet_all": 0}


BLIND, JOINT, WHOLE = (
    answer(1.0, (REST, SLOW)),
    answer(1.2, (REST, SLOW, FAST)),
    answer(1.3, (REST, SLOW, FAST)),
)
BANDED = answer(1.1, (REST, SLOW, FAST))
WITHOUT = {"4200 rpm": answer(0.5, (REST, FAST)), "8000 rpm": answer(0.7, (REST, SLOW))}


def test_each_study_tells_its_own_numbers_and_each_speed_comes_from_the_study_that_left_it_out():
    lines = table(three_studies(BLIND, JOINT, WHOLE, WITHOUT), measured_of(BLIND)).splitlines()
    assert (
        lines[0]
        == "| | published | blind | joint | joint with angles | each speed from the other two |"
    )
    cells = [[cell.strip() for cell in line.split("|")[2:-1]] for line in lines[2:]]
    assert cells == [
        [
            "289 ± 1.5 N",
            "289 (260 to 318, 97 %, fitted)",
            "347 (318 to 376, 97 %, fitted)",
            "376 (347 to 405, 97 %, fitted)",
            "–",
        ],
        [
            "812 ± 8 N",
            "812 (731 to 893, 97 %, fitted)",
            "974 (893 to 1056, 97 %, fitted)",
            "1056 (974 to 1137, 97 %, fitted)",
            "406 (325 to 487, 97 %)",
        ],
        [
            "0.68 ± 0.068 mm",
            "0.68 (0.612 to 0.748, 97 %)",
            "0.816 (0.748 to 0.884, 97 %, fitted)",
            "0.884 (0.816 to 0.952, 97 %, fitted)",
            "0.476 (0.408 to 0.544, 97 %)",
        ],
    ]
    assert [line.split("|")[1].strip()[:9] for line in lines[2:]] == [
        "at rest: ",
        "4200 rpm:",
        "8000 rpm:",
    ]


def test_a_study_that_was_fitted_to_what_it_should_leave_out_is_refused():
    with pytest.raises(SystemExit, match="was fitted"):
        three_studies(BLIND, JOINT, WHOLE, {"4200 rpm": WITHOUT["8000 rpm"]})


def test_bars_and_marks_stand_at_the_ratio_to_the_published_value():
    (panel,) = chart(three_studies(BLIND, JOINT, WHOLE, WITHOUT), measured_of(BLIND)).panels
    lines = {one.name: one for one in panel.layers if type(one).__name__ == "Line"}
    assert lines["joint"].x[:2] == pytest.approx([1.1, 1.3]) and lines["blind"].x[
        :2
    ] == pytest.approx([0.9, 1.1])
    assert lines["each speed from the other two"].x[[0, 1, 3, 4]] == pytest.approx(
        [0.4, 0.6, 0.6, 0.8]
    )
    assert lines["scatter that was allowed"].x[6:8] == pytest.approx([0.9, 1.1])
    marks = [one for one in panel.layers if type(one).__name__ == "Marks"]
    assert [(one.name, one.filled, np.round(one.x, 9).tolist()) for one in marks] == [
        ("blind", True, [1.0, 1.0]),
        ("blind", False, [1.0]),
        ("joint", True, [1.2, 1.2, 1.2]),
        (ANGLES, True, [1.3, 1.3, 1.3]),
        ("each speed from the other two", False, [0.5, 0.7]),
    ]
    assert panel.y_words[0][1] == "at rest: preload"
    heights = {height for height, _ in panel.y_words}
    assert all(
        min(abs(value - height) for height in heights) < 0.5 for one in marks for value in one.y
    )


def test_page_and_picture_are_written_and_what_is_cut_short_is_refused(tmp_path, monkeypatch):
    folders = []
    for place, one in enumerate(
        (
            BLIND,
            JOINT,
            BANDED,
            WHOLE,
            WITHOUT["4200 rpm"],
            JOINT | {"measurements": []},
            WITHOUT["8000 rpm"],
        )
    ):
        folders.append(tmp_path / str(place))
        folders[-1].mkdir()
        (folders[-1] / "run.json").write_text(json.dumps(one))
    for folder, points in (
        (folders[1], POINTS),
        (folders[2], POINTS[2:]),
        (folders[3], POINTS[2:]),
    ):
        request_of(folder)
        with Journal(folder, "any") as journal:
            journal.through(lambda _, of=points: [outcome for _, outcome in of])(
                np.array([values for values, _ in points])
            )
    (tmp_path / "docs" / "pictures").mkdir(parents=True)
    page = tmp_path / "docs" / script.PAGE
    page.write_text(f"before\n{BEGIN}old\n{END}\nafter\n")
    main([str(one) for one in folders], tmp_path / "docs")
    text = page.read_text()
    assert (
        text.startswith(f"before\n{BEGIN}1. From statics")
        and text.endswith(f"{END}\nafter\n")
        and "\nold\n" not in text
    )
    assert (tmp_path / "docs" / "pictures" / script.PICTURE).read_text().startswith("<svg")
    assert (
        "| blind | ensemble | 12 | 7.5 | few; 1 quantity is hardly told; 2 combinations are not told apart |"
        in text.splitlines()
    )
    assert "| 0.748 (0.68 to 0.816, 97 %, fitted) |" in text, "the joint column holds the bands"
    assert "4200 rpm: Stage II peak force (983, published 812 N)" in text
    kept = json.loads((tmp_path / "docs" / script.KEPT).read_text())
    assert kept["joint"]["targets"]["meet_all"] == 2 and kept[ANGLES]["targets"]["meet_all"] == 0
    assert (
        list(kept) == list(script.STUDIES)
        and kept["blind"]["points"] == 12
        and kept["blind"]["branches"] == 2
    )
    assert kept["blind"]["quantities"] == {
        "wire": {
            k: {"value": v, "unit": "m"}
            for k, v in (("best", 3.9e-3), ("low", 3.7e-3), ("high", 4e-3))
        }
    }
    page.write_text(f"before\n{BEGIN}old\n{END}\nafter\n")
    main([], tmp_path / "docs")
    assert page.read_text() == text, "what is kept is enough"
    main([str(folders[0]), str(folders[1]), "-", "-", "-", "-", "-"], tmp_path / "docs")
    assert page.read_text() == text and list(
        json.loads((tmp_path / "docs" / script.KEPT).read_text())
    ) == list(script.STUDIES)
    (folders[1] / "run.json").write_text(json.dumps(answer(1.0, (), whole=False)))
    with pytest.raises(SystemExit, match="cut short"):
        main([str(one) for one in folders], tmp_path / "docs")


def kept(
    blind: dict, joint: dict, without: dict, whole: dict = WHOLE, bands: dict | None = None
) -> dict:
    every = {
        "blind": blind,
        "joint": joint,
        BANDS: bands or joint,
        ANGLES: whole,
        "without 8000 rpm": without,
    }
    found = {name: script.kept_of(one) for name, one in every.items()}
    found["joint"]["targets"] = {
        "aims": 10,
        "points": 50,
        "meet_all": 3,
        "inside": {"misfit": 9.75},
    }
    found[BANDS]["targets"] = {"aims": 10, "points": 20, "meet_all": 1, "inside": {"misfit": 8.0}}
    found[ANGLES]["targets"] = {"aims": 10, "points": 60, "meet_all": 0}
    return found


def test_sentences_on_what_was_predicted_and_fitted_follow_the_numbers_in_both_directions():
    met = script.sentences(kept(BLIND, answer(1.0, (REST, SLOW, FAST)), answer(1.05, (REST, SLOW))))
    assert len(met) == 5
    assert "1 of the 1 values" in met[0] and "outside" not in met[0]
    assert (
        met[1].startswith("Those data determine wire (")
        and "nothing of flank control 1 (" in met[1]
    )
    assert (
        "1 of 1 Stage II peaks within 5 %, 0 of 0 spikes of Stage III within 20 %, 1 of 1 displacements of node 2 within 10 %"
        in met[2]
    )
    assert met[4].endswith("1 of 1 values lie within the central 95 %.")
    missed = script.sentences(kept(answer(1.5, (REST, SLOW)), JOINT, answer(0.5, (REST, SLOW))))
    assert "0 of the 1 values" in missed[0]
    assert missed[0].endswith("; outside: at 8000 rpm largest displacement of node 2.")
    assert missed[2].endswith(
        "; outside: 4200 rpm: Stage II peak force (983, published 812 N) "
        "and 8000 rpm: largest displacement of node 2 (0.823, published 0.68 mm)"
        "; 4 of the 70 springs that the searches computed have all 10 at once, the one farthest inside them "
        "([beehive-joint.toml](../examples/beehive-joint.toml)) at a misfit 2.2 above the least"
        "; 0 of 3 fitted values lie within the central 95 % of the draws about the likeliest; outside: at rest preload; "
        "at 4200 rpm Stage II peak force; at 8000 rpm largest displacement of node 2."
    )
    banded = script.sentences(
        kept(BLIND, JOINT, answer(0.5, (REST, SLOW)), bands=answer(1.05, (REST, SLOW)))
    )[2]
    assert banded.endswith(
        "; 2 of 2 fitted values lie within the central 95 % of the draws about the likeliest."
    )
    assert "4200 rpm: Stage II peak force (983, published 812 N)" in banded, (
        "the likeliest point is that of the search"
    )
    lower = kept(BLIND, JOINT, answer(0.5, (REST, SLOW)), bands=answer(1.0, (REST, SLOW)))
    lower[BANDS]["misfit"] = 6.5
    said = script.sentences(lower)[2]
    assert "1 of 1 Stage II peaks within 5 %" in said and "outside: 4200" not in said, (
        "the walkers came lower than the search"
    )
    assert "at a misfit 3.2 above the least; 2 of 2 fitted" in said
    assert "0 of 1 Stage II peaks within 5 %" in missed[2] and "0 of 1 displacements" in missed[2]
    assert "0 of 1" in missed[4] and missed[4].endswith(
        "; outside: at 8000 rpm largest displacement of node 2."
    )
    never = kept(BLIND, JOINT, answer(0.5, (REST, SLOW)))
    never["joint"]["targets"] = {"aims": 10, "points": 50, "meet_all": 0}
    assert (
        "; 1 of the 70 springs that the searches computed has all 10 at once; 0 of 3 fitted"
        in script.sentences(never)[2]
    )
    never[BANDS]["targets"] = {"aims": 10, "points": 20, "meet_all": 0}
    assert (
        "; none of the 70 springs that the searches computed has all 10 at once; 0 of 3 fitted"
        in script.sentences(never)[2]
    )


def test_the_sentence_on_angles_says_what_they_cost_and_who_meets_what_is_missed():
    """The joint study was not fitted to the displacement here, which stands for an angle; it may
    not free what it did not see.
    """
    heights, without = answer(1.05, (REST, SLOW)), answer(0.5, (REST, SLOW))
    said = script.sentences(kept(BLIND, heights, without, answer(1.0, (REST, SLOW, FAST))))[3]
    assert said.startswith(
        "Fitted to 1 more angles and velocities, the likeliest have 1 of these within two scatters and 1 of 1 Stage II peaks"
    )
    assert (
        "; none of the 60 springs that the search computed has all 10 at once; the central" in said
    )
    assert said.endswith("within two scatters of every published value: no contradiction is shown.")
    missed = script.sentences(kept(BLIND, heights, without))[3]
    assert (
        "0 of these within two scatters" in missed
        and "outside: 4200 rpm: Stage II peak force (1064, published 812 N)" in missed
    )
    assert (
        "miss at rest: preload (347 to 405, published 289 N) and 4200 rpm: Stage II peak force (974 to 1137, published 812 N)"
        in missed
    )
    assert (
        "at rest: preload and 4200 rpm: Stage II peak force are within reach without the angles"
        in missed
    )
    assert missed.count("largest displacement of node 2") == 1, (
        "two scatters of 10 % reach the interval that begins 20 % above"
    )
    both = script.sentences(kept(BLIND, heights, answer(1.05, (REST, SLOW))))[3]
    assert both.endswith("are within reach without the angles or without 8000 rpm.")
    parted = script.sentences(kept(BLIND, answer(1.5, (REST, SLOW, FAST)), answer(1.05, (REST,))))[
        3
    ]  # not fitted to the slow speed
    assert (
        "at rest: preload is within reach without 8000 rpm; 4200 rpm: Stage II peak force is within reach of no search that"
        in parted
    )
    cut = kept(BLIND, answer(1.5, (REST, SLOW, FAST)), answer(1.05, (REST,)))
    cut["without 8000 rpm"]["misfit"] = 7.6  # above the joint one: not at its end
    assert "within reach without 8000 rpm" not in script.sentences(cut)[3]


def test_what_the_joint_studies_miss_is_told_with_what_meeting_it_costs():
    told = kept(BLIND, JOINT, answer(0.5, (REST, SLOW)))
    told[ANGLES]["conflicts"] = told[ANGLES]["conflicts"][2:]
    assert script.conflicts(told).splitlines()[2:] == [
        "| joint | 4200 rpm: Stage II peak force | -3.2 | 7 | 4.2 | at rest: preload (+2.5) and 8000 rpm: largest displacement of node 2 "
        "(-2.8) |",
        "| joint | 8000 rpm: largest displacement of node 2 | +5.0 | 3 | 0.5 | nothing more |",
        "| joint | at rest: preload | +2.1 | 0 | – | – |",
        "| joint with angles | at rest: preload | +2.1 | 0 | – | – |",
    ]
    told["joint"]["conflicts"] = told[ANGLES]["conflicts"] = []
    assert script.conflicts(told).endswith("miss no value by more than two scatters.")


def test_a_search_that_ends_above_one_with_more_data_is_told_as_not_at_its_end():
    told = kept(BLIND, JOINT, answer(0.5, (REST, SLOW)))
    assert "prove nothing" not in script.sentences(told)[
        4
    ] and "not at its end" not in script.searches(told)
    told["without 8000 rpm"]["misfit"] = 7.6
    assert script.sentences(told)[4].endswith(
        ". The searches without 8000 rpm did not come to their end, so that their misses prove nothing."
    )
    rows = script.searches(told).splitlines()[2:]
    assert [
        "not at its end: the joint study meets these data and more at 7.5" in row for row in rows
    ] == [False, False, False, False, True]
    told[BANDS]["misfit"] = 6.5
    rows = script.searches(told).splitlines()[2:]
    assert ["not at its end: the walkers of its bands come to 6.5" in row for row in rows] == [
        False,
        True,
        False,
        False,
        False,
    ]
    assert "the joint study meets these data and more at 6.5" in rows[
        -1
    ] and "| joint, bands | 4200 rpm" in script.conflicts(told)


def test_medians_beyond_the_picture_are_named():
    studies = three_studies(BLIND, answer(2.1, (REST, SLOW, FAST)), WHOLE, WITHOUT)
    told = script.beyond(studies, measured_of(BLIND))
    assert (
        told.count("2.1 times the published value") == 3
        and "at rest: preload (joint, 2.1 times" in told
    )
    assert script.beyond(three_studies(BLIND, JOINT, WHOLE, WITHOUT), measured_of(BLIND)) == ""


def test_the_page_of_the_beehive_says_what_is_kept_of_its_searches(tmp_path):
    assert_written_anew(
        main, tmp_path, script.KEPT, Path(script.PAGE), Path("pictures") / script.PICTURE
    )
