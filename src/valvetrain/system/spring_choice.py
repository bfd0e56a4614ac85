"""Springs of a train by one word: the fidelity's name, and a card or an installed wire definition."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Mapping
from typing import Any

from valvetrain.errors import InputError
from valvetrain.parameters.case import SpringCard
from valvetrain.parameters.train import InstalledSpring, TrainParameters
from valvetrain.system.wire_from_card import wire_from_card

SPRING_MODELS = ("massless", "multi-mass", "modal-uniform", "wave-rod", "wave-rod-clash", "finite-element")
CARD_LIFT = 0.012
"""Lift (m) up to which the coils of a wire made from a card stay apart."""

CARD_MASS_MISSING = "spring '{name}' has no mass on its card, which a {model} spring needs; add its mass or use massless"


def build_springs(train: TrainParameters, model: str | None = None, spring_set: str | None = None, **options: Any) -> tuple[Any, ...]:
    """Spring models (outer first) of one spring set. ``model``: one of :data:`SPRING_MODELS`, the train's own by default.

    Raises :class:`InputError` for an unknown model, or one that needs more than a card tells.
    """
    word = model or train.spring_model
    makers = _makers()
    if word not in makers:
        near = difflib.get_close_matches(word, makers, n=1)
        hint = f"did you mean '{near[0]}'?" if near else f"use one of {', '.join(makers)}"
        raise InputError(f"spring model '{word}' is unknown; {hint}")
    chosen = {**train.spring_options, **options}
    springs = tuple(makers[word](part, chosen) for part in train.spring_parts(spring_set))
    if len(springs) == 2 and chosen.get("rubbing_coefficient"):
        from valvetrain.springs.nested import NestedSprings, RadialRubbing

        return (NestedSprings(*springs, RadialRubbing(chosen["rubbing_coefficient"], chosen.get("rubbing_force", 0.0)), name=word),)
    return springs


def _makers() -> Mapping[str, Callable[[Any, Mapping[str, Any]], Any]]:
    return {
        "massless": _massless, "multi-mass": _multi_mass, "modal-uniform": _modal, "wave-rod": _rod, "wave-rod-clash": _clashing_rod,
        "finite-element": _finite_element,
    }  # fmt: skip


def _take(options: Mapping[str, Any], *names: str) -> dict[str, Any]:
    return {name: options[name] for name in names if name in options}


def _card_mass(part: SpringCard, model: str) -> float:
    if part.mass is None:
        raise InputError(CARD_MASS_MISSING.format(name=part.name, model=model))
    return part.mass


def _massless(part: Any, options: Mapping[str, Any]) -> Any:
    from valvetrain.springs.massless import MasslessSpring

    extra = _take(options, "effective_mass_fraction")
    if isinstance(part, InstalledSpring):
        chain = _multi_mass(part, {})
        return _static_line(part, chain, extra)
    return MasslessSpring(part.rate, part.preload, part.mass or 0.0, name="massless", **extra)


def _static_line(part: InstalledSpring, chain: Any, extra: dict[str, Any]) -> Any:
    """Secant of the chain's static curve from closed to 10 mm (or nearly solid): the linear spring of the same wire."""
    from valvetrain.springs.massless import MasslessSpring

    reach = min(0.01, 0.8 * (part.installed_height - part.definition.solid_height))
    low, high = (chain.force(chain.initial_state(x), x).retainer for x in (0.0, reach))
    return MasslessSpring((high - low) / reach, low, part.definition.active_mass, name="massless", **extra)


def _multi_mass(part: Any, options: Mapping[str, Any]) -> Any:
    from valvetrain.springs.multi_mass import MultiMassSpring

    damping = _take(options, "mass_damping", "stiffness_damping", "contact_damping_time")
    if isinstance(part, InstalledSpring):
        return MultiMassSpring.from_definition(
            part.definition, part.precompression, **_take(options, "masses_per_coil", "contact_stiffness"), **damping
        )
    return MultiMassSpring.from_card(part.rate, part.preload, _card_mass(part, "multi-mass"), **_take(options, "elements"), **damping)


def _equivalent(part: Any, model: str) -> Any:
    """Uniform spring with the rate, preload and mass of the part."""
    from valvetrain.springs.equivalent import EquivalentSpring

    if isinstance(part, InstalledSpring):
        return EquivalentSpring.from_definition(part.definition, part.precompression)
    _card_mass(part, model)
    return EquivalentSpring.from_card(part, part.name)


def _modal(part: Any, options: Mapping[str, Any]) -> Any:
    from valvetrain.springs.modal_uniform import ModalUniform

    return ModalUniform(_equivalent(part, "modal-uniform"), **_take(options, "mass_damping", "stiffness_damping", "modes"))


def _rod(part: Any, options: Mapping[str, Any]) -> Any:
    from valvetrain.springs.wave_rod import WaveRod

    return WaveRod(_equivalent(part, "wave-rod"), friction=options.get("mass_damping", 0.0) / 2)


def _clashing_rod(part: Any, options: Mapping[str, Any]) -> Any:
    from valvetrain.springs.wave_rod_clash import WaveRodWithClash

    if not isinstance(part, InstalledSpring):
        raise InputError(f"spring '{part.name}' is known by its card only; a rod with clash needs the coil gaps of its wire, so use rod")
    friction = options.get("mass_damping", 0.0) / 2
    return WaveRodWithClash.from_definition(part.definition, part.precompression, friction=friction)


def _finite_element(part: Any, options: Mapping[str, Any]) -> Any:
    from valvetrain.cosserat.buffer import RodDynamics
    from valvetrain.springs.finite_element import FiniteElementRod

    dynamics = RodDynamics(**_take(options, "mass_damping", "stiffness_damping"))
    mesh = _take(options, "elements_per_coil")
    if isinstance(part, InstalledSpring):
        return FiniteElementRod(part.definition, part.precompression, dynamics=dynamics, **mesh)
    wire = wire_from_card(part, options.get("card_lift", CARD_LIFT))
    return FiniteElementRod(wire.definition, wire.precompression, dynamics=dynamics, seats="clamps", **mesh)
