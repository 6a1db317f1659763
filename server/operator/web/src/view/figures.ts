// Lengths and areas of points that were picked. Pure; metres.

export interface Place {
  x: number;
  y: number;
  z: number;
}

const between = (p: Place, q: Place) => Math.hypot(q.x - p.x, q.y - p.y, q.z - p.z);

export const lengthOf = (line: Place[]) => line.slice(1).reduce((sum, place, at) => sum + between(line[at], place), 0);

/** Of the polygon, seen from above. */
export function areaOf(corners: Place[]): number {
  const doubled = corners.reduce((sum, p, at) => {
    const q = corners[(at + 1) % corners.length];
    return sum + p.x * q.y - q.x * p.y;
  }, 0);
  return Math.abs(doubled) / 2;
}

const signed = (value: number) => `${value < 0 ? '−' : '+'}${Math.abs(value).toFixed(2)}`;

/** Two points: how far, level and in height. */
export function distanceText([p, q]: Place[]): string {
  return `${between(p, q).toFixed(2)} m · level ${Math.hypot(q.x - p.x, q.y - p.y).toFixed(2)} m · height ${signed(q.z - p.z)} m`;
}

/** Of what was saved: what was written, and what was measured between its places now. */
export function noteText({ kind, text }: { kind: string; text: string }, places: Place[]): string {
  const measured = kind === 'distance' && places.length === 2 ? distanceText(places) : kind === 'line' && places.length > 1 ? lineText(places) : kind === 'area' && places.length > 2 ? areaText(places) : '';
  return [text, measured].filter(Boolean).join(' · ') || 'its places are in no map any more';
}

export function lineText(line: Place[]): string {
  return `${lengthOf(line).toFixed(2)} m over ${line.length} points · last ${between(line.at(-2)!, line.at(-1)!).toFixed(2)} m`;
}

export function areaText(corners: Place[]): string {
  return `${areaOf(corners).toFixed(1)} m² level · around it ${lengthOf([...corners, corners[0]]).toFixed(2)} m`;
}
