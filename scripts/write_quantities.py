"""Write docs/quantities.md from the tables of quantities.

Use: python scripts/write_quantities.py
"""

from __future__ import annotations

from pathlib import Path

from valvetrain.quantities.page import quantities_page

if __name__ == "__main__":
    path = Path(__file__).resolve().parents[1] / "docs" / "quantities.md"
    path.write_text(quantities_page(), encoding="utf-8")
    print(f"wrote {path.name}")
