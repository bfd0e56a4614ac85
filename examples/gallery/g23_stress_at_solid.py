"""
How far is the wire stressed when the coils close?
==================================================

Shear at the inside of the coil by EN 13906-1: with the valve closed, at the largest lift,
and with all coils closed. A spring
that may be closed solid must bear the last of the three.
"""

import plotly.graph_objects as go

import valvetrain as vt

study = vt.simulate("gu2021-beehive-blind", "4200 rpm", models=["multi-mass"], workers=1)
moving = study.solution("multi-mass").quantities
stress = {
    "valve closed": moving["closed_nominal_shear_stress"],
    "largest lift": moving["open_nominal_shear_stress"],
    "coils closed": study.quantities["solid_nominal_shear_stress"],
}
for state, value in stress.items():
    print(f"{state}: {1e-6 * value:.0f} MPa")

# %%
# At rest the stress goes from the first to the second and back in every turn of the cam. In motion
# waves add to it: finite elements and reduced rods give the stress of the wire itself.

figure = go.Figure(go.Bar(x=list(stress), y=[1e-6 * value for value in stress.values()]))
figure.update_layout(title="Largest shear stress of the beehive spring", showlegend=False)
figure.update_xaxes(title="state")
figure.update_yaxes(title="shear stress (MPa)")
