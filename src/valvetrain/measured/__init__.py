"""Measured data that lift laws and tools share: tables, lift files, cycles over the cam angle,
sensors.
"""
