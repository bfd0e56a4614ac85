"""Unit: modes followed by their shapes, through a crossing and a veering known in closed form, and those of
a train from the closed valve to full lift.
"""

from __future__ import annotations

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from valvetrain.cli.main import app
from valvetrain.parameters.loading import load_case
from valvetrain.parameters.templates import TEMPLATES
from valvetrain.runs.train_runs import train_modes
from valvetrain.system.mode_tracking import continued


def pair(detuning: float, coupling: float) -> tuple[np.ndarray, np.ndarray]:
    """Two oscillators whose frequencies cross at a detuning of zero."""
    return np.linalg.eigh(np.array([[1.0 + detuning, coupling], [coupling, 1.0 - detuning]]))


def test_two_modes_that_cross_keep_their_names_and_those_that_veer_change_them():
    """Closed form: uncoupled, each shape stays as its frequency passes the other's; coupled and in small
    steps, the branches keep their order and exchange their shapes.
    """
    from_mode, overlap = continued(pair(-0.3, 0.0)[1], pair(0.3, 0.0)[1])
    assert from_mode.tolist() == [1, 0] and overlap == pytest.approx(1.0)
    order, before = np.arange(2), pair(-0.3, 0.1)[1]
    for detuning in np.linspace(-0.25, 0.3, 12):
        after = pair(float(detuning), 0.1)[1]
        step, overlap = continued(before, after)
        order, before = order[step], after
        assert overlap.min() > 0.7
    assert order.tolist() == [0, 1]


def test_the_overlap_is_the_squared_cosine_of_the_angle_that_shapes_turn():
    turn = np.radians(20.0)
    shapes = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    from_mode, overlap = continued(np.eye(2), shapes)
    assert from_mode.tolist() == [0, 1] and overlap == pytest.approx(np.cos(turn) ** 2)


def test_the_mode_of_a_train_goes_past_surge_as_the_seat_opens():
    """The lists were sorted by frequency alone; surge modes keep theirs within 3 %, the third, next to
    the mode of the train, within 5 % above: two modes that meet push each other apart."""
    closed, lifted = train_modes(load_case(str(TEMPLATES / "pushrod.toml")), spring_sets="card")
    assert not closed.closed_mode and sorted(lifted.closed_mode) == list(range(len(lifted.closed_mode)))  # fmt: skip
    assert lifted.closed_mode[:9] == (0, 1, 7, 2, 3, 4, 5, 6, 8)
    assert lifted.overlap[2] == min(lifted.overlap[:9]) < 0.5 and lifted.overlap[0] > 0.99
    for place in (0, 1, 4, 5, 6, 7, 8):
        before = closed.natural_frequency[lifted.closed_mode[place]]
        assert lifted.natural_frequency[place] == pytest.approx(before, rel=0.03)
    assert 1 < lifted.natural_frequency[3] / closed.natural_frequency[2] < 1.05


def test_the_command_tells_the_branch_of_each_mode_at_full_lift():
    words = ["modes", str(TEMPLATES / "pushrod.toml"), "--spring-set", "card", "--count", "5"]
    closed, lifted = json.loads(CliRunner().invoke(app, [*words, "--json"]).stdout)["train_modes"]
    assert "closed_mode" not in closed["modes"][0]
    assert [one["closed_mode"] for one in lifted["modes"]] == [1, 2, 8, 3, 4]
