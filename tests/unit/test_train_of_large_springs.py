"""Unit: a train is sampled and settled as its largest spring asks, whichever place that has; one
without springs as one of light ones.
"""

from __future__ import annotations

from typing import Any

import pytest

from train_parts import LAW, direct
from valvetrain.integrate import train_leapfrog
from valvetrain.integrate.contract import Periodic, RunOptions
from valvetrain.mechanism.build import build_mechanism
from valvetrain.solution.provenance import Provenance
from valvetrain.springs.massless import MasslessSpring
from valvetrain.system.train_system import TrainSystem


class Large(MasslessSpring):
    """A spring that says of itself that its inner state is large."""

    def prepare(self) -> None: ...

    def place_retainer(
        self, state: Any, retainer_displacement: float, travel_since: float
    ) -> None: ...


class Begun(Exception):
    """The run was begun with these options."""


LIGHT, LARGE = MasslessSpring(30e3, 300.0, 0.04), Large(30e3, 300.0, 0.04)
#: Springs of a train -> whether its run is that of a large spring.
TRAINS = {
    (): False, (LIGHT,): False, (LIGHT, LIGHT): False, (LARGE,): True, (LIGHT, LARGE): True, (LARGE, LIGHT): True, (LARGE, LARGE): True,
}  # fmt: skip


def begun(
    monkeypatch: pytest.MonkeyPatch, springs: tuple[Any, ...], until: Periodic, options: RunOptions
) -> tuple[Any, ...]:
    """Samples of a turn, and method, tolerance, most turns and comparison of the search that a run
    would begin; nothing is integrated.
    """
    chosen: list[Any] = []

    def stop(*given: Any, **more: Any) -> None:
        raise Begun(*given[1:4], more["compared"])

    monkeypatch.setattr(
        train_leapfrog, "runner", lambda system, cam_speed, asked, rest: chosen.append(asked)
    )
    monkeypatch.setattr(train_leapfrog, "steady_train", stop)
    system = TrainSystem(build_mechanism(direct(), LAW, "tappet"), springs)
    with pytest.raises(Begun) as found:
        train_leapfrog.TrainLeapfrog().run(
            system, 200.0, until, options, Provenance("case", "model", 400.0)
        )
    return chosen[0].samples, *found.value.args


@pytest.mark.parametrize("springs", TRAINS)
def test_a_large_spring_is_kept_at_half_the_samples_and_settles_by_plain_turns(
    springs, monkeypatch
):
    found = begun(monkeypatch, springs, Periodic(), RunOptions(rest=object()))
    few, usual = ("repeat", 1e-3, 3, False), ("anderson", train_leapfrog.TOLERANCE, 60, True)
    assert found == ((720, *few) if TRAINS[springs] else (1440, *usual))


@pytest.mark.parametrize("springs", TRAINS)
def test_what_is_asked_goes_before_what_is_usual(springs, monkeypatch):
    found = begun(
        monkeypatch,
        springs,
        Periodic(cycles=9, tolerance=0.02),
        RunOptions(samples=360, rest=object()),
    )
    assert (found[0], *found[2:4]) == (360, 0.02, 9)
