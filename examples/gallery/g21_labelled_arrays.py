"""
How do I get at the numbers behind a figure?
============================================

The channels of a run are an xarray dataset with names, units and coordinates. They can be selected
by coil and by time, saved as NetCDF
and read back bit for bit.
"""

import tempfile
from pathlib import Path

import numpy as np
import plotly.graph_objects as go

import valvetrain as vt

run = vt.simulate("job-t", "3000 rpm", models=["multi-mass"], workers=1).solutions[0]

with tempfile.TemporaryDirectory() as folder:
    vt.solution.save_netcdf(run, Path(folder, "run.nc"))
    again = vt.solution.load_netcdf(Path(folder, "run.nc"))
print("read back equal:", run.identical(again))

# %%
# The motion of every third of the wire, from the seat up.

motion = run.channels["axial_displacement"]
print(f"channel of shape {motion.shape}, unit {motion.attrs['units']}")
places = np.linspace(0, motion.shape[1] - 1, 5).astype(int)[1:]
figure = go.Figure()
for place in places:
    number = float(motion.coords["coil_number"][place])
    figure.add_scatter(
        x=np.degrees(run.cam_angle - run.cam_angle[0]),
        y=1e3 * motion.values[:, place],
        name=f"turn {number:.1f}",
    )
figure.update_layout(title="Motion along the wire at 3000 rpm")
figure.update_xaxes(title="cam angle (deg)")
figure.update_yaxes(title="displacement (mm)")
