"""Golden: small motions of every spring model and every kind of train, all they tell in sums; run
this file to write them anew.

Forces, energies and limits of the models are held to formulas elsewhere (``tests/contracts``,
``tests/limits``); here nothing that a
model or a train tells may move unsaid. Motions are short and smooth, so that rounding stays far
below the room that is left.
"""

from __future__ import annotations

import dataclasses
import sys
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[1]))

from known_sums import read, same, sums, write
from spring_parts import MODELS, drive, raised_cosine
from train_parts import KINDS, contacts, system
from valvetrain.integrate.train_run import TrainOptions, runner
from valvetrain.parameters.train import ContactParameters, SupportParameters, ValveParameters
from valvetrain.quantities.kinematics import rigid_table

KEPT = Path(__file__).parent / "motion_sums.json"
POINT = {"contact_stiffness": 3e9, "restitution": 0.7, "exponent": 1.5}
LAWS = {
    "linear": ContactParameters("linear", {"contact_stiffness": 3e7, "damping": 300.0}),
    "hertz-point": ContactParameters("hertz-point", {"contact_stiffness": 3e9, "damping": 500.0}),
    "hertz-line": ContactParameters("hertz-line", {"contact_stiffness": 1.2e8, "damping": 200.0}),
    "hunt-crossley": ContactParameters("hunt-crossley", POINT),
    "lankarani-nikravesh": ContactParameters("lankarani-nikravesh", POINT),
    "flores": ContactParameters("flores", POINT),
    "impact": ContactParameters(
        "impact",
        {"contact_stiffness": 3e9, "exponent": 1.5, "damping": 4992.0, "full_damping_depth": 2e-5},
    ),
}
#: Laws whose train goes through its lash: the others rattle there, which leaves of rounding what
#: differs from processor to processor.
LASHED = ("linear", "hunt-crossley", "lankarani-nikravesh")
RUBS = {
    "direct": ("cam",),
    "finger": ("cam", "valve_tip"),
    "rocker": ("valve_tip",),
    "pushrod": ("cam", "valve_tip"),
}


def tree(found: Any) -> Any:
    """Numbers and arrays of an object's fields in sums; what is not made of numbers is left out."""
    if dataclasses.is_dataclass(found):
        found = {one.name: getattr(found, one.name) for one in dataclasses.fields(found)}
    elif hasattr(found, "_asdict"):
        found = found._asdict()
    if isinstance(found, dict):
        return {str(key): told for key, value in found.items() if (told := tree(value)) is not None}
    if isinstance(found, (float, int, np.floating, np.integer)):
        return float(found)
    if isinstance(found, (np.ndarray, tuple, list)):
        try:
            return sums(found)
        except (TypeError, ValueError):
            return None
    return None


def spring(name: str) -> dict[str, Any]:
    """A model at rest, along a short event, and what it tells at its end."""
    model = MODELS[name]
    time_step = min(1e-5, 0.8 * model.stable_time_step())
    displacement, velocity = raised_cosine(6e-3, 4e-3, time_step)
    half = len(displacement) // 2 + 20
    told: dict[str, Any] = {
        "parameters": sums(model.parameters()),
        "integers": sums(model.integers()),
        "unknowns": float(model.unknowns),
        "stable step": model.stable_time_step(),
        "retainer mass": model.retainer_mass(),
    }
    state = model.initial_state(0.0)
    told["at rest"] = tree(model.energy(state, 0.0))
    told["static"] = sums([model.force(model.initial_state(x), x) for x in (0.0, 1e-3, 4e-3)])
    told["forces"] = sums(drive(model, state, displacement[:half], velocity[:half], time_step))
    told["tangent"] = float(model.tangent(state, displacement[half]))
    told["energy"] = tree(model.energy(state, displacement[half], velocity[half], time_step))
    told["energy between"] = tree(model.energy(state, displacement[half]))
    told["outputs"] = tree(model.outputs(state, displacement[half], velocity[half]))
    told["force"] = sums(model.force(state, displacement[half], velocity[half]))
    watch = model.contact_watch() if hasattr(model, "contact_watch") else None
    if watch is not None:
        told["watched"] = sums(
            watch.places
            if hasattr(watch, "places")
            else watch[0]
            if isinstance(watch, tuple)
            else []
        )
    return told


def train(kind: str, law: str) -> dict[str, Any]:
    """A cycle of every model of one kind of train, its law at every place, and its rigid table."""
    told: dict[str, Any] = {}
    for model in ("planar", "lumped", "single-mass"):
        changes: dict[str, Any] = {
            "model": model,
            "contacts": contacts(LAWS[law]),
            "lash": 5e-5 if law in LASHED else 0.0,
        }
        if model == "planar":
            changes["valve"] = ValveParameters(
                0.1, stem_stiffness=1e8, stem_damping=100.0, damping=3.0, friction=2.0
            )
            changes["support"] = None if kind == "direct" else SupportParameters(5e7, 0.1, 200.0)
        if law == "linear" and model == "planar":
            rough = dataclasses.replace(LAWS[law], friction_coefficient=0.1, friction_velocity=0.02)
            changes["contacts"] = contacts(LAWS[law]) | dict.fromkeys(RUBS[kind], rough)
        train = KINDS[kind](**changes)
        built = system(train)
        ready = runner(built, 180.0, TrainOptions(samples=360))
        state, record = ready.cycle(ready.initial_state())
        told |= {f"{model}: {key}": value for key, value in tree(record).items()}
        told |= {f"{model}: at the end, {key}": value for key, value in tree(state).items()}
        told[f"{model}: masses"] = sums(built.masses)
        told[f"{model}: step"] = float(ready.time_step)
        if law == "linear" and model == "planar":
            table = rigid_table(built, train, 180.0, samples=180)
            told |= {f"rigid: {key}": value for key, value in tree(table).items()}
    return told


NAMES = [
    *MODELS,
    *(
        f"{kind}, {law}"
        for kind in KINDS
        for law in LAWS
        if law == "linear" or kind in ("direct", "finger")
    ),
]


@cache
def told(name: str) -> dict[str, Any]:
    return spring(name) if name in MODELS else train(*name.split(", "))


@pytest.mark.parametrize("name", NAMES)
def test_a_motion_is_what_it_was(name):
    assert not same(told(name), read(KEPT)[name], 1e-5)


if __name__ == "__main__":
    write(KEPT, {name: told(name) for name in NAMES})
