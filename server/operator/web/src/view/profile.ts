// A section of the map along a line: its points by how far along they lie, and how high. Pure; metres.

export interface Flat {
  x: number;
  y: number;
}

export interface ProfilePoint {
  along_m: number;
  height_m: number;
  session: number;
  place: [number, number, number];
}

const mostPoints = 200_000;

/** Takes points one by one; of too many every second one is left out, again and again, so that they stay an even sample. */
export class Profile {
  readonly points: ProfilePoint[] = [];
  readonly length_m: number;
  private readonly legs: { from: Flat; along: Flat; begin_m: number; length_m: number }[] = [];
  private every = 1;
  private met = 0;

  /** Points within half of the width of the line from corner to corner, seen from above. */
  constructor(
    corners: Flat[],
    private readonly width_m: number,
  ) {
    let begin_m = 0;
    for (const [at, to] of corners.slice(1).entries()) {
      const from = corners[at];
      const length_m = Math.hypot(to.x - from.x, to.y - from.y);
      if (length_m === 0) continue;
      this.legs.push({ from, along: { x: (to.x - from.x) / length_m, y: (to.y - from.y) / length_m }, begin_m, length_m });
      begin_m += length_m;
    }
    this.length_m = begin_m;
  }

  take(x: number, y: number, z: number, height_m: number, session: number): void {
    for (const { from, along, begin_m, length_m } of this.legs) {
      const [dx, dy] = [x - from.x, y - from.y];
      const along_m = dx * along.x + dy * along.y;
      if (along_m < 0 || along_m > length_m || Math.abs(dy * along.x - dx * along.y) > this.width_m / 2) continue;
      if (this.met++ % this.every !== 0) continue;
      this.points.push({ along_m: begin_m + along_m, height_m, session, place: [x, y, z] });
      if (this.points.length < mostPoints) continue;
      this.every *= 2;
      let kept = 0;
      for (let at = 0; at < this.points.length; at += 2) this.points[kept++] = this.points[at];
      this.points.length = kept;
    }
  }

  /** The lowest and the highest; null: there are none. */
  heights(): [number, number] | null {
    if (this.points.length === 0) return null;
    let [low, high] = [Infinity, -Infinity];
    for (const { height_m } of this.points) [low, high] = [Math.min(low, height_m), Math.max(high, height_m)];
    return [low, high];
  }
}

const exaggerations = [1, 2, 5, 10, 20];

/** How a picture shows it: pixels for a metre along, and how many times more for one of height. */
export function profileScale(length_m: number, height_m: number, width_px: number, height_px: number): { along_px: number; times: number } {
  const fit = Math.min(width_px / Math.max(length_m, 0.1), height_px / Math.max(height_m, 0.1));
  const along_px = width_px / Math.max(length_m, 0.1);
  if (fit < along_px) return { along_px: fit, times: 1 };
  const times = exaggerations.filter((times) => along_px * times * Math.max(height_m, 0.1) <= height_px).at(-1) ?? 1;
  return { along_px, times };
}

/** A line of titles, then one for each point. `inGrid` is null where the map is not surveyed. */
export function profileCsv(points: ProfilePoint[], titleOf: (session: number) => string, inGrid: ((place: [number, number, number]) => [number, number, number]) | null): string {
  const quoted = (text: string) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
  const titles = ['along_m', 'height_m', 'session', 'x_m', 'y_m', 'z_m', ...(inGrid ? ['east_m', 'north_m', 'grid_height_m'] : [])];
  const figures = (values: number[]) => values.map((value) => value.toFixed(3));
  const lines = points.map(({ along_m, height_m, session, place }) => [...figures([along_m, height_m]), quoted(titleOf(session)), ...figures([...place, ...(inGrid ? inGrid(place) : [])])].join());
  return `${[titles.join(), ...lines].join('\n')}\n`;
}
