"""Write docs/plausible.md from the ranges of plausible values.

Use: python scripts/write_plausible.py
"""

from __future__ import annotations

from pathlib import Path

from valvetrain.quantities.plausible import plausible_page

if __name__ == "__main__":
    path = Path(__file__).resolve().parents[1] / "docs" / "plausible.md"
    path.write_text(plausible_page(), encoding="utf-8")
    print(f"wrote {path.name}")
