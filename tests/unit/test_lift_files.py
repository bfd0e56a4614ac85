"""Unit: files of lifts in every form give the same lobe; what a file does not say is asked for;
what it cannot hold is refused.
"""

import io

import numpy as np
import pytest
import xlsxwriter

from valvetrain.errors import InputError
from valvetrain.measured.lift_file import LiftAnswers, lifts_in

ANGLES = np.arange(-70.0, 71.0)
LIFTS = np.where(np.abs(ANGLES) < 60, 9.0 * np.clip(1 - (ANGLES / 60) ** 2, 0, None) ** 3, 0.0)
WHOLE = np.zeros(360)
WHOLE[110:251] = LIFTS
ALL = {"angle_of": "cam", "lift_of": "tappet", "lift_unit": "mm"}


def read(text, **answers):
    return lifts_in(
        text if isinstance(text, bytes) else text.encode(), "own.txt", LiftAnswers(**answers)
    )


def rows(form="{:g},{:.5f}", *more, scale=1.0):
    return "\n".join(
        form.format(angle, lift * scale, *extra)
        for angle, lift, *extra in zip(ANGLES, LIFTS, *more, strict=True)
    )


FORMS = {
    "commas": rows(),
    "semicolons and decimal commas": rows("{:.1f};{:.5f}").replace(".", ","),
    "blanks": rows("   {:g}    {:.5f}  "),
    "tabs": rows("{:g}\t{:.5f}"),
    "bars": rows("| {:g} | {:.5f} |"),
    "commas and blanks, decimal commas": rows("{:.1f}, {:.5f}").replace(".", ","),
    "headings, comments, empty lines": "Lobe 3\nmeasured by hand\n\n# cold\n"
    + rows()
    + "\n\n# end\n",
    "falling angles": "\n".join(reversed(rows().splitlines())),
    "utf-8 with its mark": "\ufeff".encode() + rows().encode(),
    "utf-16": rows().encode("utf-16"),
    "western coding": "Winkel °\n".encode("cp1252") + rows().encode(),
    "exponents": rows("{:e} {:e}"),
    "windows line ends": rows().replace("\n", "\r\n"),
}


@pytest.mark.parametrize("form", FORMS)
def test_the_same_lobe_in_every_form_of_text(form):
    (lobe,) = read(FORMS[form], **ALL)
    np.testing.assert_allclose(np.degrees(lobe.cam_angles), ANGLES, atol=1e-9)
    np.testing.assert_allclose(1e3 * lobe.lifts, LIFTS, atol=6e-6)
    assert lobe.lift_of == "tappet" and lobe.form == "columns"


@pytest.mark.parametrize(
    ("heading", "factor", "turn"),
    [
        ("cam angle [deg]; tappet lift [mm]", 1e-3, 1.0),
        ("Kurbelwinkel [°KW]; valve lift [mm]", 1e-3, 0.5),
        ("crank angle (deg); valve lift (inch)", 0.0254, 0.5),
        ("cam deg; lobe lift in thou", 25.4e-6, 1.0),
        ("cam angle;valve lift\n[deg];[mm]", 1e-3, 1.0),
        ("cam angle [rad]; valve lift [mm]", 1e-3, 180 / np.pi),
    ],
)
def test_headings_answer_what_they_say(heading, factor, turn):
    radians = zip(np.radians(ANGLES), LIFTS, strict=True)
    text = (
        rows("{:g};{:.5f}", scale=1.0)
        if turn < 50
        else "\n".join(f"{x:.9f};{y:.5f}" for x, y in radians)
    )
    (lobe,) = read(f"{heading}\n{text}")
    expected = ANGLES * (turn if turn < 50 else 1.0)
    np.testing.assert_allclose(np.degrees(lobe.cam_angles), expected, atol=1e-6)
    np.testing.assert_allclose(lobe.lifts, LIFTS * factor, atol=6e-6 * factor)
    assert {answer.question: answer.by for answer in lobe.answers}["angle_of"] == "file"


def test_every_open_question_is_named_at_once():
    with pytest.raises(InputError) as caught:
        read(rows())
    assert all(word in str(caught.value) for word in ("angle_of", "lift_of", "lift_unit"))


def test_an_answer_against_the_file_is_refused():
    with pytest.raises(InputError, match="crank as requested, but the file says cam"):
        read("cam angle [deg]; valve lift [mm]\n" + rows("{:g};{:.5f}"), angle_of="crank")
    with pytest.raises(InputError, match="lift_unit is inch as requested, but the file says mm"):
        read("cam angle [deg]; valve lift [mm]\n" + rows("{:g};{:.5f}"), lift_unit="inch")


def test_crank_angles_are_halved_and_the_nose_can_be_zero():
    text = "\n".join(f"{220 + 2 * at:g} {lift:.5f}" for at, lift in zip(ANGLES, LIFTS, strict=True))
    for more, first in (({}, 110), ({"zero": "nose"}, 0)):
        (lobe,) = read(text, **ALL | {"angle_of": "crank"} | more)
        np.testing.assert_allclose(np.degrees(lobe.cam_angles), ANGLES + first, atol=1e-9)


def test_a_table_taken_against_the_rotation_is_mirrored():
    skew = LIFTS * (1 + ANGLES / 200)
    text = "\n".join(f"{angle:g} {lift:.5f}" for angle, lift in zip(ANGLES, skew, strict=True))
    (lobe,) = read(text, **ALL, direction="reversed")
    np.testing.assert_allclose(1e3 * lobe.lifts, skew[::-1], atol=6e-6)
    np.testing.assert_allclose(np.degrees(lobe.cam_angles), -ANGLES[::-1], atol=1e-9)


def test_a_third_column_is_never_passed_over():
    velocity = np.gradient(LIFTS, ANGLES)
    text = rows("{:g} {:.5f} {:.6f}", velocity)
    with pytest.raises(InputError, match="does not say what column"):
        read(text, **ALL)
    (lobe,) = read(text, **ALL, columns=("angle", "lift", "velocity"))
    assert lobe.misfits["velocity"] < 0.05
    (lobe,) = read(
        rows("{:g} {:.5f} {:.6f}", -velocity), **ALL, columns=("angle", "lift", "velocity")
    )
    assert lobe.misfits["velocity"] > 0.05
    (lobe,) = read(text, **ALL, columns=("angle", "lift", "ignore"))
    assert lobe.notes == ("left out as requested: column 3",)
    (lobe,) = read("angle lift velocity\n" + text, **ALL)
    assert lobe.misfits["velocity"] < 0.05


def test_two_lobes_of_one_file():
    other = np.roll(LIFTS, 5)
    both = read(
        "cam angle [deg]\tintake valve lift [mm]\texhaust valve lift [mm]\n"
        + rows("{:g}\t{:.5f}\t{:.5f}", other)
    )
    assert [lobe.name for lobe in both] == ["intake", "exhaust"]
    np.testing.assert_allclose(1e3 * both[1].lifts, other, atol=6e-6)


def s96(lifts, tail):
    return "\n".join(f"{lift:.5f}" for lift in [*lifts, *tail])


def test_s96_says_its_angles_and_not_its_unit():
    text = s96(WHOLE, WHOLE[:36])
    with pytest.raises(InputError) as caught:
        read(text)
    assert "lift_unit" in str(caught.value) and "angle_of" not in str(caught.value)
    (lobe,) = read("own cam\n" + text, lift_of="tappet", lift_unit="mm")
    assert lobe.form == "s96" and len(lobe.lifts) == 360
    np.testing.assert_allclose(1e3 * lobe.lifts, WHOLE, atol=6e-6)
    np.testing.assert_allclose(np.degrees(lobe.cam_angles), np.arange(360.0), atol=1e-9)
    with pytest.raises(InputError, match="neither repeat its first ones"):
        read(s96(WHOLE, np.full(36, 3.0)), lift_of="tappet", lift_unit="mm")


def test_fractions_need_lift_duration_and_begin():
    place = np.linspace(0, 1, 41)
    text = "\n".join(f"{x:.4f} {np.sin(np.pi * x) ** 2:.6f}" for x in place)
    with pytest.raises(InputError) as caught:
        read(text)
    assert all(word in str(caught.value) for word in ("peak_lift", "duration", "opening"))
    words = {"angle_of": "crank", "lift_of": "valve", "peak_lift": 0.01, "opening": 0.0}
    (lobe,) = read(text, **words, duration=np.radians(240))
    assert lobe.form == "fractions"
    np.testing.assert_allclose(np.degrees(lobe.cam_angles), 120 * place, atol=1e-9)
    np.testing.assert_allclose(lobe.lifts, 0.01 * np.sin(np.pi * place) ** 2, atol=1e-8)


def test_a_workbook_holds_the_same_lobe():
    book = xlsxwriter.Workbook(content := io.BytesIO(), {"in_memory": True})
    sheet = book.add_worksheet()
    table = [("cam angle [deg]", "valve lift [mm]"), *zip(ANGLES, LIFTS, strict=True)]
    for place, row in enumerate(table):
        sheet.write_row(place, 0, row)
    book.close()
    (lobe,) = lifts_in(content.getvalue(), "written", LiftAnswers())
    assert lobe.form == "workbook"
    np.testing.assert_allclose(1e3 * lobe.lifts, LIFTS, atol=1e-9)


BAD = {
    "a row too short": ("1 2\n1 2 3\n", "line 2 of own.txt has 3 numbers"),
    "words among rows": ("1 2\nfoo\n", "line 2 of own.txt is no row of numbers"),
    "no rows": ("just words\n", "holds no row of numbers"),
    "bytes": (b"\x00\x01\x02", "neither text, a workbook nor a drawing"),
    "a broken workbook": (b"PK\x03\x04junk", "no workbook that can be read"),
    "a number beyond bounds": ("1 1e400\n" * 9, "beyond all bounds"),
    "too few stations": ("1 0\n2 1\n3 0\n", "needs eight or more"),
    "angles both ways": ("\n".join(f"{x % 5} 1" for x in range(20)), "do not run one way at row 6"),
    "more than a revolution": ("\n".join(f"{x} {x % 7}" for x in range(0, 720, 5)), "more than one cam revolution"),
    "too many columns": ("\n".join(" ".join(["1"] * 20) for _ in range(9)), "has 20 columns"),
}  # fmt: skip


@pytest.mark.parametrize("fault", BAD)
def test_a_faulty_file_gets_one_sentence(fault):
    content, words = BAD[fault]
    answers = dict(ALL) if "workbook" not in fault else {}
    with pytest.raises(InputError) as caught:
        read(content, **answers)
    assert words in str(caught.value) and "\n" not in str(caught.value)


def test_a_workbook_without_its_reader_is_said(monkeypatch):
    import builtins

    real = builtins.__import__

    def without(name, *more):
        if name == "python_calamine":
            raise ImportError(name)
        return real(name, *more)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(InputError, match=r"needs python-calamine; install the extra 'measure'"):
        read(b"PK\x03\x04" + io.BytesIO(b"x").getvalue())
