// The transform at which each session is drawn; it glides when a merge moves it.

import { type Box2, Box3, Matrix4, Quaternion, Vector3 } from 'three';
import type { Station } from '../station/station';
import type { Keyframe, Transform } from '../station/types';
import { type Laid, placementOf } from './laid';
import { extentOf, layOut, matrixOf, type Member, type Plot } from './layout';
import type { Reach } from './reach';

const glide_ms = 900;

interface Drawn {
  T_world_session: Matrix4;
  from: Matrix4;
  to: Matrix4;
  since: number;
}

/** Boxes are in the component's frame. */
interface Drawable extends Member {
  id: number;
  keyframes: Keyframe[] | undefined;
  placed: Transform | undefined;
  reached: number; // version of the points' reach
  T: Matrix4; // T_component_session
}

const still = matchMedia('(prefers-reduced-motion: reduce)');

export class Frames {
  plots = new Map<number, Plot>();
  /** Counts what changes a plot or a transform. */
  version = 0;
  private readonly drawn = new Map<number, Drawn>();
  private readonly members = new Map<number, Drawable>();
  /** Of the last sync, component by component. */
  private together = new Map<number, Drawable[]>();
  private laid: Laid | null = null;

  constructor(
    private readonly station: Station,
    private readonly reachOf: (session: number) => Reach | undefined,
  ) {}

  of(session: number): Matrix4 | undefined {
    return this.drawn.get(session)?.T_world_session;
  }

  /** Takes over what the station says now. */
  sync(): void {
    const members = new Map<number, Drawable[]>();
    for (const id of this.station.sessions.keys()) {
      const component = this.station.placed.get(id)?.component ?? -id;
      members.set(component, [...(members.get(component) ?? []), this.member(id)]);
    }
    this.together = members;
    this.plots = layOut([...members].map(([component, list]) => extentOf(component, list)));
    for (const [component, list] of members) {
      if (component === this.laid?.component && this.plots.has(this.laid.on)) continue;
      const { x, y } = this.plots.get(component)!.offset;
      for (const { id, T } of list) this.move(id, new Matrix4().makeTranslation(x, y, 0).multiply(T));
    }
    this.placeLaid();
    for (const id of this.drawn.keys())
      if (!this.station.sessions.has(id)) {
        this.drawn.delete(id);
        this.members.delete(id);
      }
    this.version++;
  }

  /** A map is drawn on another, at once; null: all lie by themselves again from the next sync on. */
  lay(laid: Laid | null): void {
    this.laid = laid;
    this.placeLaid();
    this.version++;
  }

  /** As it is drawn: T_world_component, and its box in its own frame. null: nothing is laid on another. */
  get laidMap(): { T_world_component: Matrix4; box: Box2 } | null {
    const plot = this.laid && this.plots.get(this.laid.on);
    if (!this.laid || !plot) return null;
    const T_world_component = new Matrix4().makeTranslation(plot.offset.x, plot.offset.y, 0).multiply(placementOf(this.laid));
    return { T_world_component, box: extentOf(this.laid.component, this.together.get(this.laid.component) ?? []).box };
  }

  private placeLaid(): void {
    const laid = this.laidMap;
    if (!laid) return;
    for (const { id, T } of this.together.get(this.laid!.component) ?? []) {
      const to = laid.T_world_component.clone().multiply(T);
      this.drawn.set(id, { T_world_session: to, from: to, to, since: 0 });
    }
    this.plots.delete(this.laid!.component);
  }

  /** Lowest and highest point of the paths. */
  heights(): [number, number] {
    const box = [...this.members.values()].reduce((sum, member) => sum.union(member.path), new Box3());
    return box.isEmpty() ? [0, 1] : [box.min.z, box.max.z];
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

  /** As it was, unless its path, its points or its place are others. */
  private member(id: number): Drawable {
    const keyframes = this.station.paths.get(id);
    const placed = this.station.placed.get(id)?.T_component_session;
    const reach = this.reachOf(id);
    const reached = reach?.version ?? 0;
    const known = this.members.get(id);
    if (known && known.keyframes === keyframes && known.placed === placed && known.reached === reached) return known;
    const T = placed ? matrixOf(placed) : new Matrix4();
    const path = new Box3().setFromPoints((keyframes ?? []).map(({ position }) => new Vector3(...position).applyMatrix4(T)));
    const points = new Box3().setFromPoints((reach?.corners() ?? []).map((corner) => corner.applyMatrix4(T)));
    const member = { id, keyframes, placed, reached, T, path, points };
    this.members.set(id, member);
    return member;
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
