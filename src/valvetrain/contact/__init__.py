"""Contact laws: penetration and its rate to force, tangent and dissipated power."""
