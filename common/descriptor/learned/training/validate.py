"""Recall, yaw error and junction F1 on mines that were not trained on."""
import math

import torch

from model import W


def turns(a, b):
    """Best yaw of b in a by circular correlation with a parabola through the peak, and the best one 20 deg off it."""
    a, b = (torch.nn.functional.normalize(w - w.mean(1, keepdim=True), dim=1) for w in (a, b))
    score = torch.fft.irfft(torch.fft.rfft(a) * torch.fft.rfft(b).conj(), W)
    step = 2 * math.pi / W
    found = []
    for _ in range(2):
        peak = score.argmax(1)
        left, mid, right = (score.gather(1, ((peak + d) % W)[:, None])[:, 0] for d in (-1, 0, 1))
        bend = left - 2 * mid + right
        offset = torch.where(bend < 0, (0.5 * (left - right) / bend).clamp(-0.5, 0.5), torch.zeros(()))
        found.append((peak + offset) * step)
        bins = torch.arange(W)[None] * step
        off = torch.remainder(bins - found[-1][:, None] + math.pi, 2 * math.pi) - math.pi
        score = score.masked_fill(off.abs() < math.radians(20), -2)
    return found


def apart(a, b):
    return (torch.remainder(a - b + math.pi, 2 * math.pi) - math.pi).abs() * (180 / math.pi)


def validate(embed, mines):
    hits = {"same": [], "cross": []}
    errors, second, truth, said = [], [], [], []
    for mine in mines:
        q, w, junction = embed(mine)
        right = mine.right()
        score = q @ q.T
        for query in mine.drive.unique():
            rows = (mine.drive == query).nonzero().flatten()
            for base in mine.drive.unique():
                if base == query:
                    continue
                columns = (mine.drive == base).nonzero().flatten()
                good = right[rows][:, columns]
                can = good.any(1)
                if not can.any():
                    continue
                order = score[rows][:, columns].sort(1, descending=True).indices
                ranked = good.gather(1, order)[can]
                kind = "same" if mine.sensor[rows[0]] == mine.sensor[columns[0]] else "cross"
                hits[kind].append(ranked[:, :20].float().cumsum(1).clamp(max=1))
                nearest = score[rows][:, columns].masked_fill(~good, -2).argmax(1)[can]
                i, j = rows[can], columns[nearest]
                true = mine.yaw[j] - mine.yaw[i]
                one, two = turns(w[i], w[j])
                errors.append(apart(one, true))
                second.append(torch.minimum(apart(one, true), apart(two, true)))
        truth.append(mine.ways >= 3)
        said.append(junction[:, 0] > 0)
    errors, second, truth, said = (torch.cat(v) for v in (errors, second, truth, said))
    f1 = 2 * (truth & said).sum() / (truth.sum() + said.sum())
    recall = {k: torch.cat([to_twenty(v) for v in hits[k]]).mean(0) for k in hits}
    return (" ".join(f"{k} r@1 {v[0]:.3f} r@5 {v[4]:.3f} r@20 {v[-1]:.3f}," for k, v in recall.items()) +
            f" yaw p50 {errors.median():.2f} p95 {errors.quantile(0.95):.1f} top2<10 {(second < 10).float().mean():.3f}, F1 {f1:.3f}")


def to_twenty(hits):
    """Rows of fewer than 20 answers go on as they end."""
    return torch.cat([hits, hits[:, -1:].expand(-1, 20 - hits.shape[1])], 1)
