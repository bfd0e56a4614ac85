"""Contract: with another cut-off no label says 10 kHz, in no interface; two results of one session each have
their own.
"""

from __future__ import annotations

import pytest
from typer.testing import CliRunner

import valvetrain as vt
from valvetrain.cli.main import app
from valvetrain.report.study import study_page
from valvetrain.solution.definition import label_cut_off, label_of
from valvetrain.solution.force_peak import FORCE_BANDWIDTH

CUT_OFF, WRONG, TRUE = "operation.force_bandwidth", "below 10 kHz", "below 5 kHz"
NAMES = ("peak_spring_force", "minimum_spring_force")


@pytest.fixture(autouse=True)
def usual_cut_off():
    yield
    label_cut_off(FORCE_BANDWIDTH)


def narrow() -> vt.Case:
    return vt.Case("job-c").set({CUT_OFF: "5 kHz"})


@pytest.mark.parametrize(
    "words",
    [
        "run job-c --spring massless --engine-speed 3000rpm",
        "compare job-c --spring massless --spring modal-uniform --engine-speed 3000rpm",
        "sweep job-c --spring massless --engine-speed 3000:4000:500rpm",
        "check job-c",
    ],
)
def test_no_command_prints_or_saves_another_cut_off(words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    told = CliRunner().invoke(app, [*words.split(), "--set", f"{CUT_OFF}=5 kHz"])
    assert told.exit_code == 0, told.output
    saved = [
        path.read_text("utf-8")
        for path in tmp_path.rglob("*")
        if path.suffix in (".html", ".json", ".csv", ".svg", ".toml")
    ]
    assert all(WRONG not in text for text in (told.output, *saved))
    assert words.startswith("check") or TRUE in told.output
    listed = CliRunner().invoke(app, ["runs"])
    assert WRONG not in listed.output


def test_a_study_names_the_cut_off_of_its_case():
    table = narrow().study(
        {"spring.precompression": ["6 mm", "7 mm"]}, NAMES, sampling="grid", models="massless", workers=1
    )  # fmt: skip
    vt.Case("job-c").run("3000 rpm", "massless")
    assert WRONG not in repr(table) and TRUE in repr(table)
    assert table.to_xarray()["peak_spring_force"].attrs["long_name"].endswith(TRUE)


def test_each_of_two_results_has_its_own_cut_off():
    slow = narrow().compare("3000 rpm", ["massless"])
    wide = vt.Case("job-c").compare("3000 rpm", ["massless"])
    for study, band in ((slow, TRUE), (wide, WRONG), (slow, TRUE)):
        assert band in repr(study)
        study_page(study)
        assert label_of("peak_spring_force").endswith(band)


def test_a_cut_off_that_varies_is_not_named():
    table = vt.Case("job-c").study(
        {CUT_OFF: ["5 kHz", "8 kHz"]}, NAMES, sampling="grid", models="massless", workers=1
    )
    assert WRONG not in repr(table) and TRUE not in repr(table)
