"""Property: every train of a study is brought to rest once, however many runs, labels and speeds share
it; trains that differ in lash or spring model differ in their rest.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from valvetrain.parameters.loading import load_case
from valvetrain.runs.statics import static_study
from valvetrain.runs.train_runs import prepare_trains
from valvetrain.solution.partial_failures import PartialFailures
from valvetrain.system import train_rest
from valvetrain.system.build import build


def test_each_distinct_rest_is_solved_once(monkeypatch):
    solved: list[np.ndarray] = []
    plain = train_rest.static_equilibrium

    def counted(system, cam_angle, start=None):
        solved.append(plain(system, cam_angle, start))
        return solved[-1]

    monkeypatch.setattr(train_rest, "static_equilibrium", counted)
    whole = build(load_case("vaz-ohc"))
    problem = replace(whole, members=whole.only(lambda one: one.model.word in ("massless", "multi-mass")))  # fmt: skip
    twice = (*problem.members, *(replace(one, label=f"{one.label}, again") for one in problem.members))  # fmt: skip
    failures = PartialFailures()
    ready, _ = prepare_trains(replace(problem, members=twice), problem.engine_speeds, failures)
    lashes = {one.gear.parameters.lash for one in problem.members}
    models = {one.model.word for one in problem.members}
    assert not failures.sentences and len(ready) == 2 * len(problem.members)
    assert len(solved) == len(lashes) * len(models) == len(problem.members) == 4
    rests = [one.rest.equilibrium for one in ready[: len(problem.members)]]
    by_lash = {one.gear.parameters.lash: rest for one, rest in zip(problem.members, rests, strict=True)}  # fmt: skip
    first, second = by_lash.values()
    assert np.max(np.abs(first - second)) > 1e-5  # no rest of one lash is that of the other


def test_the_springs_of_the_set_in_use_come_first():
    """Contract: not a card of another set, of 17.4 N/mm throughout; coils of the outer spring in use close in the
    lift: 17.1 N/mm installed, 22.9 at full lift.
    """
    study = static_study(load_case("vaz-ohc"))
    assert [(one.spring, one.model) for one in study.rest[:2]] == [
        ("outer", "finite-element"),
        ("inner", "finite-element"),
    ]
    assert len(study.rest) == 4
    outer = study.rest[0]
    lifted = outer.precompression + 9.7e-3
    rates = [float(outer.curve.stiffness_at(at)) for at in (outer.precompression, lifted)]
    assert rates == pytest.approx([17.1e3, 22.9e3], rel=0.01)
