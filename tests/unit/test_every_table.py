"""Every table of every page says the number, unit and sign that it names: made-up numbers are read
back cell by cell.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from known_figures import STUDIES
from synthetic_study import (
    at_rest,
    modal_run,
    own_study,
    published_study,
    rod_run,
    sweep_study,
    train_study,
)
from valvetrain.registry import find
from valvetrain.report.page import Cards, Details, Grid, Tabs, Text
from valvetrain.report.sections.published import (
    lead,
    uncertainty_grid,
    uncertainty_page,
    uncertainty_table,
)
from valvetrain.report.study import study_page
from valvetrain.runs.error_bars import UncertaintyStudy
from valvetrain.solution.comparison import Comparison
from valvetrain.solution.provenance import CaseRecord
from valvetrain.solution.status import Event, Status
from valvetrain.solution.study import Study
from valvetrain.solution.uncertainty import Uncertainty

RPM = np.pi / 30
NAMES = ("finite-element rod", "modal model with varied stiffness")

#: The form of a critical speed with its ranges and its kind.
FLOAT = "6688 (6493 to 6876: model, damping)"


def four(value: float | None) -> str:
    """Four significant digits, no zeros at the end, a real minus; a dash for nothing."""
    if value is None:
        return "–"
    text = f"{value:.4g}"
    return (text.rstrip("0").rstrip(".") if "." in text else text).replace("-", "−")


def blocks(section: str, study: Study) -> tuple:
    return find("sections", section).blocks(study)


def cells(grid: Grid) -> list[list[str]]:
    return [[cell.text for cell in row] for row, _ in grid.rows]


def the(kind: type, found: tuple):
    (one,) = (block for block in found if isinstance(block, kind))
    return one


def card_of(study: Study):
    (card,) = the(Cards, blocks("answers", study)).cards
    return card


def test_answers_say_each_number_of_each_run():
    study = STUDIES["own"]()
    card, runs = (
        card_of(study),
        [
            study.solution("finite-element", 4200 * RPM),
            study.solution("finite-element", 5600 * RPM),
            study.solution("modal-varied", 4200 * RPM),
            study.solution("modal-varied", 5600 * RPM),
        ],
    )

    def row(words: str, name: str, factor: float = 1.0) -> tuple[str, tuple[str, ...]]:
        return words, tuple(
            four(run.quantities[name] * factor if name in run.quantities else None) for run in runs
        )

    assert card.headers == tuple(f"{name}, {speed} rpm" for name in NAMES for speed in (4200, 5600))
    assert list(card.lines) == [
        ("Spring force and coil bind", ()),
        row("Peak spring force below 10 kHz (N)", "peak_spring_force"),
        row("Minimum spring force (N)", "minimum_spring_force"),
        row("Peak retainer force below 10 kHz (N)", "peak_retainer_force"),
        row("Minimum retainer force (N)", "minimum_retainer_force"),
        row("Clearance to coil bind (mm)", "coil_bind_clearance", 1e3),
        ("Surge", ()),
        row("Surge frequency (Hz)", "surge_frequency"),
        row("Surge order", "surge_cam_order"),
        row("Nearest lift harmonic", "nearest_lift_harmonic_order"),
        row("Nearest lift harmonic, amplitude (µm)", "nearest_lift_harmonic_lift", 1e6),
        row("Surge amplitude, 0 to peak (N)", "surge_amplitude_force"),
        ("Coil clash", ()),
        row("Coil contacts", "clash_count"),
        ("\u2003largest by energy: coils", ("–", "1–2", "–", "–")),
        ("\u2003its peak at cam angle (deg)", ("–", "251", "–", "–")),
        ("\u2003valve lift there (mm)", ("–", "0", "–", "–")),
        ("\u2003impulse (mN\xa0s)", ("–", "31", "–", "–")),
        row("Clash energy (mJ)", "clash_energy", 1e3),
        ("Wire stress", ()),
        row("Peak shear stress (MPa)", "peak_shear_stress", 1e-6),
        row("Minimum shear stress (MPa)", "minimum_shear_stress", 1e-6),
        row(
            "Shear stress by EN 13906-1 at the largest lift (MPa)",
            "open_nominal_shear_stress",
            1e-6,
        ),
        row("Shear stress by EN 13906-1, valve closed (MPa)", "closed_nominal_shear_stress", 1e-6),
    ]


def test_answers_of_a_train_stand_under_its_sets():
    study = STUDIES["train"]()
    card, (stock, race) = card_of(study), study.solutions
    assert card.headers == ("stock, multi-mass, 5600 rpm", "race, multi-mass, 5600 rpm")
    shown = dict(card.lines)
    for words, name, factor in (
        ("Clearance to coil bind, outer spring (mm)", "outer_coil_bind_clearance", 1e3),
        ("Seating velocity (m/s)", "seating_velocity", 1),
        ("Bounce height (mm)", "bounce_height", 1e3),
        ("Loft (mm)", "loft_gap", 1e3),
        ("Bounces", "bounce_count", 1),
        ("Time without contact (ms)", "loss_of_contact_duration", 1e3),
        ("Peak retainer force below 10 kHz (N)", "peak_retainer_force", 1),
    ):
        assert shown[words] == tuple(
            four(run.quantities[name] * factor) for run in (stock, race)
        ), words
    assert (
        shown["Contact-loss speed, rigid parts (rpm)"] == (four(700 * 30 / np.pi),) * 2
    )  # of the study, not of a run


def test_a_sweep_answers_with_the_worst_of_each_label_and_its_speed():
    card = card_of(sweep_study())
    assert card.headers == ("stock", "<race & co>")
    beyond = "\u2003beyond 6217 rpm"
    assert card.lines == (
        ("Spring force and coil bind", ()),
        ("Peak spring force below 10 kHz (N)", ("740 at 5818 rpm", "768 at 5818 rpm")),
        (beyond, ("820 at 8000 rpm", "864 at 8000 rpm")),
        ("Minimum spring force (N)", ("217 at 5818 rpm",) * 2),
        (beyond, ("181 at 8000 rpm", "181 at 8000 rpm")),
        ("Surge", ()),
        ("Surge frequency (Hz)", ("560", "672")),
        ("Surge amplitude, 0 to peak (N)", ("64.71 at 4182 rpm", "64.8 at 4727 rpm")),
        (beyond, ("64.99 at 7455 rpm", "–")),
        ("Coil clash", ()),
        ("Clash energy (mJ)", ("7 at 5818 rpm", "8.4 at 5818 rpm")),
        (beyond, ("11 at 8000 rpm", "13.2 at 8000 rpm")),
        ("Seating and contact", ()),
        ("Seating velocity (m/s)", ("0.34 at 5818 rpm",) * 2),
        (beyond, ("0.42 at 8000 rpm",) * 2),
        ("Lift lost (mm)", ("0.07 at 5818 rpm",) * 2),
        (beyond, ("0.11 at 8000 rpm",) * 2),
    )  # the speeds where control is lost stand in their own table


def test_critical_speeds_stand_in_a_table_with_how_they_were_searched():
    grid, legend, details = blocks("critical-speeds", sweep_study())
    limits, note, ranges = details.blocks
    told = cells(grid)
    assert (
        told[0] == ["Contact-loss speed", "6207–6217, at the cam", "not computed"]
        and told[6][1] == "none up to 8000"
    )
    assert [row[0].strip() for row in told[1:6]] == [
        "until",
        "again",
        "Float speed",
        "until",
        "rising / falling speed",
    ]
    # the long cells of two columns scrolled on a wide page
    assert grid.rows[0][0][1].tone == "number wraps" and grid.right[1]
    assert told[3][1] == FLOAT and told[5][1] == "6875–6885 / 6589–6599"
    assert all(f"{word}:" in legend.html for word in ("until", "rising / falling speed", "again"))
    assert "Just touching zero" in ranges.html and "Motion does not repeat" in ranges.html
    assert (
        "from 2000 to 8000 rpm" in note.html
        and "0.05 mm" in limits.html
        and "0.1 mm" in limits.html
        and "10 % of its lift" in limits.html
        and "10 rpm" in note.html
    )
    assert blocks("critical-speeds", STUDIES["own"]()) == ()


def test_many_runs_stand_below_each_other_a_question_a_table():
    speeds = [1000.0 + 100 * n for n in range(9)]
    study = own_study(
        tuple(
            replace(
                rod_run(speed * RPM),
                quantities={"peak_spring_force": 500.0 + n, "clash_energy": 1e-3 * n},
            )
            for n, speed in enumerate(speeds)
        )
    )
    force, clash = the(Cards, blocks("answers", study)).cards
    assert force.title == "Spring force and coil bind"
    assert force.headers == ("Peak spring force below 10 kHz (N)",)
    assert force.lines[3] == (f"{NAMES[0]}, 1300 rpm", ("503",)) and len(force.lines) == 9
    assert (clash.title, clash.headers, clash.lines[8]) == (
        "Coil clash",
        ("Clash energy (mJ)",),
        (f"{NAMES[0]}, 1800 rpm", ("8",)),
    )


def test_the_largest_clashes_are_listed_with_their_own_numbers():
    grid = the(Grid, blocks("answers", own_study()))
    assert grid.headers == (
        "coils",
        "first touch (cam deg)",
        "hardest (cam deg)",
        "impulse (mN s)",
        "energy (mJ)",
        "peak force (N)",
    )
    rows = [
        ["1–2", str(249 + n), str(250 + n), four(31 / n), four(17 / n), four(345 / n)]
        for n in range(1, 6)
    ]
    assert cells(grid) == [[f"{NAMES[0]}, 5600 rpm: 5 of 7 clashes"], *rows]
    several = own_study((rod_run(4200 * RPM), rod_run(), replace(rod_run(3000 * RPM, bounces=2))))
    first, more = blocks("answers", several)[1:]
    assert first.headers[0] == "largest clash" and [row[0] for row in cells(first)] == [
        f"{NAMES[0]}, {n} rpm" for n in (3000, 4200, 5600)
    ]
    assert (
        isinstance(more, Details)
        and more.summary == "The 5 largest clashes of each run"
        and len(more.blocks[0].rows) == 3 + 2 + 5 + 5
    )


def test_failed_runs_are_named_first():
    broken = replace(
        rod_run(),
        status=Status(
            "diverged", "the force is not finite", 0.0123, "coil 2", "use a smaller step"
        ),
    )
    first = blocks("answers", own_study((broken,)))[0]
    assert isinstance(first, Text) and first.tone == "alert"
    assert all(
        word in first.html for word in ("5600 rpm", "the force is not finite", "use a smaller step")
    )
    assert not [
        one
        for one in blocks("answers", own_study())
        if isinstance(one, Text) and one.tone == "alert"
    ]


def test_frequencies_and_their_differences_in_percent():
    grid = the(Grid, blocks("at-rest", own_study()))
    assert grid.headers == (
        "axial mode",
        f"{NAMES[0]} (Hz)",
        "multi-mass chain (Hz)",
        "difference (%)",
    )
    assert cells(grid) == [
        ["1", "631", "620", "−1.7"],
        ["2", "1120", "1210", "8"],
        ["3", "1639", "–", "–"],
    ]


def test_a_curve_or_modes_that_ended_early_say_so():
    rod, chain = at_rest()
    ended = Status("not-converged", "no equilibrium beyond 9 mm", 0.0, "9.1 mm", "compress less")
    for changed, words in (
        (replace(rod, curve=replace(rod.curve, status=ended)), "static curve"),
        (replace(rod, modes=replace(rod.modes, status=ended)), "modes"),
    ):
        told = [
            one.html
            for one in blocks("at-rest", replace(own_study(), rest=(changed, chain)))
            if isinstance(one, Text)
        ]
        assert (
            len(told) == 1
            and f"{NAMES[0]}, {words}:" in told[0]
            and "no equilibrium beyond 9 mm" in told[0]
        )
    assert not [one for one in blocks("at-rest", own_study()) if isinstance(one, Text)]


def test_stresses_in_megapascal_by_run():
    study = STUDIES["own"]()
    grid = the(Grid, blocks("stress", study))
    assert grid.headers[:2] == ("", "unit") and grid.headers[2:] == tuple(
        f"{name}, {speed} rpm" for name in NAMES for speed in (4200, 5600)
    )
    for row, name in zip(
        cells(grid),
        (
            "peak_shear_stress",
            "minimum_shear_stress",
            "open_nominal_shear_stress",
            "closed_nominal_shear_stress",
        ),
        strict=True,
    ):
        values = [run.quantities.get(name) for run in study.solutions]
        assert row[1:] == [
            "MPa",
            *(four(None if value is None else value * 1e-6) for value in values),
        ], name


def test_values_of_the_case_with_status_and_source():
    grid = the(Grid, blocks("case", own_study()))
    assert grid.headers == ("value of the case", "", "status", "source") and grid.choices == (
        ("status", ("measured", "estimated")),
    )
    assert cells(grid) == [
        ["spring / wire diameter", "4 mm", "measured", "own drawing"],
        ["spring / pitch", "7 mm", "estimated", ""],
    ]
    changed = replace(
        own_study(),
        record=replace(own_study().record, changed=("spring.pitch", "damping.mass_damping")),
    )
    assert (
        blocks("case", changed)[0].html
        == "Changed for this run: spring.pitch, damping.mass_damping."
    )
    assert isinstance(blocks("case", own_study())[0], Grid)


def test_how_each_run_was_computed():
    options = {
        "elements_per_coil": 24,
        "mass_damping": 12.5,
        "output_step": np.pi / 360,
        "coil_contact": True,
        "solver": "newton",
    }
    origin = replace(
        rod_run().provenance, options=options, created_at="2026-01-02", package_version="1.5"
    )
    stopped = replace(
        modal_run(),
        status=Status(
            "diverged", "the force is not finite", 0.0123, "coil 2", "use a smaller step"
        ),
    )
    study = own_study(
        (
            replace(
                rod_run(),
                provenance=origin,
                statistics={"steps": 10, "time_step": 4e-6, "gone": None},
            ),
            stopped,
        )
    )
    grid, versions = blocks("runs", study)
    assert grid.headers == ("run", "engine speed", "ended", "options and statistics")
    assert cells(grid)[0] == [
        NAMES[0],
        "5600 rpm",
        "completed",
        "elements per coil 24, mass damping 12.5 1/s, output step 0.5 deg, coil contact true, solver newton, steps 10, "
        "time step 4·10⁻⁶ s",
    ]
    assert (
        cells(grid)[1][:2] == [NAMES[1], "5600 rpm"]
        and "the force is not finite" in cells(grid)[1][2]
    )
    assert [row[0][2].tone for row in grid.rows] == ["good", "bad", "good", "good"]
    assert cells(grid)[2] == [
        NAMES[0],
        "at rest, spring",
        "completed",
        "elements per coil 24, wall time (s) 0.4",
    ]
    assert cells(grid)[3] == ["multi-mass chain", "at rest, spring", "completed", ""]
    digest = study.record.digest
    assert (
        versions.html
        == f"Versions: valvetrain 1.5, Python 3.12, numpy 2.0. Case digest {digest}. Computed 2026-01-02."
    )
    many = blocks("runs", sweep_study())
    assert (
        isinstance(many[0], Details)
        and many[0].summary == "Options and statistics of 24 runs"
        and len(many[0].blocks[0].rows) == 24
    )
    bare = replace(study, record=replace(study.record, text=""), solutions=(study.solutions[0],))
    assert "Case digest abc." in blocks("runs", bare)[-1].html
    rod, chain = at_rest()
    half = replace(rod, modes=replace(rod.modes, status=Status("not-converged", "no modes")))
    assert "no modes" in cells(blocks("runs", replace(study, rest=(half, chain)))[0])[2][2]


def test_events_with_angle_duration_and_size_each_in_its_unit():
    def event(
        kind: str, degrees: float, duration: float, size: float, unit: str, where: str, cause: str
    ) -> Event:
        return Event(kind, np.radians(degrees), 0.01, duration, size, unit, where, {"cause": cause})

    stock, race = train_study().solutions
    stock = replace(
        stock,
        events=(
            event("loft", 361.5, 4e-4, 2e-5, "m", "cam", "surge"),
            event("clash", 10, 0, 1, "N", "", ""),
        ),
    )
    race = replace(race, events=(event("bounce", 236, 1e-4, 0.37, "m/s", "seat", "rebound"),))
    grid = the(Grid, blocks("events", replace(train_study(), solutions=(stock, race))))
    assert grid.headers == (
        "run",
        "engine speed",
        "event",
        "place",
        "cam angle (deg)",
        "duration (ms)",
        "size",
        "unit",
        "cause",
    )
    assert [row[:6] + row[7:] for row in cells(grid)] == [
        ["stock, multi-mass", "5600 rpm", "loft", "cam", "1.5", "0.4", "m", "surge"],
        ["race, multi-mass", "5600 rpm", "bounce", "seat", "236", "0.1", "m/s", "rebound"],
    ]
    assert cells(grid)[1][6] == "0.37" and cells(grid)[0][6] not in ("", "0.37")
    assert grid.choices == (
        ("run", ("stock, multi-mass", "race, multi-mass")),
        ("engine speed", ("5600 rpm",)),
        ("event", ("loft", "bounce")),
    )
    many = replace(
        stock, events=tuple(event("loft", n, 1e-4, 1e-5, "m", "cam", "") for n in range(30))
    )
    (folded,) = blocks("events", replace(train_study(), solutions=(many,)))
    assert (
        isinstance(folded, Details)
        and folded.summary == "30 events"
        and not folded.blocks[0].caption
    )
    most = replace(stock, events=many.events * 14)
    (folded,) = blocks("events", replace(train_study(), solutions=(most,)))
    assert (
        len(folded.blocks[0].rows) == 400
        and folded.blocks[0].caption == "The first 400 of 420; all of them are in events.csv."
    )
    assert blocks("events", replace(train_study(), command="sweep")) == ()


def row(
    quantity: str, unit: str, given: float, computed: float | None, verdict: str, **more
) -> Comparison:
    difference = None if computed is None else computed - given
    known = {
        "engine_speed": 5600 * RPM,
        "model": "finite-element",
        "origin": "engine head test",
        "role": "prediction",
        "tolerance": None,
    }
    return Comparison(
        quantity=quantity,
        unit=unit,
        published=given,
        computed=computed,
        difference=difference,
        verdict=verdict,
        **(known | more),
    )


COMPARED = (
    row("stage_2_peak_force", "N", 790.0, 805.0, "within tolerance", tolerance=24.0, source="table 3"),
    row("coil_1_2_installed_gap", "mm", 2e-3, 1.5e-3, "misses by -25.0 %, tolerance 3.0 %", engine_speed=None, role="calibration",
        used_for="the pitch"),
    row("stage_2_peak_cam_angle", "deg", np.radians(170), np.radians(171.5), "differs by +1.5 deg", model="modal-varied",
        origin="solid finite elements"),
    row("preload", "N", 280.0, None, "not computed", engine_speed=None, model=""),
    row("largest_clash_impulse", "mN s", 0.031, 0.031, "differs by +0.0 %", engine_speed=4200 * RPM),
)  # fmt: skip


def test_given_and_computed_stand_in_their_own_columns():
    grid = blocks("published", replace(published_study(), comparisons=COMPARED))[1]
    assert grid.headers == (
        "quantity",
        "engine speed",
        "given by",
        "given",
        "model",
        "computed",
        "difference",
        "",
        "unit",
        "role",
        "verdict",
    )
    assert cells(grid) == [
        [
            "Installed gap of coils 1 and 2",
            "at rest",
            "EX",
            "2",
            NAMES[0],
            "1.5",
            "−0.5",
            "−25.0 %",
            "mm",
            "calibration",
            "misses by −25.0 %, tolerance 3.0 %",
        ],
        ["Preload", "at rest", "EX", "280", "", "–", "–", "", "N", "prediction", "not computed"],
        [
            "Largest clash impulse",
            "4200 rpm",
            "EX",
            "31",
            NAMES[0],
            "31",
            "0",
            "0.0 %",
            "mN s",
            "prediction",
            "no tolerance stated",
        ],
        [
            "Stage II peak force",
            "5600 rpm",
            "EX",
            "790",
            NAMES[0],
            "805",
            "+15",
            "+1.9 %",
            "N",
            "prediction",
            "within tolerance",
        ],
        [
            "Stage II peak, cam angle",
            "5600 rpm",
            "FE",
            "170",
            NAMES[1],
            "171.5",
            "+1.5",
            "",
            "deg",
            "prediction",
            "no tolerance stated",
        ],
    ]
    assert {cells_of[0].text: cells_of[-2].hint for cells_of, _ in grid.rows}[
        "Installed gap of coils 1 and 2"
    ] == "the pitch"
    tones = {cells_of[0].text: cells_of[-1].tone for cells_of, _ in grid.rows}
    assert (
        tones["Stage II peak force"],
        tones["Installed gap of coils 1 and 2"],
        tones["Preload"],
    ) == ("good", "bad", "quiet")


def test_findings_keep_their_own_words():
    grid = blocks("published", published_study())[2]
    assert grid.headers == (
        "place in the source",
        "finding of the source",
        "computed here",
        "verdict",
    )
    assert cells(grid) == [["section 4", "Stage II has a valley", "valley of 412 N", "holds"]]
    assert blocks("published", replace(published_study(), comparisons=(), findings=())) == ()


ROWS = (
    Uncertainty("preload", None, 287.0, 1.5, 2.1, 286.0, 0.0, (287.0, 287.0), (280.0, 290.0)),
    Uncertainty("peak_spring_force", 5600 * RPM, 811.0, 12.0, None, 805.0, 3.0, (801.0, 822.0), (790.0, 834.0)),
    Uncertainty("main_clash_cam_angle", 5600 * RPM, np.radians(250), np.radians(0.5), 0.4, np.radians(251), np.radians(0.25),
                (np.radians(248), np.radians(252)), (np.radians(249), np.radians(253))),
    Uncertainty("main_clash_impulse", 4200 * RPM, 0.035, 7e-4, 1.3, 0.036, 1e-4, (0.033, 0.037), (0.032, 0.038)),
    Uncertainty("peak_shear_stress", 4200 * RPM, 551e6, 2e6, 1.9, 553e6, 1e6, (541e6, 561e6), (531e6, 571e6)),
)  # fmt: skip


def test_uncertainties_stand_in_their_own_columns():
    grid = uncertainty_grid(ROWS)
    assert grid.headers == (
        "quantity",
        "value",
        "± numerical",
        "",
        "unit",
        "order",
        "extrapolated",
        "contact stiffness × 0.5 to 2",
        "damping × 0.6 to 1.5",
    )
    assert cells(grid) == [
        ["Statics and modes"],
        ["preload", "287", "1.5", "0.52 %", "N", "2.1", "286", "287", "280 to 290"],
        ["Engine speed 5600 rpm"],
        "peak spring force below 10 kHz|811|12|1.5 %|N|–|805|801 to 822|790 to 834".split("|"),
        ["main clash, cam angle", "250", "0.5", "", "deg", "–", "251", "248 to 252", "249 to 253"],
        ["Engine speed 4200 rpm"],
        ["main clash, impulse", "35", "0.7", "2 %", "mN s", "1.3", "36", "33 to 37", "32 to 38"],
        [
            "peak shear stress",
            "551",
            "2",
            "0.36 %",
            "MPa",
            "1.9",
            "553",
            "541 to 561",
            "531 to 571",
        ],
    ]
    written = uncertainty_table(ROWS)
    assert [column.header for column in written.columns] == [
        "quantity",
        "engine speed [rpm]",
        "unit",
        "value",
        "numerical uncertainty",
        "observed order",
        "extrapolated",
        "part of the step",
        "least over contact stiffness",
        "largest over contact stiffness",
        "least over damping",
        "largest over damping",
    ]
    second = list(written.rows())[1]
    assert (
        second[:3] == ("peak_spring_force", 5600.0, "N")
        and second[3:5] == (811.0, 12.0)
        and np.isnan(second[5])
    )
    assert second[6:] == (805.0, 3.0, 801.0, 822.0, 790.0, 834.0)


def test_the_page_of_a_refinement_names_its_meshes():
    study = UncertaintyStudy(CaseRecord("own", "Own spring", "A spring."), (16, 24, 36), ROWS, {})
    page = uncertainty_page(study)
    assert (
        page.title == "Own spring: uncertainty"
        and page.kicker == "Refinement study"
        and page.lead == "A spring."
    )
    assert dict(page.facts) == {
        "case": "own",
        "elements per coil": "16, 24, 36",
    } and "16, 24, 36 elements per coil" in lead((16, 24, 36))
    assert [type(block) for block in page.sections[0].blocks] == [Text, Grid]


@pytest.mark.parametrize(
    ("name", "kicker", "facts"),
    [
        (
            "own",
            "Comparison of models",
            {
                "case": "own-spring",
                "engine speed": "4200, 5600 rpm",
                "spring model": ", ".join(NAMES),
                "runs": "4 of 4 completed",
            },
        ),
        (
            "train",
            "Run",
            {
                "case": "own-train",
                "engine speed": "5600 rpm",
                "spring model": "stock, multi-mass; race, multi-mass",
                "runs": "2 of 2 completed",
            },
        ),
        (
            "sweep",
            "Sweep over engine speed",
            {
                "case": "own-train",
                "engine speed": "12 from 2000 to 8000 rpm",
                "spring model": "stock, <race & co>",
                "runs": "22 of 24 settled; not settled: stock at 8000 rpm; <race & co> at 8000 rpm",
            },
        ),
    ],
)
def test_the_head_of_a_page_says_what_was_run(name, kicker, facts):
    page = study_page(STUDIES[name]())
    assert (page.kicker, dict(page.facts)) == (kicker, facts)
    assert page.lead == "A spring. It is made up." and page.title == (
        "Spring of my own" if name == "own" else "Train of my own"
    )


def test_tabs_and_titles_bear_the_speed_that_they_show():
    study = STUDIES["own"]()
    for section, title in (
        ("motion", "Prescribed motion at {} rpm"),
        ("energy", f"Energy balance: {NAMES[0]}, {{}} rpm"),
        ("stress", f"Wire stress: {NAMES[0]}, {{}} rpm"),
        ("coils", f"Coil motion: {NAMES[0]}, {{}} rpm"),
    ):
        tabs = the(Tabs, blocks(section, study))
        assert [label for label, _ in tabs.items] == ["4200 rpm", "5600 rpm"]
        assert [inner[0].chart.title for _, inner in tabs.items] == [
            title.format(speed) for speed in (4200, 5600)
        ]
    told = STUDIES["published"]()
    titles = [inner[0].chart.title for _, inner in the(Tabs, blocks("gu2021", told)).items]
    assert titles == ["Force by stages at 4200 rpm", "Force by stages at 5600 rpm"]


def test_a_source_speaks_where_its_values_or_its_findings_stand_beside_the_runs():
    told = published_study()
    remarks = replace(told.record, remarks=("Said of the original.",))
    for comparisons, findings, speaks in (
        (told.comparisons, (), True),
        ((), told.findings, True),
        ((), (), False),
    ):
        study = replace(told, record=remarks, comparisons=comparisons, findings=findings)
        assert bool(study_page(study).lead) is speaks and bool(blocks("gu2021", study)) is speaks
        assert (
            any(
                isinstance(one, Text) and one.html == "Said of the original."
                for one in blocks("case", study)
            )
            is speaks
        )
