"""A law of an installed package: one file and one entry point, and a case file may name it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from valvetrain import registry

PACKAGE = '''
"""Laws of a user's own package."""

from dataclasses import dataclass

from pydantic import Field

from valvetrain.cam.contract import LiftSpec
from valvetrain.cam.sine_power import SinePower
from valvetrain.contact.hertz_point import HertzPoint
from valvetrain.contact.spec import ContactSpec
from valvetrain.parameters.schema_contact import ContactTable
from valvetrain.parameters.schema_lift import LiftModel
from valvetrain.parameters.schema_types import Angle, Mass, PositiveLength


class CosineTable(LiftModel):
    """Squared sine over 90 degrees."""

    maximum_lift: PositiveLength
    start: Angle


def cosine(*, maximum_lift, start):
    return SinePower(maximum_lift=maximum_lift, opening_start=start, closing_end=start + 1.5, power=2)


LIFT = LiftSpec(cosine, CosineTable)


@dataclass(frozen=True, slots=True)
class Oiled(HertzPoint):
    film_mass: float = 0.001


class OiledTable(ContactTable):
    """A contact with a film of oil."""

    film_mass: Mass = Field(default=0.001, description="mass of the film")


CONTACT = ContactSpec(Oiled, OiledTable)
'''
ENTRIES = "[valvetrain.lifts]\ncosine = own_laws:LIFT\n[valvetrain.contacts]\noiled = own_laws:CONTACT\n"
SCRIPT = """
import numpy as np
from valvetrain.cam import build_lift_law
from valvetrain.contact.library import build_contact_law
from valvetrain.errors import InputError
from valvetrain.parameters.loading import load_case, parse_case

case = parse_case('[lift_law]\\nkind = "cosine"\\nmaximum_lift = "9 mm"\\nstart = "90 deg"')
assert abs(build_lift_law(case.lift_law).lift(np.pi / 2 + 0.75) - 9e-3) < 1e-12
cam = load_case("tdi-pushrod", {"train.contacts.cam": {"law": "oiled", "contact_stiffness": "1e5 N/mm^1.5", "film_mass": "2 g"}})
contact = cam.train.contacts["cam"]
assert dict(contact.values) == {"contact_stiffness": 1e5 * 1000**1.5, "film_mass": 0.002}, contact.values
assert build_contact_law(contact.law, **contact.values).film_mass == 0.002
# its own key waits unused in the table of another law, as those of the built-in laws do
assert load_case("tdi-pushrod", {"train.contacts.cam.film_mass": "2 g"}).train.contacts["cam"].law == "impact"
try:
    load_case("tdi-pushrod", {"train.contacts.cam.film_mas": "2 g"})
except InputError as error:
    assert "film_mas" in str(error), error
else:
    raise AssertionError
"""


def python(script: str, *folders: Path) -> str:
    """What ``script`` prints in a process of its own that also finds the packages in ``folders``."""
    paths = os.pathsep.join(map(str, (*folders, Path(registry.__file__).parents[1])))
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, env={**os.environ, "PYTHONPATH": paths})
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_an_installed_package_brings_a_lift_law_and_a_contact_law(tmp_path):
    (tmp_path / "own_laws.py").write_text(PACKAGE)
    info = tmp_path / "own_laws-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: own-laws\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(ENTRIES)
    python(SCRIPT, tmp_path)


def test_every_law_of_the_registry_has_a_maker_and_a_table():
    for kind, maker in (("lifts", "make"), ("contacts", "law")):
        for word in registry.words(kind):
            spec = registry.find(kind, word)
            assert callable(getattr(spec, maker)) and spec.table.__doc__, word


def test_loading_a_case_imports_its_own_law_only():
    code = (
        "import sys; from valvetrain.parameters.loading import load_case; load_case('tdi-pushrod'); load_case('job-t');"
        "print(*sorted(name for name in sys.modules if name.startswith(('valvetrain.cam.', 'valvetrain.contact', 'numba'))))"
    )
    assert python(code).split() == [
        "valvetrain.cam.contract",
        "valvetrain.cam.flanks",
        "valvetrain.cam.polynomial",
        "valvetrain.cam.sine_power",
    ]
