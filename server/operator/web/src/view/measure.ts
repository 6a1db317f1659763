// Distance, length or area of points of the clouds that the operator picks.

import { Vector3 } from 'three';
import { LineMaterial } from 'three/addons/lines/LineMaterial.js';
import { LineSegments2 } from 'three/addons/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/addons/lines/LineSegmentsGeometry.js';
import { areaText, distanceText, lineText } from './figures';
import type { Frames } from './frames';
import type { Label } from './labels';
import type { Picked } from './pick';
import type { Stage } from './stage';

export type MeasureOf = 'distance' | 'line' | 'area' | 'section' | 'box' | 'note';

export const needed: Record<MeasureOf, number> = { distance: 2, line: 2, area: 3, section: 2, box: 2, note: 1 };
/** What can be saved for others. */
export const saved = ['distance', 'line', 'area', 'note'] as const;
export type Saved = (typeof saved)[number];
/** For these any place of a map will do, seen from above, also one without a point. */
export const onGround = (of: MeasureOf) => of === 'section' || of === 'box';
export const notMerged = 'These points lie in maps that are not merged: where they lie to each other is not known, so there is nothing to measure between them.';
export const nothingThere = 'No point of a map is there: click nearer to a wall.';

export class Measure {
  readonly ends: Picked[] = [];
  /** Why the last point was not taken; empty: it was. */
  fault = '';
  private readonly line: LineSegments2;
  private drawnAt = -1;

  constructor(
    private readonly stage: Stage,
    private readonly frames: Frames,
    private readonly componentOf: (session: number) => number | undefined,
  ) {
    this.line = new LineSegments2(new LineSegmentsGeometry(), new LineMaterial({ linewidth: 2, depthTest: false, transparent: true }));
    this.line.renderOrder = 30;
    this.line.frustumCulled = false;
    this.line.visible = false;
    stage.scene.add(this.line);
  }

  /** null: nothing was there. The third point of a distance begins anew. */
  take(found: Picked | null, of: MeasureOf): void {
    if (found && (of === 'note' || ((of === 'distance' || of === 'box') && this.ends.length >= 2))) this.ends.length = 0;
    this.fault = found ? '' : nothingThere;
    if (found && this.ends.length && this.componentOf(found.session) !== this.componentOf(this.ends[0].session)) this.fault = notMerged;
    if (found && !this.fault) this.ends.push(found);
    this.changed();
  }

  back(): void {
    this.ends.pop();
    this.fault = '';
    this.changed();
  }

  clear(): void {
    this.ends.length = 0;
    this.fault = '';
    this.changed();
  }

  paint(colour: string): void {
    this.line.material.color.setStyle(colour, 'srgb-linear');
  }

  /** In words; empty without enough points. */
  text(of: MeasureOf): string {
    if (this.ends.length < needed[of]) return '';
    if (this.apart()) return notMerged;
    const places = this.places();
    if (of === 'section') return 'Click on for more corners.';
    if (of === 'box' || of === 'note') return '';
    return of === 'distance' ? distanceText(places) : of === 'line' ? lineText(places) : areaText(places);
  }

  /** Points follow their maps. */
  beforeFrame(of: MeasureOf): void {
    if (this.drawnAt === this.frames.version) return;
    this.drawnAt = this.frames.version;
    const places = this.places();
    this.line.visible = places.length > 1 && !this.apart();
    if (!this.line.visible) return;
    const [p, q] = places;
    const corners = of === 'area' && places.length > 2 ? [...places, p] : of === 'box' ? [p, new Vector3(q.x, p.y, p.z), q, new Vector3(p.x, q.y, q.z), p] : places;
    this.line.geometry.dispose();
    this.line.geometry = new LineSegmentsGeometry().setPositions(corners.slice(1).flatMap((place, at) => [...corners[at].toArray(), ...place.toArray()]));
  }

  labels(of: MeasureOf): Label[] {
    const places = this.places();
    const labels: Label[] = places.map((place, at) => ({ key: `measure-${at}`, place, text: String.fromCharCode(65 + (at % 26)), kind: 'measure', rank: 0 }));
    const text = this.apart() || onGround(of) || of === 'note' ? '' : this.text(of);
    const middle = places.reduce((sum, place) => sum.add(place), new Vector3()).divideScalar(Math.max(places.length, 1));
    if (text) labels.push({ key: 'measure-text', place: middle, text, kind: 'measure', rank: 0 });
    return labels;
  }

  /** A merge was taken back since. */
  private apart(): boolean {
    return new Set(this.ends.map(({ session }) => this.componentOf(session))).size > 1;
  }

  /** As the view draws them; none when they lie in maps that came apart since. */
  corners(): Vector3[] {
    return this.apart() ? [] : this.places();
  }

  private places(): Vector3[] {
    return this.ends.flatMap(({ session, p_session }) => {
      const T = this.frames.of(session);
      return T ? [p_session.clone().applyMatrix4(T)] : [];
    });
  }

  private changed(): void {
    this.drawnAt = -1;
    this.stage.draw();
  }
}
