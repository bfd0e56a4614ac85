"""Property: a damaged file of any reader is read, refused in one sentence, or answered with a doubt; no number is absurd."""

from __future__ import annotations

import pytest
from faults.files import READERS, samples, trials

SEED, COUNT = 53, {"lift": 30, "s96": 12, "contour": 20, "drawing": 12, "scan": 30, "rig": 30}


@pytest.mark.parametrize("reader", READERS)
def test_a_damaged_file_is_read_or_refused(reader):
    found = list(trials(reader, SEED, range(COUNT.get(reader, 40))))
    assert not [(number, word, fault) for number, word, fault, _ in found if fault]
    assert len({word for _, word, _, _ in found}) > 1


def test_the_whole_files_are_answered(tmp_path):
    """Of every sample, so that what is damaged is a file that is read."""
    for reader, read in READERS.items():
        for name, content in samples(reader):
            (tmp_path / name).write_bytes(content)
            assert read(tmp_path / name) is not None, (reader, name)
