// The 3D view with its tools.

import { useLayoutEffect, useRef } from 'preact/hooks';
import { routes } from '../actions/actions';
import type { Desk } from '../context';
import { compact, dayAndTime, duration, wallClock_s } from '../parts/format';
import { Icon } from '../parts/icons';
import type { ColourBy } from '../view/cloud_material';
import { clipText } from '../view/clip';
import { type MeasureOf, needed, type Saved, saved } from '../view/measure';
import { ramp } from '../view/palette';
import { showKeys } from './keys';
import { PlaceTools } from './place_tools';
import { ProfilePanel } from './profile';
import { TimeBar } from './time_bar';

const colourWords: Record<ColourBy, string> = { robot: 'Robot', height: 'Height', age: 'Age' };
const highestRoof_m = 8;

/** When the oldest and the newest points were seen. */
function ageEnds(desk: Desk): [string, string] {
  const { oldest_s, newest_s } = desk.view()?.ages() ?? { oldest_s: 0, newest_s: 1 };
  return oldest_s > wallClock_s ? [dayAndTime(oldest_s), dayAndTime(newest_s)] : ['first seen', `${duration(newest_s - oldest_s)} later`];
}

function Legend({ desk }: { desk: Desk }) {
  const { colourBy } = desk.ui.now;
  if (colourBy === 'robot') return null;
  const [low, high] = desk.view()?.heights() ?? [0, 1];
  const ends = colourBy === 'height' ? [`${low.toFixed(0)} m`, `${high.toFixed(0)} m`] : ageEnds(desk);
  return (
    <div class="legend">
      <span>{ends[0]}</span>
      <i style={{ background: `linear-gradient(90deg, ${ramp.join()})` }} aria-hidden="true" />
      <span>{ends[1]}</span>
    </div>
  );
}

function Cuts({ desk }: { desk: Desk }) {
  const { roof_m, slice_m } = desk.ui.now;
  const [low, high] = (desk.view()?.heights() ?? [0, 1]).map((height, at) => (at ? Math.ceil(height) : Math.floor(height)));
  const slice = slice_m ?? [low, high];
  const setSlice = (at: 0 | 1, value: number) => {
    const next: [number, number] = [...slice] as [number, number];
    next[at] = value;
    if (next[0] > next[1]) next[1 - at] = value;
    desk.ui.set({ slice_m: next[0] <= low && next[1] >= high ? null : next });
  };
  return (
    <div class="cuts">
      <label title="Points higher than this over the robot's path are left out">
        <span>Roof cut</span>
        <input
          type="range"
          min={-1}
          max={highestRoof_m}
          step={0.1}
          value={roof_m ?? highestRoof_m}
          onInput={(event) => {
            const value = Number(event.currentTarget.value);
            desk.ui.set({ roof_m: value >= highestRoof_m ? null : value });
          }}
          aria-label="Roof cut: metres over the robot's path"
          aria-valuetext={roof_m === null ? 'no cut' : `${roof_m.toFixed(1)} metres`}
        />
        <output>{roof_m === null ? 'off' : `${roof_m.toFixed(1)} m`}</output>
      </label>
      {([0, 1] as const).map((at) => (
        <label key={at} title="Only points between these heights are shown">
          <span>{at ? 'to' : 'Slice from'}</span>
          <input type="range" min={low} max={high} step={0.5} value={slice[at]} onInput={(event) => setSlice(at, Number(event.currentTarget.value))} aria-label={at ? 'Slice: highest' : 'Slice: lowest'} />
          <output>{slice[at].toFixed(0)} m</output>
        </label>
      ))}
    </div>
  );
}

const measures: Record<MeasureOf, string> = { distance: 'Distance', line: 'Line', area: 'Area', section: 'Section', box: 'Clip', note: 'Note' };
const numbers = ['first', 'second', 'third'];

function MeasureTools({ desk }: { desk: Desk }) {
  const { ui } = desk;
  const { measureOf } = ui.now;
  const measure = desk.view()?.measure;
  const taken = measure?.ends.length ?? 0;
  const next = taken === 0 ? 'Click a point of the map, or move it under the cross and press Enter.' : measureOf === 'box' ? 'Now the opposite corner.' : `Now the ${numbers[taken] ?? 'next'} point.`;
  return (
    <div class="tools tools-measure">
      <div class="switch" role="group" aria-label="What to measure">
        {(Object.keys(measures) as MeasureOf[]).map((name) => (
          <button key={name} class="button button-small" aria-pressed={measureOf === name} onClick={() => ui.set({ measureOf: name })}>
            {measures[name]}
          </button>
        ))}
      </div>
      <output class={measure?.fault ? 'fault' : ''}>{measure?.fault || (taken < needed[measureOf] ? next : measure!.text(measureOf))}</output>
      {taken >= needed[measureOf] && saved.includes(measureOf as Saved) && desk.station.can(routes.note) && (
        <button
          class="button button-small"
          onClick={() =>
            void desk.actions.note(measureOf as Saved, measure!.ends).then((done) => {
              if (done) measure!.clear();
              ui.set({});
            })
          }
        >
          {measureOf === 'note' ? 'Write…' : 'Save…'}
        </button>
      )}
      {taken > 0 && (
        <button
          class="button button-small"
          onClick={() => {
            measure!.clear();
            ui.set({});
          }}
        >
          Clear
        </button>
      )}
    </div>
  );
}

export function ViewPane({ desk, mount }: { desk: Desk; mount: (canvas: HTMLCanvasElement, layer: HTMLElement) => void }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const layer = useRef<HTMLDivElement>(null);
  useLayoutEffect(() => mount(canvas.current!, layer.current!), []);
  const { ui, station } = desk;
  const { way, colourBy, measuring } = ui.now;
  const view = desk.view();
  const section = view?.section();
  const followed = station.sessions.get(ui.now.follow ?? -1);
  return (
    <main class="view">
      <div class={measuring || view?.giving ? 'stage stage-measuring' : 'stage'}>
        <canvas ref={canvas} tabIndex={0} aria-label="Map of the mine. Arrow keys move, plus and minus zoom, F shows all, question mark lists all keys." />
        <div class="labels" ref={layer} />
        {(measuring || view?.giving) && <div class="crosshair" aria-hidden="true" />}
        {station.sessions.size === 0 && station.link === 'live' && (
          <div class="empty empty-view">
            <p>The mine is dark.</p>
            <p class="muted">It appears here as soon as a robot sends its first keyframes.</p>
          </div>
        )}
      </div>
      <div class="tools-above">
        <div class="tools tools-top" role="toolbar" aria-label="View">
          <div class="switch" role="group" aria-label="Seen from">
            {(['top', 'free'] as const).map((name) => (
              <button
                key={name}
                class="button button-small"
                aria-pressed={way === name}
                onClick={() => ui.set({ way: name })}
              >
                <Icon name={name} /> {name === 'top' ? 'Top' : 'Free'}
              </button>
            ))}
          </div>
          <div class="switch" role="group" aria-label="Coloured by">
            {(Object.keys(colourWords) as ColourBy[]).map((name) => (
              <button key={name} class="button button-small" aria-pressed={colourBy === name} onClick={() => ui.set({ colourBy: name })}>
                {colourWords[name]}
              </button>
            ))}
          </div>
          <button class="button button-small" onClick={() => view?.frameAll()}>
            <Icon name="fit" /> Show all
          </button>
          <button class="button button-small" aria-pressed={measuring} onClick={() => ui.set({ measuring: !measuring })}>
            <Icon name="measure" /> Measure
          </button>
          <button class="button button-small" aria-pressed={desk.player.open} title="Show the map as it was" onClick={() => desk.player.show(!desk.player.open)}>
            <Icon name="time" /> Time
          </button>
          <button class="button button-small" aria-pressed={ui.now.grid} title="Lines of coordinates" onClick={() => ui.set({ grid: !ui.now.grid })}>
            <Icon name="top" /> Grid
          </button>
          {station.changes.length > 0 && (
            <button class="button button-small" aria-pressed={ui.now.changes} title="What was excavated or filled between sessions" onClick={() => ui.set({ changes: !ui.now.changes })}>
              <Icon name="change" /> Changes
            </button>
          )}
          {ui.now.clip && (
            <button class="button button-small" aria-pressed="true" title="Show all of the map again" onClick={() => ui.set({ clip: null })}>
              <Icon name="close" /> Only {clipText(ui.now.clip)}
            </button>
          )}
          {followed && (
            <button class="button button-small" aria-pressed="true" title="Let go" onClick={() => ui.set({ follow: null })}>
              <Icon name="target" /> Following {station.titleOf(followed)}
            </button>
          )}
          <button class="button button-small only-phone" aria-pressed={ui.now.sheet === 'tools'} onClick={() => ui.set({ sheet: ui.now.sheet === 'tools' ? null : 'tools' })}>
            Cuts
          </button>
          <button class="button button-small button-icon not-phone" aria-label="Keys" title="Keys" onClick={() => void showKeys()}>
            <Icon name="keys" />
          </button>
        </div>
        {measuring && <MeasureTools desk={desk} />}
        {ui.now.placing && <PlaceTools key={ui.now.placing.session} desk={desk} placing={ui.now.placing} />}
      </div>
      <div class={desk.player.open || section ? 'tools tools-bottom timed' : 'tools tools-bottom'}>
        <TimeBar desk={desk} />
        {section && <ProfilePanel desk={desk} section={section} />}
        <Cuts desk={desk} />
        <Legend desk={desk} />
        <span class="muted points-shown">{view && view.shown.points > 0 ? `${compact(view.shown.points)} points` : ''}</span>
      </div>
    </main>
  );
}
