"""
How much does a contact give back?
==================================

A valve of 100 g meets its seat at 0.5 m/s. Force over penetration is a loop, and the area inside it
is what the contact takes out of the
motion. Three laws of equal stiffness, all asked for a coefficient of restitution of 0.7.
"""

import plotly.graph_objects as go
from scipy.integrate import solve_ivp

import valvetrain as vt

MASS, APPROACH = 0.1, 0.5  # kg, m/s


def bounce(law):
    """Penetration (m), force (N) and what is left of the approach velocity."""

    def motion(time, state):
        return [state[1], -float(law.force(state[0], state[1], APPROACH)) / MASS]

    def leaves(time, state):
        return state[0] if time > 1e-7 else 1.0

    leaves.terminal, leaves.direction = True, -1
    found = solve_ivp(
        motion, (0, 2e-3), [0.0, APPROACH], rtol=1e-8, atol=1e-12, max_step=2e-6, events=leaves
    )
    return found.y[0], law.force(found.y[0], found.y[1], APPROACH), -found.y[1][-1] / APPROACH


figure = go.Figure()
for name in ("hertz-point", "lankarani-nikravesh", "flores"):
    loss = {} if name == "hertz-point" else {"restitution": 0.7}
    law = vt.contact.build_contact_law(name, contact_stiffness="2e9 N/m^1.5", **loss)
    penetration, force, kept = bounce(law)
    figure.add_scatter(x=1e6 * penetration, y=1e-3 * force, name=name)
    print(f"{name:20s} keeps {kept:.2f} of the approach velocity")

# %%
# Lankarani and Nikravesh derived their law for values near 1; at 0.7 it keeps more than it was
# asked for.

figure.update_layout(title="A mass of 100 g on its seat")
figure.update_xaxes(title="penetration (um)")
figure.update_yaxes(title="force (kN)")
