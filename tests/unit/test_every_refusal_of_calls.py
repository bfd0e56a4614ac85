"""What functions refuse of the springs, runs and numbers they are given, each alternative alone,
with the words that name it.
"""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from validation.calculix.solver import run_deck

import synthetic_study as made
import valvetrain as vt
from valvetrain.cam.closed_form import SinePower
from valvetrain.parameters.installed_spring import InstalledSpring, SpringCard
from valvetrain.quantities.cycle import Cycle, reported_cycle
from valvetrain.solution.channels import Variable, spring_channels
from valvetrain.solution.netcdf import load_netcdf
from valvetrain.springs.chain_layout import ChainLayout, chain_from_definition, check_masses
from valvetrain.springs.spec import spring_model
from valvetrain.springs.stress import shear_stress_factor
from valvetrain.springs.wire_from_card import wire_from_card
from valvetrain.views.files import UnfinishedRun

SPRING = vt.parameters.cylindrical("3.8 mm", "22 mm", "7 mm", total_coils=7)
CARD = SpringCard(rate=30e3, preload=250.0)
VARIED = vt.springs.ModalVaried((450.0,), 0.01, (1e-3, 0.02), (40.0, 800.0), 5e-3)
LAW = SinePower(maximum_lift=9e-3, opening_start=1.0, closing_end=3.0)
RUN = made.rod_run()
CHAIN = {
    "stiffness": np.ones(3),
    "masses": np.ones(2),
    "coil_number": np.zeros(4),
    "seat_mass": 0.1,
    "retainer_mass": 0.1,
}


def channels(**change: Variable | None):
    """The run's channels with others in their place, or without them."""
    coords = {
        name: item
        for name, item in (dict(RUN.arrays.coords) | change).items()
        if item is not None and name in RUN.arrays.coords
    }
    added = {
        name: item
        for name, item in change.items()
        if item is not None and name not in RUN.arrays.coords
    }
    return replace(
        RUN,
        channels=replace(RUN.arrays, coords=coords, variables=dict(RUN.arrays.variables) | added),
    )


def cut(run: vt.Solution, count: int):
    """The first samples of a run."""
    kept = {
        kind: {
            name: Variable(
                one.dims,
                one.values[:count] if one.dims[:1] == ("sample",) else one.values,
                one.attrs,
            )
            for name, one in getattr(run.arrays, kind).items()
        }
        for kind in ("coords", "variables")
    }
    return replace(run.arrays, **kept)


CALLS = {
    "card without mass, bar": (lambda: vt.springs.EquivalentSpring.from_card(CARD), "gives no mass"),
    "card without mass, wire": (lambda: wire_from_card(CARD, 0.01), "has no mass on its card"),
    "factor": (lambda: shear_stress_factor("wahle", 6.0), "is unknown"),
    "fibre": (lambda: shear_stress_factor("wahl", 6.0, "middle"), "use inner or outer"),
    "index": (lambda: shear_stress_factor("wahl", [6.0, 1.0]), "a spring index of 1 has no coil"),
    "time limit": (lambda: run_deck("", time_limit=0.0), "runs nothing"),
    "threads": (lambda: run_deck("", threads=0), "at least 1 thread"),
    "two elements": (lambda: chain_from_definition(SPRING, 1, 0.0), "a chain of 1 elements"),
    "one element": (lambda: ChainLayout(**CHAIN | {"stiffness": np.ones(1), "masses": np.zeros(0)}), "at least two elements"),
    "soft element": (lambda: ChainLayout(**CHAIN | {"stiffness": np.array([1.0, 0.0, 1.0])}), "must be positive"),
    "light mass": (lambda: ChainLayout(**CHAIN | {"masses": np.array([1.0, 0.0])}), "must be positive"),
    "cells": (lambda: replace(vt.springs.WaveRodWithClash.from_definition(SPRING, 5e-3), cells=2), "has 2 cells"),
    "preload": (lambda: check_masses("one", -1.0, 0.1, 0.3, 0.1), "preload of spring 'one' is -1.0 N"),
    "active mass": (lambda: check_masses("one", 1.0, -0.1, 0.3, 0.1), "mass of spring 'one' is -0.1 kg"),
    "inactive mass": (lambda: check_masses("one", 1.0, 0.1, 0.3, -0.1), "fixed ends -0.1 kg"),
    "fraction below": (lambda: check_masses("one", 1.0, 0.1, -0.1, 0.1), "between 0 and 1"),
    "fraction above": (lambda: check_masses("one", 1.0, 0.1, 1.1, 0.1), "between 0 and 1"),
    "few lifts": (lambda: VARIED.solve(np.zeros(15), 100.0), "at least 16 finite numbers"),
    "flat lifts": (lambda: VARIED.solve(np.zeros((4, 16)), 100.0), "a row of at least"),
    "lost lift": (lambda: VARIED.solve(np.full(16, math.nan), 100.0), "finite numbers"),
    "no speed": (lambda: VARIED.solve(np.zeros(16), 0.0), "cam_speed"),
    "beyond the curve": (lambda: VARIED.secant_stiffness(0.021), "curve"),
    "before the curve": (lambda: VARIED.secant_stiffness(0.5e-3), "curve"),
    "no rest": (lambda: spring_model("modal-varied").build(InstalledSpring(wire=SPRING, precompression=5e-3)), "static curve and modes"),
    "no steps": (lambda: vt.static_curve(SPRING, spring_model="massless", largest_compression=5e-3, steps=0), "whole number of steps"),
    "two springs": (lambda: vt.static_curve("vaz-ohc", spring_model="massless", largest_compression=5e-3), "holds 4 springs .*outer"),
    "rod, no steps": (lambda: vt.springs.FiniteElementRod(SPRING, 5e-3, 6).static_curve(5e-3, 0), "one step or more"),
    "rod, no way": (lambda: vt.springs.FiniteElementRod(SPRING, 5e-3, 6).static_curve(0.0), "positive compression"),
    "rod, no mode": (lambda: vt.springs.FiniteElementRod(SPRING, 5e-3, 6).modes(0), "one mode or more"),
    "rod, negative mass": (lambda: vt.springs.FiniteElementRod(SPRING, 5e-3, 6).modes(1, -0.1), "zero or more"),
    "one sample": (lambda: reported_cycle(RUN.reduced()), "fewer than two samples"),
    "one sample alone": (lambda: reported_cycle(replace(RUN, channels=cut(RUN, 1))), "fewer than two samples"),
    "unknown channel": (lambda: spring_channels(RUN.time, RUN.cam_angle, {"seat_forse": RUN.time}), "'seat_forse' is not declared"),
    "no time": (lambda: channels(time=None), "needs the coordinate 'time'"),
    "time of something else": (lambda: channels(cam_angle=Variable(("turn",), np.zeros(3), {})), "needs the coordinate 'cam_angle'"),
    "channel of nothing": (lambda: channels(mine=Variable((), np.zeros(()), {"units": "", "long_name": ""})),
                           "'mine' .* must have 'sample'"),
    "channel across": (lambda: channels(mine=Variable(("x", "sample"), np.zeros((1, len(RUN.time))), {"units": "", "long_name": ""})),
                       "must have 'sample' as its first"),
    "channel without unit": (lambda: channels(mine=Variable(("sample",), RUN.time, {"long_name": ""})), "lacks the attribute 'units'"),
    "channel without words": (lambda: channels(mine=Variable(("sample",), RUN.time, {"units": ""})), "lacks the attribute 'long_name'"),
    "channel without either": (lambda: channels(mine=Variable(("sample",), RUN.time, {})), "lacks the attribute 'units'"),
}  # fmt: skip


@pytest.mark.parametrize("name", CALLS)
def test_a_call_is_refused_in_words(name):
    call, words = CALLS[name]
    with pytest.raises(vt.InputError, match=words) as refusal:
        call()
    assert len(str(refusal.value)) > 20


def test_what_is_within_is_taken():
    check_masses("one", 0.0, 0.0, 0.0, 0.0)
    check_masses("one", 1.0, 0.1, 1.0, 0.1)
    assert VARIED.secant_stiffness(0.02) == pytest.approx(40e3) and channels().has("seat_force")
    assert isinstance(reported_cycle(RUN), Cycle)


def test_runs_that_are_kept_as_they_come_are_found_and_go_with_the_rest(tmp_path):
    kept, run, other = UnfinishedRun(lambda: tmp_path), made.modal_run(), made.rod_run()
    assert kept.file_of(run) is None and kept.folder is None
    kept.finish()
    kept.add(3, run)
    kept.add(7, run.reduced())
    place = kept.file_of(run)
    assert (
        place == tmp_path / "run-0004.nc"
        and place.is_file()
        and kept.file_of(other) is None
        and not kept.gaps.sentences
    )
    rows = [
        json.loads(line)
        for line in (tmp_path / "unfinished-runs.jsonl").read_text(encoding="utf-8").splitlines()
    ]
    assert [row.get("file") for row in rows] == ["run-0004.nc", None] and rows[0][
        "label"
    ] == run.label
    assert load_netcdf(place).channel("seat_force") == pytest.approx(run.channel("seat_force"))
    kept.begin(tmp_path / "elsewhere")
    assert kept.file_of(run) is None
    kept.begin(tmp_path)
    kept.finish()
    assert (
        not list(tmp_path.glob("*.nc"))
        and not (tmp_path / "unfinished-runs.jsonl").exists()
        and kept.file_of(run) is None
    )
    kept.finish()


@pytest.mark.parametrize("word", ["massless", "multi-mass"])
def test_the_path_behind_a_curve_reaches_as_far_as_the_curve(word):
    curve = vt.static_curve(SPRING, spring_model=word, largest_compression=8e-3, steps=4)
    assert (
        curve.path is not None
        and curve.path.compression[-1] == pytest.approx(8e-3) == curve.compression[-1]
    )
    assert len(curve.compression) == 5 < len(curve.path.compression)
