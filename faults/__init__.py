"""Repeats what goes wrong around the program with other random numbers: kills, damaged files, damaged
cases, requests to a workbench; prints what of the promises of docs/reliability.md was broken.
"""

import os
import sys
from pathlib import Path

# Threads of linear algebra that wait for a processor count as time used.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tests"), str(ROOT / "scripts")]
