"""What a record keeps of a finite-element spring shows the same outputs as its whole state."""

from __future__ import annotations

import numpy as np
import pytest

from valvetrain.integrate import train_run
from valvetrain.integrate.train_channels import spring_outputs
from valvetrain.integrate.train_log import note_body
from valvetrain.integrate.train_run import TrainOptions, runner
from valvetrain.integrate.train_steady import steady_train
from valvetrain.parameters import cylindrical
from valvetrain.parameters.loading import load_case
from valvetrain.springs import FiniteElementRod
from valvetrain.system.build import build
from valvetrain.system.train_system import TrainSystem

COARSE = {
    f"train.springs.nested.{place}.options.finite-element.elements_per_coil": 8 for place in (0, 1)
}


@pytest.mark.long
def test_the_recorded_head_of_a_large_state_is_enough(monkeypatch):
    problem = build(
        load_case("vaz-ohc", COARSE), spring_models=["finite-element"], spring_set=["nested"]
    )
    built = problem.members[0].system()
    assert isinstance(built, TrainSystem) and {
        spring.elements_per_coil for spring in built.springs
    } == {8}
    found = []
    for entries in (None, len(built.springs[1].initial_state(0.0))):
        if entries is not None:
            monkeypatch.setattr(train_run, "recorded_entries", lambda spring, size=entries: size)
        ready = runner(
            built, problem.engine_speeds[0] / 2, TrainOptions(samples=36, record_springs=True)
        )
        steady = steady_train(ready, "repeat", cycles=1)
        assert (steady.record.spring_states[1].shape[1] == entries) is (entries is not None)
        found.append(
            spring_outputs(
                steady.runner.springs[1],
                steady.record,
                steady.start.springs[1],
                1,
                built.arrays.retainer,
            )
        )
    for head, whole in zip(*found, strict=True):
        assert head.axial_displacement == pytest.approx(whole.axial_displacement, abs=1e-12)
        assert head.coil_contact_force == pytest.approx(whole.coil_contact_force, abs=1e-6)
    assert (
        max(np.max(output.coil_contact_force) for output in found[0]) < 1e4
    )  # N, a clash and no artefact


def test_the_end_of_a_wire_goes_as_far_as_the_retainer_went_since_its_step():
    rod = FiniteElementRod(cylindrical("3.8 mm", "22 mm", "7 mm", total_coils=7), 5e-3, 6)
    state, top = rod.initial_state(0.0), slice(rod.mesh.last, None)
    before = rod.rod_state(state, 0.0).position
    rod.place_retainer(state, 2e-3, 1e-5)
    after = rod.rod_state(state, 2e-3).position
    assert before[top, 2] - after[top, 2] == pytest.approx(1e-5, rel=1e-9)
    np.testing.assert_array_equal(after[: rod.mesh.last], before[: rod.mesh.last])


def test_peaks_of_a_body_are_kept_with_their_cam_angles():
    """Speed where the sample lies between the kick's ends, acceleration of either sign, by hand; of
    equals the first.
    """
    peaks = np.zeros((2, 5))
    for place, before, after, now, acceleration, angle in (
        (1e-3, 0.0, 2.0, 0.5, 4.0, 0.1),
        (3e-3, 2.0, -5.0, 0.25, -14.0, 0.2),
        (2e-3, -5.0, -6.0, 0.5, -2.0, 0.3),
        (5e-4, -6.0, 1.0, 1.0, 14.0, 0.4),
    ):
        note_body.py_func(0, place, before, after, now, acceleration, angle, peaks)
    assert peaks.tolist() == [[3e-3, 5.5, 0.3, 14.0, 0.2], [0.0] * 5]
