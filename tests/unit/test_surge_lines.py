"""Surge lines of a decay: frequency and damping of damped sines, and no line that grows or has no amplitude."""

from __future__ import annotations

import numpy as np
import pytest

from valvetrain.film.surge import fit_surge

RATE, FRAMES = 2000.0, np.arange(161.0)


def decay(natural=127.38, damping=0.0312, size=5e-4):
    """Three coils that move with other amplitudes, and three that rest; scatter of half a micrometre."""
    time, omega = FRAMES / RATE, 2 * np.pi * natural
    wave = np.exp(-damping * omega * time) * np.cos(omega * np.sqrt(1 - damping**2) * time)
    still = np.random.default_rng(4).normal(0.0, 0.5e-6, (len(time), 6))
    return still + size * np.outer(wave, [1.0, 0.9, 0.8, 0.0, 0.0, 0.0])


def fitted(moved):
    return fit_surge(moved, [np.arange(len(moved))], RATE)


def repeated(moved):
    return np.concatenate([moved[:-1], moved[-2:-1]])


def jumped(moved):
    return moved + np.where(FRAMES == FRAMES[-1], 2e-5, 0.0)[:, None]


@pytest.mark.parametrize("damage", [repeated, jumped], ids=["last frame twice", "last frame off"])
def test_a_damaged_last_frame_makes_no_line(damage):
    (line,) = fitted(damage(decay())).lines
    assert line.natural_frequency == pytest.approx(127.38, rel=1e-3)
    assert line.damping_ratio == pytest.approx(0.0312, rel=0.01)
    wave = 5e-4 * np.sqrt(np.mean([1.0, 0.81, 0.64, 0.0, 0.0, 0.0]))
    assert line.amplitude == pytest.approx(wave, rel=0.02)


def test_two_lines_are_found_and_scatter_alone_is_none():
    lines = fitted(decay() + decay(411.0, 0.012, 5e-5)).lines
    assert [one.natural_frequency for one in lines] == pytest.approx([127.38, 411.0], rel=1e-3)
    assert fitted(decay(size=0.0)) is None


def test_a_line_that_does_not_fall_has_no_damping_and_one_that_grows_is_none():
    (line,) = fitted(decay(damping=0.0)).lines
    assert 0 <= line.damping_ratio < 1e-4
    assert fitted(decay()[::-1]) is None
