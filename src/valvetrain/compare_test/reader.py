"""The test that a model is compared with: its file, its speed and unit, and what its repeats let be
said.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from valvetrain.errors import InputError
from valvetrain.measured.cycles import MeasuredCycles, cycles_in
from valvetrain.measured.tables import read_content, text_of
from valvetrain.measured.value_table import ValueTable, is_value_table, values_in
from valvetrain.parameters.case import Case
from valvetrain.quantities.traces import Trace
from valvetrain.solution.quantity import same_speed
from valvetrain.system.build import build
from valvetrain.units import dimension_powers

#: Measured cycles or a table of values, or the file that holds them.
AnyTest = MeasuredCycles | ValueTable | str | Path
#: Speeds that differ by less than this share are the same test.
SAME_SPEED = 1e-3
#: Most cycles, and most of their values in all.
MAX_CYCLES, MAX_VALUES = 2000, 10_000_000
#: Repeats below which the count of independent angles leans on scatter being alike at all angles.
FEW = 4
#: Largest file of a test (bytes), and its first characters that decide what it is.
_MAX_BYTES, _BEGINNING = 500_000_000, 1 << 16


def read_test(test: AnyTest, quantity: str = "") -> MeasuredCycles | ValueTable:
    """The test in a file, by content. ``quantity``: what cycles are compared with where the file calls it
    otherwise.
    """
    if isinstance(test, (str, Path)):
        path = Path(test)
        text = text_of(read_content(path, _MAX_BYTES, "file of a test"), path.name)
        read = values_in if is_value_table(text[:_BEGINNING]) else cycles_in
        test = read(text, path.name[:80])
    if isinstance(test, ValueTable):
        return test
    return replace(test, quantity=quantity or test.quantity)


def at_speeds(
    case: Case, test: MeasuredCycles | ValueTable, engine_speed: float | None
) -> tuple[MeasuredCycles | ValueTable, tuple[float, ...], tuple[str, ...]]:
    """The test with the crank speeds (rad/s) that are run for it in every row of a table, these
    speeds, and what is to be said of them.

    ``engine_speed``: the speed to run whatever the test states. Raises :class:`InputError` where no speed,
    or more than one, can be meant.
    """
    of_case = build(case).engine_speeds
    stated = (
        [value.engine_speed for value in test.values]
        if isinstance(test, ValueTable)
        else [2 * test.cam_speed]
    )
    notes: list[str] = []
    if engine_speed is not None:
        off = [
            speed for speed in stated if speed > 0 and abs(speed / engine_speed - 1) > SAME_SPEED
        ]
        if off and isinstance(test, ValueTable):
            raise InputError(
                f"the table gives the speeds of its values, {rpm_text(off[0])} among them; leave it out",
                "engine_speed",
            )
        run = dict.fromkeys(stated, engine_speed)
    else:
        listed = ", ".join(map(rpm_text, of_case)) or "none"
        # the case's speed where it is that of the test but for rounding
        run = {
            speed: next((near for near in of_case if same_speed(near, speed)), speed)
            for speed in stated
        }
        if 0.0 in run:
            if len(of_case) != 1:
                raise InputError(
                    f"the test does not state its speed and the case has {listed}; give the engine speed",
                    "engine_speed",
                )
            run[0.0] = of_case[0]
            notes.append(f"the test does not state its speed; the model ran at the case's {listed}")
        notes += [
            f"the test ran at {rpm_text(speed)}, the case names {listed}: the model ran at the speed of the test"
            for speed in sorted(run)
            if speed and of_case and all(abs(speed - near) > SAME_SPEED * near for near in of_case)
        ]
    if isinstance(test, ValueTable):
        test = replace(
            test,
            values=tuple(replace(one, engine_speed=run[one.engine_speed]) for one in test.values),
        )
    return test, tuple(sorted(set(run.values()))), tuple(notes)


def rpm_text(engine_speed: float) -> str:
    """A crank speed (rad/s) as notes say it."""
    return f"{engine_speed * 30 / math.pi:.6g} rpm of the crank"


def whole_cycles(cycles: MeasuredCycles) -> MeasuredCycles:
    """Cycles without missing values: those that lack more than half of their angles are left out,
    then angles that any cycle lacks.

    Raises :class:`InputError` where fewer than 8 angles are left, and for more cycles than are
    compared.
    """
    if len(cycles.values) > MAX_CYCLES or cycles.values.size > MAX_VALUES:
        raise InputError(
            f"the test holds {len(cycles.values)} cycles of {len(cycles.cam_angle)} angles; give at most {MAX_CYCLES} cycles and "
            f"{MAX_VALUES // 1_000_000} million values, such as every tenth cycle"
        )
    cycles = _one_turn(cycles)
    measured = np.isfinite(cycles.values)
    if measured.all():
        return cycles
    retained = measured.mean(axis=1) > 0.5
    angles = (
        measured[retained].all(axis=0)
        if retained.any()
        else np.zeros(len(cycles.cam_angle), dtype=bool)
    )
    if angles.sum() < 8:
        raise InputError(
            f"{cycles.source or cycles.quantity}: fewer than 8 angles were measured in every cycle; leave out cycles with many gaps"
        )
    notes = []
    if not retained.all():
        notes.append(
            f"{int((~retained).sum())} cycles lack more than half of their angles and are left out"
        )
    if not angles.all():
        notes.append(
            f"{int((~angles).sum())} of {len(angles)} angles were not measured in every cycle and are left out"
        )
    return replace(
        cycles,
        cam_angle=cycles.cam_angle[angles],
        values=np.ascontiguousarray(cycles.values[retained][:, angles]),
        notes=(*cycles.notes, *notes),
    )


def _one_turn(cycles: MeasuredCycles) -> MeasuredCycles:
    """The same from the cam's zero on, without a last angle that is the first again. Raises
    :class:`InputError` for more than one turn.
    """
    over = float(cycles.cam_angle[-1] - cycles.cam_angle[0]) - 2 * math.pi
    if over > 1e-6:
        raise InputError(
            f"{cycles.source or cycles.quantity}: the angles go over {math.degrees(over) + 360:.6g} degrees, a cam revolution has 360; "
            "give cam angles, half of the crank's"
        )
    count = len(cycles.cam_angle) - (over > -1e-6)
    angle = cycles.cam_angle[:count] % (2 * math.pi)
    order = np.argsort(angle, kind="stable")
    return replace(cycles, cam_angle=angle[order], values=cycles.values[:, :count][:, order])


def separate_cycles(test: MeasuredCycles) -> float:
    """How many separate cycles the cycles are worth, where they resemble the one before them; NaN where they do not."""
    residuals = test.values - test.values.mean(axis=0)
    total = float(np.sum(residuals**2))
    count = len(residuals)
    if count < 6 or not total > 0:
        return math.nan
    likeness = float(np.sum(residuals[1:] * residuals[:-1])) / total * count / (count - 1) + 1 / (
        count - 1
    )
    single = np.sum(residuals**2, axis=1)
    spread = math.sqrt(float(np.sum((residuals @ residuals.T) ** 2) - np.sum(single**2))) / total
    if likeness < 3 * spread / math.sqrt(count):
        return math.nan
    return max(1.0, count * (1 - likeness) / (1 + likeness))


def check_unit(trace: Trace, test: MeasuredCycles) -> None:
    """Raises :class:`InputError` unless model and test have one unit."""
    plain = [{"N m": "N*m", "1": ""}.get(unit, unit) for unit in (trace.unit, test.unit)]
    if dimension_powers(f"1 {plain[0]}".strip()) != dimension_powers(f"1 {plain[1]}".strip()):
        raise InputError(
            f"the test gives {test.quantity} in {test.unit or 'no unit'}, the model in {trace.unit}; correct the unit or the quantity",
            "unit",
        )
