"""Every rule on the film of a spring in a film in which it holds and in one in which it does not; its tables and its page."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import film_parts as made
import valvetrain as vt
from valvetrain.film.cycles import mean_of
from valvetrain.film.model import FilmedModel
from valvetrain.film.rules import FilmFacts, shared_errors
from valvetrain.film.surge import SurgeLine
from valvetrain.findings.table import explain
from valvetrain.findings.words import Words
from valvetrain.views.results import answer_of, figures_of


def filmed(frames: int = 300, **changes):
    film, _ = made.turning_film()
    given = {"marker": (4, 4), "marker_radius": 2, "marker_angle": made.MARK_ANGLE, "line": ((6, 10), (6, 239))}  # fmt: skip
    setup = vt.film.FilmSetup(**{**given, **changes}, **made.SCALE)
    return vt.film.coil_motion(film[:frames], setup)


@cache
def decay():
    rows, frame = np.arange(80.0)[:, None], np.arange(120)[:, None, None]
    moved = 3 * np.exp(-0.01 * frame) * np.cos(2 * np.pi * 0.2 * frame)
    bands = (np.exp(-(((rows - 20 * k - moved * (k in (2, 3))) / 2) ** 2)) for k in (1, 2, 3))
    setup = vt.film.FilmSetup(frame_rate=2000, scale="4, 0, 4, 50, 10 mm", free_decay=True)  # fmt: skip
    return vt.film.coil_motion(sum(bands) * np.full((1, 1, 9), 100.0), setup)


def with_lines(*pairs: tuple[float, float]):
    """The decay with surge lines of other frequencies (Hz) and amplitudes (m)."""
    found = tuple(SurgeLine(one, 0.25, 0.01, 1e-4, size) for one, size in pairs)
    return replace(decay(), surge=replace(decay().surge, lines=found))


def without_frames():
    motion = made.turning_motion()
    places = motion.places.copy()
    places[:60, 2] = np.nan
    return replace(motion, places=places)


def model(share: float) -> FilmedModel:
    """A run that is off the film by a share of its motion."""
    motion = made.turning_motion()
    grid = motion.cycles[0].cam_angle
    moved = (1 + share) * np.stack([mean_of(one.values) for one in motion.cycles], axis=1)
    apart = np.sqrt(np.nanmean((moved * share / (1 + share)) ** 2, axis=0))
    names = tuple(f"outer_coil_{turn}_70_displacement" for turn in range(6))
    return FilmedModel(motion, "own", "multi-mass", "outer", np.arange(6) + 0.7, names, 0.0, grid, moved,
                       np.nanmax(moved, axis=0), apart, motion.surge, 412.0, ())  # fmt: skip


RESULTS = {
    "turning": made.turning_motion, "decay": decay, "short": lambda: filmed(90, cam_speed=made.CAM_SPEED),
    "other speed": lambda: filmed(cam_speed=1.02 * made.CAM_SPEED), "same speed": lambda: filmed(cam_speed=made.CAM_SPEED),
    "no zero": lambda: filmed(marker_angle=None), "lost": without_frames, "silent": lambda: replace(decay(), surge=None),
    "fast": lambda: with_lines((900.0, 1e-3), (400.0, 1e-4)), "weak and fast": lambda: with_lines((900.0, 1e-4), (400.0, 1e-3)),
    "cut": lambda: replace(decay(), seen=replace(decay().seen, missing=39)), "near": lambda: model(0.01), "far": lambda: model(0.5),
}  # fmt: skip


@pytest.mark.parametrize(
    ("code", "holds", "holds_not"),
    [
        ("Y210", "cut", "decay"),
        ("Y201", "lost", "turning"), ("Y202", "fast", "weak and fast"), ("Y211", "other speed", "same speed"), ("Y212", "short", "turning"),
        ("Y213", "no zero", "turning"), ("Y214", "weak and fast", "fast"), ("Y221", "far", "near"), ("Y222", "near", "far"),
        ("Y231", "turning", "near"), ("Y232", "decay", "turning"), ("Y233", "silent", "decay"),
    ],
)  # fmt: skip
def test_a_rule_holds_in_one_film_and_not_in_another(code, holds, holds_not):
    assert code in answer_of(RESULTS[holds]()).findings.codes
    assert code not in answer_of(RESULTS[holds_not]()).findings.codes
    assert explain(code)["code"] == code


@pytest.mark.parametrize("name", RESULTS)
def test_an_answer_is_short_has_rows_figures_and_a_next_step(name):
    result = RESULTS[name]()
    answer = answer_of(result)
    assert len(str(answer.verdict).split()) <= 25 and 2 <= len(answer.lines) <= 12
    assert all(len(line.cells) == len(answer.headings) for line in answer.lines)
    first = "coils" if answer.motion.cycles else "space-time" if name == "silent" else "decay"
    assert next(iter(figures_of(answer))) == first and answer.next_step
    assert "<table>" in result._repr_html_() and result.plot().data
    json.dumps([one.to_dict() for one in replace(answer, words=Words()).findings])


def test_the_verdict_on_a_model_is_the_coil_that_is_furthest_off_and_names_its_file():
    found = answer_of(model(0.5)).verdict
    shares = model(0.5).apart / model(0.5).peaks
    coil = 1 + int(np.argmax(np.where(model(0.5).peaks > 0.05 * model(0.5).peaks.max(), shares, 0)))
    assert found.fields["coil"] == str(coil) and found.value == model(0.5).apart[coil - 1]
    assert f"displacement-coil-{coil}.csv --model multi-mass --shared " in found.step


def test_the_next_step_states_the_error_of_the_film():
    """The place of a coil, the scale as it was picked, and in full what fewer than 2.5 frames show a cycle of."""
    motion = made.turning_motion()
    place = 1e3 * float(np.nanmedian(motion.spread)) * motion.metres_per_pixel
    scale = 100 * motion.scale_spread / motion.metres_per_pixel
    assert shared_errors(FilmFacts(motion, model(0.01))).startswith(
        f"{place:.2g} mm, {scale:.2g} %"
    )
    fast = with_lines((900.0, 1e-3), (400.0, 1e-4))
    assert shared_errors(FilmFacts(fast)).startswith("1 mm")


def test_a_report_has_the_files_and_a_page(tmp_path):
    files = made.turning_motion().report(tmp_path)
    assert {path.name for path in files.data} >= {"tracks.csv", "peaks.csv", "displacement-coil-6.csv"}  # fmt: skip
    assert files.page.stat().st_size < 2.3e6
