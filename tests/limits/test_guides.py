"""Limits: a spring in its guide. The walls bound how far it bows, their forces balance those of the
ends, energy is kept, and a guide
that is not touched changes no bit."""

from __future__ import annotations

import numpy as np
import pytest

from spring_shapes import cylindrical
from valvetrain.cosserat.batch import simulate_batch
from valvetrain.cosserat.buffer import RodDynamics
from valvetrain.cosserat.state import advance
from valvetrain.cosserat.static import compress
from valvetrain.cosserat.transient import simulate
from valvetrain.errors import InputError
from valvetrain.parameters.card import SpringCard
from valvetrain.parameters.installed_spring import Guide, InstalledSpring
from valvetrain.runs.statics import rod_statics, static_curve
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.finite_element_channels import rod_channels

#: L0/D = 7.2, outer diameter 11.2 mm, inner 8.8 mm; buckles at 18.2 mm where nothing holds it.
SPRING = cylindrical("1.2 mm", "10 mm", "6 mm", 12, ends="open", name="slender")
BORE, ROD = Guide(bore="12 mm"), Guide(rod="8.0 mm")
DEEP = 0.023


def rod_in(guide: Guide | None, compression: float = 5e-3, **dynamics: float) -> FiniteElementRod:
    return FiniteElementRod(SPRING, compression, 12, RodDynamics(**dynamics), guide=guide)


@pytest.fixture(
    scope="module", params=[BORE, ROD, Guide(bore="12 mm", rod="8 mm")], ids=["bore", "rod", "both"]
)
def leaning(request):
    rod = rod_in(request.param)
    return rod, compress(rod.statics, [DEEP])[-1]


def test_the_wire_stays_within_its_walls_but_for_their_give(leaning):
    """Without walls it bows by 8 mm here; the wall gives by its force over its stiffness, well
    below a tenth of a micrometre.
    """
    rod, result = leaning
    assert result.converged
    radius = np.hypot(*result.state.position.T[:2])
    assert np.max(radius) <= (rod.guide.bore or np.inf) / 2 - 0.6e-3 + 1e-7
    assert np.min(radius) >= (rod.guide.rod or 0.0) / 2 + 0.6e-3 - 1e-7
    bare = compress(rod_in(None).statics, [DEEP])[-1].state.position
    assert np.max(np.hypot(*bare.T[:2])) > 10e-3


def test_the_walls_and_both_ends_balance_sideways(leaning):
    """Sum of the guide's forces and of the lateral end forces is nothing, while the ends carry a
    share of it.
    """
    rod, result = leaning
    _, residual, _, _ = rod.statics.assemble(result.state)
    held = ~rod.statics.free.reshape(-1, 6)[:, 0]
    ends = residual.reshape(-1, 6)[held, :3].sum(axis=0)
    walls = rod.mesh.guide.forces(result.state.position, rod.mesh.node_length)
    assert np.abs(walls).sum() > 0.1
    assert ends + walls.sum(axis=0) == pytest.approx(np.array([0.0, 0.0, ends[2]]), abs=1e-5)
    assert np.abs(walls[:, :2]).sum() >= rod.mesh.guide.pressed(
        result.state.position, rod.mesh.node_length
    )


def test_a_guided_spring_keeps_its_rate_and_says_that_it_leans():
    curve = static_curve(rod_in(BORE), DEEP, 8)[0]
    assert curve.status.completed and "leans on its guide" in curve.status.message
    assert curve.stiffness[-1] > 0.9 * curve.stiffness[0]
    assert static_curve(rod_in(None), DEEP, 8)[0].stiffness[-1] < 0.2 * curve.stiffness[0]


def test_the_place_of_first_touch_moves_with_no_step():
    found = [static_curve(rod_in(BORE), DEEP, steps)[0].leaning for steps in (3, 11)]
    assert found[0].compression == pytest.approx(found[1].compression, abs=1e-7)
    assert found[0].force == pytest.approx(found[1].force, rel=1e-4)


def test_residual_and_tangent_of_the_walls_are_the_slopes_of_their_energy():
    rod = rod_in(Guide(bore="11.3 mm", rod="8.7 mm"))
    rng = np.random.default_rng(1)
    state = rod.statics.solve(compress(rod.statics, [2e-3])[-1].state, 2e-3).state
    pushed = advance(
        state, rng.normal(0.0, 1.5e-4, rod.statics.free.shape) * rod.statics.free, 2e-3
    )
    depth = rod.mesh.guide.depth(pushed.position)
    assert depth.max() > 0 > depth.min()
    way = (
        rng.normal(0.0, 1.0, rod.statics.free.shape)
        * rod.statics.free
        * np.tile([1.0, 1, 1, 0, 0, 0], rod.mesh.vertices)
    )
    step = 1e-9
    ahead, behind = (
        rod.statics.assemble(advance(pushed, sign * step * way, 2e-3)) for sign in (1, -1)
    )
    _, residual, *_ = rod.statics.assemble(pushed)
    assert (ahead[0] - behind[0]) / (2 * step) == pytest.approx(residual @ way, rel=1e-5)
    slope = (ahead[1] - behind[1]) / (2 * step)
    assert np.abs(slope - rod.statics.tangent(pushed) @ way).max() < 1e-5 * np.abs(slope).max()


def test_energy_is_kept_while_it_leans_in_motion():
    """1500 strokes a minute into the wall: kinetic, elastic and contact energy and what damping
    took add up to the work done.
    """
    rod = rod_in(BORE, 0.012, mass_damping=20.0, stiffness_damping=1e-6)
    run = simulate(
        rod.mesh,
        rod.installed.state,
        lambda time: 0.012 + 0.005 * (1 - np.cos(2 * np.pi * 25 * time)),
        1e-4,
        400,
        rod.dynamics,
    )
    found = rod_channels(rod, run, 1.0)
    stored = sum(
        found[name].values for name in ("kinetic_energy", "elastic_energy", "contact_energy")
    )
    books = stored + found["energy_dissipated"].values - found["work_done"].values
    assert np.max(found["guide_force"].values) > 1.0 and np.min(found["guide_force"].values) == 0.0
    assert np.ptp(books) < 2e-4 * np.ptp(found["elastic_energy"].values)


def test_a_leaning_equilibrium_stays_at_rest_in_time():
    """Forces of the compiled step are those of the statics: in a millisecond nothing moves, though
    the wall bears 1 N.
    """
    rod = rod_in(BORE, DEEP)
    assert rod.mesh.guide.pressed(rod.installed.state.position, rod.mesh.node_length) > 0.5
    run = simulate(
        rod.mesh, rod.installed.state, lambda time: np.full_like(time, DEEP), 1e-4, 10, rod.dynamics
    )
    assert np.abs(run.position[-1] - rod.installed.state.position).max() < 1e-9
    assert run.seat_force == pytest.approx(np.full(11, rod.installed.seat_force), rel=1e-5)


def test_the_step_of_a_train_feels_the_wall_too():
    """The contract's own kernel from a leaning equilibrium: its forces are those of the statics,
    and a thousand steps keep them.
    """
    rod = rod_in(BORE, 0.018)
    step = rod.stable_time_step()
    rod = rod.with_time_step(step)
    state = rod.initial_state(DEEP - 0.018)
    assert rod.force(state, DEEP - 0.018).seat == pytest.approx(
        compress(rod.statics, [DEEP])[-1].seat_force, rel=1e-4
    )
    for _ in range(1000):
        ends = rod.kernel(rod.parameters(), rod.integers(), state, DEEP - 0.018, 0.0, step)
    assert ends[1] == pytest.approx(
        rod.force(rod.initial_state(DEEP - 0.018), DEEP - 0.018).seat, rel=1e-5
    )
    bowed = rod.rod_state(state, DEEP - 0.018).position
    assert rod.mesh.guide.pressed(bowed, rod.mesh.node_length) > 0.5


def test_a_guide_that_is_not_touched_changes_no_bit():
    runs = []
    for guide in (None, Guide(bore="60 mm", rod="1 mm")):
        rod = rod_in(guide, 0.006)
        runs.append(
            simulate(
                rod.mesh,
                rod.installed.state,
                lambda time: 0.006 + 0.5 * time,
                2e-5,
                60,
                rod.dynamics,
            )
        )
    bare, guided = runs
    assert np.array_equal(bare.dense_seat_force, guided.dense_seat_force) and np.array_equal(
        bare.position, guided.position
    )
    assert bare.time_step == guided.time_step


def test_rods_side_by_side_lean_as_one_alone():
    """In the lanes of a batch, beside one in a wider bore."""
    rods = [rod_in(guide, 0.012) for guide in (BORE, Guide(bore="12.4 mm"))]

    def motion(time):
        return 0.012 + 0.005 * (1 - np.cos(2 * np.pi * 25 * np.asarray(time)))

    batch = simulate_batch(
        [rod.mesh for rod in rods],
        [rod.installed.state for rod in rods],
        motion,
        1e-4,
        200,
        rods[0].dynamics,
    )
    for place, rod in enumerate(rods):
        alone = simulate(
            rod.mesh, rod.installed.state, motion, 1e-4, 200, rod.dynamics, batch.time_step
        )
        assert float(rod.mesh.guide.pressed(alone.position, rod.mesh.node_length).max()) > 0.2
        assert batch.seat_force[place] == pytest.approx(alone.seat_force, rel=1e-6)


@pytest.mark.parametrize(
    ("guide", "words"),
    [
        ({"bore": 0.0112}, "outer diameter is 11.2 mm"),
        ({"rod": 0.009}, "inner diameter is 8.8 mm"),
        ({}, "needs the diameter"),
        ({"bore": -0.02}, "bore of the guide"),
        ({"bore": 0.02, "stiffness": 0.0}, "stiffness of the guide: .* above zero"),
    ],
)
def test_a_guide_that_cannot_be_is_refused(guide, words):
    with pytest.raises(InputError, match=words):
        InstalledSpring(SPRING, precompression=5e-3, guide=Guide(**guide))


def test_a_card_has_no_wire_to_lean():
    with pytest.raises(InputError, match="cannot lean on a guide"):
        InstalledSpring(card=SpringCard(preload=300.0, rate=40e3), guide=BORE)


def test_modes_about_a_state_that_leans_say_so_as_its_curve_does():
    spring = cylindrical("2 mm", "12 mm", total_coils=12, free_length="100 mm")
    one = rod_statics(FiniteElementRod(spring, 30e-3, 8, guide=Guide(bore="22 mm")), 32e-3, 8, 6)
    assert one.curve.leaning is not None and "leans on its guide" in one.modes.status.message
    assert "does not yet touch" not in one.modes.status.message
