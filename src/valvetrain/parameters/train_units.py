"""Annotated quantities that only the [train] table needs."""

from __future__ import annotations

from typing import Annotated

from valvetrain.parameters.schema_types import quantities, quantity

Damping = Annotated[float, quantity("damping", low=0.0)]
Inertia = Annotated[float, quantity("moment of inertia", low=0.0, open_low=True)]
NotNegativeMass = Annotated[float, quantity("mass", low=0.0)]
Friction = Annotated[float, quantity("force", low=0.0)]
Torque = Annotated[float, quantity("moment", low=0.0)]
LeverRatio = Annotated[float, quantity("ratio", low=0.1, high=10.0)]
Pair = Annotated[tuple[float, ...], quantities("length")]
Gravity = Annotated[tuple[float, ...], quantities("acceleration")]
Forces = Annotated[tuple[float, ...], quantities("force")]
