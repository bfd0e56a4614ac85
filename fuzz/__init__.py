"""Feeds damaged and hostile input to the package and tells what ends in anything but an answer or
one sentence: ``make fuzz``.
"""

import os

# Threads of linear algebra that wait for a processor count as time used, up to fifty times the work.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
