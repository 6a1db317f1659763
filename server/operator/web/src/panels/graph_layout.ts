// Places for the nodes of a small graph: springs between linked ones, a push between all. Pure, and the same each time.

export interface Place {
  x: number;
  y: number;
}

const rounds = 160;

/** In [0, 1] x [0, 1]. Links are pairs of indices. */
export function graphLayout(nodes: number, links: [number, number][]): Place[] {
  const places = Array.from({ length: nodes }, (_, i) => ({
    x: 0.5 + 0.4 * Math.cos(i * 2.39996) * Math.sqrt((i + 1) / nodes),
    y: 0.5 + 0.4 * Math.sin(i * 2.39996) * Math.sqrt((i + 1) / nodes),
  }));
  const rest = 0.75 / Math.sqrt(Math.max(nodes, 1));
  for (let round = 0; round < rounds; round++) {
    const force = places.map(() => ({ x: 0, y: 0 }));
    const push = (i: number, j: number, strength: (distance: number) => number) => {
      const [dx, dy] = [places[j].x - places[i].x, places[j].y - places[i].y];
      const distance = Math.max(Math.hypot(dx, dy), 1e-3);
      const f = strength(distance) / distance;
      force[i].x -= f * dx;
      force[i].y -= f * dy;
      force[j].x += f * dx;
      force[j].y += f * dy;
    };
    for (let i = 0; i < nodes; i++) for (let j = i + 1; j < nodes; j++) push(i, j, (d) => (0.06 * rest * rest) / d);
    for (const [i, j] of links) push(i, j, (d) => -0.25 * (d - rest));
    const most = 0.05 * (1 - round / rounds);
    places.forEach((place, i) => {
      place.x += Math.max(-most, Math.min(most, force[i].x)) + 0.01 * (0.5 - place.x);
      place.y += Math.max(-most, Math.min(most, force[i].y)) + 0.01 * (0.5 - place.y);
    });
  }
  const xs = places.map(({ x }) => x);
  const ys = places.map(({ y }) => y);
  const [left, top] = [Math.min(...xs), Math.min(...ys)];
  const [width, height] = [Math.max(...xs) - left, Math.max(...ys) - top];
  return places.map(({ x, y }) => ({ x: width > 1e-6 ? (x - left) / width : 0.5, y: height > 1e-6 ? (y - top) / height : 0.5 }));
}

/** The middle of a curve from p to q, as far beside the straight line as it takes to keep clear of the other nodes. */
export function bend(p: Place, q: Place, others: Place[], clear: number): Place {
  const [dx, dy] = [q.x - p.x, q.y - p.y];
  const length = Math.max(Math.hypot(dx, dy), 1e-6);
  const [nx, ny] = [-dy / length, dx / length];
  const middle = { x: (p.x + q.x) / 2, y: (p.y + q.y) / 2 };
  const beside = [0, 1, -1, 2, -2, 3, -3].map((steps) => 0.8 * clear * steps);
  const free = beside.find((off) =>
    others.every((other) => {
      const along = ((other.x - p.x) * dx + (other.y - p.y) * dy) / (length * length);
      if (along <= 0 || along >= 1) return true;
      const side = (other.x - p.x) * nx + (other.y - p.y) * ny;
      return Math.abs(side - 4 * off * along * (1 - along)) >= clear;
    }),
  );
  return { x: middle.x + (free ?? 0) * nx, y: middle.y + (free ?? 0) * ny };
}
