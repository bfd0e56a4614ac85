"""Damping of a spring wire: Rayleigh coefficients, given directly or through a damping ratio."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any

from valvetrain.errors import InputError

#: Share of a given ratio that is stiffness-proportional when the case does not say: the least-damped point is then at ``ratio_frequency``.
DEFAULT_STIFFNESS_SHARE = 0.5
#: Relative slack within which a ratio and explicit coefficients must agree.
AGREEMENT = 0.005


@dataclass(frozen=True, slots=True)
class DampingParameters:
    """Rayleigh damping, force = (``mass_damping`` M + ``stiffness_damping`` K) velocity.

    Give the coefficients (1/s and s), or ``ratio`` (of critical) at ``ratio_frequency`` (Hz) with ``stiffness_share``, the part of
    the ratio that is stiffness-proportional: with w = 2 pi ratio_frequency, mass_damping = 2 ratio w (1 - share) and
    stiffness_damping = 2 ratio share / w. A ratio with one coefficient leaves the rest to the other. After construction
    both coefficients are numbers. Raises :class:`InputError` when two ways of saying it disagree.
    """

    mass_damping: float = None  # type: ignore[assignment]
    stiffness_damping: float = None  # type: ignore[assignment]
    ratio: float | None = None
    ratio_frequency: float | None = None
    stiffness_share: float | None = None

    def __post_init__(self) -> None:
        for name in ("mass_damping", "stiffness_damping", "ratio", "ratio_frequency"):
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and value >= 0):
                raise InputError(f"{name} must be a finite number, zero or more; it is {value}")
        if (self.ratio is None) != (self.ratio_frequency is None):
            raise InputError("a damping ratio holds at one frequency; give ratio and ratio_frequency together")
        if self.ratio is None:
            if self.stiffness_share is not None:
                raise InputError("stiffness_share splits a damping ratio; give ratio and ratio_frequency with it, or drop it")
            self._set(self.mass_damping or 0.0, self.stiffness_damping or 0.0)
        else:
            self._resolve_ratio()

    def _resolve_ratio(self) -> None:
        assert self.ratio is not None and self.ratio_frequency is not None
        if self.ratio >= 1 or self.ratio_frequency <= 0:
            raise InputError(
                f"damping ratio {self.ratio:g} at {self.ratio_frequency:g} Hz is no light damping of a spring; "
                "give a ratio below 1 (such as 0.016) at a positive frequency"
            )
        share, circular = self.stiffness_share, 2 * math.pi * self.ratio_frequency
        if share is not None and not 0 <= share <= 1:
            raise InputError(f"stiffness_share must lie between 0 (all mass-proportional) and 1; it is {share:g}")
        mass, stiffness = self.mass_damping, self.stiffness_damping
        if share is None and mass is not None and stiffness is None:
            stiffness = (2 * self.ratio - mass / circular) / circular
        elif share is None and stiffness is not None and mass is None:
            mass = (2 * self.ratio - stiffness * circular) * circular
        share = DEFAULT_STIFFNESS_SHARE if share is None else share
        mass = 2 * self.ratio * circular * (1 - share) if mass is None else mass
        stiffness = 2 * self.ratio / circular * share if stiffness is None else stiffness
        if mass < -1e-9 * circular or stiffness < -1e-9 / circular:
            raise InputError(f"the coefficient given damps more than the ratio {self.ratio:g} allows; lower it or raise the ratio")
        total = mass / (2 * circular) + stiffness * circular / 2
        split_off = self.stiffness_share is not None and abs(stiffness * circular / 2 - share * self.ratio) > AGREEMENT * self.ratio
        if abs(total - self.ratio) > AGREEMENT * self.ratio or split_off:
            raise InputError(
                f"mass_damping {mass:g} 1/s and stiffness_damping {stiffness:g} s make a ratio of {total:.4g} "
                f"at {self.ratio_frequency:g} Hz, but ratio says {self.ratio:g} (share {share:g}); give the damping one way"
            )
        self._set(max(mass, 0.0), max(stiffness, 0.0))

    def _set(self, mass: float, stiffness: float) -> None:
        object.__setattr__(self, "mass_damping", float(mass))
        object.__setattr__(self, "stiffness_damping", float(stiffness))

    def ratio_at(self, frequency_hertz: float) -> float:
        """Damping ratio (of critical) of a mode at ``frequency_hertz`` (Hz, positive)."""
        circular = 2 * math.pi * frequency_hertz
        return self.mass_damping / (2 * circular) + self.stiffness_damping * circular / 2

    def replace(self, **changes: Any) -> DampingParameters:
        """A copy with the named fields changed; changing the ratio or its split recomputes the coefficients, and the other way round."""
        by_ratio = {"ratio", "ratio_frequency", "stiffness_share"} & set(changes)
        by_coefficient = {"mass_damping", "stiffness_damping"} & set(changes)
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        if by_ratio and not by_coefficient:
            values |= {"mass_damping": None, "stiffness_damping": None}
        elif by_coefficient and not by_ratio:
            values |= {"ratio": None, "ratio_frequency": None, "stiffness_share": None}
        return DampingParameters(**(values | changes))
