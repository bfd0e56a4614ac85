"""What the registry holds of a contact law."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from valvetrain.parameters.schema_contact import ContactTable


@dataclass(frozen=True, slots=True)
class ContactSpec:
    """``law``: dataclass of the law, whose fields are its values. ``table``: its table in a case
    file.

    ``damping_unit``: whether its ``damping`` is c of c d' (N s/m) or q of 1 + q d' (s/m); empty for
    a law without one.
    """

    law: type[Any]
    table: type[ContactTable]
    damping_unit: Literal["N s/m", "s/m", ""] = ""
