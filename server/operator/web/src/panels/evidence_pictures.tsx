// Pictures of an alignment: the two submaps laid over each other, how far their surfaces lie apart, and the runner-up.

import { useEffect, useRef, useState } from 'preact/hooks';
import { Matrix4, Vector3 } from 'three';
import { percent } from '../parts/format';
import type { Overlay, Transform } from '../station/types';
import { matrixOf } from '../view/layout';

type Point = [number, number, number];
type Side = 'above' | 'side';

const size = { width: 340, height: 236 };
const dot = 1.4;

/** b as another transform would lay it. */
function moved(b: Point[], T_a_b: Transform, T_other: Transform): Point[] {
  const T = new Matrix4().multiplyMatrices(matrixOf(T_other), matrixOf(T_a_b).invert());
  const p = new Vector3();
  return b.map((point) => p.fromArray(point).applyMatrix4(T).toArray() as Point);
}

interface Canvas {
  context: CanvasRenderingContext2D;
  scale: number;
  middle: [number, number];
}

function drawPoints({ context, scale, middle }: Canvas, points: Point[], ink: string, side: Side): void {
  context.fillStyle = ink;
  for (const [x, y, z] of points) {
    const up = side === 'above' ? y : z;
    context.fillRect(size.width / 2 + (x - middle[0]) * scale - dot / 2, size.height / 2 - (up - middle[1]) * scale - dot / 2, dot, dot);
  }
}

/** The middle of what both see, and a scale that shows all of it. */
function framed(context: CanvasRenderingContext2D, points: Point[], side: Side): Canvas {
  const reach = (axis: number) => points.reduce(([least, most], { [axis]: value }) => [Math.min(least, value), Math.max(most, value)], [Infinity, -Infinity]);
  const [left, right] = reach(0);
  const [low, high] = reach(side === 'above' ? 1 : 2);
  const scale = Math.min((size.width - 24) / Math.max(right - left, 1), (size.height - 44) / Math.max(high - low, 1));
  return { context, scale, middle: [(left + right) / 2, (low + high) / 2] };
}

function drawScale({ context, scale }: Canvas, ink: string): void {
  const length_m = [1, 2, 5, 10, 20, 50, 100].filter((metres) => metres * scale < size.width / 3).at(-1) ?? 1;
  const [x, y] = [12, size.height - 12];
  context.fillStyle = ink;
  context.fillRect(x, y, length_m * scale, 1.5);
  context.font = '11px "Inter Variable", system-ui, sans-serif';
  context.fillText(`${length_m} m`, x, y - 5);
}

interface PictureProps {
  overlay: Overlay;
  T_a_b: Transform;
  names: string[];
  inks: string[];
  isDark: boolean;
  probability: number;
}

export function OverlayPicture({ overlay, T_a_b, names, inks, isDark, probability }: PictureProps) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const [side, setSide] = useState<Side>('above');
  const [other, setOther] = useState(false);
  const runnerUp = overlay.runner_up;
  useEffect(() => {
    const element = canvas.current!;
    const ratio = Math.min(devicePixelRatio, 2);
    element.width = size.width * ratio;
    element.height = size.height * ratio;
    const context = element.getContext('2d')!;
    context.scale(ratio, ratio);
    const b = other && runnerUp ? moved(overlay.b, T_a_b, runnerUp.T_a_b) : overlay.b;
    if (overlay.a.length + b.length === 0) return;
    const picture = framed(context, [...overlay.a, ...overlay.b], side);
    context.globalAlpha = 0.75;
    // Where both lie on each other neither may hide the other.
    context.globalCompositeOperation = isDark ? 'lighten' : 'multiply';
    drawPoints(picture, overlay.a, inks[0], side);
    drawPoints(picture, b, inks[1], side);
    context.globalAlpha = 1;
    context.globalCompositeOperation = 'source-over';
    drawScale(picture, isDark ? '#c8d0d8' : '#3a424a');
  }, [overlay, side, other, isDark, inks.join()]);
  return (
    <figure class="picture">
      <figcaption>
        <h4>Laid over each other</h4>
        <span class="switch" role="group" aria-label="Seen from">
          {(['above', 'side'] as const).map((name) => (
            <button key={name} class="button button-small" aria-pressed={side === name} onClick={() => setSide(name)}>
              {name === 'above' ? 'From above' : 'From the side'}
            </button>
          ))}
        </span>
      </figcaption>
      <canvas ref={canvas} role="img" aria-label={`${names[0]} and ${names[1]} near their overlap, ${other ? 'as the runner-up would lay them' : 'as they are aligned'}, seen from ${side === 'above' ? 'above' : 'the side'}`} />
      {runnerUp && (
        <div class="switch" role="group" aria-label="Placement">
          <button class="button button-small" aria-pressed={!other} onClick={() => setOther(false)}>
            This one, {percent(probability)}
          </button>
          <button class="button button-small" aria-pressed={other} onClick={() => setOther(true)}>
            Runner-up, {percent(runnerUp.probability)}
          </button>
        </div>
      )}
    </figure>
  );
}

export function ResidualHistogram({ overlay: { residuals_m, bin_m } }: { overlay: Overlay }) {
  const total = residuals_m.reduce((sum, count) => sum + count, 0);
  if (total === 0) return null;
  const most = Math.max(...residuals_m);
  let sum = 0;
  const median = residuals_m.findIndex((count) => (sum += count) >= total / 2);
  const [width, height] = [340, 84];
  const step = width / residuals_m.length;
  return (
    <figure class="picture">
      <figcaption>
        <h4>How far the surfaces lie apart</h4>
        <span class="muted">half within {(100 * (median + 1) * bin_m).toFixed(0)} cm</span>
      </figcaption>
      <svg class="histogram" viewBox={`0 0 ${width} ${height + 16}`} role="img" aria-label={`Histogram of distances; half of the points lie within ${(100 * (median + 1) * bin_m).toFixed(0)} centimetres`}>
        {residuals_m.map((count, at) => (
          <rect key={at} x={at * step + 0.75} width={Math.max(step - 1.5, 1)} y={height - (height * count) / most} height={(height * count) / most} class={at <= median ? 'near' : ''} />
        ))}
        <line x1="0" x2={width} y1={height} y2={height} />
        <text x="0" y={height + 13}>
          0
        </text>
        <text x={width} y={height + 13} text-anchor="end">
          {(100 * residuals_m.length * bin_m).toFixed(0)} cm
        </text>
      </svg>
    </figure>
  );
}
