"""Contract: sentences of studies answer in the words of the question: frequencies for masses, reasons
for stress, timing for flex.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from valvetrain.explore.study import StudyText, read_plan
from valvetrain.explore.table import StudyTable
from valvetrain.parameters.loading import load_case
from valvetrain.solution.status import COMPLETED
from valvetrain.solution.uncertainty import Uncertainty


def of_points(
    case: str, varied: str, outputs: dict, model: str = "massless", **more: str
) -> StudyTable:
    """A study along one quantity, by made-up outputs (SI)."""
    lines = "\n".join(f"{name} = {value}" for name, value in more.items())
    text = f"""
case = "{case}"
spring_models = "{model}"
outputs = {list(outputs)}
{lines}
vary = [{varied}]
"""
    plan = read_plan(StudyText(text, "study", Path()))
    inputs = plan.sampler.first(plan.varied, plan.options)
    values = np.column_stack(list(outputs.values()))
    return StudyTable(plan, inputs, plan.runs * len(inputs), values, (COMPLETED,) * len(inputs))


def test_a_mass_that_parts_the_frequencies_of_a_pair_is_told_by_them():
    """Closed form: 0.5 sqrt(k / m) of both cards; asked for frequencies, the sentence spoke in grams."""
    masses = np.array([26.2, 25.0, 24.0, 20.0, 16.0, 11.5])
    rate = 4 * 370.0**2 * 26.2e-3
    own = {"surge_amplitude_force": [185, 124, 111, 107, 105, 104], "inner_surge_frequency": np.sqrt(rate / masses * 1e3) / 2}  # fmt: skip
    given = ", ".join(map(str, masses)) + " g"
    varied = (
        f'{{ key = "train.springs.nested-cards.1.mass", label = "inner mass", values = "{given}" }}'
    )
    more = {
        "points": '{ sampler = "grid" }',
        "spring_sets": '["nested-cards"]',
        "engine_speeds": '"4850 rpm"',
    }
    outer = load_case("vaz-ohc").train.springs["nested-cards"][0].card.surge_frequency
    said = of_points("vaz-ohc", varied, own, **more).verdict
    apart = 100 * (own["inner_surge_frequency"][2] / outer - 1)
    assert (
        f"24 g (387 Hz, {apart:.2g} % from the outer's {outer:.0f} Hz), but 124 N at 25 g" in said
    )
    assert "costs" not in said, "a frequency is no price"
    both = own | {"outer_surge_frequency": np.full(6, 350.0)}
    assert "% from the outer's 350 Hz)" in of_points("vaz-ohc", varied, both, **more).verdict


def test_where_the_widest_clearance_is_best_it_is_called_the_largest_tried():
    """Contract: what lies beyond the range is not known."""
    own = {"coil_bind_clearance": [4.6e-3, 3e-3, 1.5e-3], "clash_energy": [1e-3, 2e-3, 6e-3]}
    told = of_points(
        "gu2021-beehive-blind",
        '{ key = "spring.precompression", values = "7, 9, 11 mm" }',
        own,
        "finite-element",
        engine_speeds='"6000 rpm"',
        points='{ sampler = "grid" }',
    )
    assert (
        "choose 4.6 mm, the largest tried, or more, for clash energy is least there" in told.verdict
    )


def test_no_clearance_is_advised_within_error_bars():
    """Contract: of 1.6 against 4.7 mJ one had ± 3.4 mJ, and the smaller was advised."""
    own = {
        "coil_bind_clearance": [5.7e-3, 3.7e-3, 1.5e-3],
        "clash_energy": [4.7e-3, 1.6e-3, 4.9e-3],
    }
    table = of_points(
        "gu2021-beehive-blind",
        '{ key = "spring.precompression", values = "7, 9, 11 mm" }',
        own,
        "finite-element",
        engine_speeds='"8000 rpm"',
        points='{ sampler = "grid" }',
    )
    assert "choose 3.7 mm" in table.verdict

    def bar(value: float, size: float) -> dict[str, Uncertainty]:
        same = (value, value)
        return {
            "clash_energy": Uncertainty(
                "clash_energy", 837.8, value, size, None, value, 0.0, same, same, "rod"
            )
        }

    for size, advised in ((3.4e-3, False), (0.1e-3, True)):
        vars(table)["error_bars"] = {0: bar(4.7e-3, size), 1: bar(1.6e-3, 0.3e-3)}
        assert ("choose" in table.verdict) is advised


def test_a_spring_that_is_stressed_most_has_its_reasons():
    """Closed form: stress per force 2 against 1.8 MPa/N, and twice the surge."""
    own = {
        "largest_amplitude_shear_stress": [350e6, 300e6], "peak_shear_stress": [1000e6, 900e6],
        "peak_spring_force": [500.0, 500.0], "surge_amplitude_force": [20.0, 10.0],
    }  # fmt: skip
    table = of_points(
        "gu2021-beehive-blind", '{ key = "spring.precompression", values = "7, 9 mm" }', own, "finite-element",
        engine_speeds='"6000 rpm"', points='{ sampler = "list", names = ["thin", "thick"] }',
    )  # fmt: skip
    assert table.verdict == (
        "Thin is stressed most, so of equal wires it breaks first: largest stress amplitude 350 MPa against "
        "300 MPa with thick, because its wire bears more stress per force (2 against 1.8 MPa/N) and it surges more "
        "(20 N against 10 N); with peak shear stress 1000 MPa against 900 MPa."
    )


def test_two_points_of_a_train_are_told_with_their_timing():
    """Contract: durations are neither good nor bad, and what is lost of them is."""
    own = {
        "lift_loss_displacement": [7e-5, 6e-5],
        "valve_50_thou_open_crank_angle_range": np.radians([249, 250]),
    }
    table = of_points(
        "vaz-ohc", '{ key = "train.valve.mass", values = "100, 101 g" }', own, engine_speeds='"4000 rpm"',
        spring_sets='["nested"]', points='{ sampler = "list", names = ["as built", "stiff"] }',
    )  # fmt: skip
    assert table.verdict == (
        "Best is stiff: lift lost 0.06 mm against 0.07 mm with as built; valve open at 0.050 in 250 crank deg against 249 crank deg."
    )
