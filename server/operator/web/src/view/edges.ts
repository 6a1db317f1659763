// Alignments: where two maps share rock, links between their paths; between maps that lie apart, one line.

import { Vector3 } from 'three';
import { LineMaterial } from 'three/addons/lines/LineMaterial.js';
import { LineSegments2 } from 'three/addons/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/addons/lines/LineSegmentsGeometry.js';
import type { Station } from '../station/station';
import type { Alignment, Keyframe } from '../station/types';
import type { Frames } from './frames';
import { type Link, overlapLinks } from './overlap';
import { lookOf } from './palette';
import type { Stage } from './stage';

const recount = 8; // keyframes that a path grows before the overlap is looked for again

interface Edge {
  alignment: Alignment;
  basis: string;
  links: Link[];
  line: LineSegments2;
  drawnAt: number;
  badge: Vector3;
  driven: number; // links that are shown
}

export class Edges {
  private readonly edges = new Map<number, Edge>();

  constructor(
    private readonly station: Station,
    private readonly frames: Frames,
    private readonly stage: Stage,
  ) {}

  /** Rejected ones are drawn when they are selected only. */
  sync(isDark: boolean, selected: number | null): void {
    const shown = [...this.station.alignments.values()].filter(({ id, state }) => state !== 'rejected' || id === selected);
    const ids = new Set(shown.map(({ id }) => id));
    for (const [id, edge] of this.edges)
      if (!ids.has(id)) {
        dispose(edge);
        this.edges.delete(id);
      }
    for (const alignment of shown) this.syncOne(alignment, isDark, alignment.id === selected);
  }

  private syncOne(alignment: Alignment, isDark: boolean, selected: boolean): void {
    const a = this.station.paths.get(this.station.idOf(alignment.a) ?? -1) ?? [];
    const b = this.station.paths.get(this.station.idOf(alignment.b) ?? -1) ?? [];
    const basis = [Math.ceil(a.length / recount), Math.ceil(b.length / recount), ...alignment.T_a_b].join();
    let edge = this.edges.get(alignment.id);
    if (!edge) {
      const material = new LineMaterial({ depthTest: false, transparent: true });
      const line = new LineSegments2(new LineSegmentsGeometry(), material);
      line.renderOrder = 12;
      line.frustumCulled = false;
      this.stage.signs.add(line);
      edge = { alignment, basis: '', links: [], line, drawnAt: -1, badge: new Vector3(), driven: 0 };
      this.edges.set(alignment.id, edge);
    }
    edge.alignment = alignment;
    if (edge.basis !== basis) {
      edge.basis = basis;
      edge.drawnAt = -1;
      edge.links = overlapLinks(a, b, alignment.T_a_b);
      if (edge.links.length === 0 && a.length && b.length)
        edge.links = [linkOf(a[a.length >> 1], b[b.length >> 1])];
    }
    const look = lookOf(alignment);
    const { material } = edge.line;
    material.color.setStyle(isDark ? look.dark : look.light, 'srgb-linear');
    material.linewidth = selected ? 3 : 1.6;
    material.opacity = selected ? 1 : 0.75;
    if (material.dashed !== (look.dash !== null)) {
      material.dashed = look.dash !== null;
      material.needsUpdate = true;
    }
    if (look.dash) [material.dashSize, material.gapSize] = look.dash;
  }

  /** What both sessions had driven by the moment that is shown: `lastShown` is the number of a session's last keyframe then. */
  beforeFrame(lastShown: (session: number) => number): void {
    for (const edge of this.edges.values()) {
      const [last_a, last_b] = [edge.alignment.a, edge.alignment.b].map((name) => lastShown(this.station.idOf(name) ?? -1));
      const driven = edge.links.filter(({ a, b }) => a <= last_a && b <= last_b);
      if (driven.length !== edge.driven) edge.drawnAt = -1;
      edge.driven = driven.length;
      if (edge.drawnAt === this.frames.version) continue;
      edge.drawnAt = this.frames.version;
      const [T_a, T_b] = [edge.alignment.a, edge.alignment.b].map((name) => this.frames.of(this.station.idOf(name) ?? -1));
      edge.line.visible = T_a !== undefined && T_b !== undefined && driven.length > 0;
      if (!edge.line.visible) continue;
      const apart = this.isApart(edge.alignment);
      const links = apart ? [driven[driven.length >> 1]] : driven;
      const ends = links.map(({ p_a, p_b }) => [p_a.clone().applyMatrix4(T_a!), p_b.clone().applyMatrix4(T_b!)]);
      edge.line.geometry.dispose();
      edge.line.geometry = new LineSegmentsGeometry().setPositions(ends.flatMap(([p, q]) => [...p.toArray(), ...q.toArray()]));
      edge.line.computeLineDistances();
      const [p, q] = ends[ends.length >> 1];
      edge.badge.addVectors(p, q).multiplyScalar(0.5);
    }
  }

  *badges(): Generator<[Alignment, Vector3]> {
    for (const { alignment, line, badge } of this.edges.values()) if (line.visible) yield [alignment, badge];
  }

  private isApart({ a, b }: Alignment): boolean {
    const [x, y] = [a, b].map((name) => this.station.placed.get(this.station.idOf(name) ?? -1)?.component);
    return x === undefined || x !== y;
  }
}

const linkOf = (a: Keyframe, b: Keyframe): Link => ({ p_a: new Vector3(...a.position), p_b: new Vector3(...b.position), a: a.sequence, b: b.sequence });

function dispose({ line }: Edge): void {
  line.geometry.dispose();
  line.material.dispose();
  line.removeFromParent();
}
