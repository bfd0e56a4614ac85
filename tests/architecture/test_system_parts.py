"""Under continuous integration no test may be left out for want of a program."""

from __future__ import annotations

import os
import shutil

import pytest

PARTS = {"chromium": ("chromium", "chromium-browser", "google-chrome"), "calculix-ccx": ("ccx", "ccx_2.20", "ccx_2.21")}


@pytest.mark.skipif(os.environ.get("CI") != "true", reason="only continuous integration must have every program; run with CI=true to check")
@pytest.mark.parametrize("part", PARTS)
def test_every_program_is_there(part):
    assert any(shutil.which(name) for name in PARTS[part]), f"install {part}; without it tests are left out"
