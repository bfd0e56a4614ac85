"""Samplers: strata, levels, design."""

from __future__ import annotations

import numpy as np
import pytest

from valvetrain import InputError, registry
from valvetrain.explore.distributions import LogNormal, Normal, Uniform, Values
from valvetrain.explore.samplers import sampler
from valvetrain.explore.space import Varied

UNIT = tuple(Varied(name, distribution=Uniform(0.0, 1.0)) for name in "abc")


def drawn(word, varied=UNIT, **options):
    spec = sampler(word)
    return spec.draw(varied, spec.read_options(options))


@pytest.mark.parametrize(
    "word", [word for word in registry.names("samplers") if word not in ("list", "posterior")]
)
def test_the_same_options_give_the_same_points_within_the_bounds(word):
    options = {"levels": 3} if word == "grid" else {"count": 40}
    points = drawn(word, **options)
    assert points.shape[1] == 3 and np.array_equal(points, drawn(word, **options))
    assert np.all((points >= 0) & (points <= 1)) and len(points) <= max(40, 27)
    if word != "grid":
        assert not np.array_equal(points, drawn(word, **options, seed=2))


def test_a_grid_has_every_combination_once_in_order():
    points = drawn(
        "grid",
        (Varied("a", distribution=Uniform(1.0, 2.0)), Varied("b", distribution=Values((5.0, 7.0)))),
        levels=3,
    )
    assert points.tolist() == [[1, 5], [1, 7], [1.5, 5], [1.5, 7], [2, 5], [2, 7]]


def test_a_list_is_taken_row_by_row_and_must_be_even():
    two, other, short = (
        Varied(name, distribution=Values(values))
        for name, values in (("a", (1.0, 2.0)), ("b", (3.0, 4.0)), ("b", (3.0,)))
    )
    assert drawn("list", (two, other)).tolist() == [[1, 3], [2, 4]]
    with pytest.raises(InputError, match="as many values"):
        drawn("list", (two, short))
    with pytest.raises(InputError, match="one by one"):
        drawn("list")


@pytest.mark.parametrize("count", [1, 7, 64, 100])
def test_a_latin_hypercube_has_one_point_in_every_stratum_of_every_quantity(count):
    points = drawn("latin-hypercube", count=count)
    for column in points.T:
        assert sorted(np.floor(column * count).astype(int).tolist()) == list(range(count))


def test_a_power_of_two_of_sobols_sequence_is_a_net():
    """Each of the 64 boxes 1/8 by 1/8 of any two quantities holds one of 64 points: a (0, 6, 2) net
    in base 2 (Sobol 1967).
    """
    points = drawn("sobol", UNIT[:2], count=64)
    boxes = (np.floor(points * 8) @ [8, 1]).astype(int)
    assert sorted(boxes.tolist()) == list(range(64))


@pytest.mark.parametrize(
    ("distribution", "mean", "deviation"),
    [
        (Normal(3.0, 0.5), 3.0, 0.5),
        (Uniform(1.0, 4.0), 2.5, 3 / np.sqrt(12)),
        (Values((1.0, 2.0, 6.0)), 3.0, np.sqrt(14 / 3)),
        (LogNormal(2.0, 1.5), 2 * np.exp(0.5 * np.log(1.5) ** 2), None),
        (Normal(0.0, 1.0, -1.0, 1.0), 0.0, 0.5396),
    ],
)
def test_draws_have_the_moments_of_their_distribution(distribution, mean, deviation):
    """Closed forms; 0.5396 is the deviation of a normal variable cut at one deviation either way."""
    points = drawn("sobol", (Varied("a", distribution=distribution),), count=4096)[:, 0]
    assert np.mean(points) == pytest.approx(mean, abs=5e-3)
    assert deviation is None or np.std(points) == pytest.approx(deviation, rel=5e-3)


def test_saltellis_design_changes_one_column_at_a_time():
    points = drawn("saltelli", count=160)
    rows = len(points) // 5
    a, b, *mixed = points.reshape(5, rows, 3)
    assert rows == 32
    for place, part in enumerate(mixed):
        assert np.array_equal(part[:, place], b[:, place])
        assert np.array_equal(np.delete(part, place, 1), np.delete(a, place, 1))


@pytest.mark.parametrize(
    ("word", "options", "words"),
    [
        ("sobol", {"count": 0}, "points.count"),
        *(
            (word, {"count": 1_000_001}, "points.count")
            for word in ("monte-carlo", "latin-hypercube", "sobol", "saltelli")
        ),
        ("sobol", {"cuont": 5}, "did you mean count"),
        ("grid", {"count": 5}, "names are levels"),
        ("grid", {"levels": 1000}, "fewer levels"),
        ("sobol", {"count": "many"}, "points.count"),
        ("soble", {}, "did you mean sobol"),
    ],
)
def test_options_that_a_sampler_does_not_have_are_refused(word, options, words):
    with pytest.raises(InputError, match=words):
        drawn(word, **options)


#: Whether its points are draws from the distributions, so that their scatter and percentiles are
#: those of the outputs.
DRAWN = {
    "monte-carlo": True, "latin-hypercube": True, "sobol": True, "saltelli": True, "grid": False, "list": False, "posterior": True,
}  # fmt: skip


@pytest.mark.parametrize("word", sorted({*registry.names("samplers"), *DRAWN}))
def test_points_count_as_draws_where_they_follow_their_distribution(word):
    """Points of a normal quantity: those that are draws have its deviation, those on levels or rows
    do not.
    """
    assert sampler(word).independent == DRAWN[word]
    if word in ("list", "posterior"):
        return
    normal = (
        Varied("a", distribution=Normal(0.0, 1.0, -3.0, 3.0)),
        Varied("b", distribution=Normal(0.0, 1.0, -3.0, 3.0)),
    )
    points = drawn(word, normal, **({"levels": 5} if word == "grid" else {"count": 512}))
    assert (np.std(points[:, 0]) == pytest.approx(0.987, abs=0.08)) == DRAWN[word]
