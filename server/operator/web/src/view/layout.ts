// Where components are drawn: the largest at its own coordinates, the others beside it, each in its own frame. Pure.

import { Box2, Box3, Matrix4, Vector2 } from 'three';
import type { Transform } from '../station/types';

const margin_m = 14; // around a path, for what its robot is about to see
const step_m = 10; // boxes grow in steps, or all would move with every keyframe
const gap_m = 20;

export const matrixOf = (T: Transform) => new Matrix4().set(...(T as Parameters<Matrix4['set']>));

export interface Extent {
  component: number;
  sessions: number;
  box: Box2; // in the component's frame
}

export interface Plot {
  offset: Vector2; // of the component's origin
  box: Box2; // as drawn
}

export interface Member {
  path: Box3; // all in the component's frame
  points: Box3;
}

export function extentOf(component: number, members: Member[]): Extent {
  const box = new Box2();
  const union = ({ min, max }: Box3) => void box.union(new Box2(new Vector2(min.x, min.y), new Vector2(max.x, max.y)));
  for (const { path } of members) union(path);
  if (box.isEmpty()) box.set(new Vector2(-5, -5), new Vector2(5, 5));
  box.expandByScalar(margin_m);
  for (const { points } of members) union(points);
  box.min.divideScalar(step_m).floor().multiplyScalar(step_m);
  box.max.divideScalar(step_m).ceil().multiplyScalar(step_m);
  return { component, sessions: members.length, box };
}

const aspect = 1.5; // of width and height that is aimed at: that of a view beside panels

/** The largest keeps its own coordinates, the others stand in columns to its right: as many as fill a picture best. */
export function layOut(extents: Extent[]): Map<number, Plot> {
  const [main, ...others] = [...extents].sort((x, y) => y.sessions - x.sessions || Math.abs(x.component) - Math.abs(y.component));
  if (!main) return new Map();
  const span = (rows: Map<number, Plot>) => {
    const all = [...rows.values()].reduce((sum, { box }) => sum.union(box), new Box2()).getSize(new Vector2());
    return Math.max(all.x, aspect * all.y);
  };
  // Columns may be as high as the first one, two, three ... plots on each other.
  let height_m = main.box.max.y - main.box.min.y;
  let best = columns(main, others, height_m);
  for (const { box } of others) {
    height_m += box.max.y - box.min.y + gap_m;
    const tried = columns(main, others, height_m);
    if (span(tried) < span(best)) best = tried;
  }
  return best;
}

/** Below the largest as well, where there is room. */
function columns(main: Extent, others: Extent[], height_m: number): Map<number, Plot> {
  const plots = new Map([[main.component, { offset: new Vector2(), box: main.box }]]);
  const top = main.box.max.y;
  let x = main.box.min.x;
  let y = main.box.min.y - gap_m;
  let width = main.box.max.x - main.box.min.x;
  for (const { component, box } of others) {
    const span = box.getSize(new Vector2());
    if (y < top && y - span.y < top - height_m) {
      x += width + gap_m;
      y = top;
      width = 0;
    }
    const offset = new Vector2(x - box.min.x, y - box.max.y);
    plots.set(component, { offset, box: new Box2(box.min.clone().add(offset), box.max.clone().add(offset)) });
    y -= span.y + gap_m;
    width = Math.max(width, span.x);
  }
  return plots;
}
