"""
How firm are rate and preload from a spring tester?
===================================================

A spring tester gives forces at heights, each with some noise. The fit finds the spring behind the
table and the intervals that the noise
leaves. The table here is made up, so that the truth is known: 40 N/mm from 55 mm on.
"""

import numpy as np
import plotly.graph_objects as go

import valvetrain as vt

heights = np.linspace(50e-3, 40e-3, 9)
forces = (
    40e3 * (55e-3 - heights) * (1 + 2e-3 * np.random.default_rng(1).standard_normal(len(heights)))
)
table = vt.measured.ForceHeight(heights, forces)
card = vt.spring_card.card_from_table(table, wire_diameter="4.2 mm", outer_diameter="30.2 mm")

found = vt.spring_card.spring_from_tester(table, card, installed_height=46e-3)
(rate, rate_deviation), (preload, preload_deviation) = found.rate, found.preload
print(
    f"rate {1e-3 * rate:.1f} N/mm, standard deviation {1e-3 * rate_deviation:.1f} N/mm (true: 40)"
)
print(f"preload at 46 mm {preload:.0f} N, standard deviation {preload_deviation:.1f} N (true: 360)")

# %%
# Forces of the table, and of the finite-element rod with the pitch that was found.

figure = go.Figure()
figure.add_scatter(x=1e3 * found.wire.by_rod[:, 0], y=found.wire.by_rod[:, 2], name="rod")
figure.add_scatter(
    x=1e3 * found.wire.by_rod[:, 0], y=found.wire.by_rod[:, 1], mode="markers", name="table"
)
figure.update_layout(title="A table of a spring tester and the spring behind it")
figure.update_xaxes(title="height (mm)")
figure.update_yaxes(title="force (N)")
