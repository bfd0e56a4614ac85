"""
How much speed do a lighter valve and a stronger spring buy?
============================================================

The speed at which the cam of a pushrod train first loses its follower, with springs that surge: as
it is, with a valve a fifth lighter, and with the stronger spring set. Massless springs promise more than
twice as much of a lighter valve (178 rpm) and nearly twice as much of the stronger spring (1819 rpm).
The answer is a bracket: at its lower end a run kept contact, at its upper end one did not.
"""

import numpy as np
import plotly.graph_objects as go

import valvetrain as vt

RPM = np.pi / 30
variants = {
    "as it is": ({}, "stock"),
    "lighter valve": ({"train.valve.mass": "24 g"}, "stock"),
    "stronger spring": ({}, "performance"),
}
speeds = {}
for words, (changes, springs) in variants.items():
    found = vt.critical_speeds(
        vt.load_case("tdi-pushrod", changes),
        "6000:9000:1000 rpm",
        models=["modal-uniform"],
        spring_sets=[springs],
        ranges=False,
        workers=1,
    )
    row = found.of("contact-loss")
    speeds[words] = row.engine_speed / RPM
    print(f"{words}: {speeds[words]:.0f} rpm")

# %%
# Engine speed at which contact is lost first.

figure = go.Figure(go.Bar(x=list(speeds), y=list(speeds.values())))
figure.update_layout(title="First loss of contact", showlegend=False)
figure.update_xaxes(title="train")
figure.update_yaxes(title="engine speed (rpm)")
