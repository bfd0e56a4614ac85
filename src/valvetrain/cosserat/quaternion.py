"""Unit quaternions (scalar first) of material frames; columns of the matrix are the directors d1,
d2, d3.
"""

from __future__ import annotations

import numpy as np

from valvetrain.arrays import Array


def from_directors(first: Array, second: Array, third: Array) -> Array:
    """Quaternions (n, 4) of the frames whose directors (n, 3) are given, neighbours of equal sign."""
    from scipy.spatial.transform import Rotation

    matrices = np.stack([first, second, third], axis=-1)
    quaternion = np.roll(Rotation.from_matrix(matrices).as_quat(), 1, axis=-1)
    flips = np.where(np.sum(quaternion[1:] * quaternion[:-1], axis=1) < 0, -1.0, 1.0)
    found: Array = quaternion * np.concatenate(([1.0], np.cumprod(flips)))[:, None]
    return found


def to_matrix(quaternion: Array) -> Array:
    """Rotation matrices (n, 3, 3) of unit quaternions (n, 4)."""
    from scipy.spatial.transform import Rotation

    found: Array = Rotation.from_quat(np.roll(quaternion, -1, axis=-1)).as_matrix()
    return found


def relative_vector(before: Array, after: Array) -> tuple[Array, Array]:
    """Scalar (n,) and vector part (n, 3) of conj(before) * after."""
    scalar = np.sum(before * after, axis=-1)
    vector = (
        before[..., :1] * after[..., 1:]
        - after[..., :1] * before[..., 1:]
        - np.cross(before[..., 1:], after[..., 1:])
    )
    return scalar, vector


def multiply(left: Array, right: Array) -> Array:
    """Quaternion products (n, 4)."""
    scalar = left[..., 0] * right[..., 0] - np.sum(left[..., 1:] * right[..., 1:], axis=-1)
    vector = (
        left[..., :1] * right[..., 1:]
        + right[..., :1] * left[..., 1:]
        + np.cross(left[..., 1:], right[..., 1:])
    )
    return np.concatenate([scalar[..., None], vector], axis=-1)


def from_rotation_vector(rotation: Array) -> Array:
    """Quaternions (n, 4) of rotation vectors (n, 3)."""
    angle = np.linalg.norm(rotation, axis=-1, keepdims=True)
    return np.concatenate(
        [np.cos(angle / 2), 0.5 * np.sinc(angle / (2 * np.pi)) * rotation], axis=-1
    )


def turn_back(quaternion: Array, vector: Array) -> Array:
    """Vectors (..., 3) seen from the frames of unit quaternions (..., 4): R^T v without forming the
    matrices.
    """
    axis = quaternion[..., 1:]
    twice = 2.0 * np.cross(vector, axis)
    return vector + quaternion[..., :1] * twice + np.cross(twice, axis)
