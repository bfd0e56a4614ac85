"""Unit: three identifications side by side, from answers of known numbers: each cell, bar and mark carries what it names."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

from architecture.layout import ROOT
from beehive_parts import assert_written_anew

sys.path.insert(0, str(ROOT / "scripts"))
import write_beehive_studies as script
from write_beehive_studies import BEGIN, END, chart, main, measured_of, table, three_studies

REST, SLOW, FAST = "preload", "4200 rpm, finite-element: stage_2_peak_force", "8000 rpm, finite-element: node_2_maximum_displacement"


def answer(shift: float, fitted: tuple[str, ...], whole: bool = True) -> dict:
    """Medians ``shift`` times the published value, 10 % of it to either side."""
    rows = []
    for key, value, scatter, unit in ((REST, 289.0, 1.5, "N"), (SLOW, 812.0, 8.0, "N"), (FAST, 0.68e-3, 0.068e-3, "m")):
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
        "measurements": rows, "whole": whole, "method": "ensemble", "evaluations": 7, "kept_from_before": 5,
        "warnings": ["few", "the data hardly tell 'a'", *(f"the data cannot tell '{one}' and 'z' apart" for one in "ab")],
        "branches": [branch, branch],
    }  # fmt: skip


BLIND, JOINT = answer(1.0, (REST, SLOW)), answer(1.2, (REST, SLOW, FAST))
WITHOUT = {"4200 rpm": answer(0.5, (REST, FAST)), "8000 rpm": answer(0.7, (REST, SLOW))}


def test_each_study_tells_its_own_numbers_and_each_speed_comes_from_the_study_that_left_it_out():
    lines = table(three_studies(BLIND, JOINT, WITHOUT), measured_of(BLIND)).splitlines()
    assert lines[0] == "| | published | blind | joint | each speed from the other two |"
    assert lines[2] == "| at rest: preload | 289 ± 1.5 N | 289 (260 to 318, 97 %, fitted) | 347 (318 to 376, 97 %, fitted) | – |"
    assert (
        lines[3].endswith("| 812 ± 8 N | 812 (731 to 893, 97 %, fitted) | 974 (893 to 1056, 97 %, fitted) | 406 (325 to 487, 97 %) |")
        and "4200 rpm: " in lines[3]
    )
    assert lines[4].endswith(
        "| 0.68 ± 0.068 mm | 0.68 (0.612 to 0.748, 97 %) | 0.816 (0.748 to 0.884, 97 %, fitted) | 0.476 (0.408 to 0.544, 97 %) |"
    )


def test_a_study_that_was_fitted_to_what_it_should_leave_out_is_refused():
    with pytest.raises(SystemExit, match="was fitted"):
        three_studies(BLIND, JOINT, {"4200 rpm": WITHOUT["8000 rpm"]})


def test_bars_and_marks_stand_at_the_ratio_to_the_published_value():
    (panel,) = chart(three_studies(BLIND, JOINT, WITHOUT), measured_of(BLIND)).panels
    lines = {one.name: one for one in panel.layers if type(one).__name__ == "Line"}
    assert lines["joint"].x[:2] == pytest.approx([1.1, 1.3]) and lines["blind"].x[:2] == pytest.approx([0.9, 1.1])
    assert lines["each speed from the other two"].x[[0, 1, 3, 4]] == pytest.approx([0.4, 0.6, 0.6, 0.8])
    assert lines["scatter that was allowed"].x[6:8] == pytest.approx([0.9, 1.1])
    marks = [one for one in panel.layers if type(one).__name__ == "Marks"]
    assert [(one.name, one.filled, np.round(one.x, 9).tolist()) for one in marks] == [
        ("blind", True, [1.0, 1.0]), ("blind", False, [1.0]), ("joint", True, [1.2, 1.2, 1.2]),
        ("each speed from the other two", False, [0.5, 0.7]),
    ]  # fmt: skip
    assert panel.y_words[0][1] == "at rest: preload"
    heights = {height for height, _ in panel.y_words}
    assert all(min(abs(value - height) for height in heights) < 0.5 for one in marks for value in one.y)


def test_page_and_picture_are_written_and_what_is_cut_short_is_refused(tmp_path, monkeypatch):
    folders = []
    for place, one in enumerate((BLIND, JOINT, WITHOUT["4200 rpm"], JOINT | {"measurements": []}, WITHOUT["8000 rpm"])):
        folders.append(tmp_path / str(place))
        folders[-1].mkdir()
        (folders[-1] / "run.json").write_text(json.dumps(one))
    (tmp_path / "docs" / "pictures").mkdir(parents=True)
    page = tmp_path / "docs" / script.PAGE
    page.write_text(f"before\n{BEGIN}old\n{END}\nafter\n")
    main([str(one) for one in folders], tmp_path / "docs")
    text = page.read_text()
    assert text.startswith(f"before\n{BEGIN}1. From statics") and text.endswith(f"{END}\nafter\n") and "\nold\n" not in text
    assert (tmp_path / "docs" / "pictures" / script.PICTURE).read_text().startswith("<svg")
    assert "| blind | ensemble | 12 | 7.5 | few; 1 quantities are hardly told; 2 combinations are not told apart |" in text.splitlines()
    kept = json.loads((tmp_path / "docs" / script.KEPT).read_text())
    assert list(kept) == list(script.STUDIES) and kept["blind"]["points"] == 12 and kept["blind"]["branches"] == 2
    assert kept["blind"]["quantities"] == {
        "wire": {k: {"value": v, "unit": "m"} for k, v in (("best", 3.9e-3), ("low", 3.7e-3), ("high", 4e-3))}
    }
    page.write_text(f"before\n{BEGIN}old\n{END}\nafter\n")
    main([], tmp_path / "docs")
    assert page.read_text() == text, "what is kept is enough"
    (folders[1] / "run.json").write_text(json.dumps(answer(1.0, (), whole=False)))
    with pytest.raises(SystemExit, match="cut short"):
        main([str(one) for one in folders], tmp_path / "docs")


def kept(blind: dict, joint: dict, without: dict) -> dict:
    return {name: script.kept_of(one) for name, one in {"blind": blind, "joint": joint, "without 8000 rpm": without}.items()}


def test_five_sentences_follow_the_numbers_in_both_directions():
    met = script.sentences(kept(BLIND, answer(1.0, (REST, SLOW, FAST)), answer(1.05, (REST, SLOW))))
    assert len(met) == 5
    assert "1 of the 1 values" in met[0] and "outside" not in met[0]
    assert met[1].startswith("Those data determine wire (") and "nothing of flank control 1 (" in met[1]
    assert "1 of 1 Stage II peaks within 5 %, 0 of 0 spikes of Stage III within 20 %, 1 of 1 displacements of node 2 within 10 %" in met[2]
    assert "no contradiction" in met[3] and met[4].endswith("1 of 1 values lie within the central 95 %.")
    missed = script.sentences(kept(answer(1.5, (REST, SLOW)), JOINT, answer(0.5, (REST, SLOW))))
    assert "0 of the 1 values" in missed[0]
    assert missed[0].endswith("; outside: at 8000 rpm largest displacement of node 2.")
    assert "0 of 1 Stage II peaks within 5 %" in missed[2] and "0 of 1 displacements" in missed[2]
    assert (
        "at rest: preload and 4200 rpm: Stage II peak force are met by no search that was fitted to them." in missed[3]
        and "289 N" in missed[3]
        and "812 N" in missed[3]
    )
    assert "0.68 mm" not in missed[3], "two scatters of 10 % reach the interval that begins 10 % above"
    assert "0 of 1" in missed[4] and missed[4].endswith("; outside: at 8000 rpm largest displacement of node 2.")
    freed = script.sentences(kept(BLIND, JOINT, answer(1.05, (REST, SLOW))))[3]
    assert freed.endswith("more than two scatters: at rest: preload and 4200 rpm: Stage II peak force are met without 8000 rpm.")
    parted = answer(1.05, (REST,))  # not fitted to the slow speed, so meeting it proves nothing
    assert "preload is met without 8000 rpm; 4200 rpm: Stage II peak force is met by no" in script.sentences(kept(BLIND, JOINT, parted))[3]


def test_a_search_that_ends_above_one_with_more_data_is_told_as_not_at_its_end():
    told = kept(BLIND, JOINT, answer(0.5, (REST, SLOW)))
    assert "prove nothing" not in script.sentences(told)[4] and "not at its end" not in script.searches(told)
    told["without 8000 rpm"]["misfit"] = 7.6
    assert script.sentences(told)[4].endswith(
        ". The searches without 8000 rpm did not come to their end, so that their misses prove nothing."
    )
    rows = script.searches(told).splitlines()[2:]
    assert ["not at its end: the joint study meets these data and more at 7.5" in row for row in rows] == [False, False, True]


def test_medians_beyond_the_picture_are_named():
    studies = three_studies(BLIND, answer(2.1, (REST, SLOW, FAST)), WITHOUT)
    told = script.beyond(studies, measured_of(BLIND))
    assert told.count("2.1 times the published value") == 3 and "at rest: preload (joint, 2.1 times" in told
    assert script.beyond(three_studies(BLIND, JOINT, WITHOUT), measured_of(BLIND)) == ""


def test_the_page_of_the_beehive_says_what_is_kept_of_its_searches(tmp_path):
    assert_written_anew(main, tmp_path, script.KEPT, Path(script.PAGE), Path("pictures") / script.PICTURE)
