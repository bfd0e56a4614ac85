"""The verdict on a scan: as drawn, or which quantities are not; without a design what the spring is."""

from __future__ import annotations

import math

from valvetrain.report.text import percent, speed_text
from valvetrain.scan.compare import ComparedNumber, ScanComparison
from valvetrain.scan.page import IN_MOTION
from valvetrain.scan.result import ScannedSpring
from valvetrain.solution.definition import label_of

#: Share up to which a quantity is as drawn, and quantities that are named beyond it.
AS_DRAWN, NAMED = 0.02, 3


def scan_verdict(scan: ScannedSpring, found: ScanComparison | None = None) -> str:
    """The sentence, on the comparison with the design where there is one."""
    if found is not None:
        return scan_comparison_verdict(found)
    section, turns = scan.section, scan.total_coils
    shape = "ovate wire" if section.ovate else "wire"
    share = 100 * scan.points_on_wire / max(1, scan.points_fitted)
    return (
        f"{turns[0]:.2f} turns of {1e3 * section.diameter[0]:.2f} mm {shape}, {1e3 * scan.free_length[0]:.2f} mm free, {scan.hand} hand; "
        f"points scatter by {1e6 * scan.noise:.0f} µm about it, {share:.0f} % of them are on the wire."
    )


def scan_comparison_verdict(found: ScanComparison) -> str:
    """Within which share quantities are as drawn, and those that are not, the furthest first."""
    lead = (
        f"{len(found.failures)} run{'s' * (len(found.failures) != 1)} did not complete; "
        if found.failures
        else ""
    )
    rows = [(abs(_apart(one)), one) for one in _shown(found) if math.isfinite(_apart(one))]
    if not rows:
        return _sentence(lead, "scan and design have nothing that can be compared")
    near = [apart for apart, _ in rows if apart <= AS_DRAWN]
    far = sorted((row for row in rows if row[0] > AS_DRAWN), key=lambda row: -row[0])
    if not far:
        return _sentence(lead, f"as drawn within {100 * max(near):.1f} %")
    named = ", ".join(f"{_name(one)} ({percent(_apart(one))})" for _, one in far[:NAMED])
    more = f" and {len(far) - NAMED} more" if len(far) > NAMED else ""
    if not near:
        return _sentence(lead, f"not as drawn: {named}{more}")
    return _sentence(
        lead,
        f"{len(near)} of {len(rows)} quantities are as drawn within {100 * max(near):.1f} %, but not {named}{more}",
    )


def _shown(found: ScanComparison) -> list[ComparedNumber]:
    """The quantities of the page: numbers of the computation and small parts of the surge are none."""
    return [one for one in found.numbers if one.engine_speed is None or one.quantity in IN_MOTION]


def _sentence(lead: str, said: str) -> str:
    return f"{lead}{said}." if lead else f"{said[:1].upper()}{said[1:]}."


def _apart(one: ComparedNumber) -> float:
    """Scan over design, less one; nan where the design has nothing."""
    return one.scanned / one.design - 1 if one.design else math.nan


def _name(one: ComparedNumber) -> str:
    speed = "" if one.engine_speed is None else f" at {speed_text(one.engine_speed)}"
    return f"{label_of(one.quantity)}{speed}"
