"""Writes the tables of docs/fidelity.md anew: three cases by all spring models over engine speed,
ten minutes of one core.

Use: python scripts/write_fidelity.py [DOCS]
"""

from __future__ import annotations

import sys
from pathlib import Path

import valvetrain as vt
from valvetrain.report.run_summary import reach_rows, share
from valvetrain.solution.fidelity import FidelityMap

PAGE = "fidelity.md"
#: Case -> engine speeds.
CASES = {
    "gu2021-beehive": "3000:9000:500 rpm",
    "vaz-ohc": "1000:6000:500 rpm",
    "tdi-pushrod": "1000:8000:500 rpm",
}


def markdown(found: FidelityMap) -> str:
    """A row per quantity: up to where each model is good enough, and its largest difference in
    brackets.
    """
    lines = [
        "| within 5 %, rpm | "
        + " | ".join(f"`{model}`" for model in found.models)
        + " | cheapest at all speeds |"
    ]
    lines.append("|---" * (len(found.models) + 2) + "|")
    for row in reach_rows(found):
        reaches = [found.reach(row.quantity, model) for model in found.models]
        cells = [
            one.words if one.missing else f"{one.words} ({share(one.largest)})" for one in reaches
        ]
        lines.append(f"| {row.words} | " + " | ".join(cells) + f" | `{row.cheapest}` |")
    return "\n".join(lines)


def main(docs: Path) -> None:
    """Put the table of each case between its two marks."""
    path = docs / PAGE
    text = path.read_text(encoding="utf-8")
    for case, speeds in CASES.items():
        table = markdown(vt.fidelity(case, speeds, limit="1 h").fidelity)
        begin, end = f"<!-- {case} -->\n", "<!-- end -->"
        before, _, after = text.partition(begin)
        text = f"{before}{begin}{table}\n{end}{after.partition(end)[2]}"
    path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[1] / "docs")
