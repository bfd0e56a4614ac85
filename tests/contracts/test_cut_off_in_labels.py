"""Contract: with another cut-off no label says 10 kHz, in no interface; two results of one session each have
their own.
"""

from __future__ import annotations

import pytest

import valvetrain as vt
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
        assert study.verdict
        assert label_of("peak_spring_force").endswith(band)
