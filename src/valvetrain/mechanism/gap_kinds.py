"""Codes of the gap kinds and the columns of their geometry rows (shared by builders and kernels).

Every interaction of a train has a penetration ``pen`` (m, positive when pressed together) that is a
smooth function of at most four generalised coordinates and the cam angle. A "planar point" is

    X(q0, q1) = origin + support_direction q1 + (R(sign q0) arm  or  arm q0),

the first for a body turning about ``origin``, the second for one sliding along ``arm``.

| kind | penetration |
|---|---|
| LINEAR | ``g0 + g1 q0 + g2 q1 + g3 q2 + g4 q3`` |
| CAM_LIFT | ``g5 table(cam_angle) - g0 - g1 q0 - g2 q1 - g3 q2 - g4 q3`` |
| CAM_FLAT | flat face through X with normal n: ``support_function(chi) - X . n`` |
| CAM_ROUND | arc with centre X: ``(pitch_curve(chi) - |X|) cos(pressure angle)``, exact to first order in the gap |
| POINT_PLANE | arc with centre X pressing on a plane: ``n . (X - X_closed) - g11 q2 - g10`` |
| DISTANCE | bar between X and A = A0 + d q3: ``q2 - q3 - (|X - A| - length) - g13``; without q2 the bar is rigid |

``chi = cam_angle - sense (direction - reference)``: the cam material under a follower at polar
direction ``direction`` at the cam angle ``cam_angle``.
"""

from __future__ import annotations

LINEAR, CAM_LIFT, CAM_FLAT, CAM_ROUND, POINT_PLANE, DISTANCE = range(6)

CAM_KINDS = (CAM_LIFT, CAM_FLAT, CAM_ROUND)
"""Those whose gap follows the cam angle."""

ARC_RADIUS = 14
"""Column of the radius (m) of the touching arc; only sliding needs it."""

GEOMETRY_COLUMNS = 16
"""Columns 0-7 of a planar kind: turning flag, origin x, y, arm x, y, sign, support direction x, y."""

COORDINATES_PER_INTERACTION = 4
