"""ROS messages to arrays and back. Their fields alone are used, so that those of ROS 1 and of ROS 2 will do."""

import numpy as np

INTENSITY = ("intensity", "reflectivity", "reflectance")  # the first of these that a cloud has counts, as in files
TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}


def stamp_s(header):
    stamp = header.stamp
    return stamp.secs + 1e-9 * stamp.nsecs if hasattr(stamp, "secs") else stamp.sec + 1e-9 * stamp.nanosec


def points_of(cloud):
    """(n, 3) of a sensor_msgs/PointCloud2, in its own frame, without what is not finite. ValueError: it is none."""
    return returns_of(cloud)[0]


def returns_of(cloud):
    """The same, and how strong the returns of these points were (n), as the driver says it, or None."""
    fields = {field.name: field for field in cloud.fields}
    order = ">" if cloud.is_bigendian else "<"
    strength = next((name for name in INTENSITY if name in fields and fields[name].datatype in TYPES), None)
    names = list("xyz") + ([strength] if strength else [])
    try:
        layout = np.dtype({"names": names, "formats": [order + TYPES[fields[n].datatype] for n in names],
                           "offsets": [fields[n].offset for n in names], "itemsize": cloud.point_step})
    except KeyError as missing:
        raise ValueError(f"a cloud has no field {missing} that can be read") from None
    if cloud.row_step < cloud.width * cloud.point_step or len(cloud.data) < cloud.height * cloud.row_step:
        raise ValueError(f"a cloud of {cloud.height} x {cloud.width} points has {len(cloud.data)} bytes only")
    rows = [np.frombuffer(cloud.data, layout, cloud.width, row * cloud.row_step) for row in range(cloud.height)]
    points = np.concatenate(rows) if rows else np.empty(0, layout)
    out = np.stack([points[n].astype(np.float32) for n in "xyz"], axis=1)
    finite = np.isfinite(out).all(axis=1)
    return out[finite], points[strength].astype(np.float32)[finite] if strength else None


def rotation_of(x, y, z, w):
    norm = np.sqrt(x * x + y * y + z * z + w * w)
    if not 0.5 < norm < 2:
        raise ValueError(f"({x}, {y}, {z}, {w}) is no rotation")
    x, y, z, w = (v / norm for v in (x, y, z, w))
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def quaternion_of(R):
    """x, y, z, w with w >= 0. From the largest of its squares, so that no half turn is a special case."""
    squares = np.array([1 + R[0, 0] - R[1, 1] - R[2, 2], 1 - R[0, 0] + R[1, 1] - R[2, 2],
                        1 - R[0, 0] - R[1, 1] + R[2, 2], 1 + np.trace(R)])
    k = int(np.argmax(squares))
    products = {(0, 1): R[0, 1] + R[1, 0], (0, 2): R[0, 2] + R[2, 0], (1, 2): R[1, 2] + R[2, 1],
                (0, 3): R[2, 1] - R[1, 2], (1, 3): R[0, 2] - R[2, 0], (2, 3): R[1, 0] - R[0, 1]}
    q = np.array([squares[k] if i == k else products[min(i, k), max(i, k)] for i in range(4)])
    return q / np.linalg.norm(q) * (-1 if q[3] < 0 else 1)


def pose_of(pose):
    """4 x 4 of a geometry_msgs/Pose or Transform. ValueError: it is none."""
    t, q = (pose.position, pose.orientation) if hasattr(pose, "position") else (pose.translation, pose.rotation)
    T = np.eye(4)
    T[:3, :3] = rotation_of(q.x, q.y, q.z, q.w)
    T[:3, 3] = t.x, t.y, t.z
    if not np.isfinite(T).all():
        raise ValueError("a pose is not finite")
    return T


def fill_transform(transform, T):
    """Writes a 4 x 4 into a geometry_msgs/Transform."""
    t, q = transform.translation, transform.rotation
    t.x, t.y, t.z = (float(v) for v in T[:3, 3])
    q.x, q.y, q.z, q.w = (float(v) for v in quaternion_of(T[:3, :3]))
    return transform
