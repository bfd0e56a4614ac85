"""Everything that tests let the package make is what it was: solutions, springs at rest, figures,
tables, sentences, files, answers.

Kept in ``golden/made``, a file per file of tests: of each thing a digest of its words and two sums
of its numbers. What a test makes has to
be among the things that are kept, so tests run in any order and choice. ``python
tests/golden/keep_made.py FILE...`` writes the files anew,
from several runs; what differs between these (times, places of files) is left out. Nothing here
shows that a number is right; it says that
one moved.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import re
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from functools import cache, lru_cache, wraps
from importlib import import_module, metadata
from io import BytesIO
from pathlib import Path
from platform import machine, python_version_tuple
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from valvetrain.solution import atomic

KEPT = Path(__file__).parent / "golden" / "made"
#: Where the environment names a folder, what is made is written there and not compared.
FOLDER = "VALVETRAIN_MADE"
#: Classes whose objects are looked at as they are made: what the pipeline hands on, and what pages
#: are built of.
WATCHED = """
    solution.result.Solution solution.static.StaticCurve solution.static.SpringAtRest solution.static.StaticStress
    solution.static.Buckling solution.static.Leaning solution.modal.ModalResult solution.rest_point.RestPoint
    solution.train_modes.TrainModes solution.critical.SpeedBracket solution.critical.Crossing solution.critical.CriticalSpeed
    solution.fidelity.FidelityRow solution.fidelity.Reach solution.comparison.Comparison solution.comparison.Finding
    report.chart.Chart report.page.Text report.page.Grid report.page.Card report.page.Listing report.page.Motion report.page.Page
    report.motion.parts.SpringDrawing report.motion.parts.Body report.motion.parts.Variant parameters.spring.SpringDefinition
    system.problem.Problem quantities.adequacy.AdequacyTest measurements.film.result.CoilMotion measurements.rig_result.RigResult
    measurements.force_height.ForceHeight measurements.measured_cycles.MeasuredCycles measurements.measured_lift.MeasuredLift
    measurements.lift_smoothing.SmoothedLift measurements.value_table.ValueTable measurements.spring_scan.result.ScannedSpring
    studies.scan_against_design.ScanComparison studies.film_model.FilmedModel studies.compare_test.ModelAgainstTest
    studies.spring_card.SpringFit studies.spring_tester.TesterFit studies.spring_tester.PitchStations studies.optimum.result.Optimum
    studies.points.table.StudyTable identification.result.Identified identification.datum.Datum validation.row.Row
    identification.conflicts.Conflict identification.information.Information identification.least_squares.Peak
    identification.multistart.Ends identification.profiles.Profile quantities.agreement.Agreement quantities.contact_loss.RigidForces
    quantities.difference_band.DifferenceBand quantities.energy.EnergyBalance quantities.kinematics.RigidTable
    quantities.kinematics.RigidMotion quantities.spectrum.OrderSpectrum quantities.stress.WireStress quantities.trace_events.EventRow
    quantities.train_events.RigidCycle cosserat.modes.RodModes springs.equivalent.EquivalentSpring
    springs.equivalent.InstalledGaps springs.linear.SpringMatrices springs.chain_layout.ChainLayout springs.chain_layout.CoilContacts
    springs.modal_varied.ModalSolution springs.stress.FibreFactors mechanism.parts.AssembledMechanism mechanism.rigid.RatioCurve
    mechanism.rigid.RigidKinematics cam.flank_pulse.HalfLobe cam.arcs.Lobe cam.pieces.PeriodicPieces measurements.sensor.Seen
    measurements.lift_alignment.LiftAlignment measurements.lift_figures.LiftFigure measurements.pulses.Teeth
    measurements.recording.Recording measurements.shaft_angle.ShaftAngle measurements.text_table.TextTable
    measurements.film.phase.CamPhase measurements.film.surge.SurgeFit measurements.film.tracks.Tracks
    measurements.spring_scan.trace.Trace measurements.spring_scan.tube.Tube studies.against_test.RunAgainstTest
    studies.error_bars.Uncertainty studies.lift_band.LiftBandStudy studies.spread.Spread studies.shared_errors.SharedErrors
    studies.seen.SeenChannel studies.solid.SolidCost studies.critical_search.Look studies.grid_convergence.GridConvergence
""".split()
#: Files of tests whose things depend on time, on other processes or on chance.
LEFT = re.compile(
    r"tests/property/|browser|workbench|_streams|workers_and_signals|test_half_written|full_disk|test_how_to|dask|memory|"
    r"unfinished|kill|stopp|interrupt|resum|goes_on|lost"
)
#: Fields and keys that differ from run to run, or say what stands elsewhere too.
FLEETING_KEYS = re.compile(
    r"wall_time|seconds|created|digest|version|provenance|statistics|dependenc|memory|folder|path|^files?$|compiled|workers|uuid|elapsed|command_line"
)
#: Fields of objects that are looked at by themselves, or are packed to the last bit.
OWN_FIELDS = re.compile(r"^(record|modes|curve|points|sections|data|chart)$")
#: Words that do: times, versions, digests; those with a stroke name folders.
FLEETING = re.compile(
    r"\b[0-9a-f]{8,}\b|\d{4}-\d\d-\d\d\S*|\b\d+\.\d+\.\d+\S*|\b[\d.]+ ?(?:s|ms|min|MB|GB|MiB|GiB|kB)\b|\d{8}-\d{6}-?\S*"
)
NUMBER = re.compile(r"[-+−]?\d+\.?\d*(?:e[-+]?\d+)?", re.IGNORECASE)
#: Numbers below this are noise; most things kept of one file of tests and one name.
NOISE, MOST = 1e-9, 400
TOLD = "_told_to_the_tests"
#: Characters of a text that are looked at.
LONGEST = 400_000

made: dict[str, dict[str, list[list[float]]]] = {}
now: dict[str, str] = {"file": ""}
unknown: list[str] = []


def versions() -> list[str]:
    """What moves numbers and words beside the package itself."""
    found = [f"Python {'.'.join(python_version_tuple()[:2])} {machine()}"]
    for name in (
        "numpy",
        "scipy",
        "numba",
        "rich",
        "typer",
        "plotly",
        "xarray",
        "pydantic",
        "nicegui",
    ):
        with contextlib.suppress(metadata.PackageNotFoundError):
            found.append(f"{name} {metadata.version(name)}")
    return found


@cache
def are_same() -> bool:
    """Whether what is installed is what the things were kept with."""
    return (KEPT / "versions.json").exists() and json.loads(
        (KEPT / "versions.json").read_text()
    ) == versions()


@lru_cache(50_000)
def of_text(text: str) -> tuple[str, tuple[float, ...]]:
    """Words of a text without spaces, ``#`` for each number, and its numbers; what differs from run
    to run is left out.
    """
    cleaned = FLEETING.sub(
        "", "".join(part for part in re.split(r"(\s+)", text) if "/" not in part)
    )
    found = tuple(float(one.replace("−", "-")) for one in NUMBER.findall(cleaned))
    return "".join(NUMBER.sub("#", cleaned).split()), found


@cache
def stays(key: str) -> bool:
    """Whether what stands under a key is the same from run to run."""
    return not FLEETING_KEYS.search(key)


@cache
def parts_of(kind: type) -> tuple[str, ...]:
    """Fields of a dataclass that are looked at."""
    return tuple(
        one.name for one in fields(kind) if stays(one.name) and not OWN_FIELDS.match(one.name)
    )


def flat(one: Any, words: list[str], numbers: list[Any], depth: int = 0) -> None:
    """Adds the words and numbers of ``one`` in their order; each number leaves a ``#`` among the
    words.
    """
    if one is None or isinstance(one, bool | np.bool_):
        words.append(str(one))
    elif isinstance(one, int | float | np.number):
        words.append("#")
        if not isinstance(numbers[-1], list):
            numbers.append([])
        numbers[-1].append(float(one.real))
    elif isinstance(one, str):
        said, found = of_text(one[:LONGEST])
        words.append(said)
        if found:
            numbers.append(found)
    elif isinstance(one, np.ndarray):
        words.append(str(one.shape))
        if one.dtype.kind in "fiub":
            numbers.append(np.asarray(one, dtype=float).ravel())
        else:
            flat(one.ravel().tolist(), words, numbers, depth + 1)
    elif isinstance(one, Mapping):
        for key, value in one.items():
            if stays(str(key)):
                words.append(str(key))
                flat(value, words, numbers, depth + 1)
    elif isinstance(one, list | tuple | set | frozenset):
        if (
            isinstance(one, list | tuple)
            and len(one) > 3
            and {type(value) for value in one} == {float}
        ):
            words.extend("#" * len(one))
            numbers.append(tuple(one))
            return
        for value in sorted(one, key=str) if isinstance(one, set | frozenset) else one:
            flat(value, words, numbers, depth + 1)
    elif is_dataclass(one) and depth < 12:
        for name in parts_of(type(one)):
            with contextlib.suppress(AttributeError):
                words.append(name)
                flat(getattr(one, name), words, numbers, depth + 1)
    else:
        words.append(type(one).__name__)


def told(one: Any) -> tuple[str, list[float]]:
    """Digest of the words of a thing; count and two sums of its numbers, each by its sign and the
    decades of its size.
    """
    words: list[str] = []
    numbers: list[Any] = [[]]
    flat(one, words, numbers)
    found = np.concatenate([np.asarray(part, dtype=float) for part in numbers])
    known = np.isfinite(found)
    with np.errstate(over="ignore", invalid="ignore"):
        sizes = np.arcsinh(np.where(known, found, 0.0) / NOISE)
    words.append(str(np.flatnonzero(~known).tolist()))
    sizes = np.minimum(np.abs(sizes), 1e3) * np.sign(
        sizes
    )  # of numbers near the largest there are, infinite
    sums = [
        float(len(found)),
        round(float(sizes.sum()), 6),
        round(float(sizes @ np.cos(1.0 + 0.7 * np.arange(len(found)))), 6),
    ]
    return hashlib.sha256("|".join(words).encode()).hexdigest()[:8], sums


def alike(first: list[float], second: list[float]) -> bool:
    """Whether two triples of sums differ by rounding alone."""
    room = 2e-6 + 1e-7 * first[0]
    return (
        first[0] == second[0]
        and abs(first[1] - second[1]) < room
        and abs(first[2] - second[2]) < room
    )


@cache
def kept() -> tuple[dict[str, dict[str, list[list[float]]]], dict[str, dict[str, Any]]]:
    """All things that are kept, by name and digest, and what each file of tests leaves out; nothing
    where other versions are installed.
    """
    pool: dict[str, dict[str, list[list[float]]]] = {}
    left: dict[str, dict[str, Any]] = {}
    if not are_same():
        return pool, left
    for path in sorted(KEPT.glob("*/*.json")):
        one = json.loads(path.read_text(encoding="utf-8"))
        left[f"tests/{path.parent.name}/{path.stem}.py"] = {
            "unsure": set(one["unsure"]),
            "words_alone": set(one["words_alone"]),
        }
        for name, things in one["made"].items():
            for digest, sums in things.items():
                pool.setdefault(name, {}).setdefault(digest, []).extend(sums)
    return pool, left


def note(name: str, one: Any) -> None:
    """Looks at a thing as it is made."""
    file = now["file"]
    if not file:
        return
    try:
        digest, sums = told(one)
    except Exception as error:  # a thing that tests made too strange to be told
        digest, sums = type(error).__name__, [0.0, 0.0, 0.0]
    if FOLDER in os.environ:
        place = made.setdefault(f"{file}|{name}", {}).setdefault(digest, [])
        if len(place) < MOST and not any(alike(sums, old) for old in place):
            place.append(sums)
        return
    pool, left = kept()
    if file not in left or name in left[file]["unsure"]:
        return
    among = pool.get(name, {}).get(digest)
    sure = among is not None and (
        f"{name}|{digest}" in left[file]["words_alone"] or any(alike(sums, old) for old in among)
    )
    if not sure and len(unknown) < 20:
        unknown.append(f"{name}: {'other numbers' if among else 'other words'}")


def _watch_class(module: str, name: str) -> None:
    cls = getattr(import_module(f"valvetrain.{module}"), name)
    usual = cls.__init__

    @wraps(usual)
    def watched(self: Any, *given: Any, **more: Any) -> None:
        usual(self, *given, **more)
        if now["file"]:
            note(_named(name, self), self)
            if (
                name == "Solution" and TOLD not in self.arrays.__dict__
            ):  # copies with other quantities share the channels
                self.arrays.__dict__[TOLD] = True
                note(_named("channels", self), {**self.arrays.coords, **self.arrays.variables})

    cls.__init__ = watched


def _named(name: str, one: Any) -> str:
    """What a thing is called: words of it that stay where its numbers move."""
    if name in ("Solution", "channels"):
        return f"{name} {one.provenance.case_name} {one.provenance.label}"[:60]
    words = (
        getattr(one, "key", "")
        or getattr(one, "title", "")
        or getattr(one, "html", "")
        or " ".join(getattr(one, "headers", ()))
    )
    return f"{name} {' '.join(re.findall(r'[A-Za-z]+', str(words)[:60]))}"[:40].strip()


usual_write, usual_invoke = atomic.write_bytes, CliRunner.invoke


def write_bytes(path: str | os.PathLike[str], content: bytes | memoryview) -> Path:
    """``write_bytes`` of the package, with the texts among its files looked at."""
    name = Path(path).name
    if now["file"] and name.rpartition(".")[2] in ("csv", "json", "toml", "svg", "txt", "s96"):
        with contextlib.suppress(UnicodeDecodeError):
            text = bytes(content).decode()
            _note_text(f"file {name[:40]}", text, name.endswith(".json"))
    if now["file"] and name.endswith(".gif"):
        note(f"file {name[:40]}", _seen(bytes(content)))
    return usual_write(path, content)


def _seen(film: bytes) -> list[Any]:
    """Colours of every picture of a film, coarse."""
    from PIL import Image, ImageSequence

    with Image.open(BytesIO(film)) as pictures:
        return [
            np.asarray(one.convert("RGB").resize((48, 27), Image.Resampling.BOX), dtype=float)
            for one in ImageSequence.Iterator(pictures)
        ]


def invoke(self: CliRunner, app: Any, args: Any = None, **more: Any) -> Any:
    """``CliRunner.invoke``, with the answer looked at."""
    found = usual_invoke(self, app, args, **more)
    if now["file"]:
        name = f"answer {args[0] if isinstance(args, list | tuple) and args else ''}"
        complaint = "\n".join(
            one
            for one in found.stderr.splitlines()
            if not one.startswith("compiling kernels, once")
        )
        note(f"{name} end", (found.exit_code, complaint if found.exit_code else ""))
        _note_text(name, found.stdout, found.stdout.lstrip().startswith("{"))
    return found


def _note_text(name: str, text: str, may_be_json: bool) -> None:
    base = tempfile.gettempdir()
    text = re.sub(re.escape(base) + r"\S*", "", text)
    if may_be_json:
        with contextlib.suppress(ValueError):
            for key, value in json.loads(text).items():
                if not FLEETING_KEYS.search(key):
                    note(f"{name} {key}"[:60], value)
            return
    note(name, text)


atomic.write_bytes = write_bytes
CliRunner.invoke = invoke  # type: ignore[method-assign]
for _one in WATCHED:
    _watch_class(*_one.rsplit(".", 1))


class Watch:
    """Plugin: tells which file of tests is at work, and fails a test that made something unknown."""

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> None:
        file = item.nodeid.partition("::")[0]
        chance = getattr(getattr(item, "obj", None), "is_hypothesis_test", False)
        now["file"] = (
            "" if chance or LEFT.search(item.nodeid) or item.get_closest_marker("long") else file
        )
        unknown.clear()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_teardown(self, item: pytest.Item) -> Iterator[None]:
        yield
        found, _ = list(dict.fromkeys(unknown)), unknown.clear()
        now["file"] = ""
        if found:
            pytest.fail(
                f"made something that is not kept in tests/golden/made: {'; '.join(found[:5])}",
                pytrace=False,
            )

    def pytest_sessionfinish(self) -> None:
        if FOLDER in os.environ and made:
            (Path(os.environ[FOLDER]) / f"{os.getpid()}.json").write_text(json.dumps(made))
