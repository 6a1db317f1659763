// Text over the canvas, as elements of the page: sharp, selectable by keyboard, read out. Those that would lie over a
// more important one are left out.

import type { Vector3 } from 'three';
import type { Stage } from './stage';

export interface Label {
  key: string;
  place: Vector3;
  text: string;
  kind: 'robot' | 'away' | 'frame' | 'verdict' | 'measure' | 'control' | 'note' | 'change';
  colour?: string;
  rank: number; // smaller ones are drawn first
  describe?: string;
  /** off: it stands at the edge, for its place is out of sight. */
  onClick?: (off: boolean) => void;
}

/** Pixels between a place and the text over it. */
const over: Record<Label['kind'], number> = { robot: 18, away: 18, frame: 1, verdict: 0, measure: 0, control: 9, note: 0, change: 22 };
const inset_px = { x: 6, above: 84, below: 56 }; // tools lie over the picture's edges

const arrows = ['→', '↗', '↑', '↖', '←', '↙', '↓', '↘'];

interface Shown {
  element: HTMLElement;
  label: Label;
  width: number;
  height: number;
}

export class Labels {
  private readonly shown = new Map<string, Shown>();

  constructor(
    private readonly layer: HTMLElement,
    private readonly stage: Stage,
  ) {}

  set(labels: Label[]): void {
    const keys = new Set(labels.map(({ key }) => key));
    for (const [key, { element }] of this.shown)
      if (!keys.has(key)) {
        element.remove();
        this.shown.delete(key);
      }
    for (const label of labels) this.put(label);
  }

  place(): void {
    const taken: [number, number, number, number][] = [];
    const rows = [...this.shown.values()].sort((x, y) => x.label.rank - y.label.rank);
    for (const { element, label, width, height } of rows) {
      const { x, y, z } = this.stage.toPage(label.place);
      const wanted = label.kind === 'frame' ? Math.min(x, this.stage.size.x - width - 4) : x - width / 2;
      let left = Math.round(x < this.stage.size.x ? wanted : x);
      let top = Math.round(y - over[label.kind] - (label.kind === 'frame' ? height : height / 2));
      let outside = z > 1 || left + width < 0 || top + height < 0 || left > this.stage.size.x || top > this.stage.size.y;
      const off = outside && label.kind === 'robot' && z <= 1; // who drives is never lost out of sight
      if (off) {
        outside = false;
        element.dataset.off = arrows[Math.round((4 * Math.atan2(this.stage.size.y / 2 - y, x - this.stage.size.x / 2)) / Math.PI + 8) % 8];
        left = Math.min(Math.max(left, inset_px.x), this.stage.size.x - width - 16 - inset_px.x);
        top = Math.min(Math.max(top, inset_px.above), this.stage.size.y - height - inset_px.below);
      } else delete element.dataset.off;
      const hidden = outside || taken.some(([l, t, r, b]) => left < r && left + width > l && top < b && top + height > t);
      element.style.visibility = hidden ? 'hidden' : 'visible';
      element.style.transform = `translate(${left}px, ${top}px)`;
      if (!hidden) taken.push([left - 2, top - 1, left + width + 2, top + height + 1]);
    }
  }

  private put(label: Label): void {
    const known = this.shown.get(label.key);
    if (known && known.label.text === label.text && known.label.kind === label.kind && known.label.colour === label.colour) {
      known.label = label;
      return;
    }
    const element = known?.element ?? document.createElement(label.onClick ? 'button' : 'div');
    element.className = `label label-${label.kind}`;
    element.textContent = label.text;
    element.style.setProperty('--mark', label.colour ?? 'currentColor');
    if (label.describe) element.setAttribute('aria-label', label.describe);
    element.onclick = () => this.shown.get(label.key)?.label.onClick?.(element.dataset.off !== undefined);
    if (!known) this.layer.append(element);
    this.shown.set(label.key, { element, label, width: element.offsetWidth, height: element.offsetHeight });
  }
}
