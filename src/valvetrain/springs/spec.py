"""What the registry holds of a spring model: its word, options, needs, and how it is made from an
installed spring.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import Strict, TypeAdapter, ValidationError

from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.spring_options import SpringOptions
from valvetrain.registry import find
from valvetrain.solution.static import SpringAtRest
from valvetrain.springs.contract import SpringModel
from valvetrain.units import believed


class NoOptions(SpringOptions):
    """A model without a choice."""


@dataclass(frozen=True)
class SpringModelSpec:
    """One fidelity of a spring as studies, reports and documents know it.

    ``make(installed, options, rest)`` builds the model; ``options`` is the typed table of its
    options; ``rest`` the spring at rest by
    the finite-element rod, given where ``needs_rest``. ``wire_only``: why a card does not serve,
    empty where it does. ``needs_mass``:
    whether a card must give its mass. ``no_motion``: why the model does not run in time, empty
    where it does; ``alone``: why not in the steps of a train, ``driver``: the model that a train runs with
    before this one follows its motion; ``no_statics``: why it gives no curve on its own.
    ``shows``: what beyond
    the end forces (``sections``, ``clash``, ``stress``). ``damped``: whether the damping of the
    spring has an effect.
    ``processor_time``: seconds of one core per simulated second, for estimates. ``beside``: models whose critical
    speeds the range of this one holds too.
    """

    word: str
    label: str
    colour: str
    options: type[SpringOptions]
    make: Callable[[InstalledSpring, Any, SpringAtRest | None], SpringModel]
    knows: str
    leaves_out: str
    shows: tuple[str, ...] = ()
    wire_only: str = ""
    needs_mass: bool = True
    needs_rest: bool = False
    no_motion: str = ""
    alone: str = ""
    driver: str = ""
    no_statics: str = ""
    damped: bool = True
    processor_time: float = 0.5
    beside: tuple[str, ...] = ()
    citation: str = ""

    def why_not(self, spring: InstalledSpring) -> str:
        """Why this model cannot represent ``spring``; empty when it can."""
        if spring.card is None:
            return ""
        if self.wire_only:
            return f"spring '{spring.name}' is known by its card only; {self.wire_only}"
        if self.needs_mass and spring.card.mass is None:
            return (
                f"spring '{spring.name}' has no mass on its card, which a {self.word} spring needs; add its mass, or wire_diameter and "
                "outer_diameter to compute it, or use massless"
            )
        return ""

    def build(self, spring: InstalledSpring, rest: SpringAtRest | None = None) -> SpringModel:
        """The model of an installed spring. Raises :class:`InputError` where it cannot represent
        it, or for options it does not take.
        """
        reason = self.why_not(spring)
        if reason:
            raise InputError(reason)
        with believed():  # the parts of the spring were doubted where they were given
            return self.make(spring, self.read_options(spring.options_of(self.word)), rest)

    def read_options(self, values: Mapping[str, Any]) -> SpringOptions:
        """The model's options with defaults filled in; values are SI, as an installed spring holds them, which
        knows their names. Raises :class:`InputError` for a value of another type.
        """
        for name, value in values.items():
            field = self.options.model_fields[name]
            if field.annotation in (int, bool):
                kind: Any = Annotated[field.annotation, *field.metadata, Strict()]
                try:
                    TypeAdapter(kind).validate_python(value)
                except ValidationError as error:
                    requirement = error.errors()[0]["msg"].removeprefix("Input should be ")
                    raise InputError(
                        f"{name} of a {self.word} spring is {value!r}; it should be {requirement}"
                    ) from error
        return self.options.model_construct(**values)


def spring_model(word: str, where: str = "") -> SpringModelSpec:
    """The entry of a spring model by its word. Raises :class:`InputError` with the nearest word for
    an unknown one.
    """
    spec = find("springs", word, where)
    if not isinstance(spec, SpringModelSpec):
        raise InputError(
            f"what is registered as spring model '{word}' is no SpringModelSpec; repair the package that brings it",
            where,
        )
    return spec
