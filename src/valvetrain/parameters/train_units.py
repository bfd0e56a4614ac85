"""Annotated quantities that only the [train] table needs."""

from __future__ import annotations

from typing import Annotated

from valvetrain.parameters.schema_types import LARGEST_MASS, quantities, quantity

#: Moments of inertia (kg m2) beyond this are slips, as masses beyond theirs.
LARGEST_INERTIA = 1e2
Damping = Annotated[float, quantity("damping", low=0.0)]
Inertia = Annotated[float, quantity("moment of inertia", low=0.0, high=LARGEST_INERTIA, open_low=True)]
NotNegativeMass = Annotated[float, quantity("mass", low=0.0, high=LARGEST_MASS)]
Friction = Annotated[float, quantity("force", low=0.0)]
Torque = Annotated[float, quantity("moment", low=0.0)]
LeverRatio = Annotated[float, quantity("ratio", low=0.1, high=10.0)]
Pair = Annotated[tuple[float, ...], quantities("length")]
Gravity = Annotated[tuple[float, ...], quantities("acceleration")]
Forces = Annotated[tuple[float, ...], quantities("force")]
