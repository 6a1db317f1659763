"""Form 2 of a cloud's code: an octree, depth first, through a binary range coder."""

from bisect import bisect_left


class Model:
    """How likely a bit is 0, in 1/65536."""

    __slots__ = ("quick", "slow", "seen")

    def __init__(self):
        self.quick = self.slow = 32768
        self.seen = 0

    def zero(self):
        return min(max((self.quick + self.slow) // 2, 64), 65472)

    def learn(self, bit):
        self.seen = min(self.seen + 1, 7)
        quick_shift = min(self.seen, 4)
        if bit:
            self.quick -= self.quick >> quick_shift
            self.slow -= self.slow >> self.seen
        else:
            self.quick += (65535 - self.quick) >> quick_shift
            self.slow += (65535 - self.slow) >> self.seen


class RangeEncoder:
    def __init__(self):
        self._out = bytearray()
        self._low, self._range = 0, 0xFFFFFFFF
        self._held, self._ones = None, 0

    def bit(self, model, bit):
        bound = (self._range >> 16) * model.zero()
        if bit:
            self._low += bound
            self._range -= bound
        else:
            self._range = bound
        model.learn(bit)
        self._normalise()

    def plain(self, bits, count):
        for i in reversed(range(count)):
            self._range >>= 1
            if bits >> i & 1:
                self._low += self._range
            self._normalise()

    def finish(self):
        for _ in range(5):
            self._shift()
        return bytes(self._out)

    def _normalise(self):
        while self._range < 1 << 24:
            self._range = self._range << 8 & 0xFFFFFFFF
            self._shift()

    def _shift(self):
        if self._low < 0xFF000000 or self._low > 0xFFFFFFFF:
            carry = self._low >> 32
            if self._held is not None:
                self._out.append(self._held + carry)
            self._out += bytes([(255 + carry) % 256]) * self._ones
            self._ones = 0
            self._held = self._low >> 24 & 0xFF
        else:
            self._ones += 1
        self._low = self._low << 8 & 0xFFFFFFFF


class OctreeEncoder:
    """Models and coder are shared by all sweeps of one cloud."""

    def __init__(self):
        self._coder = RangeEncoder()
        self._repeated = Model()
        self._alone, self._occupied = {}, {}

    def put(self, codes, levels):
        """Sorted Morton codes below 8^levels, at least one."""
        self._cube(codes, levels, 0)

    def finish(self):
        return self._coder.finish()

    def _cube(self, codes, levels, siblings):
        coder = self._coder
        if levels == 0:
            for _ in codes[1:]:
                coder.bit(self._repeated, 1)
            coder.bit(self._repeated, 0)
            return
        if levels <= 5:
            alone = len(codes) == 1
            coder.bit(self._alone.setdefault((levels, siblings), Model()), alone)
            if alone:
                coder.plain(codes[0], 3 * levels)
                return
        shift = 3 * (levels - 1)
        prefix = (codes[0] >> (shift + 3)) << 3
        ends = [0] + [bisect_left(codes, (prefix + child + 1) << shift) for child in range(8)]
        pattern, count, children = 1, 0, []
        for child in range(8):
            occupied = ends[child + 1] > ends[child]
            if child < 7 or count > 0:
                coder.bit(self._occupied.setdefault((levels, pattern), Model()), occupied)
            pattern = 2 * pattern + occupied
            if occupied:
                count += 1
                children.append(codes[ends[child]:ends[child + 1]])
        for child in children:
            self._cube(child, levels - 1, count)
