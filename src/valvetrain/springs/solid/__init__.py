"""Solid finite elements of a coil spring in motion: bricks along the wire, as a spring model."""
