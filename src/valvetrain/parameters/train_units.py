"""Annotated quantities that only the [train] table needs."""

from __future__ import annotations

from valvetrain.parameters.schema_types import quantities, quantity

Damping = quantity("damping", low=0.0)
Inertia = quantity("moment of inertia", low=0.0, open_low=True)
NotNegativeMass = quantity("mass", low=0.0)
Friction = quantity("force", low=0.0)
Torque = quantity("moment", low=0.0)
Pair = quantities("length")
Gravity = quantities("acceleration")
Forces = quantities("force")
