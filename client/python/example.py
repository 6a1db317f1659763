"""The smallest robot in Python: python3 example.py SESSION_DIR HOST:PORT [ENROLMENT]"""
import sys
from pathlib import Path

import headframe
import numpy as np

folder, server = Path(sys.argv[1]), sys.argv[2]
enrolment = sys.argv[3] if len(sys.argv) > 3 else ""
poses = np.loadtxt(folder / "poses.txt", ndmin=2)  # stamp x y z qx qy qz qw
with headframe.Robot("example", spool="example-spool", server=server, enrolment=enrolment) as robot:
    robot.on_transforms(lambda t: print(f"revision {t.revision} places {len(t.T_component_session)} sessions"))
    for (stamp_s, *t, x, y, z, w), scan in zip(poses, sorted((folder / "scans").glob("*.bin"))):
        T_local_sensor = np.eye(4)
        T_local_sensor[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                                  [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                                  [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
        T_local_sensor[:3, 3] = t
        points = np.fromfile(scan, np.float32).reshape(-1, 4)  # x, y, z, intensity
        robot.add_scan(stamp_s, T_local_sensor, points, points[:, 3])
    robot.finish()
