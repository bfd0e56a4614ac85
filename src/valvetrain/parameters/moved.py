"""Tables of earlier case files: where each of their keys stands now."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from valvetrain.parameters.schema_types import problem

_FINITE_ELEMENT = "[spring.options.finite-element]"
#: Table -> key -> where it went; the empty key speaks for the whole table.
_MOVED: dict[tuple[str, ...], dict[str, str]] = {
    ("installation",): {"": "part of [spring], with the same keys"},
    ("damping",): {"": "[spring.damping], with the same keys"},
    ("spring_card",): {"": "[spring], with the same keys"},
    ("rod",): {
        "": f"split: numbers of the mesh stand in {_FINITE_ELEMENT}, coil contact in [spring.contact]",
        "contact_stiffness": "[spring.contact] stiffness",
        "contact_damping_time": "[spring.contact] damping_time",
        "output_step": "[operation] output_step",
        "elements_per_coil": f"{_FINITE_ELEMENT} elements_per_coil",
        "curvature_correction": f"{_FINITE_ELEMENT} curvature_correction",
        "time_step": f"{_FINITE_ELEMENT} time_step",
    },
    ("train", "spring_options"): {
        "": "part of each [[train.springs.SET]] block",
        "mass_damping": "damping.mass_damping in each [[train.springs.SET]] block",
        "stiffness_damping": "damping.stiffness_damping in each [[train.springs.SET]] block",
        "contact_stiffness": "contact.stiffness in each [[train.springs.SET]] block",
        "contact_damping_time": "contact.damping_time in each [[train.springs.SET]] block",
        "masses_per_coil": "options.multi-mass.masses_per_coil in each [[train.springs.SET]] block",
        "elements": "options.multi-mass.elements in each [[train.springs.SET]] block",
        "modes": "options.modal-uniform.modes in each [[train.springs.SET]] block",
        "elements_per_coil": "options.finite-element.elements_per_coil in each [[train.springs.SET]] block",
        "card_lift": "options.finite-element.card_lift in each [[train.springs.SET]] block",
        "effective_mass_fraction": "options.massless.effective_mass_fraction in each [[train.springs.SET]] block",
        "rubbing_coefficient": "[train.rubbing] coefficient",
        "rubbing_force": "[train.rubbing] normal_force",
    },
}


def refuse_moved(tree: Mapping[str, Any]) -> None:
    """Raise a located problem for the first table of an earlier case file."""
    for path, keys in _MOVED.items():
        table: Any = tree
        for part in path:
            table = table.get(part) if isinstance(table, Mapping) else None
        if table is None:
            continue
        name = ".".join(path)
        key = next((key for key in table if key in keys), "") if isinstance(table, Mapping) else ""
        shown = f"[{name}] {key}".rstrip()
        raise problem(f"{shown} is now {keys[key]}; move it there", (*path, key) if key else path)
