"""
May I give inches, pounds and pint quantities?
==============================================

Everywhere. A number without a unit is SI; a text with a unit and a quantity of the package pint are
as good. A slip of units is refused
with its likely meaning.
"""

import plotly.graph_objects as go
from pint import UnitRegistry

import valvetrain as vt

units = UnitRegistry()
spring = vt.parameters.SpringDefinition(
    wire_diameter=0.177 * units.inch,
    mean_diameter="1.2 inch",
    pitch=9e-3,
    total_coils=6.5,
    material="OTEVA 90 SC",
    name="imperial",
)
curve = vt.static_curve(spring, 0.5 * units.inch, models="multi-mass")
load = curve.force_at("0.4 in")
print(f"{load:.0f} N = {load / 4.4482216:.0f} lbf at 0.4 in")

try:
    vt.parameters.SpringDefinition(
        wire_diameter=4.5,
        mean_diameter="30 mm",
        pitch="9 mm",
        total_coils=6.5,
        material="OTEVA 90 SC",
    )
except vt.InputError as error:
    print(error)

# %%
# The curve in the units of the drawing.

figure = go.Figure(
    go.Scatter(x=curve.compression / 25.4e-3, y=curve.force / 4.4482216, name="force")
)
figure.update_layout(title="A spring in inches and pounds", showlegend=False)
figure.update_xaxes(title="compression (in)")
figure.update_yaxes(title="force (lbf)")
