"""Unit: a study over the draws of an identification has their scatter and correlation, and refuses
what are no draws.
"""

from __future__ import annotations

import numpy as np
import pytest

import valvetrain as vt
from study_parts import identification_plan
from valvetrain.explore.execution import Execution
from valvetrain.explore.identify import run_identification

QUANTITIES = """
[quantities.rate]
key = "spring.rate"
prior = "uniform"
low = "25 N/mm"
high = "40 N/mm"
[quantities.mass]
key = "spring.mass"
prior = "normal"
mean = "42 g"
standard_deviation = "4 g"
"""
#: A frequency tells rate over mass: the posterior is a narrow ridge, where priors alone are not.
MEASURED = """
[measurements.ringing]
frequencies = "435 Hz"
scatter = "0.3 %"
spring_model = "wave-rod"
"""
CARD = 'title = "card"\n[spring]\npreload = "250 N"\nrate = "32 N/mm"\nmass = "42 g"\n'
STUDY = """
case = "card.toml"
outputs = ["card_rate", "card_surge_frequency"]
points = { sampler = "posterior", file = "found/draws.nc", count = 100 }
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("draws")
    (place / "card.toml").write_text(CARD)
    request = identification_plan(f'case = "card.toml"\n{QUANTITIES}{MEASURED}', "card", place)
    found = run_identification(request, Execution(workers=1))
    (place / "found").mkdir()
    found.save(place / "found" / "draws.nc")
    return place, found


def study(place, text: str) -> vt.explore.StudyTable:
    (place / "study.toml").write_text(text)
    return vt.study(place / "study.toml", workers=1)


def test_a_study_over_a_posterior_keeps_its_scatter_and_correlation(folder):
    """Truth known: the frequency of the draws is that measured; even draws of the priors, which know no
    ridge, scatter ten times as far.
    """
    place, found = folder
    table = study(place, STUDY + QUANTITIES)
    assert len(table) == 100 and table.completed.all()
    np.testing.assert_allclose(table.inputs.mean(axis=0), found.values.mean(axis=0), rtol=0.01)
    apart = np.corrcoef(table.inputs.T)[0, 1] - np.corrcoef(found.values.T)[0, 1]
    assert abs(apart) < 0.02 and np.corrcoef(table.inputs.T)[0, 1] > 0.9
    ridge = np.std(table.inputs[:, 0] / table.inputs[:, 1])
    prior = study(
        place, STUDY.replace('"posterior", file = "found/draws.nc"', '"sobol"') + QUANTITIES
    )
    assert np.std(prior.inputs[:, 0] / prior.inputs[:, 1]) > 10 * ridge


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ("found/draws.nc", "found/none.nc", "no such file"),
        ("found/draws.nc", "card.toml", "is no result of valvetrain"),
        ("[quantities.mass]", "[quantities.weight]", "the draws have no 'weight'; .*mass"),
        ("count = 100", "count = 0", "count"),
    ],
)
def test_what_are_no_draws_of_the_quantities_is_refused(folder, before, after, words):
    with pytest.raises(vt.InputError, match=words):
        study(folder[0], (STUDY + QUANTITIES).replace(before, after))
