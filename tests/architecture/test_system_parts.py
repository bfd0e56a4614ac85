"""Under continuous integration no test may be left out for want of a program."""

from __future__ import annotations

import re

import pytest

from architecture.layout import ROOT
from system_parts import PROGRAMS, program, under_ci


@pytest.mark.skipif(
    not under_ci(),
    reason="only continuous integration must have every program; run with CI=true to check",
)
@pytest.mark.parametrize("marker", PROGRAMS)
def test_every_program_is_there(marker):
    assert program(marker), f"install {PROGRAMS[marker][1]}; without it tests are left out"


def test_the_installer_and_the_tests_look_for_the_same_programs():
    text = (ROOT / "scripts" / "system_parts.sh").read_text(encoding="utf-8")
    listed = re.findall(r'"([\w. -]+)\|([\w-]+)\|', text)
    assert listed == [(" ".join(names), package) for names, package in PROGRAMS.values()]
