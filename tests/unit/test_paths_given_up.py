"""Unit: a path of compression that keeps failing is given up, and what it found before is kept."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from twins.rod_cases import small_spring
from valvetrain.cosserat.mesh import mesh_spring
from valvetrain.cosserat.state import free_state
from valvetrain.cosserat.static import FAILURES, NewtonOptions, RodStatics, compress


class TakesSteps:
    """Stands for statics that find an equilibrium after steps of ``longest`` at most and up to
    ``end``; keeps what was asked and failed.
    """

    def __init__(self, longest: float, end: float = 1.0) -> None:
        self.longest, self.end, self.options = longest, end, NewtonOptions()
        self.mesh, self.asked, self.failed, self.at = None, 0, 0, 0.0

    def solve(self, state, compression):
        step, self.asked = abs(compression - self.at), self.asked + 1
        held = step <= self.longest * (1 + 1e-9) and compression <= self.end
        if held:
            self.at = compression
        self.failed += not held
        return SimpleNamespace(converged=held, state=SimpleNamespace(compression=self.at))


def path(statics, *targets):
    return compress(statics, targets, SimpleNamespace(compression=0.0))


def test_steps_that_fail_again_and_again_end_the_path():
    """Every third increment is doubled and fails; 22 mm by increments of two micrometres would ask
    10 000 times.
    """
    statics = TakesSteps(2.2e-6)
    found = path(statics, 22e-3)
    assert [one.converged for one in found] == [False]
    assert statics.failed == FAILURES and statics.asked < 6 * FAILURES


def test_a_path_that_ends_is_left_at_the_smallest_increment_with_what_it_had():
    statics = TakesSteps(1.0, end=5.3e-3)
    found = path(statics, 2e-3, 4e-3, 6e-3)
    assert [one.converged for one in found] == [True, True, False]
    assert (
        statics.at == pytest.approx(5.3e-3, abs=2 * statics.options.smallest_increment)
        and statics.failed <= 12
    )


@pytest.mark.parametrize("most", [3, 7])
def test_newton_ends_after_its_iterations(most):
    """A tolerance that rounding never meets: the answer says how often it was asked, and that it
    did not converge.
    """
    statics = RodStatics(
        mesh_spring(small_spring(2.4, pitch=6e-3), 16),
        options=NewtonOptions(tolerance=0.0, iterations=most),
    )
    result = statics.solve(free_state(statics.mesh), 0.5e-3)
    assert not result.converged and result.iterations == most
