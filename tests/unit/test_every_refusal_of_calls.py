"""What functions refuse of the springs, runs and numbers they are given, each alternative alone,
with the words that name it.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from validation.calculix.solver import run_deck

import synthetic_study as made
import valvetrain as vt
from spring_shapes import cylindrical
from valvetrain.parameters.card import SpringCard
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.solution.channels import Variable, spring_channels
from valvetrain.springs.chain_layout import ChainLayout, chain_from_definition, check_masses
from valvetrain.springs.spec import spring_model
from valvetrain.springs.stress import shear_stress_factor
from valvetrain.springs.wire_from_card import wire_from_card

SPRING = cylindrical("3.8 mm", "22 mm", "7 mm", total_coils=7)
CARD = SpringCard(rate=30e3, preload=250.0)
VARIED = vt.springs.ModalVaried((450.0,), 0.01, (1e-3, 0.02), (40.0, 800.0), 5e-3)
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
    "no steps": (lambda: vt.static_curve(SPRING, models="massless", largest_compression=5e-3, steps=0), "whole number of steps"),
    "two springs": (lambda: vt.static_curve("vaz-ohc", models="massless", largest_compression=5e-3), "holds 4 springs .*outer"),
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
