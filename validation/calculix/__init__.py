"""Solid finite elements of a wire at rest and in motion by CalculiX: an independent program beside our own."""
