"""Rotations and poses. A pose is a 4x4 matrix T_target_source: p_target = T_target_source @ p_source."""

import numpy as np


def pose(position, quaternion_xyzw):
    """4x4 from a position (3) in metres and a quaternion (x, y, z, w) of any length but 0."""
    x, y, z, w = np.asarray(quaternion_xyzw, float) / np.linalg.norm(quaternion_xyzw)
    T = np.eye(4)
    T[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                 [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                 [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    T[:3, 3] = position
    return T


def quaternion(R):
    """(x, y, z, w) of a rotation matrix, from its largest component: exact enough for every rotation."""
    squares = np.array([1 + R[0, 0] - R[1, 1] - R[2, 2], 1 - R[0, 0] + R[1, 1] - R[2, 2],
                        1 - R[0, 0] - R[1, 1] + R[2, 2], 1 + R[0, 0] + R[1, 1] + R[2, 2]])
    k = int(np.argmax(squares))
    xy, xz, yz = R[0, 1] + R[1, 0], R[0, 2] + R[2, 0], R[1, 2] + R[2, 1]
    wx, wy, wz = R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]
    rows = [[squares[0], xy, xz, wx], [xy, squares[1], yz, wy], [xz, yz, squares[2], wz], [wx, wy, wz, squares[3]]]
    q = np.array(rows[k])
    return q / np.linalg.norm(q)


def is_pose(T):
    """A rotation, and a place within the 1e8 m that the protocol knows."""
    return (T.shape == (4, 4) and np.isfinite(T).all() and np.abs(T[:3, 3]).max() <= 1e8 and
            np.allclose(T[:3, :3] @ T[:3, :3].T, np.eye(3), atol=1e-6) and np.linalg.det(T[:3, :3]) > 0)


def inverse(T):
    out = np.eye(4)
    out[:3, :3] = T[:3, :3].T
    out[:3, 3] = -T[:3, :3].T @ T[:3, 3]
    return out


def transform(T, points):
    """Points (n, 3) of the source frame in the target frame."""
    return points @ T[:3, :3].T + T[:3, 3]


def angle_rad(R):
    """Of the whole rotation, 0 to pi."""
    x, y, z, w = quaternion(R)
    return 2 * np.arctan2(np.sqrt(x * x + y * y + z * z), abs(w))


def levelled(T_local_sensor, points_sensor):
    """Points in the levelled frame: origin and heading of the sensor, z along gravity."""
    R = T_local_sensor[:3, :3]
    yaw = np.arctan2(R[1, 0], R[0, 0])
    c, s = np.cos(yaw), np.sin(yaw)
    return points_sensor @ (np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) @ R).T
