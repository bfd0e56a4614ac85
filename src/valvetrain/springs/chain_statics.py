"""Static equilibrium of a chain with unilateral contact: Newton on a convex piecewise quadratic
energy, with line search.
"""

from __future__ import annotations

import numpy as np

from valvetrain.arrays import Array
from valvetrain.coil_contact.law import ContactResponse, contact_response
from valvetrain.errors import InputError
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.springs.chain_layout import ChainLayout, chain_from_definition

CONTACT_STIFFNESS = 1e10
#: Elements per turn of the chain that reduces a definition.
REDUCTION_MESH = 24


def contact_depths(layout: ChainLayout, nodes: Array) -> Array:
    """Overlap (m, negative when open) of every contact for node positions (N + 1,), compressive
    from the free state; of (N + 1, n) positions at n instants (p, n).
    """
    c = layout.contacts
    upper, lower, next_one = nodes[c.upper].T, nodes[c.lower].T, nodes[c.lower + 1].T
    depth: Array = (upper - lower * (1 - c.fraction) - next_one * c.fraction - c.gap).T
    if c.ends:
        depth[-c.ends :] = ((c.end_rows @ nodes).T - c.gap[-c.ends :]).T
    return depth


def contact_rows(layout: ChainLayout) -> Array:
    """Gradient of every contact depth by the node positions, shape (p, N + 1)."""
    c = layout.contacts
    rows = np.zeros((c.count, len(layout.coil_number)))
    index = np.arange(c.count)
    np.add.at(rows, (index, c.upper), 1.0)
    np.add.at(rows, (index, c.lower), -(1 - c.fraction))
    np.add.at(rows, (index, c.lower + 1), -c.fraction)
    if c.ends:
        rows[-c.ends :] = c.end_rows
    return rows


def element_matrix(layout: ChainLayout) -> Array:
    """Stiffness matrix (N/m) of the elements alone over all nodes, shape (N + 1, N + 1)."""
    k = layout.stiffness
    matrix = np.zeros((len(k) + 1, len(k) + 1))
    index = np.arange(len(k))
    matrix[index, index] += k
    matrix[index + 1, index + 1] += k
    matrix[index, index + 1] -= k
    matrix[index + 1, index] -= k
    return matrix


def stiffness_matrix(layout: ChainLayout, tangent: Array) -> Array:
    """Elements plus the contacts, each with its stiffness times ``tangent`` (p,): (N + 1, N + 1)."""
    rows = contact_rows(layout)
    return element_matrix(layout) + rows.T @ ((layout.contacts.stiffness * tangent)[:, None] * rows)


def contact_responses(layout: ChainLayout, nodes: Array) -> ContactResponse:
    """Force, tangent and energy (p,) of every contact over its stiffness; the tangent is 0 where it is open, 1 where the
    linear law presses.
    """
    return contact_response(layout.contacts.law, contact_depths(layout, nodes))


def potential(layout: ChainLayout, nodes: Array) -> tuple[float, float]:
    """Elastic energy of the elements and of the contacts (J)."""
    contacts = layout.contacts
    stored = contact_responses(layout, nodes).energy
    return float(layout.stiffness @ np.diff(nodes) ** 2 / 2), float(contacts.stiffness @ stored)


def solve_static(layout: ChainLayout, compression: float, iterations: int = 200) -> Array:
    """Node positions (N + 1,) at rest when the retainer is ``compression`` (m) below its free
    height.

    Raises :class:`InputError` when no equilibrium is found (never seen: the energy is convex).
    """
    elements, rows = element_matrix(layout), contact_rows(layout)
    flow = np.concatenate(([0.0], np.cumsum(1 / layout.stiffness)))
    nodes: Array = compression * flow / flow[-1]
    scale = layout.rate * max(abs(compression), 1e-6)
    for _ in range(iterations):
        found = contact_responses(layout, nodes)
        push = layout.contacts.stiffness * found.elastic
        residual = (elements @ nodes + push @ rows)[1:-1]
        if np.max(np.abs(residual)) < 1e-11 * scale * len(nodes):
            return nodes
        pressing = np.flatnonzero(
            found.tangent
        )  # few: the product over all contacts is most of the cost
        tangent = (layout.contacts.stiffness * found.tangent)[pressing, None]
        matrix = elements + rows[pressing].T @ (tangent * rows[pressing])
        move = np.zeros_like(nodes)
        move[1:-1] = np.linalg.solve(matrix[1:-1, 1:-1], -residual)
        nodes = nodes + _line_search(layout, nodes, move, float(residual @ move[1:-1])) * move
    raise InputError(
        f"no static state of the chain at {1e3 * compression:.3f} mm compression; lower the contact stiffness"
    )


def _line_search(layout: ChainLayout, nodes: Array, move: Array, slope: float) -> float:
    start, step = sum(potential(layout, nodes)), 1.0
    while step > 1e-6 and sum(
        potential(layout, nodes + step * move)
    ) > start + 1e-4 * step * slope + 1e-15 * abs(start):
        step /= 2
    return step


def static_curve(layout: ChainLayout, compressions: Array) -> tuple[Array, Array]:
    """Force (N) and tangent rate (N/m) at each compression (m) from the free state; coils close
    where the gaps say.
    """
    force, rate = np.zeros(len(compressions)), np.zeros(len(compressions))
    for i, compression in enumerate(compressions):
        nodes = solve_static(layout, float(compression))
        found = contact_responses(layout, nodes)
        matrix = stiffness_matrix(layout, found.tangent)
        pushed = (layout.contacts.stiffness * found.elastic) @ contact_rows(layout)
        force[i] = (element_matrix(layout) @ nodes + pushed)[-1]
        inner = np.linalg.solve(matrix[1:-1, 1:-1], matrix[1:-1, -1])
        rate[i] = matrix[-1, -1] - matrix[-1, 1:-1] @ inner
    return force, rate


def frequencies(layout: ChainLayout, compression: float, count: int) -> Array:
    """First ``count`` natural frequencies (Hz), both ends fixed, about the static state at a
    compression (m); touching coils stay closed.
    """
    closed = contact_responses(layout, solve_static(layout, compression)).tangent
    root = 1 / np.sqrt(layout.masses)
    matrix = root[:, None] * stiffness_matrix(layout, closed)[1:-1, 1:-1] * root
    return np.asarray(np.sqrt(np.linalg.eigvalsh(matrix)[:count]) / (2 * np.pi))


def reduction_chain(spring: SpringDefinition) -> ChainLayout:
    """Fine chain of the wire used to reduce a definition."""
    first, last = spring.free_coils
    return chain_from_definition(
        spring, max(2, round((last - first) * REDUCTION_MESH)), CONTACT_STIFFNESS
    )


def first_period_of(spring: SpringDefinition, precompression: float) -> float:
    """First natural period (s) of a wire at a precompression (m), both ends fixed, by a fine chain."""
    return 1 / float(frequencies(reduction_chain(spring), precompression, 1)[0])
