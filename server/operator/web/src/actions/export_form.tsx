// Which map, as what, how dense.

import { useState } from 'preact/hooks';
import { bytes, percent } from '../parts/format';
import type { Station } from '../station/station';
import { nameOf } from '../station/station';
import type { Progress } from './download';

const formats: Record<string, string> = {
  ply: 'PLY cloud',
  pcd: 'PCD cloud',
  las: 'LAS cloud',
  pdf: 'Plan to scale, PDF',
  svg: 'Plan to scale, SVG',
  png: 'Plan to scale, PNG',
  atlas: 'Atlas as JSON',
  tum: 'Trajectory, TUM',
  csv: 'Trajectory, CSV',
};
const clouds = ['ply', 'pcd', 'las'];
const plans = ['pdf', 'svg', 'png'];
const scales = [100, 200, 250, 500, 1000, 2000, 5000];

const isOfMap = (format: string) => !['atlas', 'tum', 'csv'].includes(format);

/** The formats that this server writes. */
function available(station: Station): string[] {
  return Object.keys(formats).filter((format) => {
    if (plans.includes(format)) return station.can(`GET /api/v1/plan?format=${format}`);
    return !clouds.includes(format) || station.can(`GET /api/v1/export?format=${format}`);
  });
}

function PlanFields() {
  return (
    <>
      <label class="field">
        Scale
        <select name="scale">
          <option value="0">the largest that fits A3</option>
          {scales.map((scale) => (
            <option key={scale} value={scale}>
              1:{scale}, on the smallest paper that holds it
            </option>
          ))}
        </select>
      </label>
      <div class="field-row">
        <label class="field">
          Heights from (m)
          <input name="low" type="number" step="any" placeholder="lowest" />
        </label>
        <label class="field">
          to (m)
          <input name="high" type="number" step="any" placeholder="highest" />
        </label>
      </div>
    </>
  );
}

export function ExportForm({ station, component }: { station: Station; component?: number }) {
  const [format, setFormat] = useState('ply');
  const largestFirst = [...station.components].sort((x, y) => y.sessions.length - x.sessions.length);
  const trajectory = format === 'tum' || format === 'csv';
  const framed = station.can('GET /api/v1/export?frame') && format !== 'atlas';
  return (
    <div class="form">
      <label class="field">
        Format
        <select name="format" value={format} onChange={(event) => setFormat(event.currentTarget.value)} data-first>
          {available(station).map((name) => (
            <option key={name} value={name}>
              {formats[name]}
            </option>
          ))}
        </select>
      </label>
      {trajectory && (
        <label class="field">
          Session
          <select name="session">
            {[...station.sessions.values()].map((session) => (
              <option key={session.id} value={session.id}>
                {station.titleOf(session)}
              </option>
            ))}
          </select>
        </label>
      )}
      {isOfMap(format) && (
        <label class="field">
          Map
          <select name="component" value={String(component ?? largestFirst[0]?.id ?? '')}>
            {largestFirst.map(({ id, sessions }) => (
              <option key={id} value={id}>
                {sessions.map((session) => station.titleOfName(session)).join(', ')}
              </option>
            ))}
          </select>
        </label>
      )}
      {plans.includes(format) && <PlanFields />}
      {clouds.includes(format) && (
        <label class="field">
          One point per cube of
          <select name="voxel" defaultValue="0.1">
            <option value="0.05">5 cm</option>
            <option value="0.1" selected>
              10 cm
            </option>
            <option value="0.25">25 cm</option>
            <option value="0.5">50 cm</option>
            <option value="0">every point</option>
          </select>
        </label>
      )}
      {framed && (
        <label class="field">
          Frame
          <select name="frame">
            <option value="component">the map's own</option>
            {station.surveys.length > 0 && (
              <option value="grid" selected={format !== 'tum' && format !== 'csv'}>
                the mine grid (surveyed)
              </option>
            )}
          </select>
        </label>
      )}
      <div id="export-progress" class="export-progress" hidden>
        <progress aria-label="Export" />
        <output class="muted" aria-live="off" />
      </div>
    </div>
  );
}

/** After a fault nothing goes on. */
export function hideProgress(): void {
  const row = document.querySelector<HTMLElement>('#export-progress');
  if (row) row.hidden = true;
}

/** Nothing came yet: the server counts the points, for a file's head says how many there are. */
export function showProgress(at: Progress | null): void {
  const row = document.querySelector<HTMLElement>('#export-progress');
  if (!row) return;
  row.hidden = false;
  const [bar, words] = [row.querySelector('progress')!, row.querySelector('output')!];
  if (at === null || at.total_bytes === null) bar.removeAttribute('value');
  else bar.value = at.received_bytes / Math.max(at.total_bytes, 1);
  words.value =
    at === null ? 'The server counts the points…' : at.total_bytes === null ? bytes(at.received_bytes) : `${percent(bar.value)} of ${bytes(at.total_bytes)}`;
}

export function exportPath(form: FormData, station: Station): { path: string; name: string } {
  const format = String(form.get('format'));
  if (form.get('component') === '' || (isOfMap(format) && !form.has('component'))) throw new Error('There is no map yet: it appears with the first keyframe of a robot.');
  const frame = form.get('frame') === 'grid' ? '&frame=grid' : '';
  const component = String(form.get('component'));
  if (format === 'atlas') return { path: '/api/v1/atlas', name: 'atlas.json' };
  if (format === 'tum' || format === 'csv') {
    const session = station.sessions.get(Number(form.get('session')))!;
    const names = `robot=${encodeURIComponent(session.robot)}&session=${encodeURIComponent(session.session)}`;
    return {
      path: `/api/v1/trajectory?${names}&format=${format}${frame}`,
      name: `${nameOf(session).replace(/[^A-Za-z0-9_.-]+/g, '_')}.${format === 'tum' ? 'txt' : 'csv'}`,
    };
  }
  if (plans.includes(format)) {
    const cut = ['low', 'high'].map((name) => (form.get(name) ? `&${name}=${String(form.get(name))}` : '')).join('');
    const scale = Number(form.get('scale'));
    return { path: `/api/v1/plan?component=${component}&format=${format}${scale ? `&scale=${scale}` : ''}${cut}${frame}`, name: `plan-${component}.${format}` };
  }
  return {
    path: `/api/v1/export?component=${component}&format=${format}&voxel=${String(form.get('voxel'))}${frame}`,
    name: `mine-${component}.${format}`,
  };
}
