"""Limits: files of spring testers as people have them, made from springs that are known; the truth
lies inside the printed band, or the answer is a doubt.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import binom

from valvetrain.errors import InputError
from valvetrain.measured.force_curve import force_curve
from valvetrain.measured.force_height import ForceHeight, read_force_height
from valvetrain.spring_card import spring_from_tester

LANGUAGES = {
    "English": ("Time", "Position", "Deflection", "Height", "Load"),
    "German": ("Prüfzeit", "Standardweg", "Federweg", "Höhe", "Standardkraft"),
    "French": ("Temps", "Déplacement", "Flèche", "Hauteur", "Charge"),
    "Spanish": ("Tiempo", "Posición", "Deflexión", "Altura", "Fuerza"),
}
FORCES = {"N": 1.0, "lbf": 4.4482216152605, "lb": 4.4482216152605, "kgf": 9.80665, "kg": 9.80665, "g": 9.80665e-3, "gf": 9.80665e-3,
          "daN": 10.0, "kN": 1e3}  # fmt: skip
LENGTHS = {"mm": 1e-3, "in": 25.4e-3, "thou": 25.4e-6}


def written(values, decimals, mark, thousands, quoted):
    """Numbers as a machine writes them."""
    cells = []
    for value in values:
        cell = f"{value:,.{decimals}f}" if thousands else f"{value:.{decimals}f}"
        if mark == ",":
            cell = cell.translate(str.maketrans(",.", ".,"))
        cells.append(f'"{cell}"' if quoted else cell)
    return cells


def made(rng, folder):
    """A file of a tester, its spring in SI, and whether it is clean."""
    rate, free = rng.uniform(10e3, 110e3), rng.uniform(35e-3, 65e-3)
    solid = free * rng.uniform(0.45, 0.6)
    stroke, rising = free - solid, rng.choice([0.0, 0.0, rng.uniform(0.1, 0.5)])
    bound = rng.random() < 0.5
    wall = rate * rng.uniform(15, 50)
    kind = rng.choice(["height", "compression", "travel"])
    before = rng.uniform(0.3e-3, 6e-3) if kind == "travel" or rng.random() < 0.2 else 0.0
    begin = -before if before else stroke * rng.choice([0.0, rng.uniform(0.05, 0.25)])
    end = stroke + rng.uniform(200, 700) / wall if bound else stroke * rng.uniform(0.8, 0.97)
    spacing = rng.choice([0.02e-3, 0.05e-3, 0.1e-3, 0.25e-3, 0.5e-3, 1e-3])
    place = np.append(np.arange(begin, end - spacing / 3, spacing), end)
    loop, lost = (
        0.0,
        0.0,
    )  # the spring's own force lies between the mean of the strokes and the pressing one
    if rng.random() < 0.4:
        place = np.append(place, place[-2::-1])
        loop, lost = rng.choice([0.0, rng.uniform(0.002, 0.01)]), rng.uniform(0, 1)

    def force(travel, turning=0.0):
        pressed = np.clip(travel, 0, stroke)
        spring = rate * (pressed + rising * pressed**2 / (2 * stroke))
        return spring * (1 + turning) + wall * np.clip(travel - stroke, 0, None)

    stroke_sign = np.sign(np.gradient(place))
    noise = rate * stroke * rng.choice([1e-4, 3e-4, 1e-3, 4e-3])
    load = force(place, loop * (stroke_sign - lost)) + noise * rng.standard_normal(len(place))
    if not loop and rng.random() < 0.1:
        order = rng.permutation(len(place))
        place, load = place[order], load[order]
    zero = before if before and kind != "height" else 0.0
    along = free - place if kind == "height" else rng.choice([1, -1]) * (place + zero)
    sign = rng.choice([1, 1, -1])
    words = LANGUAGES[rng.choice(list(LANGUAGES))]
    units = rng.choice(list(LENGTHS)), rng.choice(list(FORCES))
    digits = np.array([LENGTHS[units[0]], FORCES[units[1]]])
    finest = np.array([rng.choice([1e-6, 1e-5]), rate * stroke * rng.choice([1e-5, 1e-4, 1e-3])])
    decimals = np.clip(np.ceil(np.log10(digits / finest)), 0, 6).astype(int)
    mark, quoted = rng.choice([".", ","]), rng.random() < 0.3
    delimiter = (
        rng.choice([";", "\t"]) if mark == "," and not quoted else rng.choice([";", "\t", ","])
    )
    thousands = rng.random() < 0.2 and (quoted or delimiter != ",")
    columns = [
        written(along / digits[0], decimals[0], mark, thousands, quoted),
        written(sign * load / digits[1], decimals[1], mark, thousands, quoted),
    ]
    names = [words[{"travel": 1, "compression": 2, "height": 3}[kind]], words[4]]
    shown = list(units)
    if rng.random() < 0.4:
        columns.insert(0, written(np.arange(len(place)) * 0.1, 3, mark, thousands, quoted))
        names.insert(0, words[0])
        shown.insert(0, "s")
    elif rng.random() < 0.5:
        columns, names, shown = columns[::-1], names[::-1], shown[::-1]
    quote = '"{}"'.format if quoted else "{}".format
    heads = [
        delimiter.join(quote(f"{name} [{unit}]") for name, unit in zip(names, shown, strict=True))
    ]
    if rng.random() < 0.5:
        heads = [
            delimiter.join(map(quote, names)),
            delimiter.join(quote(f"({unit})") for unit in shown),
        ]
    if rng.random() < 0.4:
        heads = [f"Sample{delimiter}valve spring", "", *heads]
    rows = [delimiter.join(row) for row in zip(*columns, strict=True)]
    (folder / "tester.csv").write_text("\n".join([*heads, *rows]), encoding="utf-8")
    low, high = max(begin, 0.05 * stroke), min(end, stroke)
    height = free - rng.uniform(low + 0.1 * (high - low), high - 0.1 * (high - low))
    away = 1e-7
    truth = {
        "force": force(free - height), "solid": solid if bound else np.nan, "free": free,
        "rate": (force(free - height + away) - force(free - height - away)) / (2 * away),
    }  # fmt: skip
    given = None if kind == "height" else free
    return height, given, truth, noise < 1.1e-3 * rate * stroke and not loop


def counted(seed, count, folder):
    """For each band whether the truth lies in it, band and error; doubts of the clean files."""
    rng, inside, doubts = np.random.default_rng(seed), {}, []
    for _ in range(count):
        height, given, truth, clean = made(rng, folder)
        table = read_force_height(folder / "tester.csv", free_length=given)
        if clean:
            doubts.append(bool(table.doubts))
        if table.doubts:
            continue
        fit = spring_from_tester(table, installed_height=height)
        bands = {"rate": fit.rate, "force": fit.preload, "solid": fit.solid_height}
        bands |= {"free": fit.free_length} if given is None else {}
        for key, band in bands.items():
            if band is not None and np.isfinite(truth[key]):
                inside.setdefault(key, []).append((abs(band[0] - truth[key]), 2 * band[1]))
    return {key: np.array(rows).T for key, rows in inside.items()}, doubts


def check_family(seed, count, folder):
    inside, doubts = counted(seed, count, folder)
    assert set(inside) == {"rate", "force", "solid", "free"}
    for key, (off, band) in inside.items():
        hits = int(np.sum(off <= band))
        assert binom.cdf(hits, len(off), 0.95) > 0.01, (
            f"{key}: {hits} of {len(off)} bands hold the truth"
        )
        assert np.all(band > 0)
    assert sum(doubts) <= max(1, 0.03 * len(doubts))
    return inside


def test_the_truth_lies_inside_the_bands_of_twenty_files(tmp_path):
    check_family(1, 20, tmp_path)


@pytest.mark.long
def test_the_truth_lies_inside_the_bands_of_three_hundred_files(tmp_path):
    inside = check_family(2, 300, tmp_path)
    for key, (off, band) in inside.items():
        assert np.median(off / band) >= 0.25, key


def file_of(folder, rows, head="Position (mm),Force (N)"):
    (folder / "tester.csv").write_text(
        "\n".join([head, *(",".join(map(str, row)) for row in rows)])
    )
    return folder / "tester.csv"


def test_travel_before_contact_is_taken_off_and_a_wrong_free_length_is_a_doubt(tmp_path):
    """33.5 N/mm from 52 mm on; the position counts from 4.6 mm above the spring."""
    position = np.arange(0, 28.55, 0.1)
    noise = 0.3 * np.random.default_rng(1).standard_normal(len(position))
    force = 33.5 * np.clip(position - 4.6, 0, None) + noise
    file = file_of(tmp_path, zip(position.round(4), force.round(3), strict=True))
    fit = spring_from_tester(read_force_height(file, free_length=52e-3), installed_height=40e-3)
    assert (
        fit.preload[0] == pytest.approx(33.5 * 12, abs=2 * fit.preload[1]) and fit.preload[1] < 0.2
    )
    assert fit.rate[0] == pytest.approx(33.5e3, abs=2.5 * fit.rate[1]) and fit.solid_height is None
    heights = file_of(
        tmp_path,
        zip((56.6 - position).round(4), force.round(3), strict=True),
        "Height (mm),Force (N)",
    )
    assert [doubt.code for doubt in read_force_height(heights, free_length=56.6e-3).doubts] == [
        "Z105"
    ]
    assert not read_force_height(heights, free_length=52e-3).doubts


@pytest.mark.parametrize("unit", ["kgf", "gf", "g", "kp", "daN"])
def test_a_few_points_of_a_scale_make_rates_and_a_doubt(tmp_path, unit):
    """1.14 N/mm through all five, 0.84 over the last three; a rate that falls is no spring's."""
    size = {"kgf": 1, "kp": 1, "daN": 0.980665}.get(unit, 1000)
    weights = [0, 0.512, 1.880, 2.818, 3.600]
    rows = [
        (place, round(size * weight, 6))
        for place, weight in zip([0, 1, 10, 20, 30], weights, strict=True)
    ]
    table = read_force_height(file_of(tmp_path, rows, f"compression (mm),force ({unit})"))
    lines = [np.polyfit(-table.heights[k:], table.forces[k:], 1)[0] for k in (0, -3)]
    assert lines == pytest.approx([1138, 843], rel=2e-3)
    assert [doubt.code for doubt in table.doubts] == ["Z104"]


@pytest.mark.parametrize(("loop", "code"), [(0.0, []), (0.2, ["Z106"])])
def test_rubbing_is_a_doubt(tmp_path, loop, code):
    place = np.append(np.arange(0, 20, 0.5), np.arange(20, -0.1, -0.5))
    force = 40 * place * (1 + loop * np.sign(np.gradient(place)))
    file = file_of(tmp_path, zip(place, force.round(2), strict=True))
    assert [doubt.code for doubt in read_force_height(file, free_length=50e-3).doubts] == code


def test_one_station_far_off_leaves_the_rate():
    """It was looked for in ever narrower windows without an end, or of stations that are noise failed."""
    place = np.arange(60) * 0.25e-3
    force = 40e3 * place + 60.0 * (place == place[30])
    rate = ForceHeight(50e-3 - place, force).rate_at(50e-3 - place[30])
    assert rate.value == pytest.approx(40e3, rel=1e-6) and rate.deviation > 10e3
    for seed in range(8):
        noise = np.random.default_rng(seed).normal(0, 400, 20)
        assert force_curve(place[:20] * 4, 160e3 * place[:20] + noise).scatter > 100


@pytest.mark.parametrize("column", [0, 1])
def test_a_cell_that_was_mistyped_is_a_doubt(tmp_path, column):
    """The travel of a station reads zero, or its force ten times less: the force falls where the spring is pressed further."""
    place = np.arange(25.0)
    rows = np.column_stack(
        [place, np.round(40 * place + np.random.default_rng(2).normal(0, 1, 25), 1)]
    )
    rows[4, column] /= (1e6, 10)[column]
    table = read_force_height(file_of(tmp_path, rows), free_length=56e-3)
    assert [doubt.code for doubt in table.doubts] == ["Z107"]


def test_a_rate_that_no_spring_has_is_refused():
    place = np.arange(20) * 1e-6
    with pytest.raises(InputError, match="no spring has"):
        spring_from_tester(ForceHeight(50e-3 - place, 1e9 * place))


def test_forces_that_never_press_are_refused(tmp_path):
    """The last three rows have lost their signs: the zero before contact was taken for the largest force."""
    place = np.arange(0.0, 24.0, 0.8)
    force = 30.0 * np.clip(place - 2.0, 0, None) + 4000 * np.clip(place - 22.0, 0, None)
    turned = np.where(place > 21, -1, 1)
    file = file_of(tmp_path, zip((turned * place).round(1), (turned * force).round(1), strict=True))
    with pytest.raises(InputError, match="presses at no station"):
        read_force_height(file, free_length=52e-3)


def test_no_number_is_printed_for_forces_that_are_noise(tmp_path):
    noise = np.random.default_rng(3).standard_normal(80).round(3)
    with pytest.raises(InputError):
        read_force_height(
            file_of(tmp_path, zip(np.arange(80) / 10, noise, strict=True)), free_length=50e-3
        )
