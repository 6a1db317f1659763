#!/usr/bin/python3
"""Trains the family `learned` from views of simulated mines. Same seed and same machine, same weights."""
import argparse
import copy
import math
import random
import time

import torch
import torch.nn.functional as F

import views
from export import export
from model import Learned, W
from validate import validate

SHARP = 256  # bins of yaw in the loss


def contrast(q, same, away, tau):
    """InfoNCE, every anchor with all its positives; what is neither same nor away is left out."""
    logit = (q @ q.T) / tau
    rest = torch.logsumexp(logit.masked_fill(~away, -1e4), 1, keepdim=True)
    each = F.softplus(rest - logit)
    return (each * same).sum() / same.sum().clamp(min=1)


def yaw_loss(w, i, j, yaw):
    """Cross entropy over the turns of the circular correlation of w_i and w_j; yaw: of view j in view i."""
    a, b = (torch.fft.rfft(F.normalize(w[k] - w[k].mean(1, keepdim=True), dim=1)) for k in (i, j))
    product = F.pad(a * b.conj(), (0, SHARP // 2 - W // 2))
    score = torch.fft.irfft(product, SHARP) * (SHARP / W)
    bins = torch.arange(SHARP) * (2 * math.pi / SHARP)
    off = torch.remainder(bins[None] - yaw[:, None] + math.pi, 2 * math.pi) - math.pi
    target = torch.softmax(-0.5 * (off / math.radians(1.5)) ** 2, 1)
    return -(target * torch.log_softmax(16 * score, 1)).sum(1).mean()


class Batches:
    """Anchors with a view of the same place by another drive, and the views that looked most like them elsewhere in the
    same mine when the network last looked."""

    def __init__(self, mines, seed, anchors=64, hard=2):
        self.mines, self.anchors, self.hard = mines, anchors, hard
        self.random, self.rng = random.Random(seed), torch.Generator().manual_seed(seed)
        self.pool, self.alike = [], {}

    def look(self, net, mines_at_once, bf16):
        """Draws new mines and finds the look-alikes in them."""
        self.pool = self.random.sample(range(len(self.mines)), min(mines_at_once, len(self.mines)))
        self.alike = {}
        for k in self.pool:
            mine = self.mines[k]
            q = embed(net, mine, bf16)[0]
            score = (q @ q.T).masked_fill(~mine.negative(), -2)
            self.alike[k] = (score.topk(12, 1).indices, mine.positive())

    def draw(self, share):
        """A batch from two mines; share: of the hard negatives among the negatives drawn."""
        images, yaws, ways, places, owner = [], [], [], [], []
        for k in self.random.sample(self.pool, 2):
            mine, (alike, positive) = self.mines[k], self.alike[k]
            can = positive.any(1).nonzero().flatten()
            anchor = can[torch.randperm(len(can), generator=self.rng)[: self.anchors // 2]]
            partner = torch.multinomial(positive[anchor].float(), 1, generator=self.rng).flatten()
            pick = torch.randint(0, alike.shape[1], (len(anchor), self.hard), generator=self.rng)
            hard = alike[anchor].gather(1, pick).flatten()
            easy = torch.randint(0, len(mine), (len(hard),), generator=self.rng)
            other = torch.where(torch.rand(len(hard), generator=self.rng) < share, hard, easy)
            index = torch.cat([anchor, partner, other]).unique()
            images.append(mine.image[index])
            yaws.append(mine.yaw[index])
            ways.append(mine.ways[index])
            places.append(index)
            owner += [k] * len(index)
        same = torch.zeros(len(owner), len(owner), dtype=torch.bool)
        away, near = ~same, same.clone()
        at = 0
        for k, index in zip(dict.fromkeys(owner), places):
            block = slice(at, at + len(index))
            mine = self.mines[k]
            same[block, block] = self.alike[k][1][index][:, index]
            away[block, block] = mine.negative()[index][:, index]
            at += len(index)
        return torch.cat(images), torch.cat(yaws), torch.cat(ways), same, away


def embed(net, mine, bf16, size=512):
    net.eval()
    with torch.no_grad(), torch.autocast("cpu", dtype=torch.bfloat16, enabled=bf16):
        out = [net(views.planes(part).to(memory_format=torch.channels_last)) for part in mine.image.split(size)]
    net.train()
    return [torch.cat(parts).float() for parts in zip(*out)]


def arguments():
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--views", required=True, help="folder of training views")
    options.add_argument("--validation", required=True, help="folder of views of other mines")
    options.add_argument("--out", required=True, help="the ONNX file")
    options.add_argument("--steps", type=int, default=6000)
    options.add_argument("--seed", type=int, default=1)
    options.add_argument("--threads", type=int, default=1)
    options.add_argument("--bf16", action="store_true", help="half the time on a processor that has bfloat16")
    return options.parse_args()


class Training:
    def __init__(self, mines, given):
        self.given, self.begun, self.step = given, time.time(), 0
        self.net = Learned().to(memory_format=torch.channels_last)
        self.calm = copy.deepcopy(self.net).eval()  # the mean of the weights over the last steps
        self.batches = Batches(mines, given.seed)
        self.optimiser = torch.optim.AdamW(self.net.parameters(), lr=2e-3, weight_decay=1e-4)

    def take_step(self):
        """The three losses: place, yaw, junction."""
        rate = 2e-3 * min(1, (self.step + 1) / 200) * 0.5 * (1 + math.cos(math.pi * self.step / self.given.steps))
        for group in self.optimiser.param_groups:
            group["lr"] = rate
        image, yaw, ways, same, away = self.batches.draw(min(0.8, self.step / 1500))
        x, yaw = views.disturbed(views.planes(image), yaw, self.batches.rng)
        with torch.autocast("cpu", dtype=torch.bfloat16, enabled=self.given.bf16):
            q, w, junction = self.net(x.to(memory_format=torch.channels_last))
        q, w, junction = q.float(), w.float(), junction.float()
        i, j = same.nonzero(as_tuple=True)
        losses = torch.stack([contrast(q, same, away, 0.07), yaw_loss(w, i, j, yaw[j] - yaw[i]),
                              F.binary_cross_entropy_with_logits(junction[:, 0], (ways >= 3).float())])
        self.optimiser.zero_grad()
        (losses * torch.tensor([1.0, 0.3, 0.3])).sum().backward()
        torch.nn.utils.clip_grad_norm_(self.net.parameters(), 5)
        self.optimiser.step()
        self.follow(min(0.998, self.step / (self.step + 20)))
        self.step += 1
        return losses.detach()

    def follow(self, keep):
        with torch.no_grad():
            for mean, now in zip(self.calm.state_dict().values(), self.net.state_dict().values()):
                mean.mul_(keep).add_(now, alpha=1 - keep) if mean.is_floating_point() else mean.copy_(now)

    def save(self, unseen):
        minutes = (time.time() - self.begun) / 60
        figures = validate(lambda mine: embed(self.calm, mine, self.given.bf16), unseen)
        print(f"step {self.step}, {minutes:.1f} min: {figures}", flush=True)
        export(self.calm, self.given.out)
        torch.save(self.calm.state_dict(), self.given.out + ".pt")  # to look at, and to go on from


def main():
    given = arguments()
    torch.manual_seed(given.seed)
    torch.set_num_threads(given.threads)
    mines, unseen = views.load(given.views), views.load(given.validation)
    print(f"{len(mines)} mines, {sum(map(len, mines))} views; validation: {len(unseen)}, {sum(map(len, unseen))}", flush=True)
    training = Training(mines, given)
    means = torch.zeros(3)
    while training.step < given.steps:
        if training.step % 100 == 0:
            training.batches.look(training.net, 12, given.bf16)
        means = 0.98 * means + 0.02 * training.take_step()
        if training.step % 50 == 0:
            print(f"step {training.step} of {given.steps}: {' '.join(f'{v:.3f}' for v in means / (1 - 0.98 ** training.step))}, "
                  f"{(time.time() - training.begun) / training.step:.2f} s a step", flush=True)
        if training.step % 1000 == 0 or training.step == given.steps:
            training.save(unseen)


if __name__ == "__main__":
    main()
