"""Solid bricks: the swept mesh of a wire, its elements, contact, statics, modes and explicit motion."""
