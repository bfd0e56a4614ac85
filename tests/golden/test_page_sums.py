"""Golden: page, pictures and tables of four made-up studies, block by block in words and sums; run
this file to write them anew.

That each table, figure and sentence carries what it names is shown by
``tests/unit/test_every_*.py``; here nothing may move unsaid.
"""

from __future__ import annotations

import hashlib
import re
import sys
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import pytest

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[1]))

from known_figures import STUDIES
from known_sums import NUMBER, read, same, sums, write
from valvetrain.report.study import write_study

KEPT = Path(__file__).parent / "page_sums.json"
#: Sizes in bytes of scripts that are not ours: the plotting library and the style of the page.
FOREIGN = 100_000
#: Characters of a file that are looked at: long tables of channels go on as they begin.
MOST = 60_000
#: What differs from one machine and version to the next: packed numbers to their last bit, digests,
#: versions, times.
FLEETING = re.compile(
    r'"bdata":"[^"]*"|\b[0-9a-f]{16,}\b|'
    r"\d+\.\d+\.\d+\S*|\d{4}-\d\d-\d\dT[\d:.+Z]+|(?<=>)[^<]*(?:Python|numpy|Linux)[^<]*"
)


def block(text: str) -> list[Any]:
    """Sums of the numbers of a block; its words by their digest."""
    words = " ".join(NUMBER.sub("#", text).split())
    return [
        *sums([float(one) for one in NUMBER.findall(text)]),
        hashlib.sha256(words.encode()).hexdigest()[:12],
    ]


def blocks(text: str, cut: str) -> dict[str, Any]:
    """A text cut before each ``cut``; block -> its sums and, apart, its words."""
    told: dict[str, Any] = {}
    for place, part in enumerate(re.split(f"(?={cut})", text)):
        *numbers, words = block(part)
        head = " ".join(re.sub(r"<[^>]*>", " ", part).split())[:50]
        told[f"{place} {head}"] = {"numbers": numbers, "words": words}
    return told


@cache
def told(name: str) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as folder:
        written = write_study(STUDIES[name](), folder, page=True, figures=True)
        found: dict[str, Any] = {
            f"{path.parent.name if path.suffix == '.svg' else ''} {path.name}": blocks(
                FLEETING.sub("", path.read_text(encoding="utf-8")[:MOST]), r"<g\b"
            )
            for path in sorted((*written.data, *written.figures))
            if path.suffix in (".csv", ".svg")
        }
        page = written.page.read_text(encoding="utf-8")
    # pictures without scripts are those of the files above; what moves is packed to its last bit
    # (tests/unit/test_motion_data.py)
    page = re.sub(
        r'<noscript>.*?</noscript>|<script type="application/json" id="motion-.*?</script>',
        "",
        page,
        flags=re.S,
    )
    page = re.sub(
        r"<(script|style)\b.*?</\1>",
        lambda part: "" if len(part[0]) > FOREIGN or part[1] == "style" else part[0],
        page,
        flags=re.S,
    )
    return found | blocks(FLEETING.sub("", page), r"<h[1-4]\b|<table\b|<figure\b|<script\b")


@pytest.mark.parametrize("name", STUDIES)
def test_a_page_is_what_it_was(name):
    assert not same(told(name), read(KEPT)[name], 1e-7)


if __name__ == "__main__":
    write(KEPT, {name: told(name) for name in STUDIES})
