"""Unit: pictures of cases to scale are drawn from the parts alone, closed and at full lift to one
scale; sizes are compared with those of the case.
"""

import re

import numpy as np
import pytest

from valvetrain.parameters.loading import library_names, load_case, parse_case
from valvetrain.parameters.templates import KINDS, template_text
from valvetrain.system.build import build
from valvetrain.views.motion.still import _variant, case_picture


def size(svg: str) -> tuple[float, float]:
    width, height = map(float, re.search(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', svg).groups())
    return width, height


@pytest.mark.parametrize("name", [*KINDS, *library_names()])
def test_every_template_and_case_of_the_library_is_drawn(name):
    case = parse_case(template_text(name), name) if name in KINDS else load_case(name)
    svg = case_picture(case, closed_alone=True)
    width, height = size(svg)
    assert svg.count("<path") > 100 and 10 < width < 300 and 10 < height < 400


def test_nothing_is_drawn_of_a_card_without_a_mass():
    assert case_picture(parse_case('[spring]\npreload = "250 N"\nrate = "32 N/mm"\n', "own")) == ""


@pytest.mark.parametrize("kind", ["pushrod", "finger", "rocker"])
def test_the_tip_of_a_lever_goes_down_by_the_lift(kind):
    case = parse_case(template_text(kind), kind)
    (member, *_) = build(case, spring_models=("massless",)).members
    turned = next(one for one in _variant(member).bodies if one.name == "lever").pose[:, 2]
    lever, lift = case.train.lever, member.gear.mechanism.kinematics.maximum_lift
    ways = lever.valve_angle + np.array([0.0, turned[np.argmax(np.abs(turned))]])
    drop = lever.valve_arm * np.diff(np.sin(ways))[0]
    assert -drop == pytest.approx(lift + case.train.lash, rel=0.01)
