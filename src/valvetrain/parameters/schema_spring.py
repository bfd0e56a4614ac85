"""The wire and the card of a spring block in a case file."""

from __future__ import annotations

import warnings
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, ValidatorFunctionWrapHandler, WrapValidator

from valvetrain.errors import InputError, UnusualValueWarning
from valvetrain.parameters.card_doubts import doubtful_turns
from valvetrain.parameters.constructors import pitch_with_closed_ends, wind
from valvetrain.parameters.curves import Constant, Curve, add_curves
from valvetrain.parameters.installed_spring import SpringCard
from valvetrain.parameters.material import MaterialField, material_by_name
from valvetrain.parameters.schema_curves import CurveField, HeightForm, curve_of
from valvetrain.parameters.schema_types import (
    Force,
    Mass,
    Name,
    PositiveLength,
    Stiffness,
    StrictModel,
    guarded,
    problem,
    quantity,
)
from valvetrain.parameters.spring import EndCoil, EndKind, SpringDefinition, is_closed

#: A spring of more turns than this is taken for a mistake, and would cost minutes to check.
MAX_COILS = 200.0
#: A card of fewer active turns is a slip of units, and a chain of its mass could not be damped.
MIN_TURNS = 0.3

TotalCoils = Annotated[float, quantity("ratio", low=0.0, high=MAX_COILS, open_low=True)]


def _read_end(raw: Any, read: ValidatorFunctionWrapHandler) -> Any:
    """An end with its turns; its kind alone where no turns are given, since those of a spring given by its
    free length are the textbook's.
    """
    table = {"kind": raw} if isinstance(raw, str) else raw
    end: EndCoil = read(table)
    return end if isinstance(raw, EndCoil) or table.keys() - {"kind"} else end.kind


#: Of a card that names no material.
DEFAULT_MATERIAL = material_by_name("EN 10270-2 VDSiCr")
EndField = Annotated[EndCoil, WrapValidator(_read_end)]


class SpringModel(StrictModel):
    """The wire of a spring block."""

    name: Name = ""
    wire_diameter: CurveField
    mean_diameter: CurveField | None = None
    outer_diameter: CurveField | None = None
    pitch: CurveField | None = None
    height: HeightForm | None = None
    free_length: PositiveLength | None = Field(
        default=None, description="unloaded length, from which the pitch follows"
    )
    total_coils: TotalCoils
    hand: Literal["right", "left"] = Field(default="right", description="sense of winding")
    material: MaterialField
    ends: EndField | None = Field(
        default=None, description="kind of both ends; without it closed-ground"
    )
    lower_end: EndField | None = None
    upper_end: EndField | None = None
    solid_height: PositiveLength | None = Field(
        default=None, description="at coil bind, as a card states it; without it computed"
    )

    def build(self, name: str) -> SpringDefinition:
        """The spring this table defines; raises pydantic's located error or :class:`InputError`."""
        total = float(self.total_coils)
        wire = guarded(curve_of, self.wire_diameter, total, path=("wire_diameter",))
        diameter_key = self._one_of("mean_diameter", "outer_diameter")
        diameter = guarded(curve_of, getattr(self, diameter_key), total, path=(diameter_key,))
        pitch, lower, upper = self._wind(total, wire)
        spring: SpringDefinition = guarded(
            lambda: SpringDefinition(
                wire_diameter=wire,
                mean_diameter=diameter
                if diameter_key == "mean_diameter"
                else add_curves(diameter, wire, -1.0),
                pitch=pitch,
                total_coils=total,
                material=self.material,
                lower_end=lower,
                upper_end=upper,
                hand=self.hand,
                name=self.name or name,
                stated_solid_height=self.solid_height,
            )
        )
        return spring

    def _wind(self, total: float, wire: Curve) -> tuple[Curve, EndCoil, EndCoil]:
        """Pitch law and both ends, from a pitch, a height or the free length."""
        key = self._one_of("pitch", "height", "free_length")
        if self.ends is not None and (self.lower_end is not None or self.upper_end is not None):
            raise problem(
                "'ends' speaks for both ends, so lower_end and upper_end contradict it; give one or the other",
                ("ends",),
            )
        default: EndKind = "closed-ground"
        lower: EndCoil | EndKind = self.lower_end or self.ends or default
        upper: EndCoil | EndKind = self.upper_end or self.ends or default
        if self.free_length is not None:
            wound: tuple[Curve, EndCoil, EndCoil] = guarded(
                wind,
                total,
                wire,
                self.free_length,
                lower,
                upper,
                path=("free_length",),
            )
            return wound
        closed = tuple(float(is_closed(end)) for end in (lower, upper))
        try:
            pitch = curve_of(getattr(self, key), total, wire)
            if (
                isinstance(pitch, Constant) and any(closed) and isinstance(wire, Constant)
            ):  # one length is the pitch between closed ends
                pitch = pitch_with_closed_ends(total, wire.level, pitch.level, *closed)
        except InputError as error:  # a pitch made from the wire shows a wrong unit in the wire
            raise problem(
                error.reason, ("wire_diameter" if error.where == "wire_diameter" else key,)
            ) from error
        first, last = (end if isinstance(end, EndCoil) else EndCoil(end) for end in (lower, upper))
        return pitch, first, last

    def _one_of(self, *names: str) -> str:
        given = [name for name in names if getattr(self, name) is not None]
        if len(given) > 1:
            raise problem(
                f"{' and '.join(given)} are {'both' if len(given) == 2 else 'all'} given and may contradict each other; give one",
                (given[1],),
            )
        if not given:
            raise problem(f"neither {' nor '.join(names)} is given; add one")
        return given[0]


class SpringCardModel(StrictModel):
    """The card of a spring block: rate, or two loads and the lift or the heights between them;
    mass, or wire and coils to compute it.
    """

    name: Name = "spring card"
    preload: Force
    preload_height: PositiveLength | None = Field(
        default=None, description="at which preload is given; without it installed_height"
    )
    rate: Stiffness | None = None
    open_load: Force | None = None
    open_lift: PositiveLength | None = None
    open_height: PositiveLength | None = Field(
        default=None, description="at which open_load is given, in place of open_lift"
    )
    free_length: PositiveLength | None = Field(
        default=None, description="in place of rate: preload over the way to its height"
    )
    mass: Mass | None = Field(
        default=None, description="that vibrates; without it from wire and coils"
    )
    installed_height: PositiveLength | None = Field(
        default=None, description="without it preload_height"
    )
    solid_height: PositiveLength | None = Field(default=None, description="at coil bind")
    wire_diameter: PositiveLength | None = Field(default=None, description="for the mass")
    mean_diameter: PositiveLength | None = Field(default=None, description="for the mass")
    outer_diameter: PositiveLength | None = Field(
        default=None, description="for the mass, in place of mean_diameter"
    )
    active_coils: TotalCoils | None = Field(
        default=None, description="for the mass; without them as many as give the rate"
    )
    material: MaterialField | None = Field(
        default=None, description="for the mass; without it EN 10270-2 VDSiCr"
    )

    def build(self, label: str = "") -> SpringCard:
        """The card as installed; refuses a rate that contradicts the loads. ``label``: how a warning
        calls it.
        """
        if self.preload < 0:
            raise problem("a preload is a compressive force, zero or more", ("preload",))
        preload_height, installed = self._heights()
        rate, lift = self._rate(preload_height)
        preload = self.preload + (
            rate * (preload_height - installed)
            if preload_height is not None and installed is not None
            else 0.0
        )
        if preload < 0:
            raise problem(
                "the spring would be loose at this installed_height; install it lower",
                ("installed_height",),
            )
        if lift is not None and preload_height is not None and installed is not None:
            lift -= preload_height - installed
        load = None if lift is None else preload + rate * lift
        if (
            self.solid_height is not None
            and installed is not None
            and self.solid_height >= installed
        ):
            raise problem(
                "solid_height is not below installed_height; check both", ("solid_height",)
            )
        self.refuse_open_solid(lift, installed)
        return SpringCard(
            rate=rate,
            preload=preload,
            mass=self._mass(rate, label or f"'{self.name}'"),
            installed_height=installed,
            open_load=load
            if self.open_load is None or preload_height != installed
            else self.open_load,
            open_lift=lift,
            solid_height=self.solid_height,
            name=self.name,
        )

    def refuse_open_solid(self, open_lift: float | None, installed: float | None) -> None:
        """Refuse an open load at a height where the coils are closed already."""
        if open_lift is None or installed is None or self.solid_height is None:
            return
        if (height := installed - open_lift) < self.solid_height * (1 - 1e-9):
            key = "open_lift" if self.open_height is None else "open_height"
            made = "" if self.open_height is not None else " (by open_lift)"
            raise problem(
                f"the open load is given at {height * 1e3:.4g} mm{made}, but the spring is solid at {self.solid_height * 1e3:.4g} mm "
                f"(solid_height), where it cannot be pressed further; check both heights",
                (key,),
            )

    def _heights(self) -> tuple[float | None, float | None]:
        """Heights (m) at which the preload is stated and at which the spring is installed."""
        preload_height, installed = self.preload_height, self.installed_height
        return (installed if preload_height is None else preload_height), (
            preload_height if installed is None else installed
        )

    def _rate(self, preload_height: float | None) -> tuple[float, float | None]:
        """Rate (N/m) and the lift (m) from the preload to the open load, where it is specified."""
        load, lift = self.open_load, self._lift(preload_height)
        by_loads = None if load is None or lift is None else (load - self.preload) / lift
        if by_loads is not None and by_loads <= 0:
            raise problem(
                "open_load does not exceed preload, so the rate would not be positive; check both",
                ("open_load",),
            )
        if self.rate is not None:
            if self.free_length is not None:
                self.refuse_free_length()
            if by_loads is not None and abs(by_loads / self.rate - 1) > 0.02:
                raise problem(
                    f"rate {self.rate / 1e3:g} N/mm contradicts the loads, which make {by_loads / 1e3:.4g} N/mm; correct one of them",
                    ("rate",),
                )
            return self.rate, lift
        by_free = self._from_free(preload_height)
        if by_loads is None and by_free is None:
            raise problem(
                "the rate is missing; give rate, or open_load and open_lift or open_height, or free_length"
            )
        if by_loads is not None and by_free is not None and abs(by_free / by_loads - 1) > 0.05:
            warnings.warn(
                f"the loads of a spring make {by_loads / 1e3:.4g} N/mm, its free length and preload {by_free / 1e3:.4g} N/mm: "
                "it is progressive, or a number is wrong; the rate of the loads is taken",
                UnusualValueWarning,
                stacklevel=2,
            )
        return by_loads or by_free or 0.0, lift

    def _lift(self, preload_height: float | None) -> float | None:
        """Lift (m) from the preload to the open load, as given or by the heights of both."""
        if self.open_height is None:
            return self.open_lift
        if self.open_lift is not None:
            raise problem(
                "open_lift and open_height are both given and may contradict; give one",
                ("open_height",),
            )
        if preload_height is None:
            raise problem(
                "open_height needs the height of the preload; add installed_height",
                ("open_height",),
            )
        if self.open_height >= preload_height:
            raise problem(
                f"open_height is not below that of the preload ({preload_height * 1e3:.4g} mm); check both",
                ("open_height",),
            )
        return preload_height - self.open_height

    def refuse_free_length(self) -> None:
        """Refuse a free length where the rate is given already."""
        raise problem(
            "free_length gives the rate, which rate gives too; leave one of them out",
            ("free_length",),
        )

    def _from_free(self, preload_height: float | None) -> float | None:
        """Rate (N/m) of the preload and the free length, as service manuals give them; None without one."""
        if self.free_length is None:
            return None
        if preload_height is None:
            raise problem(
                "free_length needs the height of the preload; add installed_height",
                ("free_length",),
            )
        if self.free_length <= preload_height or self.preload == 0:
            raise problem(
                f"free_length is not above the height of a preload ({preload_height * 1e3:.4g} mm); check both",
                ("free_length",),
            )
        return self.preload / (self.free_length - preload_height)

    def mean_of(self, wire: float, needed: str) -> float:
        """Mean coil diameter (m) of a ``wire`` (m); refuses two diameters or none, by the sentence ``needed``,
        and coils that are too narrow.
        """
        mean, outer = self.mean_diameter, self.outer_diameter
        if (mean is None) == (outer is None):
            raise problem(needed, ("mean_diameter",))
        mean = mean if mean is not None else (outer or 0.0) - wire
        if mean <= 2 * wire:
            raise problem(
                "the coils are too narrow for this wire (index below 2); check diameters and units",
                ("wire_diameter",),
            )
        return mean

    def _mass(self, rate: float, label: str) -> float | None:
        """Mass (kg) that vibrates: as specified, or of the active turns, rho pi^2 d^2 D n / 4; None
        where neither is specified. ``label``: the spring's, for a warning.
        """
        if self.mass is not None or self.wire_diameter is None:
            if self.mass is None and (
                self.mean_diameter or self.outer_diameter or self.active_coils
            ):
                raise problem(
                    "the mass from wire and coils needs wire_diameter; add it, or mass",
                    ("wire_diameter",),
                )
            return self.mass
        wire, material = self.wire_diameter, self.material or DEFAULT_MATERIAL
        mean = self.mean_of(wire, "the mass from wire and coils needs mean_diameter or outer_diameter; give one of them")  # fmt: skip
        by_rate = material.shear_modulus * wire**4 / (8 * mean**3 * rate)
        if by_rate < MIN_TURNS:
            raise problem(
                f"rate, wire and coil diameter make {by_rate:.2g} active turns, which no spring has; check wire_diameter, coil diameter, "
                "loads and their units",
                ("wire_diameter",),
            )
        coils = self.active_coils or by_rate
        if self.active_coils is None and (
            doubt := doubtful_turns(by_rate, wire, self.solid_height, None)
        ):
            warnings.warn(f"spring {label}: {doubt}", UnusualValueWarning, stacklevel=2)
        if not 0.7 < coils / by_rate < 1.4:
            raise problem(
                f"wire and coils make a rate of {rate * by_rate / coils / 1e3:.3g} N/mm, but the card has {rate / 1e3:.3g} N/mm, which "
                f"takes {by_rate:.3g} active coils; correct one of them, or give mass",
                ("wire_diameter",),
            )
        return float(material.density * np.pi**2 * wire**2 * mean * coils / 4)
