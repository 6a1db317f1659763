"""A recorded session: scans/*.bin (float32 x, y, z, intensity), poses.txt (t x y z qx qy qz qw), sensor.json."""

import json
import os
import re

import numpy as np

from .geometry import pose

SENSOR_KEYS = ("model", "beams", "fov_up_deg", "fov_down_deg", "max_range_m")


def of_file(path, read):
    """What `read` makes of the file; a fault in it names the file."""
    with open(path, encoding="utf-8") as file:
        try:
            return read(file)
        except ValueError as fault:
            raise ValueError(f"{path}: {fault}") from fault


def read_trajectory(path):
    """{stamp_s: 4x4} of a TUM file: t x y z qx qy qz qw a line."""
    rows = of_file(path, lambda file: np.loadtxt(file, ndmin=2))
    return {row[0]: pose(row[1:4], row[4:8]) for row in rows}


class Recording:
    def __init__(self, folder):
        self._scans = os.path.join(folder, "scans")
        if not os.path.isdir(self._scans):
            raise ValueError(f"{folder} is no recorded session: it has no folder scans/ (of .bin files)")
        names = [name for name in os.listdir(self._scans) if name.endswith(".bin")]
        self._names = sorted(names, key=lambda name: [int(n) for n in re.findall(r"\d+", name)])
        self._poses = of_file(os.path.join(folder, "poses.txt"), lambda file: np.loadtxt(file, ndmin=2))
        if len(self._poses) != len(self._names):
            raise ValueError(f"{folder}: {len(self._poses)} poses for {len(self._names)} scans")
        told = of_file(os.path.join(folder, "sensor.json"), json.load)
        self.sensor = {key: told[key] for key in SENSOR_KEYS if key in told}
        for key in ("fov_up_deg", "fov_down_deg"):
            self.sensor[key] = abs(self.sensor.get(key, 0))

    def __iter__(self):
        """(stamp_s, T_local_sensor, points_sensor) in order."""
        for name, row in zip(self._names, self._poses):
            values = np.fromfile(os.path.join(self._scans, name), np.float32)
            if len(values) % 4:
                raise ValueError(f"{os.path.join(self._scans, name)} is cut off: it does not end with a whole point")
            yield row[0], pose(row[1:4], row[4:8]), values.reshape(-1, 4)[:, :3]
