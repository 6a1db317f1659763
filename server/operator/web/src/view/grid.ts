// Scale bar, north and the lines of a frame's coordinates, for the view from above. Pure; metres.

/** 1, 2 or 5 times a power of ten: the largest that is no more. */
export function roundStep(most: number): number {
  const power = 10 ** Math.floor(Math.log10(most));
  return [5, 2, 1].map((digit) => digit * power).find((step) => step <= most * (1 + 1e-9)) ?? power;
}

/** x and y of T * (x, y), T as the server writes transforms (16 numbers, row-major). */
export const moved = (T: number[], x: number, y: number, z = 0): [number, number, number] => [
  T[0] * x + T[1] * y + T[2] * z + T[3],
  T[4] * x + T[5] * y + T[6] * z + T[7],
  T[8] * x + T[9] * y + T[10] * z + T[11],
];

export interface Line {
  /** The coordinate that is the same along it: 0 is east (x), 1 is north (y). */
  axis: 0 | 1;
  value: number;
  from: [number, number];
  to: [number, number];
}

export interface Box {
  min: { x: number; y: number };
  max: { x: number; y: number };
}

/** Lines of constant grid coordinates across a box of the component's frame, clipped to it. `T_grid_component` turns about
 * the vertical only, or hardly more. */
export function gridLines(box: Box, T: number[], step: number): Line[] {
  const yaw = Math.atan2(T[4], T[0]);
  const [c, s] = [Math.cos(yaw), Math.sin(yaw)];
  const corners: [number, number][] = [
    [box.min.x, box.min.y],
    [box.max.x, box.min.y],
    [box.max.x, box.max.y],
    [box.min.x, box.max.y],
  ];
  const inGrid = ([x, y]: [number, number]): [number, number] => [c * x - s * y + T[3], s * x + c * y + T[7]];
  const inComponent = (e: number, n: number): [number, number] => [c * (e - T[3]) + s * (n - T[7]), -s * (e - T[3]) + c * (n - T[7])];
  const reach = corners.map(inGrid);
  const lines: Line[] = [];
  for (const axis of [0, 1] as const) {
    const [low, high] = [Math.min(...reach.map((p) => p[axis])), Math.max(...reach.map((p) => p[axis]))];
    const [start, end] = [Math.min(...reach.map((p) => p[1 - axis])), Math.max(...reach.map((p) => p[1 - axis]))];
    for (let at = Math.ceil(low / step); at * step <= high; at++) {
      const value = at * step;
      const ends = [start, end].map((other) => (axis === 0 ? inComponent(value, other) : inComponent(other, value)));
      const clipped = clip(ends[0], ends[1], box);
      if (clipped) lines.push({ axis, value, from: clipped[0], to: clipped[1] });
    }
  }
  return lines;
}

/** The part of a line that lies in the box (Liang and Barsky). */
function clip(p: [number, number], q: [number, number], { min, max }: Box): [[number, number], [number, number]] | null {
  const [dx, dy] = [q[0] - p[0], q[1] - p[1]];
  let [from, to] = [0, 1];
  for (const [along, room] of [
    [-dx, p[0] - min.x],
    [dx, max.x - p[0]],
    [-dy, p[1] - min.y],
    [dy, max.y - p[1]],
  ]) {
    if (Math.abs(along) < 1e-12) {
      if (room < 0) return null;
      continue;
    }
    const share = room / along;
    if (along < 0) from = Math.max(from, share);
    else to = Math.min(to, share);
  }
  if (from >= to) return null;
  const at = (share: number): [number, number] => [p[0] + share * dx, p[1] + share * dy];
  return [at(from), at(to)];
}
