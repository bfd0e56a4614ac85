"""Solid finite elements of a coil spring: swept mesh, Abaqus/CalculiX deck, runs with ``ccx`` and
their results.
"""
