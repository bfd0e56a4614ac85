"""Cards whose numbers are possible, but hardly those of one spring."""

from __future__ import annotations

#: Share within which the surge of the mass on a card is that of its wire.
SAME_SURGE = 0.1
#: Fewest active turns that EN 13906-1 computes, and most inactive turns at either closed end of a
#: valve spring (one is common, a published single with 6.15 turns in all has 1.3).
MIN_ACTIVE, MAX_INACTIVE = 2.0, 1.6


def doubtful_surge(surge: float, of_wire: float, free_turns: float, turns: float | None) -> str:
    """Why the mass or the turns of a card do not go with its wire, as a sentence; empty where the surge differs by less than
    :data:`SAME_SURGE`.

    Parameters
    ----------
    surge : first frequency (Hz) by rate and mass of the card
    of_wire : that of as many turns of the wire as give the rate (Hz)
    free_turns : those turns
    turns : active turns on the card; None where it has a mass

    Examples
    --------
    >>> doubtful_surge(653.0, 810.0, 3.34, None)[:65]
    'the mass makes a surge of 653 Hz, but the 3.34 free turns of wire'
    """
    if abs(surge / of_wire - 1) <= SAME_SURGE:
        return ""
    given, key = ("mass", "mass") if turns is None else (f"{turns:.3g} turns", "active_coils")
    verb = "makes" if turns is None else "make"
    return (
        f"the {given} {verb} a surge of {surge:.0f} Hz, but the {free_turns:.3g} free turns of wire that give the rate make {of_wire:.0f} Hz; "
        f"leave out {key}, or check wire, coil diameter and rate"
    )


def doubtful_turns(
    active: float, wire_diameter: float, solid_height: float | None, total_coils: float | None
) -> str:
    """Why turns are hardly those of one spring, as a sentence; empty for common ones.

    Parameters
    ----------
    active : active turns by rate, wire and coil diameter
    wire_diameter : in m
    solid_height : height of all coils closed (m), with ends ground over half a turn; None where unknown
    total_coils : all turns; None where unknown

    Examples
    --------
    >>> doubtful_turns(3.55, 4.75e-3, None, 6.15)
    ''
    >>> doubtful_turns(1.9, 4.5e-3, 29.2e-3, None)[:63]
    'rate, wire and coil diameter make 1.9 active turns, but the sol'
    """
    total = total_coils
    if total is None and solid_height is not None:
        total = solid_height / wire_diameter
    if total is not None and active > total:
        source = "the solid height leaves" if total_coils is None else "there are"
        return (
            f"rate, wire and coil diameter make {active:.3g} active turns, but {source} {total:.3g} in all; check wire_diameter, coil diameter, "
            "loads and heights"
        )
    if active >= MIN_ACTIVE and (total is None or total - active <= 2 * MAX_INACTIVE):
        return ""
    digits = 2 if float(f"{active:.2g}") < MIN_ACTIVE else 3
    found = f"rate, wire and coil diameter make {active:.{digits}g} active turns"
    if total is not None:
        source = "the solid height makes" if total_coils is None else "there are"
        found += f", but {source} {total:.3g} in all, of which some {max(total - 2, 0):.2g} should be active"
    else:
        found += f", fewer than the {MIN_ACTIVE:g} that a spring has"
    return (
        f"{found}: are these the loads of a dual spring with the wire of its outer one? Then enter outer and inner as two springs "
        "of one set, each with its own wire and diameter, and loads of its own or loads_of = 'pair'; else check loads, heights and diameters"
    )
