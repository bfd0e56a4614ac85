"""Every quantity of a dozen cases is where it was, within a tolerance by what it means.

The numbers are in ``numbers.csv``; ``scripts/write_net.py`` writes them anew and says which cases run.
"""

from __future__ import annotations

import math

import pytest
from write_net import JOBS, Entry, Key, compute, moved, read, stored

NUMBERS = read()
FORCE = Key("case", "4000", "massless", "", "peak_spring_force")


@pytest.mark.parametrize("job", JOBS, ids=str)
def test_numbers_are_where_they_were(job):
    numbers = stored(job, NUMBERS)
    assert numbers
    assert not moved(numbers, compute(job))


def test_every_stored_number_belongs_to_one_job():
    owned = [key for job in JOBS for key in stored(job, NUMBERS)]
    assert sorted(owned) == sorted(NUMBERS)


@pytest.mark.parametrize(("value", "count"), [(500.4, 0), (500.6, 1), (499.4, 1), (math.nan, 1)])
def test_a_number_beyond_its_tolerance_is_named(value, count):
    old = {FORCE: Entry(500.0, "N", "settled", 0.5)}
    assert len(moved(old, {FORCE: Entry(value, "N", "settled", 0.5)})) == count


def test_a_number_that_is_not_resolved_has_to_be_there():
    old = {FORCE: Entry(500.0, "N", "not resolved", math.nan)}
    assert not moved(old, {FORCE: Entry(900.0, "N", "impact", 45.0)})
    assert len(moved(old, {})) == 1 and len(moved({}, old)) == 1
