"""Examples: the commands of docs/tutorial.md run as they stand, in order, and print what the page
shows.

The two sweeps, 20 s together, run with ``make test-long``. ``python scripts/write_pages.py
tutorial`` writes the page anew.
"""

from __future__ import annotations

import contextlib
import re
from pathlib import Path

import numpy as np
import pytest
import write_pages

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8")


def found(folder: Path, wanted=lambda command: True) -> list[tuple[str, str, str]]:
    """Command, what the page shows of it and what it prints."""
    with contextlib.chdir(folder):
        return [
            (step["command"], step["printed"], printed)
            for step, printed in write_pages.run_page(PAGE, wanted)
        ]


def test_the_quick_commands_print_what_the_page_shows(tmp_path):
    printed = found(tmp_path, lambda command: "valvetrain sweep" not in command)
    assert len(printed) == 4 and not [command for command, shown, now in printed if shown != now]


@pytest.mark.long
def test_all_commands_print_what_the_page_shows_and_its_pictures_are_drawn_from_them(tmp_path):
    printed = found(tmp_path)
    assert len(printed) == 6 and not [command for command, shown, now in printed if shown != now]
    for name, picture in write_pages.tutorial_pictures(tmp_path).items():
        assert picture.data and (ROOT / "docs" / "pictures" / f"{name}.svg").is_file(), name


def test_the_curve_of_the_spring_passes_through_the_marks_of_its_card():
    """Contract: the curve passed 3 % above the second load, which the page says is met within 0.1 %."""
    picture = (ROOT / "docs" / "pictures" / "tutorial-spring.svg").read_text(encoding="utf-8")
    (drawn,) = re.findall(r'<path class="js-line" d="M([\d.,L]+)"', picture)
    x, y = np.array([one.split(",") for one in drawn.split("L")], dtype=float).T
    marks = re.findall(r'<path class="point" transform="translate\(([\d.]+),([\d.]+)\)"', picture)
    assert len(marks) == 2
    for across, down in (map(float, one) for one in marks):
        assert np.interp(-across, -x, y) == pytest.approx(down, abs=0.5)


def test_the_gain_that_the_page_tells_is_that_of_its_tables():
    """20 lbf more: the nominal speeds of float and of the first loss of contact."""
    gains = []
    for words in (r"floats +█+ +from (\d+) rpm", r"LOSES THE CAM AT ABOUT (\d+) RPM"):
        before, after = (float(value) for value in re.findall(words, PAGE))
        gains.append(after - before)
    told = re.search(
        r"The float moves up by some (\d+) rpm, the first loss of contact by (\d+)", PAGE
    )
    assert gains == [float(value) for value in told.groups()]
