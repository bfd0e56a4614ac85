"""Unit: pictures of cases to scale are drawn from the parts alone, closed and at full lift to one
scale; sizes are compared with those of the case.
"""

import re

import numpy as np
import pytest

from valvetrain.parameters.loading import library_names, load_case, parse_case
from valvetrain.parameters.templates import KINDS, template_text
from valvetrain.report.motion.still import case_picture


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
