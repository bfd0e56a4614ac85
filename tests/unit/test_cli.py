"""The commands and what they print; wrong input is one sentence and exit code 2."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest

from unit.cli_parts import call, sentence, typed
from valvetrain import __version__
from valvetrain.errors import InputError
from valvetrain.parameters.loading import LIBRARY, library_names
from valvetrain.runs.request_fields import read_speeds


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


UNIFORM = ("uniform-spring", "--set", "spring.options.finite-element.elements_per_coil=8")


COMMANDS = (
    "run",
    "compare",
    "sweep",
    "static",
    "modes",
    "refine",
    "runs",
    "compare-runs",
    "new",
    "cases",
    "check",
)


def test_version_and_help():
    assert call("--version").stdout == f"valvetrain {__version__}\n"
    for arguments in ([], ["--help"]):
        result = call(*arguments)
        assert result.exit_code == 0
        assert all(name in result.stdout for name in COMMANDS)
    for name in COMMANDS:
        assert call(name, "--help").exit_code == 0


def test_cases_lists_every_case_and_prints_the_file_of_one():
    result = call("cases")
    assert result.exit_code == 0 and all(name in result.stdout for name in library_names())
    assert "vasilyev2016" in result.stdout
    assert call("cases", "uniform-spring").stdout == (LIBRARY / "uniform-spring.toml").read_text()
    listed = json.loads(call("cases", "--json").stdout)["cases"]
    assert [one["name"] for one in listed] == list(library_names())
    assert (
        json.loads(call("cases", "job-c", "--json").stdout)["text"]
        == (LIBRARY / "job-c.toml").read_text()
    )


@pytest.mark.parametrize("name", library_names())
def test_check_understands_every_library_case(name):
    result = call("check", name)
    assert result.exit_code == 0 and result.stdout.startswith(name)
    assert max(map(len, result.stdout.splitlines())) <= 100


def test_the_estimated_rate_of_a_conical_spring_is_the_closed_form():
    from spring_shapes import conical
    from valvetrain.parameters.winding import OPEN_END
    from valvetrain.quantities.statics import definition_quantities

    ends = {"lower_end": OPEN_END, "upper_end": OPEN_END}
    spring = conical(3e-3, 30e-3, 18e-3, 8e-3, 6, **ends)
    lower, upper = 15e-3, 9e-3
    rate = (
        spring.material.shear_modulus * 3e-3**4 / (16 * 6 * (lower + upper) * (lower**2 + upper**2))
    )
    assert definition_quantities(spring)["estimated_rate"] == pytest.approx(rate, rel=1e-5)


def test_static_agrees_with_the_library_and_writes_csv(tmp_path):
    from valvetrain.parameters.loading import load_case
    from valvetrain.runs.statics import static_curve
    from valvetrain.springs.spec import spring_model

    result = call(
        "static",
        *UNIFORM,
        *typed("--to '8 mm' --steps 4 --output"),
        str(tmp_path / "own"),
        "--json",
    )
    assert result.exit_code == 0
    found = json.loads(result.stdout)
    (spring,) = load_case("uniform-spring").springs
    curve, _ = static_curve(
        spring_model("finite-element").build(
            spring.with_options("finite-element", elements_per_coil=8)
        ),
        8e-3,
        4,
    )
    (rest,) = found["springs_at_rest"]
    assert rest["static_curve"]["force"] == {"values": curve.force.tolist(), "unit": "N"}
    assert rest["static_curve"]["compression"]["values"] == pytest.approx(
        [0, 2e-3, 4e-3, 6e-3, 8e-3]
    )
    assert found["quantities"]["preload"]["value"] == pytest.approx(curve.force_at(7e-3))
    (file,) = (tmp_path / "own").glob("static-*.csv")
    last = list(csv.DictReader(file.read_text().splitlines()))[-1]
    height = spring.wire.free_length - 8e-3
    assert float(last["force [N]"]) == pytest.approx(curve.force[-1])
    assert float(last["height [mm]"]) == pytest.approx(1e3 * height)
    assert float(last["wire shear [MPa]"]) > float(last["nominal shear [MPa]"]) > 0


#: What a user types wrong: names, numbers, units, key paths, files.
WRONG = [
    ("run", "gu2021-behive"), ("run", "zzz"), ("rum",), ("run",), ("run", "job-c", "--engin-speed", "1 rpm"),
    ("run", "job-c", "--rpm", "4200 mm"), ("run", "job-c", "--rpm", "-5 rpm"),
    ("run", "job-c", "--rpm", "9:1:1 rpm"), ("run", "job-c", "--rpm", "1:2:1e-9 rpm"),
    ("run", "job-c", "--model", "modal"), ("sweep", "job-c", "--model", "massless,xyz"), ("compare", "job-c", "--limit", "much"),
    ("run", "job-c", "--spring-set", "stock"), ("compare", "vaz-ohc", "--model", "solid"), ("new", "job-c"), ("new", "a\nb"), ("new", "."),
    ("new", "mine", "--kind", "fingr"), ("compare-runs", "one", "two"), ("run", "uniform-spring", "--rpm", "1000 rpm"),
    ("run", "job-c", "--workers", "0"), ("run", "job-c", "--set", "spring"), ("run", "job-c", "--set", "spring.wire_diametre=4 mm"),
    ("run", "job-c", "--set", "spring.wire_diameter=4 N"), ("run", "job-c", "--set", "spring.wire_diameter=4"),
    ("run", "job-c", "--set", "spring.mean_diameter=3.5 mm"), ("run", "job-c", "--set", "spring.total_coils.x=4"),
    ("run", "job-c", "--set", "sprung.x=4"), ("run", "job-c", "--set", "spring.pitch.coils.9=4"),
    ("run", "job-c", "--set", "spring.options.finite-element.time_step="),
    ("run", "job-c", "--set", "spring.options.finite-element.elements_per_coil=2"),
    ("run", "job-c", "--set", "spring.options.finite-element.elements_per_coil=many"),
    ("static", "uniform-spring", "--to", "40 mm"),
    ("static", "uniform-spring", "--to", "12"), ("static", "uniform-spring", "--to", "-1 mm"), ("static", "uniform-spring", "--steps", "1"),
    ("static", "uniform-spring", "--output", "/dev/null"), ("modes", "uniform-spring", "--count", "0"),
    ("modes", "uniform-spring", "--compression", "30 mm"), ("cases", "uniform"), ("check", "."), ("check", "x" * 5000), ("check", "a\0b"),
    ("check", "missing.toml"), ("check", "binary.toml"), ("check", ""), ("run", "job-c", "--output", "binary.toml"),
    ("run", "job-c", "--output", "binary.toml/deeper"),
]  # fmt: skip


@pytest.mark.parametrize("arguments", WRONG)
def test_wrong_input_is_one_sentence_and_exit_code_2(tmp_path, monkeypatch, arguments):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "binary.toml").write_bytes(bytes(range(256)))
    result = call(*arguments)
    assert result.exit_code == 2 and sentence(result)
    assert [path.name for path in tmp_path.iterdir()] == ["binary.toml"]


def test_a_set_value_loses_the_note_of_the_value_it_replaces():
    from valvetrain.cli.options import choose_case

    assert choose_case("gu2021-beehive").notes["spring.wire_diameter"].status == "identified"
    changed = choose_case(
        "gu2021-beehive",
        [
            "spring.wire_diameter=4.1 mm",
            "spring.pitch=7 mm",
            "spring.damping.stiffness_share=",
            "spring.options.finite-element.elements_per_coil=10",
        ],
    )
    assert changed.notes["spring.wire_diameter"].status is None
    assert float(changed.spring.wire_diameter.value(1.0)) == pytest.approx(4.1e-3)
    assert float(changed.spring.pitch.value(3.3)) == pytest.approx(7e-3)
    (spring,) = changed.springs
    assert (
        spring.damping.stiffness_share is None
        and spring.options_of("finite-element")["elements_per_coil"] == 10
    )
    assert changed.cite() == choose_case("gu2021-beehive").cite()


def test_engine_speeds_are_read_in_rpm_and_ranges_hold_both_ends():
    rpm = np.pi / 30
    assert read_speeds("4200, 5600 rpm", "--rpm") == pytest.approx((4200 * rpm, 5600 * rpm))
    assert read_speeds("70 rev/s", "--rpm") == pytest.approx((4200 * rpm,))
    assert read_speeds("1000:9000:100 rpm", "--rpm") == pytest.approx(
        [speed * rpm for speed in range(1000, 9001, 100)]
    )
    assert read_speeds("1000:1950:100 rpm", "--rpm")[-1] == pytest.approx(1900 * rpm)
    for text in ("1000:9000:100", "4200, 5600", "4.2e3", " 3000 "):  # numbers alone are rpm
        assert read_speeds(text, "--rpm") == read_speeds(f"{text} rpm", "--rpm")
    with pytest.raises(InputError, match="is a length"):
        read_speeds("3000 mm", "--rpm")
