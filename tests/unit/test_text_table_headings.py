"""Unit: numbers, names and units of the columns of a text, however it writes them."""

from __future__ import annotations

import pytest

from valvetrain.measured.tables import read_text_table

ROWS = ["0;1,5;80", "1;2,5;81", "2;3,5;82"]


@pytest.mark.parametrize(
    ("headings", "names", "units"),
    [
        (["Time [ms];Lift (in);Oil T [degF]"], ("Time", "Lift", "Oil T"), ("ms", "in", "degF")),
        (["Time / ms;Lift in inch;Oil T"], ("Time", "Lift", "Oil T"), ("ms", "inch", "")),
        (["Time;Ventilhub mm;Oil T"], ("Time", "Ventilhub mm", "Oil T"), ("", "mm", "")),
        (["Time;check in;Oil T"], ("Time", "check in", "Oil T"), ("", "", "")),
        (['"Time";"Lift";"Oil T"'], ("Time", "Lift", "Oil T"), ("", "", "")),
        (["Time;Lift;Oil T", "ms;in;degF"], ("Time", "Lift", "Oil T"), ("ms", "in", "degF")),
        (["Time;Lift;Oil T", "[ms];[in];[degF]"], ("Time", "Lift", "Oil T"), ("ms", "in", "degF")),
        (
            ["Time;Lift;Boost", "(ms);(in);(inHg)"],
            ("Time", "Lift", "Boost"),
            ("ms", "in", "inHg"),
        ),  # one that nobody has heard of
        (["Time;Lift;State", "s;mm;text"], ("Time", "Lift", "State"), ("s", "mm", "text")),
        (["Logger 3", "Time;Lift;Oil T", "s;m;K"], ("Time", "Lift", "Oil T"), ("s", "m", "K")),
        (["s;m;K"], ("s", "m", "K"), ("", "", "")),  # nothing above them
        (
            ["my first log", "t;F;s"],
            ("t", "F", "s"),
            ("", "", ""),
        ),  # a title of three words is no row of names
        (["Time Lift  Oil", "ms in degF"], ("Time", "Lift", "Oil"), ("ms", "in", "degF")),
        (["Time;Lift;Oil T", "logger;one;two"], ("logger", "one", "two"), ("", "", "")),
        (["t;F;m", "kind;of;table"], ("kind", "of", "table"), ("", "", "")),
        (["mm;mm;mm", "s;mm;K"], ("s", "mm", "K"), ("", "", "")),  # two rows of units are no names
        (["nothing of three"], ("nothing", "of", "three"), ("", "", "")),
        (["a title"], ("", "", ""), ("", "", "")),
        ([], ("", "", ""), ("", "", "")),
    ],
)
def test_names_and_units_in_one_line_or_in_two(headings, names, units):
    table = read_text_table("\n".join([*headings, *ROWS]), "own.csv")
    assert (table.names, table.units) == (names, units)
    assert table.rows.tolist() == [
        [0, 1.5, 80],
        [1, 2.5, 81],
        [2, 3.5, 82],
    ] and table.first_line == 1 + len(headings)


@pytest.mark.parametrize(
    ("lines", "rows"),
    [
        (['"0.5","828.0"', '"1.5","1,012.0"'], [[0.5, 828], [1.5, 1012]]),
        (["0.5;828", "1.5;1,012"], [[0.5, 828], [1.5, 1012]]),
        (["0,5;828,0", "1,5;1.012,5"], [[0.5, 828], [1.5, 1012.5]]),
        (["0,5;828", "1,5;1.012"], [[0.5, 828], [1.5, 1012]]),
        (["1;828", "2;920", "3;1,012"], [[1, 828], [2, 920], [3, 1012]]),
        (["0,302;0,816", "1,302;3,118"], [[0.302, 0.816], [1.302, 3.118]]),
        (["1\t1 012,5", "2\t2 024,5"], [[1, 1012.5], [2, 2024.5]]),
        (["1;1'012.5", "2;2'024.5"], [[1, 1012.5], [2, 2024.5]]),
        (["\u22121;\u22123.5", "\u22122;\u22124.5"], [[-1, -3.5], [-2, -4.5]]),
        (["1.5 2.5e2", "2.5 3.5D2"], [[1.5, 250], [2.5, 350]]),
    ],
)
def test_a_number_is_read_however_its_marks_are_written(lines, rows):
    """Quotes, decimal commas, thousands parted by comma, point, blank or apostrophe, a typographic minus."""
    quoted = '"place","force"' if '"' in lines[0] else "place;force"
    assert read_text_table("\n".join([quoted, *lines]), "tester.csv").rows.tolist() == rows
