"""Contract: what a case runs unless it is told otherwise is physics; the replica of what a source does runs where it is
named. For every library and template case and every way in that builds runs of a case.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

import pytest

import valvetrain as vt
from valvetrain.parameters.loading import library_names, load_case
from valvetrain.parameters.train import TrainParameters
from valvetrain.runs import compare, refine, run, run_up
from valvetrain.system.build import build

TEMPLATES = Path(vt.__file__).parent / "templates"
TRAINS = [
    name
    for name in (*library_names(), *map(str, sorted(TEMPLATES.glob("*.toml"))))
    if load_case(name).train is not None
]


class Built(Exception):
    """The runs that a command was about to make."""


def members_of(module: object, call: Callable[[], object], monkeypatch) -> Iterable:
    """The members that a command builds first."""

    def stop(*args: object, **options: object) -> None:
        raise Built(build(*args, **options).members)

    monkeypatch.setattr(module, "build", stop)
    with pytest.raises(Built) as found:
        call()
    return found.value.args[0]


def is_physical(train: TrainParameters, member) -> bool:
    """Whether a member is none of the replicas of the case, by its label, and has its springs as they are installed."""
    replicas = {one.label for one in train.variants if one.replica}
    springs = [one for some in train.springs.values() for one in some]
    return member.label not in replicas and all(spring in springs for spring in member.springs)


WAYS = {
    "run": (run, lambda case: vt.simulate(case, workers=1)),
    "sweep": (run, lambda case: vt.sweep(case, [300.0, 400.0], workers=1)),
    "run-up": (run_up, lambda case: vt.run_up(case, "2000 rpm", "2400 rpm", "0.2 s")),
    "compare": (compare, lambda case: vt.compare(case, "2000 rpm", workers=1)),
    "refine": (refine, lambda case: refine.refined(case, [300.0], workers=1)),
}


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", TRAINS, ids=lambda name: Path(name).stem)
def test_the_runs_of_a_case_are_physical_unless_a_replica_is_named(name, way, monkeypatch):
    case, (module, call) = load_case(name), WAYS[way]
    members = members_of(module, lambda: call(case), monkeypatch)
    assert members and all(is_physical(case.train, member) for member in members)


def test_a_run_whose_springs_have_no_preload_is_marked_as_a_replica_in_every_case():
    """The slip of a source is data of the case: springs at rest with the valve closed are no valvetrain's."""
    for name in TRAINS:
        variants = load_case(name).train.variants
        assert all(bool(one.replica) == one.without_preload for one in variants), name


def test_a_replica_runs_where_it_is_named():
    case = load_case("tdi-pushrod")
    every = [one.label for one in case.train.variants]
    named = [member.label for member in build(case, spring_set="as printed").members]
    assert sorted(named) == sorted(every)
    beside = build(case, spring_models="massless", spring_set=["stock", "as printed"]).members
    replicas = [one.label for one in case.train.variants if one.replica]
    assert [one.label for one in beside] == [
        "stock, massless",
        *(f"{one}, massless" for one in replicas),
    ]
    alone = build(case, spring_models="massless", spring_set="as printed").members
    assert [one.label for one in alone] == [f"{one}, massless" for one in replicas]
