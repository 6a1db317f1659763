// The section along a line that was picked, as a drawing with its scale; to be read, and taken home.

import { useEffect, useRef, useState } from 'preact/hooks';
import type { Desk } from '../context';
import { Icon } from '../parts/icons';
import { roundStep } from '../view/grid';
import { clipText, slabAlong } from '../view/clip';
import { type Profile, profileCsv, profileScale } from '../view/profile';
import type { Section } from '../view/section';

const height_px = 150;
const inset = { left: 42, right: 10, top: 10, bottom: 18 };
const step_px = { along: 90, height: 32 };
const dot_px = 1.5;

interface Drawn {
  along_px: number;
  times: number;
  low_m: number;
  base_px: number;
}

function drawn(profile: Profile, width_px: number): Drawn {
  const [low_m, high_m] = profile.heights() ?? [0, 1];
  const room = { x: width_px - inset.left - inset.right, y: height_px - inset.top - inset.bottom };
  const { along_px, times } = profileScale(profile.length_m, high_m - low_m, room.x, room.y);
  return { along_px, times, low_m, base_px: height_px - inset.bottom };
}

function draw(context: CanvasRenderingContext2D, width_px: number, profile: Profile, scale: Drawn, inks: { ground: string; text: string; line: string; of: (session: number) => string }): void {
  const { along_px, times, low_m, base_px } = scale;
  const up_px = along_px * times;
  context.fillStyle = inks.ground;
  context.fillRect(0, 0, width_px, height_px);
  context.font = '11px "Inter Variable", system-ui, sans-serif';
  context.lineWidth = 1;
  const rule = (x: number, y: number, to_x: number, to_y: number) => {
    context.strokeStyle = inks.line;
    context.beginPath();
    context.moveTo(x, y);
    context.lineTo(to_x, to_y);
    context.stroke();
  };
  const [step, rise] = [roundStep(step_px.along / along_px), roundStep(step_px.height / up_px)];
  context.fillStyle = inks.text;
  context.textBaseline = 'top';
  for (let at = 0; at * step <= profile.length_m + 1e-6; at++) {
    const x = inset.left + at * step * along_px;
    rule(x, inset.top, x, base_px);
    context.fillText(`${(at * step).toFixed(step < 1 ? 1 : 0)}${at === 0 ? ' m' : ''}`, x + 2, base_px + 4);
  }
  context.textBaseline = 'middle';
  context.textAlign = 'right';
  for (let at = Math.ceil(low_m / rise); base_px - (at * rise - low_m) * up_px >= inset.top; at++) {
    const y = base_px - (at * rise - low_m) * up_px;
    rule(inset.left, y, width_px - inset.right, y);
    context.fillText((at * rise).toFixed(rise < 1 ? 1 : 0), inset.left - 5, y);
  }
  context.textAlign = 'left';
  for (const { along_m, height_m, session } of profile.points) {
    context.fillStyle = inks.of(session);
    context.fillRect(inset.left + along_m * along_px - dot_px / 2, base_px - (height_m - low_m) * up_px - dot_px / 2, dot_px, dot_px);
  }
}

function save(blob: Blob, name: string): void {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}

export function ProfilePanel({ desk, section }: { desk: Desk; section: Section }) {
  const { ui, station, colours } = desk;
  const { profile, component, ends } = section;
  const canvas = useRef<HTMLCanvasElement>(null);
  const [spot, setSpot] = useState('');
  const inGrid = desk.view()!.intoGrid(component);
  const scale = drawn(profile, canvas.current?.clientWidth ?? 600);
  useEffect(() => {
    const element = canvas.current!;
    const width_px = element.clientWidth;
    const ratio = Math.min(devicePixelRatio, 2);
    [element.width, element.height] = [width_px * ratio, height_px * ratio];
    const context = element.getContext('2d')!;
    context.scale(ratio, ratio);
    const style = getComputedStyle(element);
    const inkOf = new Map([...station.sessions.values()].map((session) => [session.id, colours.of(session, ui.isDark)]));
    const inks = { ground: style.getPropertyValue('--panel'), text: style.getPropertyValue('--muted'), line: style.getPropertyValue('--line'), of: (session: number) => inkOf.get(session) ?? '#888888' };
    draw(context, width_px, profile, drawn(profile, width_px), inks);
  }, [profile, ui.isDark, canvas.current?.clientWidth]);
  const point = (event: PointerEvent) => {
    const along_m = (event.offsetX - inset.left) / scale.along_px;
    const height_m = scale.low_m + (scale.base_px - event.offsetY) / (scale.along_px * scale.times);
    setSpot(along_m < 0 || along_m > profile.length_m ? '' : `${along_m.toFixed(2)} m along, ${height_m.toFixed(2)} m high`);
  };
  const heights = profile.heights();
  const facts = heights ? `${profile.length_m.toFixed(2)} m long, heights from ${heights[0].toFixed(2)} to ${heights[1].toFixed(2)} m${inGrid ? ' of the mine grid' : ''}${scale.times > 1 ? `, drawn ${scale.times} times as high` : ''}` : 'No points lie here: make it wider.';
  const slab = slabAlong(component, ends[0], ends.at(-1)!, ui.now.sectionWidth_m);
  return (
    <div class="profile" role="group" aria-label="Section">
      <div class="profile-head">
        <output>{spot || facts}</output>
        <label>
          <span class="muted">Width</span>
          <input type="range" min={0.2} max={20} step={0.2} value={ui.now.sectionWidth_m} onInput={(event) => ui.set({ sectionWidth_m: Number(event.currentTarget.value) })} aria-label="Width of the section" aria-valuetext={`${ui.now.sectionWidth_m.toFixed(1)} metres`} />
          <span>{ui.now.sectionWidth_m.toFixed(1)} m</span>
        </label>
        {ends.length === 2 && (
          <button class="button button-small" title={`Show nothing of the map but ${clipText(slab)}`} onClick={() => ui.set({ clip: slab })}>
            Cut out
          </button>
        )}
        <button class="button button-small" disabled={!heights} onClick={() => canvas.current!.toBlob((blob) => blob && save(blob, 'section.png'))}>
          <Icon name="export" /> PNG
        </button>
        <button
          class="button button-small"
          disabled={!heights}
          onClick={() => save(new Blob([profileCsv(profile.points, (id) => station.titleOf(station.sessions.get(id)!), inGrid)], { type: 'text/csv' }), 'section.csv')}
        >
          <Icon name="export" /> CSV
        </button>
      </div>
      <canvas ref={canvas} style={{ height: `${height_px}px` }} role="img" aria-label={`Section: ${facts}`} onPointerMove={point} onPointerLeave={() => setSpot('')} />
    </div>
  );
}
