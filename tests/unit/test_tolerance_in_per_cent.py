"""A tolerance in per cent is a share of what stands in the case, whatever unit that is in; ends by
hand.
"""

from __future__ import annotations

import pytest

import valvetrain as vt
from unit.test_identification_answer import CARD
from valvetrain.errors import InputError
from valvetrain.explore.files import VaryModel, varied_of_table
from valvetrain.parameters.loading import parse_case

CASE = parse_case(CARD)


def reached(case: vt.Case, **told: object) -> tuple[float, float, float, str]:
    """Least, middle and largest value (SI), and the unit shown."""
    varied = varied_of_table(VaryModel(**told), case)
    low, middle, high = varied.distribution.at([0.0, 0.5, 1.0])
    return float(low), float(middle), float(high), varied.unit


@pytest.mark.parametrize("shape", ["normal", "uniform"])
def test_a_share_of_a_value_with_a_unit(shape):
    """It was refused: "32000 has no unit; a stiffness is needed here"."""
    told = reached(CASE, key="spring.rate", tolerance="5 %", shape=shape)
    assert told == (pytest.approx(30.4e3), pytest.approx(32e3), pytest.approx(33.6e3), "N/mm")


@pytest.mark.parametrize(
    ("key", "more", "ends", "unit"),
    [
        ("spring.damping.ratio", {}, (0.018, 0.022), ""),
        ("spring.mean_diameter", {"as": "factor"}, (0.9, 1.1), ""),
        ("spring.mean_diameter.values.1", {}, (0.9 * 22.2e-3, 1.1 * 22.2e-3), "mm"),
    ],
)
def test_a_share_of_a_plain_number_a_factor_and_one_of_several(key, more, ends, unit):
    case = vt.load_case(
        "gu2021-beehive-blind", {"spring.damping": {"ratio": 0.02, "ratio_frequency": "600 Hz"}}
    )
    case = (
        vt.load_case(
            "gu2021-beehive-blind",
            {"spring.mean_diameter": {"coils": [0, 3, 7], "values": "22.2, 22.2, 17 mm"}},
        )
        if more or unit
        else case
    )
    low, middle, high, shown = reached(case, key=key, tolerance="10 %", shape="uniform", **more)
    assert (low, high, shown) == (
        pytest.approx(ends[0]),
        pytest.approx(ends[1]),
        unit,
    ) and middle == pytest.approx(sum(ends) / 2)


def test_a_tolerance_with_a_unit_is_what_it_was():
    assert reached(CASE, key="spring.rate", tolerance="1 N/mm", shape="uniform")[
        :3
    ] == pytest.approx((31e3, 32e3, 33e3))


@pytest.mark.parametrize(
    ("told", "sentence"),
    [
        ({"key": "spring.rate", "as": "offset"}, "zero in the case"),
        ({"key": "spring.pitch"}, "is not in the case"),
        ({"key": "spring.rate", "tolerance": "0 %"}, "tolerance of zero or less"),
    ],
)
def test_nothing_to_take_a_share_of_is_one_sentence(told, sentence):
    with pytest.raises(InputError, match=sentence):
        reached(CASE, **{"tolerance": "5 %", **told})
