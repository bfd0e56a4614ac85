"""Reading a case takes time in proportion to its length, and no more of a file than a case can be."""

from __future__ import annotations

import time
from importlib import resources

import pytest

from valvetrain.errors import InputError
from valvetrain.measured.lift_file import LiftAnswers, lifts_in
from valvetrain.parameters.loading import MAX_PARTS, load_case, parse_case
from valvetrain.springs.spec import spring_model
from valvetrain.system.build import build

CARD = '[spring]\nwire_diameter = "4 mm"\nmean_diameter = "24 mm"\ntotal_coils = 6\nends = "open"\nprecompression = "7 mm"\n'
ANSWERS = LiftAnswers(angle_of="cam", lift_of="valve", angle_unit="rad", lift_unit="m")


def numbers(count: int) -> str:
    return ", ".join(f"{0.01 * place:.2f}" for place in range(count))


#: What grew with the square of its length -> the text of a case with ``count`` of it.
LONG = {
    "one text of many numbers": lambda count: (
        f'[lift_law]\nkind = "spline"\ncam_angles = "{numbers(count)} deg"\nlifts = "1 mm"\n'
    ),
    "a list of many texts": lambda count: (
        '[lift_law]\nkind = "spline"\nlifts = [' + '"1 mm", ' * count + "]\n"
    ),
    "blanks inside a unit": lambda count: CARD.replace('"4 mm"', f'"4 N{" " * 4 * count}m x"'),
    "digits": lambda count: CARD.replace('"4 mm"', f'"{"4" * 4 * count}x, 4 mm"'),
    "parts of a key": lambda count: f"{'.'.join('a' * 4 * count)} = 1\n",
    "parts of a header": lambda count: f"[{'.'.join('a' * 4 * count)}]\nb = 1\nc = 1\n",
    "keys with parts": lambda count: (
        "[spring]\n" + "".join(f"a.b{place}.c = 1\n" for place in range(count))
    ),
    "inline tables": lambda count: "[spring]\npitch = [" + "{ a = 1 }, " * count + "]\n",
    "blanks in a line": lambda count: f"a{' ' * 8 * count}. b{' ' * 8 * count}c = 1\n",
}


def seconds(text: str) -> float:
    """Time to read, or refuse, a case; the better of two, for the machine may be busy."""
    spent = []
    for _ in range(2):
        start = time.perf_counter()
        with pytest.raises(InputError):
            parse_case(text)
        spent.append(time.perf_counter() - start)
    return min(spent)


@pytest.mark.parametrize("of", LONG)
def test_four_times_the_text_takes_about_four_times_as_long(of):
    """Quadratic reading takes 16 times as long, and seconds at these lengths; what takes no time at
    all is not compared.
    """
    load_case("job-t")  # what reading loads once
    short, long = seconds(LONG[of](750)), seconds(LONG[of](3000))
    assert long < 9 * short + 0.1


#: What a line of a table grew beyond all bounds with, or with the square of -> the text of a table
#: with ``count`` of it.
NASTY = {
    "blanks before a word": lambda count: "0 0\n1" + " " * count + "x\n",
    "commas that part or are decimal": lambda count: "0 0\n" + "1," * count + "x\n",
    "tabs and blanks": lambda count: "0 0\n1" + "\t " * count + "x\n",
    "signs": lambda count: "0 0\n" + "+-" * count + "\n",
    "a heading of brackets": lambda count: "[" * count + ";b\n0 0\n",
    "a heading of blanks": lambda count: "a" + " " * count + "(;b\n0 0\n",
    "many headings": lambda count: "a b c\n" * count + "0 0\n",
}


@pytest.mark.parametrize("text", NASTY.values(), ids=NASTY)
def test_a_table_of_text_is_read_in_one_pass(text):
    """60 000 blanks took 105 s, 28 numbers with commas 1.2 s and twice that with one more."""
    start = time.perf_counter()
    with pytest.raises(InputError):
        lifts_in(text(100_000).encode(), "t.csv", ANSWERS)
    assert time.perf_counter() - start < 5


def test_a_key_may_have_as_many_parts_as_any_case_needs():
    with pytest.raises(InputError, match=rf"line 2: a key has more than {MAX_PARTS} parts"):
        parse_case("\n" + ".".join("abcdefghijklmnopqrstuvwxyzabcdefghi") + " = 1")
    with pytest.raises(InputError, match="unknown"):
        parse_case(".".join("abcdefghijk") + " = 1")
    with pytest.raises(InputError, match="unknown"):
        parse_case(f'a = "{"a. " * (MAX_PARTS - 1)}"\n# {"... " * 100}')


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('mass = "125 g"', 'mass = "1.25e+14 g"'),
        ('inertia = "75 kg mm^2"', 'inertia = "1e9 kg m^2"'),
    ],
    ids=("mass", "inertia"),
)
def test_a_part_too_heavy_for_any_valve_gear_is_refused_before_its_equilibrium_is_sought(old, new):
    text = (
        resources.files("valvetrain").joinpath("parameters/library/vaz-ohc.toml").read_text("utf-8")
    )
    assert old in text
    with pytest.raises(InputError, match="is too large; give a value of at most"):
        parse_case(text.replace(old, new), "heavy")


@pytest.mark.parametrize(
    "damping", ['stiffness_damping = "1e308 s"', 'ratio = 0.016\nratio_frequency = "1e-300 Hz"']
)
def test_damping_that_leaves_no_time_step_is_refused(damping):
    text = CARD + f'pitch = "8 mm"\nmaterial = "OTEVA 90 SC"\n[spring.damping]\n{damping}\n'
    spring = build(parse_case(text, "damped")).springs[0]
    with pytest.raises(InputError, match="no time step at which it can be integrated"):
        spring_model("finite-element").build(spring).stable_time_step()


@pytest.mark.parametrize(
    ("given", "thin"), [("4 mm", "1e-300 mm"), ("4 mm", "0.9 um"), ("24 mm", "0.9 um")]
)
def test_a_wire_that_is_none_is_refused_where_it_is_read(given, thin):
    """Its mass was zero, and the estimate of its surge frequency divided by it."""
    text = CARD + 'pitch = "8 mm"\nmaterial = "OTEVA 90 SC"\n'
    with pytest.raises(InputError, match="is less than a micrometre"):
        parse_case(text.replace(f'"{given}"', f'"{thin}"'), "thread")


def test_a_wire_with_hardly_any_stiffness_finds_no_equilibrium_and_says_so():
    text = CARD.replace('"4 mm"', '"1.1 um"') + 'pitch = "8 mm"\nmaterial = "OTEVA 90 SC"\n'
    spring = build(parse_case(text, "thread")).springs[0]
    with pytest.raises(InputError, match="finds no equilibrium"):
        _ = spring_model("finite-element").build(spring).installed


def test_a_coil_contact_beyond_any_steel_is_refused_at_reading():
    text = (
        CARD
        + 'pitch = "8 mm"\nmaterial = "OTEVA 90 SC"\n[spring.contact]\nstiffness = "1e300 N/mm/mm"\n'
    )
    with pytest.raises(InputError, match=r"spring\.contact\.stiffness"):
        parse_case(text, "hard")
