"""Figures of a film: coils over the cam angle next to the model, the decay and the space-time picture."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go

from valvetrain.film.cycles import TURN, mean_of
from valvetrain.film.rules import FilmFacts
from valvetrain.views.style import ANGLE, LEAD, RIGID, SECOND, SPEEDS, dots, line, styled

#: Frames and stations of the space-time picture at most, and cam revolutions that it shows.
FRAMES, STATIONS, TURNS = 400, 300, 3.0


def coils(facts: FilmFacts) -> go.Figure | None:
    """Displacement (mm) of every coil over the cam angle, mean of the turns; dashed: the model."""
    motion, model, fig = facts.motion, facts.model, go.Figure()
    if motion.dwell is None:
        return None
    for coil, cycles in enumerate(motion.cycles):
        colour = SPEEDS[coil % len(SPEEDS)]
        mean = 1e3 * mean_of(cycles.values)
        fig.add_trace(line(np.degrees(cycles.cam_angle), mean, f"coil {coil + 1}", colour))
        if model is not None:
            moved = 1e3 * model.displacement[:, coil]
            fig.add_trace(line(np.degrees(model.cam_angle), moved, "model", colour, "dash", showlegend=coil == 0))  # fmt: skip
    first, last = np.degrees(motion.dwell)
    for begin, end in ((first, min(last, 360.0)), (0.0, last - 360.0)):
        if end > begin:
            fig.add_vrect(begin, end, fillcolor=RIGID, opacity=0.2, line_width=0)
    styled(fig, ANGLE, ("displacement towards the seat, mm",), 420)
    return fig.update_xaxes(range=[0, 360], dtick=60)


def decay(facts: FilmFacts) -> go.Figure | None:
    """One decay (mm over ms) as filmed and as fitted, of the coil that rings most."""
    surge = facts.motion.surge
    if surge is None:
        return None
    fig = go.Figure([
        line(1e3 * surge.curve_time, 1e3 * surge.curve, "damped sines fitted", LEAD),
        dots(1e3 * surge.time, 1e3 * surge.measured, f"coil {surge.coil}", SECOND)
    ])  # fmt: skip
    return styled(fig, "time from the beginning of the decay, ms", ("displacement, mm",))


def space_time(facts: FilmFacts) -> go.Figure:
    """Brightness along the line (px) over time (ms) as the camera saw it, with the tracks of the coils."""
    motion, last = facts.motion, min(FRAMES, len(facts.motion.time))
    if motion.phase is not None:
        turned = motion.phase.cam_angle - motion.phase.cam_angle[0]
        last = min(last, max(16, int(np.searchsorted(turned, TURNS * TURN))))
    top = motion.seen.picture.shape[1] - 1
    every = -(-motion.seen.picture.shape[1] // STATIONS)
    picture, time = motion.seen.picture[:last, ::every], 1e3 * motion.time[:last]
    dark, bright = np.percentile(picture, (1, 99.9))
    grey = np.clip(255 * (picture - dark) / max(bright - dark, 1e-9), 0, 255).astype(np.uint8)
    fig = go.Figure(
        go.Heatmap(
            x=time,
            y=top - every * np.arange(grey.shape[1]),
            z=grey.T,
            colorscale="gray",
            showscale=False,
        )
    )
    for coil, place in enumerate((motion.places + motion.drift[:, None])[:last].T):
        fig.add_trace(line(time, top - place, f"coil {coil + 1}", SPEEDS[coil % len(SPEEDS)]))
    return styled(fig, "time, ms", ("from the end of the line, px",), 460)
