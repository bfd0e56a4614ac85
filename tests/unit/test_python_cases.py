"""Cases, springs and trains as objects: identity by content, one language of paths, the numbers of
the command line.
"""

from __future__ import annotations

import threading
import tomllib

import numpy as np
import pint
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import valvetrain as vt
from valvetrain.api.trace import labelled
from valvetrain.units import dimension_of

UNITS = pint.UnitRegistry()
WIRE = {
    "wire_diameter": "3.8 mm", "mean_diameter": "22 mm", "total_coils": 7, "pitch": "7 mm", "material": "EN 10270-2 VDSiCr",
    "installed_height": "36 mm",
}  # fmt: skip


def lift_of(peak):
    """A smooth lift (m) of the cam angle (rad), zero but for 63 degrees either side of 180."""
    return lambda cam_angle: peak * max(0.0, 1 - ((cam_angle - np.pi) / 1.1) ** 2) ** 4


def test_one_content_is_one_case_whatever_said_it(tmp_path):
    """Contract: equality and digest by content, not by text."""
    case = vt.Case("gu2021-beehive-blind")
    path = case.save(tmp_path / "mine.toml")
    same = [vt.Case(path), vt.Case(case.text), vt.Case(case.tree), vt.Case(case), vt.load(path)]
    assert [one.digest for one in same] == [case.digest] * len(same)
    assert all(one == case for one in same)
    assert len({*same, case}) == 1


@pytest.mark.parametrize(
    "value", ["3.9 mm", 0.0039, np.float64(0.0039), 3.9 * UNITS.mm, "0.39 cm"], ids=repr
)
@pytest.mark.parametrize("path", ["spring.wire_diameter", "springs.0.wire.wire_diameter"])
def test_one_language_of_paths_and_units(path, value):
    """Contract: the path of the file and of the object, SI, text and quantity are one change."""
    changed = vt.Case("job-t").set({path: value})
    assert changed == vt.Case("job-t").set({"spring.wire_diameter": "3.9 mm"}) != vt.Case("job-t")
    assert tomllib.loads(changed.text)["spring"]["wire_diameter"]["value"].endswith(("m", "meter"))


@settings(max_examples=20, deadline=None)
@given(
    diameter=st.floats(3e-3, 4.2e-3), pitch=st.floats(6.8e-3, 8e-3), speed=st.floats(50.0, 900.0)
)
def test_what_is_saved_is_read_again(tmp_path_factory, diameter, pitch, speed):
    """Property: any number given in Python comes back from the file, and every bit counts to 12
    digits.
    """
    spring = vt.Spring(**WIRE | {"wire_diameter": diameter, "pitch": pitch})
    case = vt.Case(spring=spring, lift_law=lift_of(8e-3), engine_speeds=speed)
    again = vt.load(case.save(tmp_path_factory.mktemp("case") / "own.toml"))
    assert again == case and again.parameters.operation.engine_speeds == (speed,)
    assert case.set({"spring.wire_diameter": diameter * (1 + 1e-9)}) != case


def test_different_lifts_are_different_cases():
    """Two tables that numpy prints alike were one case once."""
    cases = [vt.Case(spring=vt.Spring(**WIRE), lift_law=lift_of(peak)) for peak in (8e-3, 8.017e-3)]
    assert cases[0] != cases[1] and cases[0].digest != cases[1].digest


def test_a_changed_case_has_the_text_of_the_change():
    changed = vt.Case("job-t").set({"spring.wire_diameter": "3.9 mm"}, title="Thinner wire")
    assert "3.9 mm" in changed.text and "4.0 mm" not in changed.text
    found = vt.Case("job-t").diff(changed)
    assert "title" in found and any(
        path.startswith("springs.0.wire.wire_diameter") for path in found
    )


def test_a_spring_alone_gives_the_closed_form():
    """Closed form: rate G d^4 / (8 D^3 n), first surge frequency of a uniform spring
    d / (2 pi D^2 n) sqrt(G / (2 rho)), of a spring whose end turns are open.
    """
    shear_modulus, density, wire, mean, coils = 79e9, 7850.0, 4e-3, 30e-3, 8
    material = {
        "name": "steel",
        "youngs_modulus": 206e9,
        "shear_modulus": shear_modulus,
        "density": density,
    }
    spring = vt.Spring(
        wire_diameter=wire, mean_diameter=mean, total_coils=coils, ends="open", pitch=8e-3, material=material, precompression=5e-3,
        seats="clamps",
    )  # fmt: skip
    rate = shear_modulus * wire**4 / (8 * mean**3 * coils)
    assert spring.static(models="multi-mass").force_at(8e-3) == pytest.approx(8e-3 * rate, rel=0.03)
    first = wire / (2 * np.pi * mean**2 * coils) * np.sqrt(shear_modulus / (2 * density))
    assert spring.frequencies("modal-uniform", 1)[0] == pytest.approx(first, rel=0.03)


def test_a_lift_that_is_a_function_moves_as_the_law_of_the_library():
    """Twin: the sine to the fourth power of job-t, as a function of the cam angle."""
    case = vt.Case("job-t")
    low, high = np.radians([127.0, 233.0])

    def lift(cam_angle):
        inside = low < cam_angle < high
        return 10e-3 * np.sin(np.pi * (cam_angle - low) / (high - low)) ** 4 if inside else 0.0

    own = case.set(lift_law=lift)
    for name in ("peak_spring_force", "minimum_spring_force"):
        one, other = (
            item.run("4000 rpm", models="multi-mass").quantities[name] for item in (case, own)
        )
        assert other == pytest.approx(one, rel=1e-5)


@pytest.mark.parametrize(
    ("lift", "sentence"),
    [
        (lambda cam_angle: 9.0 * (cam_angle > 3), "metres"),
        (lambda cam_angle: 1e-3, "closed somewhere"),
        (lambda cam_angle: "high", "lift function fails"),
        (7, "cam angles"),
    ],
)
def test_a_lift_that_is_none_is_refused(lift, sentence):
    with pytest.raises(vt.InputError, match=sentence):
        vt.Case(spring=vt.Spring(**WIRE), lift_law=lift)


def test_a_train_from_parts_is_the_train_of_the_file():
    whole = vt.Case("tdi-pushrod")
    parts = dict(whole.tree["train"])
    kind, springs = parts.pop("kind"), parts.pop("springs")
    case = vt.Case(
        train=vt.Train(kind, springs=springs, **parts),
        lift_law=whole.tree["lift_law"],
        engine_speeds="3000 rpm",
    )
    options = {"models": "massless", "spring_sets": "stock"}
    one, other = (item.run("3000 rpm", **options) for item in (whole, case))
    assert vt.diff(one, other) == {} and one.quantities["peak_spring_force"] > 0


def test_no_spring_set_is_the_sets_of_the_case_and_a_number_is_none():
    """Twin: None, as no argument at all."""
    words = ("job-t", "2000 rpm")
    none, plain = (
        vt.simulate(*words, models="massless", **given).solutions[0]
        for given in ({"spring_sets": None}, {})
    )
    assert vt.diff(none, plain) == {}
    with pytest.raises(vt.InputError, match="'5' is no name; give one as text"):
        vt.simulate(*words, models="massless", spring_sets=5)


def test_a_study_computes_what_was_requested_and_nothing_else():
    """Twin: each point is the run of the changed case."""
    table = vt.Case("job-t").study(
        {"spring.pitch": vt.Uniform("7.2 mm", "7.8 mm")}, "peak_spring_force", count=3, engine_speeds="4000 rpm", models="massless",
        workers=1,
    )  # fmt: skip
    assert [
        name for name in table.to_xarray().data_vars if "force" in name or "preload" in name
    ] == ["peak_spring_force"]
    for pitch, force in zip(
        table.column("spring.pitch"), table.column("peak_spring_force"), strict=True
    ):
        run = (
            vt.Case("job-t").set({"spring.pitch": float(pitch)}).run("4000 rpm", models="massless")
        )
        assert force == pytest.approx(run.quantities["peak_spring_force"], rel=1e-12)


def test_an_unknown_is_found_again():
    """Recovery: the precompression that made the measured preload."""
    case, options = vt.Case("job-t"), {"engine_speeds": "4000 rpm", "models": "massless"}
    true = case.set({"spring.precompression": "7.3 mm"}).run("4000 rpm", models="massless")
    measured = {"peak_spring_force": (true.quantities["peak_spring_force"], 0.5)}
    quick = vt.explore.Search(draws=10)
    found = case.identify(
        {"spring.precompression": ("6 mm", "8 mm")}, measured, workers=1, search=quick, **options
    )
    assert found.best["spring.precompression"] == pytest.approx(7.3e-3, rel=1e-3)


def test_a_trace_tells_an_unknown():
    """Recovery within its own interval: the precompression behind a force with noise of 3 N."""
    case, options = vt.Case("job-t"), {"engine_speeds": "4000 rpm", "models": "massless"}
    true = case.set({"spring.precompression": "7.3 mm"}).run("4000 rpm", models="massless")
    trace = true["seat_force"] + np.random.default_rng(2).normal(0.0, 3.0, 720)
    unknown = {"spring.precompression": ("6 mm", "8 mm")}
    quick = vt.explore.Search(draws=10)
    found = case.identify(
        unknown, trace.rename("seat_force"), scatter="3 N", search=quick, **options
    )
    # 180 samples of 3 N know a force to 0.22 N, a compression at 30 N/mm to 7.5 um
    assert found.best["spring.precompression"] == pytest.approx(7.3e-3, abs=4 * 7.5e-6)
    for wrong, scatter, words in (
        (trace.rename(None), None, "whose name is a channel"),
        (trace.rename("seat_forse"), None, "did you mean seat_force"),
        (trace.rename("seat_force").assign_attrs(units="mm"), None, "is in mm, the channel in N"),
        (trace.rename("seat_force"), "3 mm", "force is needed"),
        (trace.rename("seat_force").assign_coords(cam_angle=np.arange(720) / 2), None, "degrees"),
    ):
        with pytest.raises(vt.InputError, match=words):
            case.identify(unknown, wrong, scatter=scatter, **options)


def as_pairs(trace):
    return {
        trace.name: list(
            zip(trace["cam_angle"].values.tolist(), trace.values.tolist(), strict=True)
        )
    }


@pytest.mark.parametrize(
    "form",
    [
        lambda trace: {trace.name: trace.rename("own")},
        lambda trace: trace.to_series(),
        lambda trace: trace.to_dataframe()[[trace.name]],
        lambda trace: trace.to_dataframe()[[trace.name]].reset_index(),
        lambda trace: {trace.name: trace.to_dataframe()[[trace.name]].reset_index()},
        as_pairs,
        lambda trace: {trace.name: np.array(as_pairs(trace)[trace.name])},
        lambda trace: {
            trace.name: [
                (f"{float(np.degrees(angle))!r} deg", f"{force / 4.4482216152605!r} lbf")
                for angle, force in as_pairs(trace)[trace.name]
            ]
        },
    ],
)
def test_a_trace_in_any_form_is_the_same_trace(form):
    trace = vt.Case("job-t").run("4000 rpm", models="massless")["seat_force"]
    read = labelled(form(trace))
    assert read.name == "seat_force" and dimension_of(read.attrs.get("units", "N")) == "force"
    assert np.allclose(read.values, trace.values, rtol=1e-12)
    assert np.allclose(read["cam_angle"].values, trace["cam_angle"].values, rtol=1e-12)


@pytest.mark.parametrize(
    "measured",
    [
        3.0,
        "seat_force",
        [(0.0, 400.0), (0.1, 410.0)],  # of no channel
        {"seat_force": 400.0},
        {"seat_force": (400.0, 1.0, 2.0)},
        {"peak_spring_force": (800.0, 5.0), "seat_force": [(0.0, 400.0), (0.1, 410.0)]},
        np.zeros((3, 4)),
    ],
)
def test_what_is_no_measurement_is_refused_with_what_is(measured):
    with pytest.raises(vt.InputError, match=r"(?s)DataArray.*DataFrame"):
        vt.Case("job-t").identify({"spring.precompression": ("6 mm", "8 mm")}, measured)


def test_a_trace_in_other_units_is_the_same_trace():
    case, options = vt.Case("job-t"), {"engine_speeds": "4000 rpm", "models": "massless"}
    force = case.run("4000 rpm", models="massless")["seat_force"]
    pounds = (force / 4.4482216152605).assign_coords(cam_angle=np.degrees(force["cam_angle"]))
    pounds = pounds.rename("seat_force").assign_attrs(units="lbf")
    pounds["cam_angle"].attrs["units"] = "deg"
    found = case.identify(
        {"spring.precompression": ("6 mm", "8 mm")}, pounds, scatter="1 lbf", search=vt.explore.Search(draws=10), **options,
    )  # fmt: skip
    assert found.best["spring.precompression"] == pytest.approx(7e-3, rel=1e-6)


def test_a_function_of_a_cell_runs_in_workers():
    """Same bits for one process and for two, of a function that no module holds."""
    base, factor = vt.Case("job-t"), 1.5

    def force(pitch):
        run = base.set({"spring.pitch": pitch}).run("3000 rpm", models="massless")
        return factor * run.quantities["peak_spring_force"]

    designs = ["7.2 mm", "7.4 mm", "7.6 mm"]
    assert vt.map(force, designs, workers=2) == vt.map(force, designs, workers=1)
    with pytest.raises(vt.InputError, match="cannot be sent"):
        lock = threading.Lock()
        vt.map(lambda one: lock.locked(), [1, 2], workers=2)


def test_several_runs_are_not_one():
    with pytest.raises(vt.InputError, match="name one speed and one model"):
        vt.Case("gu2021-beehive-blind").run(models="massless")


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        (lambda case: vt.Case(5), "is no case"),
        (lambda case: case.set({"spring.pitch": 4 * UNITS.kg}), "a length is needed"),
        (lambda case: case.set({"spring.pitch": object()}), "no value of a case"),
        (lambda case: vt.Uniform("7 mm", "8 kg"), "a length is needed"),
        (
            lambda case: case.study({"spring.pitch": vt.Uniform("7 kg", "8 kg")}, "preload"),
            "dimension mass",
        ),
        (
            lambda case: case.study({"spring.pitch": ["7 kg", "8 kg"]}, "preload", sampling="grid"),
            "dimension mass",
        ),
        (
            lambda case: case.identify(
                {"spring.precompression": ("6 mm", "8 mm")}, {"preload": ("280 mm", "1 N")}
            ),
            "a force is needed",
        ),
        (
            lambda case: case.study(
                {"spring.pitch": [7e-3, 8e-3], "spring.wire_diameter": [4e-3]},
                "preload",
                sampling="list",
            ),
            "as many values",
        ),
        (lambda case: case.study({"spring.pitch": [7e-3]}, [len]), "no name"),
        (lambda case: case.study({"lift_law": [len]}, "preload"), "no number"),
        (lambda case: vt.load("mine.txt"), r"\.toml"),
        (lambda case: vt.save(case, "mine.nc"), r"\.toml"),
        (lambda case: vt.diff(case, 3), "two of a kind"),
        (lambda case: vt.Case(vt.load_case("job-t").replace(springs=())), "no file"),
    ],
)
def test_wrong_input_is_refused_in_one_sentence(wrong, sentence):
    with pytest.raises(vt.InputError, match=sentence):
        wrong(vt.Case("job-t"))


def test_listed_designs_are_run_row_by_row():
    rows = {"spring.pitch": ["7.4 mm", 7.5e-3], "spring.wire_diameter": ["4 mm", "3.9 mm"]}
    table = vt.Case("job-t").study(rows, "preload", sampling="list", workers=1)
    assert table.column("spring.pitch") == pytest.approx([7.4e-3, 7.5e-3])
    assert table.column("spring.wire_diameter") == pytest.approx([4e-3, 3.9e-3])


def bump(cam_angle, centre, peak, half):
    away = (cam_angle - centre + np.pi) % (2 * np.pi) - np.pi
    return peak * max(0.0, 1 - (away / half) ** 2) ** 4


@pytest.mark.parametrize(
    "lift",
    [
        lambda cam_angle: bump(cam_angle, 0.1, 9e-3, 0.9),
        lambda cam_angle: bump(cam_angle, 2.0, 9e-3, 0.9) + bump(cam_angle, 4.9, 2e-3, 0.4),
        lambda cam_angle: bump(cam_angle, 3.0, 9e-3, 2.9),
    ],
    ids=["over the zero of the angle", "two events", "almost the whole turn"],
)
def test_all_of_a_lift_function_is_in_the_law(lift):
    """Closed form: the law is the function at every angle, to a hundredth of a micrometre."""
    case = vt.Case(spring=vt.Spring(**WIRE), lift_law=lift)
    law, angles = vt.cam.build_lift_law(case.parameters.lift_law), np.linspace(0, 2 * np.pi, 1441)
    assert law.lift(angles, 0) == pytest.approx([lift(one) for one in angles], abs=1e-8)


def test_a_name_is_of_the_case_and_its_file(tmp_path):
    case = vt.Case(vt.Case("job-t").tree | {"name": "old"}, name="mine")
    assert case.name == "mine" == vt.load(case.save(tmp_path / "other.toml")).name
