"""What ``import valvetrain`` costs, the start of the interpreter taken off."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Mapping


def measure() -> Mapping[str, float]:
    """Best of five starts of the interpreter, with and without the import (s)."""
    return {"import valvetrain": best("import valvetrain") - best("pass")}


def best(code: str) -> float:
    """Shortest of five runs of ``code`` in a new interpreter (s)."""
    seconds = []
    for _ in range(5):
        start = time.perf_counter()
        subprocess.run([sys.executable, "-c", code], check=True)
        seconds.append(time.perf_counter() - start)
    return min(seconds)
