"""
How slender may a spring be before it buckles?
==============================================

A long spring gives way to the side. The closed formula of Haringx, as in EN 13906-1, tells the
compression at which it does, by slenderness
and by how its ends are held.
"""

import numpy as np
import plotly.graph_objects as go

import valvetrain as vt

slenderness = np.linspace(2.0, 8.0, 241)
figure = go.Figure()
for words, coefficient in (
    ("both ends fixed", 0.5),
    ("one end hinged", 0.7),
    ("both ends hinged", 1.0),
):
    share = np.array(
        [
            vt.quantities.buckling_compression(
                0.022 * one, "22 mm", seating_coefficient=coefficient
            )
            / (0.022 * one)
            for one in slenderness
        ]
    )
    share[np.isinf(share)] = np.nan
    figure.add_scatter(x=slenderness, y=100 * share, name=words)
    print(f"{words}: never below a slenderness of {slenderness[np.isfinite(share)][0]:.1f}")

# %%
# Valve springs have a slenderness of about 2: they stand.

figure.update_layout(title="Compression at which a spring buckles")
figure.update_xaxes(title="free length over mean diameter (1)")
figure.update_yaxes(title="compression over free length (%)")
