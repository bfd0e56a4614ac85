"""Lines of keys in a TOML text, for messages that point at them."""

from __future__ import annotations

import pytest

from valvetrain.parameters.toml_text import find_line

TEXT = '''# comment = 1
title = "a = b"
long = """
inside = 3
"""

[spring]
wire.diameter = 1
pitch = { coils = [0, 1], values = "1 mm" }
knots = [
  1,  # x = 2
  2,
]
after = 3
"quoted key" = 1

[[published]]
model = "a"
[published.quantities]
preload = "1 N"
[[published]]
model = "b"
[published.quantities]
preload = "2 N"
'''


@pytest.mark.parametrize(
    ("path", "line"),
    [
        (("title",), 2),
        (("long",), 3),
        (("inside",), None),
        (("spring",), 7),
        (("spring", "wire", "diameter"), 8),
        (("spring", "pitch", "values"), 9),
        (("spring", "pitch", "values", 0), 9),
        (("spring", "knots", 1), 10),
        (("spring", "x"), 7),
        (("spring", "after"), 14),
        (("spring", "quoted key"), 15),
        (("published", 0, "model"), 18),
        (("published", 0, "quantities", "preload"), 20),
        (("published", 1, "quantities", "preload"), 24),
        (("published", 1, "quantities", "other"), 23),
    ],
)
def test_lines(path, line):
    assert find_line(TEXT, path) == line
