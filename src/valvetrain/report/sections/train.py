"""Forces of a train's contacts and links, its cam torque and the clearance to the piston."""

from __future__ import annotations

from valvetrain.report.chart import Panel
from valvetrain.report.figures.common import angle_panels, by_speed, panels_chart
from valvetrain.report.page import Block, SectionSpec, figure_or_gap
from valvetrain.report.words import speed_words
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study

#: Forces of the springs and of rigid parts, which have their own sections; single springs bear a name in front.
_OTHERS = ("seat_force", "retainer_force", "normal_force", "shear_force", "coil_contact_force", "rigid_contact_force", "contact_force")


def force_channels(runs: list[Solution]) -> list[str]:
    """Channels of contact and link forces that the runs have: contacts first."""
    names = dict.fromkeys(str(name) for run in runs for name, one in run.arrays.variables.items() if len(one.dims) == 1)
    springs = {f"{spring}_{other}" for run in runs for spring in run.springs for other in _OTHERS}
    forces = [name for name in names if name.endswith("_force") and name not in (*_OTHERS, *springs, "static_retainer_force")]
    return sorted(forces, key=lambda name: not name.endswith("_contact_force"))


def blocks(study: Study) -> tuple[Block, ...]:
    """Contact and link forces, then torque, lever speed and piston clearance, by engine speed."""

    def panels_of(runs: list[Solution], channels: list[str]) -> list[Panel]:
        found = []
        for name in channels:
            rigid = ("rigid_contact_force", "rigid parts") if name == "cam_contact_force" else ("", "")
            found += angle_panels(study, runs, name, name.replace("_", " "), still=rigid[0], still_words=rigid[1])
        return found

    def at(engine_speed: float, runs: list[Solution], key: str) -> tuple[Block, ...]:
        speed = speed_words(engine_speed)
        rest = [name for name in ("cam_torque", "lever_speed", "piston_clearance") if any(run.has(name) for run in runs)]
        titles = (f"Contact and link forces at {speed}", f"Cam torque and clearance at {speed}")
        captions = (
            "Force of every contact and elastic link over the steady cycle; dashed: the cam contact force of rigid parts.",
            "Torque that drives the cam, turning speed of the lever, clearance of piston and valve along the cylinder.",
        )
        found: tuple[Block, ...] = ()
        for place, names in enumerate((force_channels(runs), rest)):
            panels = panels_of(runs, names)
            found += figure_or_gap(titles[place], panels_chart, f"{key}-{place + 1}", titles[place], captions[place], panels, 210)
        return found

    return by_speed(study, "train", at)


SPEC = SectionSpec("train", "Contacts and cam torque", blocks)
