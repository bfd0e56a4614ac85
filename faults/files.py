"""Damaged files of every kind that people measure: each is read, refused in one sentence, or answered with a doubt.

``python -m faults.files [--seed 1] [--count 2000] [READER ...]`` prints for each reader how many files were answered,
doubted and refused, and fails for anything else that was raised and for a number that no valvetrain has and no doubt names.
"""

from __future__ import annotations

import argparse
import io
import math
import os
import sys
import tempfile
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from functools import cache, partial
from pathlib import Path
from random import Random
from typing import Any

import numpy as np

from faults.inputs import damaged, damaged_text
from known_lifts import three_arc
from valvetrain.errors import InputError, UnusualValueWarning

#: What a reader gives: codes of its doubts, and numbers by what they are (SI).
Read = tuple[Iterable[str], Iterable[tuple[str, float]]]
#: Bounds (SI) of numbers without a doubt: wide enough for model engines and ship engines.
BOUNDS = {
    "lift": (1e-4, 0.1), "duration": (math.radians(5), 2 * math.pi), "acceleration": (1e-6, 1.0), "rate": (50.0, 5e6), "force": (-1e3, 1e5),
    "height": (2e-3, 0.5), "turns": (1.0, 40.0), "wire": (2e-4, 0.03), "points": (1, 1e7), "channel": (-1e12, 1e12), "film": (-1e7, 1e7),
}  # fmt: skip


def lobe(angles: np.ndarray) -> np.ndarray:
    """A lift (mm) over cam degrees, with its nose at 130."""
    u = np.clip(np.abs(angles - 130.0) / 62.0, 0, 1)
    return np.asarray(9.0 * (1 - u**2) ** 3 * (1 + 0.8 * u**2))


def rows(heading: str, *columns: np.ndarray, mark: str = ",") -> bytes:
    """A table as text."""
    lines = (mark.join(f"{value:g}" for value in row) for row in zip(*columns, strict=True))
    return "\n".join([heading, *lines]).encode()


@cache
def samples(reader: str) -> tuple[tuple[str, bytes], ...]:
    """Whole files of a reader: name and content."""
    turn, round_ = np.arange(0.0, 360.0, 5.0), np.arange(0.0, 360.0, 3.0)
    if reader == "lift":
        thou = np.round(lobe(turn) / 0.0254) / 1000
        german = rows("Nockenwinkel [Grad];Stößelhub [mm]", turn, np.round(lobe(turn), 3), mark=";")
        return ("a.csv", rows("cam angle (deg),valve lift (in)", turn, thou)), ("b.txt", german.replace(b".", b","))  # fmt: skip
    if reader == "s96":
        every = np.round(lobe(np.arange(0.0, 396.0) % 360), 4)
        return (("a.s96", b"cam\n" + b"\n".join(b"%g" % one for one in every)),)
    if reader == "contour":
        radii = 1e3 * three_arc(np.radians(round_ - 180))
        x, y = radii * np.cos(np.radians(round_)), radii * np.sin(np.radians(round_))
        return ("a.csv", rows("angle (deg),radius (mm)", round_, radii)), ("b.csv", rows("x (mm),y (mm)", x, y))  # fmt: skip
    if reader == "drawing":
        from ezdxf.filemanagement import new

        document, out = new(units=4), io.StringIO()
        radii = 1e3 * three_arc(np.radians(round_ - 180))
        points = np.column_stack([radii * np.cos(np.radians(round_)), radii * np.sin(np.radians(round_))])  # fmt: skip
        document.modelspace().add_lwpolyline(points.tolist(), close=True)
        document.write(out)
        return (("a.dxf", out.getvalue().encode()),)
    if reader == "tester":
        travel = np.arange(0.0, 24.0, 0.8)
        force = 30.0 * np.clip(travel - 2.0, 0, None) + 4000 * np.clip(travel - 22.0, 0, None)
        quoted = rows("Height (mm);Force (N)", 52 - travel, np.round(force, 1), mark=";")
        return ("a.csv", rows("Position (mm),Load (lbf)", travel, np.round(force / 4.448, 2))), ("b.csv", quoted)  # fmt: skip
    if reader == "scan":
        from sample_scan import Scanner, cloud, ply, springs

        points, _ = cloud(springs()["conical"], 1600, Scanner(noise=0.03e-3, seed=4))
        table = rows("x [mm] y [mm] z [mm]", *(1e3 * points[::10].T), mark=" ")
        facet = b"facet normal 0 0 1\nouter loop\nvertex 0 0 1\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
        corners = b"".join(b"v %g %g %g\n" % tuple(point) for point in points[:30] * 1e3)
        faces = b"solid a\n" + 9 * facet + b"endsolid"
        return ("a.ply", ply(points)), ("b.xyz", table), ("c.stl", faces), ("d.obj", corners + b"f 1 2 3\nf 4 5 6\n")  # fmt: skip
    if reader == "rig":
        from sample_rig import WRITERS, Rig, record

        def opened(angle: np.ndarray) -> np.ndarray:
            return np.asarray(np.clip(np.cos(angle), 0, None) ** 2)

        rig = record(
            Rig(cycles=3, sampling_rate=2e3, seed=2),
            lambda angle: 9e-3 * opened(angle),
            lambda angle: 200 + 270 * opened(angle),
        )
        with tempfile.TemporaryDirectory() as folder:
            WRITERS["rig.csv"](Path(folder, "rig.csv"), rig)
            return (("rig.csv", Path(folder, "rig.csv").read_bytes()),)
    texts = {
        "events": "IVO 5 before top, IVC 32.5 after bottom, EVO 40 before bottom, EVC 8 after top",
        "card": "4.2 mm|32 mm|46 mm, 350 N|34 mm, 830 N|23.5 mm|54.75 mm|5.6",
        "film": "2000 1/s|6, 10, 6, 239|4, 0, 4, 120, 20 mm|12, 5|170:350 deg|5",
    }
    return ((reader, texts[reader].encode()),)


def lifts(file: Path, **answers: Any) -> Read:
    """Lobes of a table or contour with their figures."""
    from valvetrain.lift.answer import LiftAnswer
    from valvetrain.lift.figures import LobeResult, lift_figures
    from valvetrain.lift.rules import LiftFacts
    from valvetrain.measured.lift_file import LiftAnswers, read_lift
    from valvetrain.measured.lift_smoothing import smooth_lift

    found = read_lift(file, LiftAnswers(**answers))
    laws = [smooth_lift(one.cam_angles, one.lifts) for one in found]
    lobes = [LobeResult(one, law, lift_figures(law)) for one, law in zip(found, laws, strict=True)]
    numbers = []
    for one in (figure for lobe in lobes for figure in lobe.figures):
        kinds = {"peak_lift": "lift", "duration_at_50_thou": "duration", "largest_acceleration": "acceleration"}  # fmt: skip
        numbers += [(kinds[one.name], one.value), ("lift", one.spread + 1e-3)] if one.name in kinds else []  # fmt: skip
    findings = LiftAnswer(LiftFacts(tuple(lobes))).findings
    return [
        one.code for one in findings if one.mark in ("warn", "bad") and one.code != "L208"
    ], numbers


def tester(file: Path) -> Read:
    """The spring behind a table of forces."""
    from valvetrain.measured.force_height import read_force_height
    from valvetrain.spring_card.tester import spring_from_tester

    table = read_force_height(file, free_length=52e-3)
    fit = spring_from_tester(table)
    heights = [("height", pair) for pair in (fit.free_length, fit.solid_height) if pair is not None]
    pairs = [("rate", fit.rate), ("force", fit.preload), *heights]
    numbers = [(name, value) for name, pair in pairs for value in (pair[0], pair[0] + pair[1])]
    return [one.code for one in table.doubts], numbers


def card(file: Path) -> Read:
    """The wire of a catalogue card."""
    from valvetrain.spring_card.answer import CardAnswer
    from valvetrain.spring_card.card import CatalogueCard, SpringLoad
    from valvetrain.spring_card.fit import spring_from_card
    from valvetrain.spring_card.rules import CardFacts

    words = file.read_bytes().decode("utf-8", "replace").split("|")
    keys = ("wire_diameter", "outer_diameter", "installed_load", "open_load", "solid_height", "free_length", "total_coils")  # fmt: skip
    given: dict[str, Any] = dict(zip(keys, words, strict=False))
    for key in ("installed_load", "open_load"):
        height, _, force = str(given.get(key, "")).partition(",")
        given[key] = SpringLoad(height, force.strip())
    fit = spring_from_card(CatalogueCard(**given))
    codes = CardAnswer(CardFacts(fit)).findings.codes
    wire = fit.spring.wire
    assert wire is not None
    return [code for code in codes if code.startswith("Z10")], [("turns", float(wire.total_coils)), ("height", float(wire.free_length))]  # fmt: skip


def events(file: Path) -> Read:
    """The events of a cam card."""
    from valvetrain.lift.timing import cams_of, typed_figures

    figures = typed_figures(cams_of(file.read_bytes().decode("utf-8", "replace"), None))
    return (), [("duration", one.value / 2) for one in figures if one.name.startswith("event_duration")]  # fmt: skip


def scan(file: Path) -> Read:
    """The points of a scan; of a whole cloud the spring as well."""
    from valvetrain.scan.answer import ScanAnswer
    from valvetrain.scan.clouds import open_cloud
    from valvetrain.scan.reconstruct import spring_from_scan

    points = open_cloud(file).points
    if len(points) < 1500:
        return (), [("points", len(points))]
    made = spring_from_scan(file, unit="mm", points=1500)
    codes = ScanAnswer(made).findings.codes
    return [code for code in codes if code.startswith("Y1")], [
        ("wire", made.section.diameter[0]), ("height", made.free_length[0]), ("turns", made.total_coils[0])
    ]  # fmt: skip


def rig(file: Path) -> Read:
    """Channels of a recording as cycles."""
    from valvetrain.rig.answer import RigAnswer
    from valvetrain.rig.cycles import cycles_in
    from valvetrain.rig.reader import read_here
    from valvetrain.rig.request import RigAnswers

    answers = RigAnswers(angle_of="crank", encoder="Crank angle", zero={"spring_force": "215 N"})
    result = cycles_in(read_here(file), file.name, answers)
    numbers = [("channel", float(np.nanmax(np.abs(one.mean)))) for one in result.cycles]
    return [one.code for one in RigAnswer(result).findings if one.mark in ("warn", "bad")], numbers


def film(file: Path) -> Read:
    """The settings of a film."""
    from valvetrain.film.setup import FilmSetup

    words = file.read_bytes().decode("utf-8", "replace").split("|")
    keys = ("frame_rate", "line", "scale", "marker", "dwell", "line_width")
    given: dict[str, Any] = dict(zip(keys, words, strict=False))
    setup = FilmSetup(**given)
    return (), [("film", value) for value in (setup.frame_rate, setup.line_width) if value is not None]  # fmt: skip


TAPPET = {"lift_of": "tappet", "angle_of": "cam"}
READERS: dict[str, Callable[[Path], Read]] = {
    "lift": lifts, "s96": lambda file: lifts(file, lift_unit="mm", **TAPPET), "contour": lambda file: lifts(file, follower="flat"),
    "drawing": lambda file: lifts(file, follower="flat"), "events": events, "tester": tester, "card": card, "scan": scan, "rig": rig, "film": film,
}  # fmt: skip


def broken(outcome: Callable[[], Read]) -> tuple[str, str]:
    """The word for what came of a file, and what is wrong with it; empty where nothing is."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            warnings.simplefilter("ignore", UnusualValueWarning)
            doubts, numbers = outcome()
    except InputError as error:
        text = str(error)
        return "refused", "" if text.isprintable() and 10 < len(text) < 900 else f"no sentence: {text[:200]!r}"  # fmt: skip
    except Exception as error:
        frame = error.__traceback__
        while frame is not None and frame.tb_next is not None:
            frame = frame.tb_next
        place = "" if frame is None else f"{Path(frame.tb_frame.f_code.co_filename).name}:{frame.tb_lineno}"  # fmt: skip
        return "raised", f"{type(error).__name__} at {place}: {str(error)[:200]}"
    if list(doubts):
        return "doubted", ""
    wrong = [f"{name} {value:g}" for name, value in numbers if not BOUNDS[name][0] <= value <= BOUNDS[name][1]]  # fmt: skip
    return "answered", ", ".join(wrong)


def trials(reader: str, seed: int, numbers: Iterable[int]) -> Iterator[tuple[int, str, str, bytes]]:
    """Number, word and fault of each damaged file, and its content."""
    with tempfile.TemporaryDirectory() as folder:
        for number in numbers:
            chance = Random(f"{reader} {seed} {number}")
            name, whole = chance.choice(samples(reader))
            text = b"\0" not in whole and chance.random() < 0.8
            content = whole if number < 0 else (damaged_text if text else damaged)(chance, whole)
            file = Path(folder, name)
            file.write_bytes(content)
            yield number, *broken(partial(READERS[reader], file)), content


def main() -> int:
    """Damage and read; 1 where a file broke a promise."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("readers", nargs="*", default=list(READERS), choices=[[], *READERS][1:])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--keep", type=Path, help="folder for the files that broke a promise")
    given = parser.parse_args()
    faults = 0
    for reader in given.readers:
        words: Counter[str] = Counter()
        for number, word, fault, content in trials(reader, given.seed, range(given.count)):
            words[word] += 1
            if fault:
                faults += 1
                print(f"{reader} {given.seed} {number}: {word}: {fault}", flush=True)
                if given.keep is not None:
                    given.keep.mkdir(parents=True, exist_ok=True)
                    (given.keep / f"{reader}-{number}").write_bytes(content)
        print(reader, dict(words), flush=True)
    return min(faults, 1)


if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    sys.exit(main())
