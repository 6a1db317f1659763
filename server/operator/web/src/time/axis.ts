// The axis that a slider of time moves along: where nobody drove for long it is short. Pure; seconds.

export interface Span {
  from_s: number;
  to_s: number;
}

interface Piece extends Span {
  at_s: number; // where it begins on the axis
}

const gapShare = 0.02; // of all the time driven: the longest that a pause takes

/** Stamps are those of the robots' clocks. Both ways are monotonic and continuous, and inverse to each other. */
export class TimeAxis {
  readonly length_s: number;
  private readonly pieces: Piece[] = [];

  constructor(spans: Span[]) {
    const joined: Span[] = [];
    for (const { from_s, to_s } of [...spans].sort((x, y) => x.from_s - y.from_s)) {
      const last = joined.at(-1);
      if (last && from_s <= last.to_s) last.to_s = Math.max(last.to_s, to_s);
      else joined.push({ from_s, to_s });
    }
    const driven_s = joined.reduce((sum, { from_s, to_s }) => sum + to_s - from_s, 0);
    let at_s = 0;
    for (const [at, span] of joined.entries()) {
      if (at > 0) at_s += Math.min(span.from_s - joined[at - 1].to_s, Math.max(gapShare * driven_s, 1));
      this.pieces.push({ ...span, at_s });
      at_s += span.to_s - span.from_s;
    }
    this.length_s = at_s;
  }

  toStamp(at_s: number): number {
    if (this.pieces.length === 0) return 0;
    const next = this.pieces.findIndex((piece) => piece.at_s > at_s);
    const index = (next < 0 ? this.pieces.length : Math.max(next, 1)) - 1;
    const { from_s, to_s, at_s: begin_s } = this.pieces[index];
    const inside_s = at_s - begin_s;
    if (inside_s <= to_s - from_s || next <= 0) return from_s + Math.min(Math.max(inside_s, 0), to_s - from_s);
    const { from_s: resumed_s, at_s: resumedAt_s } = this.pieces[next];
    const end_s = begin_s + to_s - from_s;
    return to_s + ((at_s - end_s) / (resumedAt_s - end_s)) * (resumed_s - to_s);
  }

  toAxis(stamp_s: number): number {
    for (const [index, { from_s, to_s, at_s }] of this.pieces.entries()) {
      if (stamp_s <= to_s) {
        if (stamp_s >= from_s || index === 0) return at_s + Math.max(stamp_s - from_s, 0);
        const before = this.pieces[index - 1];
        const end_s = before.at_s + before.to_s - before.from_s;
        return end_s + ((stamp_s - before.to_s) / (from_s - before.to_s)) * (at_s - end_s);
      }
    }
    return this.length_s;
  }
}

/** How many of the stamps, which rise, are no later. */
export function countUntil(stamps: { stamp_s: number }[], stamp_s: number): number {
  let [low, high] = [0, stamps.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (stamps[middle].stamp_s <= stamp_s) low = middle + 1;
    else high = middle;
  }
  return low;
}
