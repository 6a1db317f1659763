"""A cloud's code. A cloud is a list of sweeps (origin (3), points (n, 3)), metres, in the keyframe's sensor frame."""

import math
import struct

import numpy as np

from .octree import Model, OctreeEncoder, RangeEncoder

MOST_BLOCK_BYTES = 131072


def varint(value):
    out = bytearray()
    while value >= 0x80:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    out.append(value)
    return bytes(out)


def signed_varint(value):
    return varint(2 * value if value >= 0 else -2 * value - 1)


def cells(metres, cell_m):
    """Rounded to the grid, halves away from zero."""
    scaled = np.asarray(metres, float) / float(np.float32(cell_m))
    return (np.sign(scaled) * np.floor(np.abs(scaled) + 0.5)).astype(np.int64)


def morton(offsets):
    """Bit i of x, y, z is bit 3i, 3i + 1, 3i + 2 of the code."""
    codes = np.zeros(len(offsets), np.int64)
    for axis in range(3):
        for i in range(21):
            codes |= (offsets[:, axis] >> i & 1) << (3 * i + axis)
    return codes


def content(sweeps, cell_m=0.01, form=1):
    """What stands inside the zstd frame."""
    out = [varint(form), struct.pack("<f", cell_m), varint(len(sweeps))]
    octree = OctreeEncoder()
    for origin, points in sweeps:
        out += [signed_varint(int(c)) for c in cells(origin, cell_m)]
        out.append(varint(len(points)))
        if not len(points):
            continue
        grid = cells(points, cell_m)
        corner = grid.min(axis=0)
        out += [signed_varint(int(c)) for c in corner]
        codes = np.sort(morton(grid - corner))
        if form == 1:
            out += [varint(int(step)) for step in np.diff(codes, prepend=0)]
        else:
            levels = (int(codes[-1]).bit_length() + 2) // 3
            out.append(varint(levels))
            octree.put([int(c) for c in codes], levels)
    if form == 2:
        stream = octree.finish()
        points = sum(len(points) for _, points in sweeps)
        if points > 262144 or points // 2 > len(stream):
            return content(sweeps, cell_m, form=1)
        out.append(stream)
    return b"".join(out)


def intensity_level(intensity):
    return round(31 * math.sqrt(intensity / 255))


def content_with_intensity(sweeps, cell_m=0.01, form=2):
    """Form 3. Sweeps are (origin, points, intensity): of a sweep with points as many, 0 to 255, or none."""
    plain = content([(origin, points) for origin, points, _ in sweeps], cell_m, form)
    coder, models = RangeEncoder(), {}
    for _, points, intensity in sweeps:
        if not len(points):
            continue
        coder.plain(1 if len(intensity) else 0, 1)
        grid = cells(points, cell_m)
        levels = [intensity_level(i) for i in intensity]
        before = 0
        for _, level in sorted(zip(morton(grid - grid.min(axis=0)).tolist(), levels)):
            pattern = 1
            for i in reversed(range(5)):
                bit = level >> i & 1
                coder.bit(models.setdefault((before, pattern), Model()), bit)
                pattern = 2 * pattern + bit
            before = level
    return varint(3) + varint(len(plain)) + plain + coder.finish()


def zstd_of_raw_blocks(data):
    """One zstd frame that any zstd library reads, made without one."""
    out = [b"\x28\xb5\x2f\xfd\xa0", struct.pack("<I", len(data))]
    for at in range(0, len(data), MOST_BLOCK_BYTES):
        block = data[at:at + MOST_BLOCK_BYTES]
        last = at + MOST_BLOCK_BYTES >= len(data)
        out += [struct.pack("<I", len(block) << 3 | last)[:3], block]
    return b"".join(out)


def encode(sweeps, cell_m=0.01, form=1):
    return zstd_of_raw_blocks(content(sweeps, cell_m, form))
