"""Unit: pictures of cases to scale are drawn from the parts alone, closed and at full lift to one
scale; sizes are compared with those of the case.
"""

import json
import re

import numpy as np
import pytest

import valvetrain as vt
from valvetrain.parameters.loading import library_names, load_case, parse_case
from valvetrain.parameters.templates import KINDS, template_text
from valvetrain.report import opening, theme
from valvetrain.report.motion.still import case_picture
from valvetrain.report.run_charts import line_styles


def size(svg: str) -> tuple[float, float]:
    width, height = map(float, re.search(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', svg).groups())
    return width, height


@pytest.mark.parametrize("name", [*KINDS, *library_names()])
def test_every_template_and_case_of_the_library_is_drawn(name):
    case = parse_case(template_text(name), name) if name in KINDS else load_case(name)
    svg = case_picture(case, closed_alone=True)
    width, height = size(svg)
    assert svg.count("<path") > 100 and 10 < width < 300 and 10 < height < 400


def test_a_spring_stands_as_high_as_it_is_installed_and_a_taller_one_higher():
    text = template_text("spring")
    case = parse_case(text, "own")
    installed = 1e3 * case.springs[0].installed_height
    _, height = size(case_picture(case, closed_alone=True))
    assert installed < height < 1.6 * installed, "seats and the turned view add to it"
    lower = parse_case(text, "own", changes={"spring.installed_height": "39 mm"})
    gain = 1e3 * lower.springs[0].installed_height - installed
    assert size(case_picture(lower, closed_alone=True))[1] - height == pytest.approx(gain, abs=1.0)


def test_full_lift_stands_beside_the_closed_valve_to_the_same_scale():
    case = load_case("job-c")
    alone, both = size(case_picture(case, closed_alone=True)), size(case_picture(case))
    assert both[0] > 2 * alone[0] and both[1] == pytest.approx(alone[1])
    assert np.isfinite(both).all()


def test_nothing_is_drawn_of_a_card_without_a_mass():
    assert case_picture(parse_case('[spring]\npreload = "250 N"\nrate = "32 N/mm"\n', "own")) == ""


def test_the_picture_that_opens_shows_most_of_the_wire_at_the_worst_speed():
    """Contract: a model of one mass judged worst opened the page with a bare wire, beside a rod whose
    stress is known.
    """
    study = vt.simulate("job-t", "3000 rpm", spring_models=["modal-uniform", "multi-mass"])
    worst = study.solutions[0]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(opening, "worst_run", lambda runs: worst)
        (motion,) = opening.motion_blocks(study)
    assert json.loads(motion.data)["variants"][0]["label"] == "multi-mass"


def test_sets_of_one_model_are_drawn_in_colours_of_their_own():
    """Contract: they shared the colour of their model and differed in the dashes alone."""
    text = template_text("pushrod", cards=True)
    study = vt.simulate(parse_case(text, "own"), "3000 rpm", spring_set=["card", "dual"])
    looks = line_styles(study).values()
    assert [look.colour for look in looks] == list(theme.SERIES[:2])
    assert len({look.dash for look in looks}) == 2
