// Drawn over the map from above: lines of coordinates, scale bar, north. A canvas of its own, which takes no clicks.

import { Vector3 } from 'three';
import type { Transform } from '../station/types';
import { type Box, gridLines, roundStep } from './grid';
import type { Plot } from './layout';
import type { Stage } from './stage';

const step_px = 150; // between two lines, at the most
const bar_px = 150;
const leastPlot_px = 120; // smaller ones would be nothing but lines
const beside_px = 14;

export interface Framed {
  plot: Plot;
  /** null: not surveyed; lines are then those of the map's own frame. */
  T_grid_component: Transform | null;
}

const identity: Transform = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

export class Decor {
  private readonly canvas = document.createElement('canvas');
  private ink = '#888888';
  private line = '#444444';

  constructor(
    layer: HTMLElement,
    private readonly stage: Stage,
  ) {
    this.canvas.className = 'decor';
    this.canvas.setAttribute('aria-hidden', 'true');
    layer.before(this.canvas);
  }

  paint(ink: string, line: string): void {
    this.ink = ink;
    this.line = line;
  }

  draw(frames: Framed[], grid: boolean): void {
    const ratio = Math.min(devicePixelRatio, 2);
    const { x: width, y: height } = this.stage.size;
    const context = this.canvas.getContext('2d')!;
    if (this.canvas.width !== width * ratio || this.canvas.height !== height * ratio) {
      this.canvas.width = width * ratio;
      this.canvas.height = height * ratio;
    }
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    if (frames.length === 0) return;
    context.font = '11px "Inter Variable", system-ui, sans-serif';
    context.fillStyle = this.ink;
    if (this.stage.way === 'top') {
      if (grid) for (const framed of frames) this.drawGrid(context, framed);
      this.drawScale(context);
    }
    for (const framed of frames) if (framed.T_grid_component) this.drawNorth(context, framed, frames.length === 1);
  }

  /** The length of the bar in metres, as drawn. */
  get bar_m(): number {
    return roundStep(bar_px * this.stage.metresPerPixel(this.stage.target));
  }

  private drawGrid(context: CanvasRenderingContext2D, { plot, T_grid_component }: Framed): void {
    const metres = this.stage.metresPerPixel(this.stage.target);
    const { x: width, y: height } = this.stage.size;
    const { target } = this.stage;
    const seen = { min: { x: target.x - (width / 2) * metres, y: target.y - (height / 2) * metres }, max: { x: target.x + (width / 2) * metres, y: target.y + (height / 2) * metres } };
    const { offset } = plot;
    const box: Box = {
      min: { x: Math.max(plot.box.min.x, seen.min.x) - offset.x, y: Math.max(plot.box.min.y, seen.min.y) - offset.y },
      max: { x: Math.min(plot.box.max.x, seen.max.x) - offset.x, y: Math.min(plot.box.max.y, seen.max.y) - offset.y },
    };
    if (Math.min(box.max.x - box.min.x, box.max.y - box.min.y) < leastPlot_px * metres) return;
    const step = roundStep(step_px * metres);
    const toPage = ([x, y]: [number, number]) => this.stage.toPage(new Vector3(x + offset.x, y + offset.y, 0));
    context.strokeStyle = this.line;
    context.lineWidth = 1;
    context.textBaseline = 'bottom';
    for (const { axis, value, from, to } of gridLines(box, T_grid_component ?? identity, step)) {
      const [p, q] = [toPage(from), toPage(to)];
      context.beginPath();
      context.moveTo(p.x, p.y);
      context.lineTo(q.x, q.y);
      context.stroke();
      const text = value.toFixed(step < 1 ? 1 : 0);
      // Lines of equal easting are named below their lower end, those of equal northing above their left one.
      const end = axis === 0 ? (p.y > q.y ? p : q) : p.x < q.x ? p : q;
      context.fillText(text, Math.min(Math.max(end.x + 3, 3), width - context.measureText(text).width - 3), axis === 0 ? Math.min(end.y + 14, this.stage.size.y - 3) : Math.max(end.y - 3, 12));
    }
  }

  private drawScale(context: CanvasRenderingContext2D): void {
    const length_m = this.bar_m;
    const length_px = length_m / this.stage.metresPerPixel(this.stage.target);
    const right = this.stage.size.x - beside_px;
    const y = this.stage.size.y - this.lower_px();
    context.fillRect(right - length_px, y, length_px, 2);
    for (const x of [right - length_px, right - 1.5]) context.fillRect(x, y - 5, 1.5, 7);
    context.textBaseline = 'bottom';
    context.textAlign = 'right';
    context.fillText(length_m < 1 ? `${length_m} m` : `${length_m.toFixed(0)} m`, right, y - 6);
    context.textAlign = 'left';
  }

  /** Over the tools at the lower edge. */
  private lower_px(): number {
    const tools = this.canvas.parentElement?.parentElement?.querySelector<HTMLElement>('.tools-bottom');
    return (tools?.offsetHeight ?? 0) + 26;
  }

  private drawNorth(context: CanvasRenderingContext2D, { plot, T_grid_component: T }: Framed, alone: boolean): void {
    const yaw = Math.atan2(T![4], T![0]);
    const north = new Vector3(Math.sin(yaw), Math.cos(yaw), 0); // in the component's frame, as the view shows it
    const middle = alone ? this.stage.target : new Vector3(plot.box.max.x, plot.box.max.y, 0);
    const [from, to] = [this.stage.toPage(middle), this.stage.toPage(middle.clone().addScaledVector(north, 20 * this.stage.metresPerPixel(middle)))];
    const turn = Math.atan2(to.x - from.x, from.y - to.y);
    const [x, y] = alone ? [this.stage.size.x - 30, 76] : [from.x - 22, from.y + 24];
    context.save();
    context.translate(x, y);
    context.rotate(turn);
    context.beginPath();
    context.moveTo(0, -20);
    context.lineTo(7, 8);
    context.lineTo(0, 3);
    context.lineTo(-7, 8);
    context.closePath();
    context.fill();
    context.rotate(-turn);
    context.textAlign = 'center';
    context.textBaseline = 'middle';
    context.fillText('N', -30 * Math.sin(-turn), -30 * Math.cos(turn));
    context.restore();
  }
}
