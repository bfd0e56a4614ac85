"""A law that remembers gives the bits of the law itself, whatever it was asked before."""

from __future__ import annotations

import numpy as np

from valvetrain import load_case
from valvetrain.cam import LiftLaw, build_lift_law
from valvetrain.cam.cached import MAX_ANSWERS, RememberedLift


def test_answers_are_those_of_the_law_and_few_are_kept():
    law = build_lift_law(load_case("gu2021-beehive-blind").lift_law)
    known = RememberedLift(law)
    assert isinstance(known, LiftLaw) and (known.continuity, known.joints) == (
        law.continuity,
        law.joints,
    )
    generator = np.random.default_rng(2)
    for _ in range(2):
        for turn in range(3 * MAX_ANSWERS):
            angles = np.sort(generator.random(200 + turn) * 6)
            for derivative in (0, 1):
                assert np.array_equal(known.lift(angles, derivative), law.lift(angles, derivative))
    assert len(known._answers) == MAX_ANSWERS


def test_other_angles_between_the_same_ends_are_not_taken_for_those_before():
    law = build_lift_law(load_case("gu2021-beehive-blind").lift_law)
    known, angles = RememberedLift(law), np.linspace(2.0, 4.0, 300)
    known.lift(angles)
    moved = angles.copy()
    moved[150] += 1e-9
    assert np.array_equal(known.lift(moved), law.lift(moved)) and np.array_equal(
        known.lift(angles), law.lift(angles)
    )
    angles[10] += 0.1  # the caller's own array may change
    assert np.array_equal(known.lift(angles), law.lift(angles))
    assert known.lift(3.0) == law.lift(3.0)
