"""The channels of docs/architecture.md are those of the runs: each where the table says, and none
beside them.
"""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from valvetrain import registry
from valvetrain.parameters.loading import load_case
from valvetrain.runs.api import simulate
from valvetrain.solution.result import Solution
from valvetrain.springs.spec import spring_model

PAGE = Path(__file__).parents[2] / "docs" / "architecture.md"
SPEED = 4000 * np.pi / 30
ALONE = {
    "finite elements under prescribed motion": "finite-element",
    "modal-varied under prescribed motion": "modal-varied",
}
#: Of solids, which are run in their own tests.
SOLIDS = "solid finite elements"
SYSTEMS = {"both", "trains", "prescribed motion", SOLIDS, *ALONE}


def promised() -> dict[str, str]:
    """Channel -> systems, from the table of the page; patterns left out."""
    rows = [
        line.strip("|").split(" | ")
        for line in PAGE.read_text(encoding="utf-8").split("## Channels")[1].splitlines()
        if line.startswith("| `")
    ]
    found = {name: row[-1].strip(" |") for row in rows for name in re.findall(r"`(\w+)`", row[0])}
    assert set(found.values()) <= SYSTEMS
    return found


@cache
def runs(case: str) -> tuple[Solution, ...]:
    """One coarse run by every model that moves in every system."""
    models = {word: spring_model(word) for word in registry.names("springs")}
    words = [word for word, one in models.items() if not (one.no_motion or one.alone)]
    key = "spring" if case == "job-c" else "train.springs.nested.{}"
    coarse = {
        f"{key.format(place)}.options.finite-element.elements_per_coil": 6
        for place in (0, 1)[: 1 if case == "job-c" else 2]
    }
    loaded = load_case(
        case,
        coarse
        | (
            {"spring.guide.bore": "40 mm", "operation.cycles": 1}
            if case == "job-c"
            else {"train.cycles": 1}
        ),
    )
    return simulate(loaded, engine_speeds=[SPEED], models=words, workers=1).solutions


def shown(run: Solution) -> set[str]:
    """Names of a run's channels, those of a pair without the name of their spring."""
    pair = r"^(outer|inner)_" if len(run.springs) > 1 else r"^$"
    return {re.sub(pair, "", str(name)) for name in run.channels.data_vars}


def test_every_promised_channel_is_where_the_table_says():
    prescribed, trains = (set().union(*map(shown, runs(case))) for case in ("job-c", "vaz-ohc"))
    for name, systems in promised().items():
        where = {
            "both": name in prescribed and name in trains,
            "trains": name in trains and name not in prescribed,
            "prescribed motion": name in prescribed and name not in trains,
            SOLIDS: name not in prescribed and name not in trains,
        }
        for words, model in ALONE.items():
            having = {run.model for run in runs("job-c") if name in shown(run)}
            where[words] = having == {model} and name not in trains
        assert where[systems], (name, systems)


@pytest.mark.parametrize("case", ["job-c", "vaz-ohc"])
def test_every_channel_of_a_run_stands_in_the_table_with_its_unit(case):
    known = set(promised())
    for run in runs(case):
        for name in shown(run):
            assert name in known or re.fullmatch(
                r"\w+_(contact_force|gap|force|moment|displacement|angle)", name
            ), (run.label, name)
        for channel in run.channels.data_vars.values():
            assert (
                channel.dims[0] == "sample"
                and channel.attrs["units"]
                and channel.attrs["long_name"]
            )


def test_motion_of_the_retainer_is_in_every_run_and_its_derivatives_agree():
    for run in (*runs("job-c"), *runs("vaz-ohc")):
        time, velocity = run.time, run.channel("retainer_velocity")
        slope = np.gradient(run.channel("valve_lift"), time)
        assert slope == pytest.approx(velocity, abs=0.03 * np.max(np.abs(velocity))), run.label
        if run in runs("job-c"):
            bend = np.gradient(velocity, time)[2:-2]
            acceleration = run.channel("retainer_acceleration")
            assert bend == pytest.approx(
                acceleration[2:-2], abs=0.03 * np.max(np.abs(acceleration))
            ), run.label
        else:
            assert run.has("retainer_acceleration")
