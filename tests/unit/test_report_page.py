"""The folder of a study: complete, self-contained, readable back, whole or not at all, without a
word that is not the user's.
"""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from synthetic_study import (
    own_study,
    published_study,
    record,
    rod_run,
    sweep_study,
    train_run,
    train_study,
)
from valvetrain.solution.netcdf import load_netcdf, load_result
from valvetrain.solution.quantity import Quantity
from valvetrain.solution.status import PartialFailures, Status
from valvetrain.views import results
from valvetrain.views.answer import Answer
from valvetrain.views.json import study_json
from valvetrain.views.page import page_of
from valvetrain.views.results import write_study

STUDIES = {
    "own": own_study,
    "published": published_study,
    "train": train_study,
    "sweep": sweep_study,
}


def test_files_are_read_back(tmp_path):
    files = write_study(own_study(), tmp_path, page=False)
    names = {path.name for path in files.data}
    assert (
        files.figures == ()
        and {
            "finite-element-5600rpm.nc",
            "modal-varied-4200rpm.csv",
            "static-spring-finite-element.nc",
            "static-spring-multi-mass.csv",
            "modes-spring-finite-element.nc",
            "modes-spring-multi-mass.csv",
            "quantities.csv",
            "events.csv",
        }
        <= names
    )
    assert load_netcdf(tmp_path / "finite-element-5600rpm.nc").identical(rod_run())
    few = np.genfromtxt(tmp_path / "finite-element-5600rpm.csv", delimiter=",", names=True)
    np.testing.assert_array_equal(few["seat_force_N"], rod_run().channel("seat_force"))
    assert len(load_result(tmp_path / "static-spring-finite-element.nc").force) == 40
    assert load_result(tmp_path / "modes-spring-finite-element.nc").axial_modes == (1, 2, 4)
    rows = (tmp_path / "quantities.csv").read_text().splitlines()
    assert (
        len(rows) == 1 + len(own_study().quantities)
        and "finite-element,5600.0,peak_spring_force,811.0,N,811.0,N" in rows
    )
    assert len((tmp_path / "events.csv").read_text().splitlines()) == 8
    assert not [path for path in tmp_path.rglob("*") if path.name.endswith(".part")]


def test_no_two_runs_share_a_file(tmp_path):
    near = (3000.001 * np.pi / 30, 3000.002 * np.pi / 30)
    runs = tuple(train_run(speed, label) for label in ("x 1", "x/1", "X 1") for speed in near)
    files = write_study(replace(train_study(), solutions=runs), tmp_path, page=False)
    found = [load_netcdf(path) for path in files.data if path.suffix == ".nc"]
    assert {(run.label, run.engine_speed) for run in found} == {
        (label, speed) for label in ("x 1", "x/1", "X 1") for speed in near
    }
    assert len({path.name.lower() for path in files.data}) == len(files.data)


def test_words_from_outside_are_escaped():
    evil = "<!--<script>alert(1)</script>"
    runs = (train_run(label=evil), train_run(label="other", spring_set="race"))
    told = record(title=evil, description=evil, text=evil, remarks=(evil,))
    html = page_of(Answer(replace(train_study(), record=told, solutions=runs, notes=(evil,))))
    assert "<!--" not in html and "<script>alert" not in html
    assert "&lt;!--&lt;script&gt;alert" in html


@pytest.mark.parametrize("keep", [0, 1, 2, 5, 100])
def test_runs_that_ended_at_once_do_not_break_the_page(keep):
    run = rod_run(status=Status("diverged", "at once"))
    short = replace(run, channels=run.channels.isel(sample=slice(0, keep)), events=())
    gaps = PartialFailures()
    page_of(Answer(own_study((short,))), gaps)
    assert not gaps.sentences


def test_page_of_nothing_but_a_case():
    gaps = PartialFailures()
    page_of(Answer(replace(own_study(()), rest=(), still={})), gaps)
    assert not gaps.sentences


def test_page_that_cannot_be_finished_is_not_begun(tmp_path, monkeypatch):
    def fail(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(results, "page_of", fail)
    with pytest.raises(KeyboardInterrupt):
        write_study(own_study(), tmp_path)
    assert not (tmp_path / "report.html").exists()
    assert not [path for path in tmp_path.rglob("*") if path.name.endswith(".part")]
    assert load_netcdf(tmp_path / "finite-element-5600rpm.nc").status.completed


def test_same_study_gives_the_same_page():
    assert page_of(Answer(own_study())) == page_of(Answer(own_study()))


def test_one_json_shape_for_every_study():
    shapes = {name: study_json(make()) for name, make in STUDIES.items()}
    assert len({tuple(shape) for shape in shapes.values()}) == 1
    assert len({tuple(run) for shape in shapes.values() for run in shape["runs"]}) == 1
    run = shapes["own"]["runs"][1]
    assert run["quantities"]["coil_bind_clearance"] == {"value": 1.25e-3, "unit": "m"}
    assert run["engine_speed"]["unit"] == "rpm" and run["engine_speed"]["value"] == pytest.approx(
        5600
    )
    assert (
        run["events"][0]["details"]["energy"] == {"value": 0.017, "unit": "J"}
        and run["clash_count"]["value"] == 7
    )
    assert shapes["own"]["quantities"]["preload"] == {"value": 287.0, "unit": "N"}
    assert shapes["published"]["comparisons"][0]["published"] == {"value": 790.0, "unit": "N"}
    json.dumps(shapes, allow_nan=False)


def test_every_number_of_the_study_is_in_its_json():
    study = own_study()
    shape = study_json(study)
    runs = {
        (run["label"], round(run["engine_speed"]["value"])): run["quantities"]
        for run in shape["runs"]
    }
    for key, value in study.quantities.items():
        held = (
            shape["quantities"]
            if key.engine_speed is None
            else runs[key.label, round(key.engine_speed * 30 / np.pi)]
        )
        assert held[key.name]["value"] == pytest.approx(value), Quantity(*([key.name]))
