// The transform at which each session is drawn; it glides when a merge moves it.

import { Box3, Matrix4, Quaternion, Vector3 } from 'three';
import type { Station } from '../station/station';
import { type Extent, extentOf, layOut, matrixOf, type Plot } from './layout';

const glide_ms = 900;

interface Drawn {
  T_world_session: Matrix4;
  from: Matrix4;
  to: Matrix4;
  since: number;
}

const still = matchMedia('(prefers-reduced-motion: reduce)');

export class Frames {
  plots = new Map<number, Plot>();
  /** Counts what changes a plot or a transform. */
  version = 0;
  private readonly drawn = new Map<number, Drawn>();

  constructor(private readonly station: Station) {}

  of(session: number): Matrix4 | undefined {
    return this.drawn.get(session)?.T_world_session;
  }

  /** Takes over what the station says now. */
  sync(): void {
    const members = new Map<number, { id: number; T: Matrix4; path: [number, number, number][] }[]>();
    for (const id of this.station.sessions.keys()) {
      const placed = this.station.placed.get(id);
      const component = placed?.component ?? -id;
      const T = placed ? matrixOf(placed.T_component_session) : new Matrix4();
      const path = (this.station.paths.get(id) ?? []).map(({ position }) => position);
      members.set(component, [...(members.get(component) ?? []), { id, T, path }]);
    }
    const extents: Extent[] = [...members].map(([component, list]) => extentOf(component, list));
    this.plots = layOut(extents);
    for (const [component, list] of members)
      for (const { id, T } of list) {
        const { x, y } = this.plots.get(component)!.offset;
        this.move(id, new Matrix4().makeTranslation(x, y, 0).multiply(T));
      }
    for (const id of this.drawn.keys()) if (!this.station.sessions.has(id)) this.drawn.delete(id);
    this.version++;
  }

  /** A step of what moves; whether anything does. */
  step(now: number): boolean {
    let moving = false;
    for (const drawn of this.drawn.values()) {
      if (drawn.T_world_session.equals(drawn.to)) continue;
      const share = still.matches ? 1 : Math.min((now - drawn.since) / glide_ms, 1);
      drawn.T_world_session.copy(share === 1 ? drawn.to : between(drawn.from, drawn.to, share * share * (3 - 2 * share)));
      this.version++;
      moving = true;
    }
    return moving;
  }

  /** Of everything that is drawn, from above. */
  box(component?: number): Box3 {
    const box = new Box3();
    for (const [id, { box: plot }] of this.plots)
      if (component === undefined || component === id) {
        box.expandByPoint(new Vector3(plot.min.x, plot.min.y, 0));
        box.expandByPoint(new Vector3(plot.max.x, plot.max.y, 0));
      }
    return box;
  }

  private move(session: number, to: Matrix4): void {
    const known = this.drawn.get(session);
    if (!known) this.drawn.set(session, { T_world_session: to.clone(), from: to, to, since: 0 });
    else if (!known.to.equals(to))
      this.drawn.set(session, { T_world_session: known.T_world_session, from: known.T_world_session.clone(), to, since: performance.now() });
  }
}

function between(a: Matrix4, b: Matrix4, share: number): Matrix4 {
  const [p, q] = [new Vector3(), new Vector3()];
  const [u, v] = [new Quaternion(), new Quaternion()];
  const scale = new Vector3();
  a.decompose(p, u, scale);
  b.decompose(q, v, scale);
  return new Matrix4().compose(p.lerp(q, share), u.slerp(v, share), new Vector3(1, 1, 1));
}
