"""Unit: the command ``lift``, a case with a measured lift, and what its noise does to the forces of
a run.
"""

import json
import shlex
import shutil

import numpy as np
import pytest

import valvetrain as vt
from unit.cli_parts import call as invoke
from unit.cli_parts import typed
from valvetrain.cam import build_lift_law
from valvetrain.errors import InputError
from valvetrain.lift.band import lift_band_study
from valvetrain.lift.files import case_with
from valvetrain.parameters.lift_law import LiftLawParameters
from valvetrain.parameters.loading import load_case
from valvetrain.views.page import data_of

#: A polydyne-like lobe: 9 mm over 120 cam deg about 180.
ANGLES = np.arange(90.0, 271.0)
TRUE = 9.0 * np.clip(1 - ((ANGLES - 180) / 60) ** 2, 0, None) ** 3
NOISY = TRUE + np.random.default_rng(7).normal(0, 3e-3, len(ANGLES))
HEAD = "cam angle [deg]; valve lift [mm]\n"


@pytest.fixture
def table(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "lobe.dat"
    file.write_text(
        HEAD + "\n".join(f"{angle:g};{lift:.5f}" for angle, lift in zip(ANGLES, NOISY, strict=True))
    )
    return file


def own_case(tmp_path, more=""):
    """The template of a spring alone with its lift measured."""
    from valvetrain.parameters.loading import LIBRARY

    text = (LIBRARY.parent.parent / "templates" / "spring.toml").read_text()
    begin, end = text.index("[lift_law]"), text.index("# Speeds of the crank")
    case = tmp_path / "own.toml"
    case.write_text(
        text[:begin] + f'[lift_law]\nkind = "measured"\nfile = "lobe.dat"\n{more}\n' + text[end:]
    )
    return case


def test_json_holds_figures_with_their_spread_and_the_folder_its_files(table):
    result = invoke("lift", str(table), "--json", "--at", "5 mm", "--output", "out")
    data = json.loads(result.stdout)
    verdict = data["findings"][0]
    assert verdict["code"] == "L211"
    assert verdict["value"]["value"] == pytest.approx(9e-3, rel=4e-4)
    degrees = np.degrees(verdict["fields"]["more"]["value"]["value"])
    assert degrees == pytest.approx(120 * np.sqrt(1 - (1 / 9) ** (1 / 3)), abs=0.05)
    found = data["lobes"][0]["figures"]["duration_at_5_mm"]
    half = np.radians(60) * np.sqrt(1 - (5 / 9) ** (1 / 3))
    assert found["value"] == pytest.approx(2 * half, rel=2e-3)
    assert abs(found["value"] - 2 * half) < 4 * found["standard_deviation"]
    assert data["lobes"][0]["noise"] == pytest.approx(3e-6, rel=0.25)
    assert {"lift.csv", "lift.toml", "report.html", "run.json"} <= {
        path.rsplit("/")[-1] for path in data["files"]
    }
    csv = np.genfromtxt("out/lift.csv", delimiter=",", skip_header=1)
    nose = np.argmin(np.abs(csv[:, 0] - 180))
    assert csv[nose, 1] == pytest.approx(9.0, abs=0.01) and csv[nose, 5] == pytest.approx(
        -6 * 9 / np.radians(60) ** 2, rel=0.05
    )


def test_two_lobes_tell_overlap(table, tmp_path):
    exhaust = tmp_path / "exhaust.dat"
    exhaust.write_text(
        HEAD
        + "\n".join(f"{angle - 105:g};{lift:.5f}" for angle, lift in zip(ANGLES, TRUE, strict=True))
    )
    data = json.loads(invoke("lift", str(table), "--exhaust", str(exhaust), "--json").stdout)
    found = data["both_lobes"]
    assert np.degrees(found["lobe_separation"]["value"]) == pytest.approx(105, abs=0.05)
    half = 60 * np.sqrt(1 - (1 / 9) ** (1 / 3))
    assert np.degrees(found["overlap_at_1_mm"]["value"]) == pytest.approx(
        2 * (2 * half - 105), abs=0.2
    )


def test_a_stated_noise_and_band_are_in_the_file_that_is_written(table):
    """Contract: the law of lift.toml is that of the page; --noise was left out of it."""
    words = ("lift", str(table), "--noise", "8 um", "--band", "20 um", "--output", "out")
    assert invoke(*words).exit_code == 0
    law = vt.load_case(_case_of(open("out/lift.toml").read())).lift_law
    assert law.values["noise"] == pytest.approx(8e-6) and law.values["band"] == pytest.approx(2e-5)
    assert invoke("lift", str(table), "--output", "found").exit_code == 0
    assert 'noise = "0.0 m"' in open("found/lift.toml").read()


def _case_of(text: str) -> str:
    """A case file with that lift law."""
    with open("with-lift.toml", "w") as file:
        file.write(f'name = "own"\n{text}')
    return "with-lift.toml"


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("--angle-of", "crank"), "crank as requested, but the file says cam"),
        (("--at", "12 mm"), "the lobe rises 9"),
        (("--noise", "3"), "--noise"),
        (("--rpm", "4000 rpm"), "name it with --case"),
        (("--columns", "angle, hub"), "a column is one of"),
        (("--zero", "top"), "zero is file or nose"),
        (("--case", "job-t", "--draws", "2"), "draws is a number from 4"),
        (("--case", "tdi-pushrod"), "driven by the lift of the tappet"),
    ],
)
def test_wrong_words_get_one_sentence(table, words, sentence):
    result = invoke("lift", str(table), *words)
    assert result.exit_code == 2 and sentence in result.stderr and "Traceback" not in result.output


def test_a_case_takes_a_measured_lift_and_keeps_it_whole(table, tmp_path):
    case = vt.load_case(str(own_case(tmp_path)))
    law = build_lift_law(case.lift_law)
    angles = np.radians(ANGLES[35:-35])
    np.testing.assert_allclose(law.lift(angles), 1e-3 * TRUE[35:-35], atol=8e-6)
    assert case.lift_law.zero_of_angle == "as in the file"
    table.unlink()  # the resolved text holds the stations
    from valvetrain.parameters.loading import parse_case

    again = parse_case(case.text, "own")
    assert again.lift_law == case.lift_law


@pytest.mark.parametrize(
    ("more", "sentence"),
    [
        ('lobe = "intake"', "name one of them as lobe"),
        ('angle_of = "crank"', "the file says cam"),
        ('noise = "5 mm"', "noise is a length above zero"),
        ('lifts = ["1 mm"]', "not by both"),
        ("draw = -1", "draw: -1 does not fit"),
        ('lift_of = "tappet"', "the file says valve"),
    ],
)
def test_a_case_refuses_what_does_not_fit(table, tmp_path, more, sentence):
    with pytest.raises(InputError, match=sentence):
        vt.load_case(str(own_case(tmp_path, more)))


def test_the_noise_is_carried_into_forces(table, tmp_path):
    """Twice the noise, about twice the spread of the peak force; the mean study is that of the case
    itself, bit for bit.
    """
    case, law = vt.load_case("job-t"), vt.load_case(str(own_case(tmp_path))).lift_law
    spreads = []
    for noise in (2e-6, 8e-6):
        drawn = case.replace(lift_law=law.replace(noise=noise))
        found = lift_band_study(drawn, "6000 rpm", draws=4, models=["modal-uniform"], workers=1)
        spreads.append(found.spread("peak_spring_force"))
        assert found.failures == () and spreads[-1].draws == 4
    assert 0 < spreads[0].spread < spreads[1].spread < 0.2 * spreads[1].value
    alone = vt.simulate(drawn, "6000 rpm", models=["modal-uniform"])
    assert spreads[1].value == alone.quantities["peak_spring_force"]


def test_the_spread_does_not_depend_on_workers(table, tmp_path):
    case = vt.load_case("job-t").replace(lift_law=vt.load_case(str(own_case(tmp_path))).lift_law)
    words = {"draws": 4, "models": ["massless"]}
    found = [lift_band_study(case, "5000 rpm", workers=n, **words).spreads for n in (1, 2)]
    assert list(map(repr, found[0])) == list(map(repr, found[1]))


def test_a_request_of_many_laws_is_refused_with_its_numbers(table, tmp_path):
    asked = ("--case", "job-t", "--rpm", "100:9000:10 rpm", "--draws", "64")
    said = invoke("lift", str(table), *asked, "--output", str(tmp_path / "out")).stderr
    for words in ("beyond the bound of", "fewer laws, speeds or unknowns", "--limit '"):
        assert words in said
    assert not (tmp_path / "out").exists()


def test_a_lift_that_was_not_measured_has_no_band():
    with pytest.raises(InputError, match="is not measured"):
        lift_band_study("job-t", "2000 rpm")


def test_a_lobe_becomes_the_lift_of_a_case(table):
    words = typed("--case job-t --model massless --rpm '2000 rpm' --draws 4")
    result = invoke("lift", str(table), *words, "--json")
    assert result.exit_code == 0, result.output
    data = json.loads(result.stdout)
    carried = {one["quantity"]: one for one in data["carried"]}
    assert (data["findings"][0]["code"], data["findings"][0]["quantity"]) == ("L210", "peak_spring_force")  # fmt: skip
    whole = vt.load_case(f"{data['folder']}/case.toml")
    assert whole.lift_law.kind == "measured"
    assert whole.springs[0].precompression == vt.load_case("job-t").springs[0].precompression
    assert (
        carried["peak_spring_force"]["laws"] == 4
        and carried["peak_spring_force"]["standard_deviation"] > 0
    )
    shutil.rmtree("runs")


def test_a_measured_lobe_keeps_the_rocker_and_the_lash_of_the_card_that_it_replaces():
    law = LiftLawParameters("zero", {}, "tappet")
    changed = case_with(load_case("template:pushrod", {"lift_law.lash": "0.010 in"}), law)
    assert changed.train.lever.valve_arm / changed.train.lever.drive_arm == pytest.approx(1.6)
    assert changed.train.lash == pytest.approx(0.254e-3)


def test_the_next_step_of_a_good_table_is_this_command_with_a_case(table):
    data = json.loads(invoke("lift", str(table), "--noise", "3 um", "--json").stdout)
    words = shlex.split(data["findings"][0]["step"])
    assert words[:3] == ["valvetrain", "lift", str(table)]
    assert words[words.index("--noise") + 1] == "3 um" and words[-1].startswith("template:")
    again = json.loads(invoke(*words[1:], "--draws", "4", "--model", "massless", "--json").stdout)
    assert again["findings"][0]["code"] == "L210"


def test_typed_events_are_drawn_and_go_on_as_an_engine(tmp_path, monkeypatch):
    """By hand: 5 before top to 32.5 after bottom is 217.5 degrees about 103.75 after top."""
    monkeypatch.chdir(tmp_path)
    events = "IVO 5 before top, IVC 32.5 after bottom"
    data = json.loads(invoke("lift", "--events", events, "--output", "page", "--json").stdout)
    bar = data_of((tmp_path / "page/report.html").read_text(encoding="utf-8"))["data-events"]["data"]  # fmt: skip
    assert bar[0]["text"] == ["-5° to 212.5°"] and len(bar) == 1
    step = shlex.split(data["findings"][0]["step"])
    assert step[step.index("--duration") + 1 :: 2] == ["217.5 deg", "103.75 deg"]
    assert invoke(*step[1:]).exit_code == 0
    again = json.loads(invoke("lift", "my-engine.toml", "--json").stdout)
    assert again["timing"]["ivo_at_50_thou"]["value"] == pytest.approx(np.radians(5), abs=1e-5)
    assert again["findings"][0]["step"] == "valvetrain run my-engine.toml"
