"""What Python answers: channels over one cam revolution by every model (contract, property), names
and orders of arguments, units (contract).
"""

from __future__ import annotations

import warnings

import matplotlib as mpl
import numpy as np
import pint
import pytest

import valvetrain as vt
from valvetrain import registry
from valvetrain.errors import UnusualValueWarning
from valvetrain.parameters.train_parts import CamParameters, ValveParameters
from valvetrain.solution.channels import spring_channels
from valvetrain.springs.spec import spring_model

mpl.use("Agg")
TURN = 2 * np.pi
MODELS = [
    name
    for name in registry.names("springs")
    if not (spring_model(name).no_motion or spring_model(name).alone)
]


@pytest.fixture(scope="module")
def runs():
    """Every model that moves, of a spring alone whose coils close, and of a nested pair in a train."""
    alone = vt.Case("job-c").set({"spring.options.finite-element.elements_per_coil": 6})
    train = vt.Case("vaz-ohc").set({"train.cycles": 1})
    some = ["massless", "multi-mass", "wave-rod-clash"]
    found = [*vt.simulate(alone.parameters, "3000 rpm", MODELS, workers=1).solutions]
    found += vt.simulate(
        train.parameters, "3000 rpm", some, spring_sets="nested", workers=1
    ).solutions
    return found


def test_half_a_revolution_is_the_open_valve_by_every_model(runs):
    """Property: the lift of a symmetric law is largest at the cam angle pi, of a spring alone and
    of a train, in the cycle and in all of the samples; every answer is the one of a spring at that
    angle.
    """
    for run in runs:
        lift = run["valve_lift"].sel(cam_angle=run["valve_lift"].idxmax("cam_angle"))
        assert float(lift) == run.channel("valve_lift").max(), run.label
        within = run.cam_angle % TURN
        for angle in (0.4, np.pi, 5.9):
            nearest = run["valve_lift"].sel(cam_angle=angle, method="nearest")
            sample = int(np.argmin(np.abs(within - angle)))
            assert float(nearest) == pytest.approx(run.channel("valve_lift")[sample], abs=1e-6)
            other = run.channels["valve_lift"].sel(cam_angle=angle, method="nearest")
            assert float(other) == float(nearest), run.label


def test_every_channel_of_every_model_has_axes_that_plot(runs):
    """Contract: units, labels and strictly ascending coordinates along every dimension."""
    import matplotlib.pyplot as plt

    for run in runs:
        angle = run.cycle["cam_angle"].values
        assert angle[0] == 0.0 and angle[-1] < TURN
        assert len(angle) * np.median(np.diff(angle)) == pytest.approx(TURN)
        for name in map(str, run.channels.data_vars):
            channel = run[name]
            assert channel.dims[0] == "cam_angle"
            for one in (channel, *channel.coords.values()):
                assert one.attrs["units"] and one.attrs["long_name"], (run.label, name, one.name)
            for dim in channel.dims:
                values = channel[dim].values
                assert np.isfinite(values).all() and (np.diff(values) > 0).all(), (name, dim)
        for name in ("seat_force", "coil_gap", "outer_coil_gap", "modal_coordinate"):
            if run.has(name) and run[name].size:
                run[name].plot()
                assert plt.gca().get_xlabel() or plt.gca().get_ylabel()
                plt.close("all")


def test_contacts_of_one_coil_are_the_least_gap_and_all_of_the_force():
    """Closed form: the chain lists the sections on the seat one by one, all with the coil number 0."""
    pairs = [1.5, 2.0, 0.0, 7.0, 0.0]
    gap = np.array([[5.0, 4.0, 3.0, 2.0, 1.0]] * 3) * 1e-3
    values = {"coil_gap": gap, "coil_contact_force": 1e6 * gap}
    run = vt.Solution(spring_channels([0, 1, 2], [TURN, 8.0, 9.0], values, upper_coil=pairs))
    assert run["coil_gap"].upper_coil.values.tolist() == [0.0, 1.5, 2.0, 7.0]
    assert run["coil_gap"][0].values.tolist() == [1e-3, 5e-3, 4e-3, 2e-3]
    assert run["coil_contact_force"][0].values.tolist() == [4e3, 5e3, 4e3, 2e3]
    assert run.cam_angle.tolist() == [TURN, 8.0, 9.0] and int(run.cycle.revolution) == 1


def test_files_hold_the_angle_that_counts_on(tmp_path):
    """Contract: what is stored is as before, and a file gives the run again, to the last bit."""
    import xarray

    case = vt.Case("job-t").set({"operation.cycles": 3})
    run = case.run("2000 rpm", models="massless")
    path = vt.save(run, tmp_path / "run.nc")
    with xarray.open_dataset(path, engine="h5netcdf") as file:
        assert np.array_equal(file["cam_angle"].values, run.cam_angle)
        assert file["cam_angle"].values[0] == pytest.approx(2 * TURN) and "revolution" not in file
    again, rebuilt = vt.load(path), vt.Solution(run.channels)
    assert again.identical(run) and np.array_equal(rebuilt.cam_angle, run.cam_angle)
    assert int(run.channels.revolution) == 2 and run.channels.cam_angle.values[0] == 0.0


UNITS = pint.UnitRegistry()


@pytest.mark.parametrize(
    "radius", ["18 mm", 0.018, np.float64(0.018), 18 * UNITS.mm, "1.8 cm"], ids=repr
)
def test_parts_take_a_unit_a_plain_number_and_a_quantity(radius):
    with warnings.catch_warnings(action="error"):
        assert CamParameters(radius).base_radius == pytest.approx(0.018, rel=1e-12)
        assert ValveParameters("125 g").mass == pytest.approx(0.125)


@pytest.mark.parametrize(
    ("part", "sentence"),
    [
        (lambda: CamParameters(18), "base_radius of the cam is 18000 mm"),
        (lambda: CamParameters("18 m"), "base_radius of the cam is 18000 mm"),
        (lambda: ValveParameters("125 kg"), "mass of the valve is 125000 g, beyond"),
        (lambda: vt.Case("tdi-pushrod").set({"train.valve.mass": "95 kg"}), "mass of the valve"),
        (lambda: vt.Case("tdi-pushrod").set({"train.valve.mass": 125}), "a plain number is in kg"),
    ],
)
def test_an_unusual_value_warns_and_is_taken(part, sentence):
    with pytest.warns(UnusualValueWarning, match=sentence):
        part()


def test_no_case_of_the_library_is_unusual():
    with warnings.catch_warnings(action="error"):
        for case in vt.list_cases():
            vt.load_case(case.name)


def test_degrees_and_millimetres_are_not_taken_for_radians_and_metres():
    degrees = np.arange(90.0, 271.0)
    lifts = 9e-3 * np.clip(1 - ((degrees - 180) / 60) ** 2, 0, None) ** 3
    right = vt.measured.smooth_lift(np.radians(degrees), lifts)
    by_units = vt.measured.smooth_lift(degrees * UNITS.deg, 1e3 * lifts * UNITS.mm)
    angles = np.linspace(2, 4, 5)
    assert by_units.lift(angles) == pytest.approx(right.lift(angles), abs=1e-7)
    with pytest.raises(vt.InputError, match=r"cam_angles: 270 rad .* '270 deg'"):
        vt.measured.smooth_lift(degrees, lifts)
    with pytest.raises(vt.InputError, match=r"lifts: 9 m .* 9 mm"):
        vt.measured.smooth_lift(np.radians(degrees), 1e3 * lifts)
