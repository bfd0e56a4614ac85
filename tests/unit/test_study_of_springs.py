"""Unit: a study that has stress among its outputs is judged by it, and points of a list go by their names."""

from __future__ import annotations

import pytest

import valvetrain as vt
from valvetrain.errors import InputError
from valvetrain.explore.study_answer import StudyAnswer
from valvetrain.parameters.templates import template_text

STUDY = """
case = "spring.toml"
engine_speeds = "3000 rpm"
spring_models = ["massless"]
outputs = ["surge_frequency", "peak_spring_force", "open_nominal_shear_stress"]
points = {{ sampler = "list"{names} }}

[[vary]]
key = "spring.wire_diameter"
values = "3.9, 3.6 mm"

[[vary]]
key = "spring.mean_diameter"
values = "22.0, 22.3 mm"

[[vary]]
key = "spring.total_coils"
values = "6.8, 5.26"

[[vary]]
key = "spring.pitch.pitch"
values = "8.4, 12.75 mm"
"""
NAMES = ', names = ["thick", "thin"]'


@pytest.fixture
def study(tmp_path):
    """The table of the study file, with names or without."""
    (tmp_path / "spring.toml").write_text(template_text("spring"))

    def made(names: str):
        (tmp_path / "study.toml").write_text(STUDY.format(names=names))
        return vt.study(tmp_path / "study.toml", output=tmp_path / "out")

    return made


def test_points_of_a_list_go_by_their_names(study):
    """Contract: names head the columns; without them their values tell them apart."""
    named, bare = study(NAMES), study("")
    assert StudyAnswer(named).headings == ["thick", "thin"]
    assert StudyAnswer(named).verdict.fields["point"] in ("thick", "thin")
    assert "3.6 mm" in StudyAnswer(bare).headings[1]
    assert StudyAnswer(bare).verdict.quantity == "open_nominal_shear_stress"


@pytest.mark.parametrize("names", ['"thick"', '"one", "one"', '"a", "b", "c"'])
def test_names_that_do_not_fit_the_points_are_refused(study, names):
    """Contract: one name for each point, no two alike."""
    with pytest.raises(InputError, match="a name for each of the 2 points"):
        study(f", names = [{names}]")
