"""A recorded session: scans/*.bin (float32 x, y, z, intensity), poses.txt (t x y z qx qy qz qw), sensor.json."""

import json
import os
import re

import numpy as np

from .geometry import pose

SENSOR_KEYS = ("model", "beams", "fov_up_deg", "fov_down_deg", "max_range_m")


class Recording:
    def __init__(self, folder):
        self._scans = os.path.join(folder, "scans")
        names = [name for name in os.listdir(self._scans) if name.endswith(".bin")]
        self._names = sorted(names, key=lambda name: [int(n) for n in re.findall(r"\d+", name)])
        self._poses = np.loadtxt(os.path.join(folder, "poses.txt"), ndmin=2)
        if len(self._poses) != len(self._names):
            raise ValueError(f"{folder}: {len(self._poses)} poses for {len(self._names)} scans")
        with open(os.path.join(folder, "sensor.json"), encoding="utf-8") as file:
            told = json.load(file)
        self.sensor = {key: told[key] for key in SENSOR_KEYS if key in told}
        for key in ("fov_up_deg", "fov_down_deg"):
            self.sensor[key] = abs(self.sensor.get(key, 0))

    def __iter__(self):
        """(stamp_s, T_local_sensor, points_sensor) in order."""
        for name, row in zip(self._names, self._poses):
            scan = np.fromfile(os.path.join(self._scans, name), np.float32).reshape(-1, 4)
            yield row[0], pose(row[1:4], row[4:8]), scan[:, :3]
