"""Outputs that no run of a study can give are refused before the first point, and no others."""

from __future__ import annotations

import pytest

import valvetrain as vt
from train_parts import SINGLE_MASS
from unit.cli_parts import SMALL
from valvetrain.explore.engine import Engine, Evaluation
from valvetrain.explore.evaluate import evaluate
from valvetrain.explore.outputs import Run
from valvetrain.explore.study import refuse_outputs
from valvetrain.quantities.request import PointRequest

NAMES = (
    "clash_count", "peak_clash_force", "largest_clash_energy", "peak_shear_stress", "peak_equivalent_stress",
    "open_nominal_shear_stress", "peak_spring_force", "surge_amplitude_force",
)  # fmt: skip
SPEED = 900.0


def case_of(tmp_path, text: str) -> vt.Case:
    (tmp_path / "own.toml").write_text(text)
    return vt.load_case(tmp_path / "own.toml")


def refuse(case: vt.Case, name: str, models, key: str) -> None:
    space = vt.Space({key: vt.Uniform(1.0, 2.0)})
    outputs = vt.Outputs(name, engine_speeds=(SPEED,), spring_models=models)
    refuse_outputs(case, Evaluation(case, space, outputs).tasks)


@pytest.mark.parametrize("model", ["massless", "modal-varied", "multi-mass", "finite-element"])
def test_exactly_what_a_run_does_not_give_is_refused(model, tmp_path):
    """Other path: the names that the run itself gives."""
    case = case_of(tmp_path, SMALL)
    request = PointRequest(NAMES)
    found = evaluate(case, {}, Run(SPEED, model), request)
    assert found.status.completed, found.status.sentence()
    for name in NAMES:
        if name in found.values:
            refuse(case, name, model, "spring.precompression")
        else:
            with pytest.raises(vt.InputError, match=f"cannot be had by {model}"):
                refuse(case, name, model, "spring.precompression")


def test_one_model_that_gives_it_is_enough(tmp_path):
    case = case_of(tmp_path, SMALL)
    refuse(case, "clash_count", ["massless", "finite-element"], "spring.precompression")
    refuse(case, "clash_count", [], "spring.precompression")  # the case's own model


@pytest.mark.parametrize(
    "name", ["peak_clash_force", "open_nominal_shear_stress", "peak_shear_stress"]
)
def test_a_card_has_neither_coils_nor_stress(name, tmp_path):
    case = case_of(tmp_path, SINGLE_MASS)
    with pytest.raises(vt.InputError, match="spring 'spring' is known by card alone"):
        refuse(case, name, "multi-mass", "train.springs.card.0.preload")
    refuse(case, "peak_spring_force", "multi-mass", "train.springs.card.0.preload")


def test_a_quantity_of_the_other_system_is_refused(tmp_path):
    case = case_of(tmp_path, SMALL)
    with pytest.raises(vt.InputError, match="a spring has no mean cam power"):
        refuse(case, "mean_cam_power", "massless", "spring.precompression")


def test_a_study_file_is_refused_before_anything_is_computed(monkeypatch):
    monkeypatch.setattr(Engine, "compute", None)
    text = (
        'case = "tdi-pushrod"\nengine_speeds = "3000 rpm"\nspring_models = "massless"\n'
        'outputs = ["peak_clash_force", "peak_cam_contact_force"]\n'
        'vary = [{ key = "train.valve.mass", values = "90, 110 g" }]\n'
    )
    with pytest.raises(
        vt.InputError, match=r"line 4, outputs: the peak clash force .* cannot be had"
    ):
        vt.study(text, workers=1)
