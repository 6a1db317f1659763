// What operators wrote on the map: a name at its place, and the line of what they measured. Both follow their sessions.

import { Vector3 } from 'three';
import { LineMaterial } from 'three/addons/lines/LineMaterial.js';
import { LineSegments2 } from 'three/addons/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/addons/lines/LineSegmentsGeometry.js';
import type { Note } from '../station/types';
import { noteText } from './figures';
import type { Frames } from './frames';
import type { Label } from './labels';
import type { Stage } from './stage';

const longest = 42; // characters of a name on the map

export class NoteMarks {
  private readonly line: LineSegments2;
  private drawnAt = -1;
  private notes: Note[] = [];

  constructor(
    stage: Stage,
    private readonly frames: Frames,
    private readonly componentOf: (session: number) => number,
  ) {
    this.line = new LineSegments2(new LineSegmentsGeometry(), new LineMaterial({ linewidth: 1.5, depthTest: false, transparent: true, opacity: 0.85 }));
    this.line.renderOrder = 25;
    this.line.frustumCulled = false;
    stage.signs.add(this.line);
  }

  sync(notes: Note[], colour: string): void {
    this.line.material.color.setStyle(colour, 'srgb-linear');
    if (notes === this.notes) return;
    this.notes = notes;
    this.drawnAt = -1;
  }

  /** As the view draws them; none of a session that is gone, or of maps that came apart. */
  placesOf({ places }: Note): Vector3[] {
    if (new Set(places.map(({ session_id }) => this.componentOf(session_id))).size > 1) return [];
    const drawn = places.flatMap(({ session_id, p_session }) => {
      const T = this.frames.of(session_id);
      return T ? [new Vector3(...p_session).applyMatrix4(T)] : [];
    });
    return drawn.length === places.length ? drawn : [];
  }

  beforeFrame(): void {
    if (this.drawnAt === this.frames.version) return;
    this.drawnAt = this.frames.version;
    const ends = this.notes.flatMap((note) => {
      const places = this.placesOf(note);
      const corners = note.kind === 'area' && places.length > 2 ? [...places, places[0]] : places;
      return corners.slice(1).flatMap((place, at) => [...corners[at].toArray(), ...place.toArray()]);
    });
    this.line.visible = ends.length > 0;
    this.line.geometry.dispose();
    if (ends.length > 0) this.line.geometry = new LineSegmentsGeometry().setPositions(ends);
  }

  labels(onClick: (note: Note) => void): Label[] {
    return this.notes.flatMap((note) => {
      const places = this.placesOf(note);
      if (places.length === 0) return [];
      const full = noteText(note, places);
      const text = full.length > longest ? `${full.slice(0, longest)}…` : full;
      const place = places.reduce((sum, one) => sum.add(one), new Vector3()).divideScalar(places.length);
      return [{ key: `note-${note.id}`, place, text, kind: 'note' as const, rank: 2, describe: `Note: ${full}`, onClick: () => onClick(note) }];
    });
  }
}
