"""Views of simulated mines, as headframe-mine-views writes them (tests/mine/views/views.hpp has the layout)."""
import glob
import math
import os
import struct

import torch

NO_RANGE = -32768
RIGHT_M, RIGHT_OVERLAP = 5.0, 30  # what a right answer is, in validation as in the bench
POSITIVE_M, AWAY_M = 4.0, 8.0     # training: what must look alike, and what must not; between them nothing is asked


class Mine:
    def __init__(self, path):
        with open(path, "rb") as file:
            raw = bytearray(file.read())
        if raw[:4] != b"HFV1" or len(raw) < 20:
            raise SystemExit(f"{path} holds no views; write them anew with headframe-mine-views")
        n, rows, columns, pairs = struct.unpack("<4I", raw[4:20])
        if len(raw) != 20 + n * (28 + 2 * rows * columns) + 12 * pairs:
            raise SystemExit(f"{path} is cut short; delete it and run headframe-mine-views again")
        meta = torch.frombuffer(raw, dtype=torch.float32, offset=20, count=7 * n).view(n, 7)
        kinds = torch.frombuffer(raw, dtype=torch.int32, offset=20, count=7 * n).view(n, 7)
        at = 20 + 28 * n
        self.place, self.yaw = meta[:, :3].clone(), meta[:, 3].clone()
        self.sensor, self.ways, self.drive = (kinds[:, k].clone().long() for k in (4, 5, 6))
        self.image = torch.frombuffer(raw, dtype=torch.int16, offset=at, count=n * rows * columns).view(n, rows, columns).clone()
        at += 2 * n * rows * columns
        pair = torch.frombuffer(raw, dtype=torch.int32, offset=at, count=3 * pairs).view(pairs, 3).long()
        self.overlap = torch.zeros(n, n, dtype=torch.uint8)
        self.overlap[pair[:, 0], pair[:, 1]] = pair[:, 2].to(torch.uint8)
        self.overlap[pair[:, 1], pair[:, 0]] = pair[:, 2].to(torch.uint8)
        self.distance = torch.cdist(self.place, self.place).half()

    def __len__(self):
        return len(self.yaw)

    def right(self):
        return (self.distance < RIGHT_M) & (self.overlap >= RIGHT_OVERLAP)

    def positive(self):
        other = self.drive[:, None] != self.drive[None, :]
        return (self.distance < POSITIVE_M) & (self.overlap >= 40) & other

    def negative(self):
        return self.distance > AWAY_M


def load(folder):
    files = sorted(glob.glob(os.path.join(folder, "*.views")))
    if not files:
        raise SystemExit(f"no views in {folder}; write them with headframe-mine-views --out {folder}")
    return [Mine(f) for f in files]


def planes(image):
    """int16 [n, rows, columns] to the network's float [n, 2, rows, columns]."""
    seen = image != NO_RANGE
    value = torch.where(seen, image.float() / 1000, torch.zeros(()))
    return torch.stack([value, seen.float()], 1)


def disturbed(x, yaw, rng):
    """Turns every view by any angle, and spoils it as a robot would: noise, a blind sector, lost returns, a bad level."""
    n, _, rows, columns = x.shape
    turn = torch.randint(0, columns, (n,), generator=rng)
    column = (torch.arange(columns)[None] + turn[:, None]) % columns
    x = x.gather(3, column[:, None, None, :].expand(n, 2, rows, columns))
    yaw = yaw + turn * (2 * math.pi / columns)  # the new azimuth 0 lies `turn` columns further round
    lift = torch.randint(-1, 2, (n,), generator=rng) * (torch.rand(n, generator=rng) < 0.3)
    row = torch.arange(rows)[None] + lift[:, None]
    x = x.gather(2, row.clamp(0, rows - 1)[:, None, :, None].expand(n, 2, rows, columns))
    keep = torch.ones(n, 1, rows, columns)
    blind = torch.randint(8, 48, (n,), generator=rng) * (torch.rand(n, generator=rng) < 0.15)
    start = torch.randint(0, columns, (n,), generator=rng)
    behind = (torch.arange(columns)[None] - start[:, None]) % columns < blind[:, None]
    keep = keep * (~behind)[:, None, None, :]
    lossy = (torch.rand(n, generator=rng) < 0.2).float() * 0.3
    keep = keep * (torch.rand(n, 1, rows, columns, generator=rng) >= lossy[:, None, None, None])
    noise = torch.randn(n, 1, rows, columns, generator=rng) * 0.01
    value = (x[:, :1] + noise) * x[:, 1:] * keep
    return torch.cat([value, x[:, 1:] * keep], 1), yaw
