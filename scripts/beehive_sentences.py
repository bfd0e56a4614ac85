"""Sentences with numbers of the calibrated beehive: those of docs/beehive.md between marks, and those of other
pages and the README; scripts/beehive_page.py writes them.
"""

from __future__ import annotations

import math
import re
import tempfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import sample_test_cycles

import valvetrain as vt
from valvetrain.compare_test.compare import compare_with_test
from valvetrain.parameters.loading import load_case
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.solution.study import Study
from valvetrain.sources.gu2021_reading import sampled
from valvetrain.sources.gu2021_stages import spike_index

CASE, ROD = "gu2021-beehive", "finite-element"
DEG, US, RPM = math.pi / 180, 1e-6, math.pi / 30


def spike_angles(study: Study) -> list[int]:
    """Cam angle (whole deg) of the highest sample of Stage III at 8000 rpm, by phase of the samples."""
    event = study.lift_event
    assert event is not None
    cycle = reported_cycle(study.solution(ROD, 8000 * RPM))
    read, found = sampled(cycle), []
    for angle, force in zip(read.cam_angle, read.force, strict=True):
        found.append(round(angle[spike_index(replace(cycle, cam_angle=angle), force, event)] / DEG))
    return found


def spike_text(study: Study) -> str:
    """The spike at 8000 rpm in each way of reading it, and to which collisions its samples belong."""
    run = study.solution(ROD, 8000 * RPM).quantities
    angles = spike_angles(study)
    seen = ", ".join(
        f"{angle} degrees at {angles.count(angle)} of {len(angles)}"
        for angle in sorted(set(angles))
    )
    low, high = (run[f"stage_3_{word}_sampled_peak_force"] for word in ("least", "largest"))
    return (
        f"At 8000 rpm the spike is {run['stage_3_peak_force']:.0f} N in the median over the phase, {low:.0f} to "
        f"{high:.0f} N over it, {run['stage_3_every_instant_peak_force']:.0f} N at every instant and "
        f"{run['stage_3_below_20_khz_peak_force']:.0f} N below 20 kHz,\n{run['stage_3_peak_duration'] / US:.0f} us wide at "
        f"half height, with an impulse of {run['stage_3_peak_impulse']:.3f} N s. Published are 1430 N; 83 us are the "
        "time from contact to contact.\n"
        f"The highest sample of Stage III is, by phase, the collision at {seen}."
    )


#: Readings taken wherever the model has them: words, quantity of their angle.
PLACES = (
    ("contact to contact from", "coil_1_2_bounce_start_cam_angle"),
    ("node 2 fastest at", "node_2_stage_3_minimum_velocity_cam_angle"),
)
#: Farther apart (deg) than this, two angles are those of different collisions: half the distance of two.
ONE_COLLISION = 13.0


def place_text(study: Study) -> str:
    """Where contacts and the velocity of node 2 were read, beside where the source has them."""
    lines = []
    for words, quantity in PLACES:
        for row in study.comparisons:
            if row.quantity == quantity and row.computed is not None and row.engine_speed:
                angle, there = row.computed / DEG, row.published / DEG
                other = ", another collision" if abs(angle - there) > ONE_COLLISION else ""
                speed = row.engine_speed / RPM
                lines.append(f"{words} {angle:.1f} degrees ({there:g}) at {speed:.0f} rpm{other}")
    return (
        "The aims of durations and of node 2 are read where the model has them, beside the source's place: "
        + ";\n".join(lines)
        + "."
    )


def peak_text(second: Mapping[str, float], settled: Mapping[str, float]) -> str:
    """The largest sample of Stage II at 8000 rpm, and which stage holds the peak of the cycle."""
    names = ("stage_3_peak_force", "stage_2_peak_force")
    more, later = (run[names[0]] - run[names[1]] for run in (second, settled))
    above = f"{abs(more):.0f} N {'below' if more > 0 else 'above'} the spike"
    holds = "as the source says" if more > 0 else "and not in Stage III as the source says"
    same = "in the settled motion too" if (later > 0) == (more > 0) else "not in the settled motion"
    return (
        f"The largest sample of Stage II at 8000 rpm is {second[names[1]]:.0f} N at "
        f"{second['stage_2_peak_cam_angle'] / DEG:.1f} degrees, {above}: the peak of the cycle lies in\n"
        f"Stage {'III' if more > 0 else 'II'}, {holds}, in the second revolution; {same}."
    )


def spikes_with_friction() -> list[tuple[float, float]]:
    """Spike (N) and energy imbalance at 8000 rpm without friction between coils, with 0.1 and with 0.3."""
    case, found = load_case(CASE), []
    for friction in (0.0, 0.1, 0.3):
        spring = case.springs[0].with_options(ROD, coil_friction=friction)
        run = vt.simulate(
            case.replace(springs=(spring,)), "8000 rpm", spring_models=[ROD], workers=1
        )
        read = run.solutions[0].quantities
        found.append((read["stage_3_peak_force"], read["energy_imbalance_ratio"]))
    return found


def ratio_to_the_head_test() -> float:
    """Chi square over its degrees of freedom of the calibrated rod against the head test's values."""
    with tempfile.TemporaryDirectory() as folder:
        sample_test_cycles.main(Path(folder))
        found = compare_with_test(CASE, Path(folder) / "engine-head.csv")
    (rod,) = (one for one in found.runs if one.label == ROD)
    assert rod.adequacy is not None
    return rod.adequacy.ratio


def texts_elsewhere(
    run: Mapping[str, float], blind: Mapping[str, float]
) -> dict[str, tuple[str, str]]:
    """File -> pattern and text of the sentence there, of the quantities at 8000 rpm of both springs."""
    spike, angle = run["stage_3_peak_force"], run["stage_3_peak_cam_angle"] / DEG
    (free, _), (some, closed), (much, less) = spikes_with_friction()
    return {
        "README.md": (
            r"calibrated \d+ N, blind prediction \d+ N",
            f"calibrated {spike:.0f} N, blind prediction {blind['stage_3_peak_force']:.0f} N",
        ),
        "docs/model-against-test.md": (
            r"F = \d+, the spike \d+ N at [\d.]+ degrees",
            f"F = {ratio_to_the_head_test():.0f}, the spike {spike:.0f} N at {angle:.1f} degrees",
        ),
        "docs/theory/coil-contact.md": (
            r"closes to [\d.]+ % with\n\$\\mu = 0\.1\$ and to [\d.]+ % with 0\.3(.*)\. "
            r"Its spike there is \d+ N without friction, \d+ N with 0\.1 and \d+ N with",
            f"closes to {100 * closed:.1g} % with\n$\\\\mu = 0.1$ and to {100 * less:.1g} % with 0.3\\1. "
            f"Its spike there is {free:.0f} N without friction, {some:.0f} N with 0.1 and {much:.0f} N with",
        ),
    }


def write_elsewhere(root: Path, run: Mapping[str, float], blind: Mapping[str, float]) -> None:
    """What other pages print of the calibrated spring, each number in the words around it."""
    for name, (pattern, text) in texts_elsewhere(run, blind).items():
        file = root / name
        whole, count = re.subn(pattern, text, file.read_text(encoding="utf-8"))
        assert count == 1, f"{name} has its sentence of the calibrated spring {count} times"
        file.write_text(whole, encoding="utf-8")
