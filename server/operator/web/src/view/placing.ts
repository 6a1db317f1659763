// A map that the operator lays on another by hand. It moves in the plan; as long as nobody sets its height it runs as high
// as the map under it.

import { Matrix4, Vector3 } from 'three';
import type { Station } from '../station/station';
import type { Frames } from './frames';
import { type Laid, besideOf, originOf, pivotOf, placementOf, riseOf, thinned } from './laid';
import { matrixOf } from './layout';

/** The session that is placed, and the map it is laid on: on that session of it, or on the one it comes to lie beside (null). */
export interface PlacingOf {
  session: number;
  on: number;
  onSession: number | null;
}

/** What the server is asked. */
export interface RoughPlacement {
  a: number;
  b: number;
  at: [number, number, number, number];
}

export class Placing {
  private of: PlacingOf | null = null;
  private laid: Laid | null = null;
  private heightByHand = false;
  /** Paths of the maps, each in the frame of its map. */
  private under: Vector3[] = [];
  private over: Vector3[] = [];
  private readonly listeners = new Set<() => void>();

  constructor(
    private readonly station: Station,
    private readonly frames: Frames,
  ) {}

  get now(): Laid | null {
    return this.laid;
  }

  /** Gives back how to leave off. */
  onChange(listener: () => void): () => void {
    this.listeners.add(listener);
    return () => void this.listeners.delete(listener);
  }

  /** The map lies in the middle of the other one at first; null: it goes back to where it was. Whether there is something new to look at. */
  begin(of: PlacingOf | null): boolean {
    const known = this.of;
    this.of = of;
    if (!of && !known) return false;
    if (!of) {
      this.lay(null);
      return true;
    }
    if (known && known.session === of.session && known.on === of.on) return false;
    const component = this.componentOf(of.session);
    [this.under, this.over] = [of.on, component].map((id) => thinned(this.membersOf(id).flatMap((session) => this.pathOf(session))));
    this.heightByHand = false;
    this.lay({ on: of.on, component, pivot: pivotOf(this.over), at: pivotOf(this.under), turn_rad: 0 });
    return true;
  }

  /** Whether both maps are still there, each by itself. */
  get holds(): boolean {
    return this.laid === null || (this.of !== null && this.componentOf(this.of.session) === this.laid.component && this.membersOf(this.laid.on).length > 0);
  }

  /** Metres in the plan, as the view shows it. */
  move(x_m: number, y_m: number): void {
    if (this.laid) this.lay({ ...this.laid, at: this.laid.at.clone().add(new Vector3(x_m, y_m, 0)) });
  }

  turn(by_rad: number): void {
    if (this.laid) this.lay({ ...this.laid, turn_rad: this.laid.turn_rad + by_rad });
  }

  lift(by_m: number): void {
    this.heightByHand = true;
    if (this.laid) this.lay({ ...this.laid, at: this.laid.at.clone().add(new Vector3(0, 0, by_m)) });
  }

  /** null: nothing is being placed, or one of the two has no path yet. */
  asked(): RoughPlacement | null {
    if (!this.laid || !this.of) return null;
    const { on, session: b, onSession } = this.of;
    const T_on_component = placementOf(this.laid);
    const moved = thinned(this.pathOf(b)).map((place) => place.applyMatrix4(T_on_component));
    const a = onSession ?? besideOf(new Map(this.membersOf(on).map((id) => [id, thinned(this.pathOf(id))])), moved);
    if (a === null || moved.length === 0) return null;
    return { a, b, at: originOf(this.matrixOf(a), T_on_component.multiply(this.matrixOf(b))) };
  }

  private lay(laid: Laid | null): void {
    this.laid = laid;
    if (laid && !this.heightByHand) {
      const T = placementOf(laid);
      const rise_m = riseOf(this.under, this.over.map((place) => place.clone().applyMatrix4(T)));
      if (rise_m !== null) this.laid = { ...laid, at: laid.at.clone().add(new Vector3(0, 0, rise_m)) };
    }
    this.frames.lay(this.laid);
    for (const listener of this.listeners) listener();
  }

  private componentOf(session: number): number {
    return this.station.placed.get(session)?.component ?? -session;
  }

  private membersOf(component: number): number[] {
    return [...this.station.sessions.keys()].filter((id) => this.componentOf(id) === component);
  }

  /** T_component_session */
  private matrixOf(session: number): Matrix4 {
    const placed = this.station.placed.get(session);
    return placed ? matrixOf(placed.T_component_session) : new Matrix4();
  }

  private pathOf(session: number): Vector3[] {
    const T = this.matrixOf(session);
    return (this.station.paths.get(session) ?? []).map(({ position }) => new Vector3(...position).applyMatrix4(T));
  }
}
