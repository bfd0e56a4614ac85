"""Shares of a spring's mass, and the check that all spring models share."""

from __future__ import annotations

from valvetrain.errors import InputError

#: Share of the wire's mass that moves with the retainer in the static shape (Rayleigh).
RAYLEIGH_FRACTION = 1.0 / 3.0


def check_masses(
    name: str, preload: float, active_mass: float, fraction: float, inactive_mass: float
) -> None:
    """Raise :class:`InputError` for a preload or mass no spring has."""
    if preload < 0:
        raise InputError(
            f"preload of spring '{name}' is {preload} N; give zero or a positive force"
        )
    if active_mass < 0 or inactive_mass < 0:
        raise InputError(
            f"mass of spring '{name}' is {active_mass} kg (fixed ends {inactive_mass} kg); give zero or positive masses"
        )
    if not 0 <= fraction <= 1:
        raise InputError(
            f"effective_mass_fraction of spring '{name}' is {fraction}; it must lie between 0 and 1 (one third is usual)"
        )
