// What changed in the mine between sessions, the newest first; and from when on it is listed and drawn.

import type { Desk } from '../context';
import { dayAndYear } from '../parts/format';
import { changeKey, changeLooks, changesSince, changeSize } from '../station/changes';
import type { Change } from '../station/types';
import { moved } from '../view/grid';

/** In the mine's grid where the map is surveyed, otherwise in the map's frame. */
function placeText(desk: Desk, { component, p }: Change): string {
  const T = component === null ? null : desk.station.gridOf(component);
  const [x, y, z] = (T ? moved(T, ...p) : p).map((metres) => metres.toFixed(1));
  return T ? `E ${x} N ${y} H ${z} m` : `x ${x} y ${y} z ${z} m of the map`;
}

function Row({ desk, change }: { desk: Desk; change: Change }) {
  const { ui, station } = desk;
  const { kind, older, newer, alignment } = change;
  const look = changeLooks[kind];
  const key = changeKey(change);
  const show = () => {
    ui.set({ change: key, changes: true });
    desk.view()?.lookAtChange(change);
  };
  return (
    <li class="change" data-chosen={ui.now.change === key ? '' : undefined}>
      <button class="log-link change-name" aria-pressed={ui.now.change === key} onClick={show}>
        <span class="chip" title={look.about} style={{ '--mark': ui.isDark ? look.dark : look.light }}>
          <span aria-hidden="true">{look.sign}</span>
          {kind}
        </span>
        {changeSize(change)}
      </button>
      <span>
        between <time dateTime={new Date(1000 * older.stamp_s).toISOString()}>{dayAndYear(older.stamp_s)}</time> and{' '}
        <time dateTime={new Date(1000 * newer.stamp_s).toISOString()}>{dayAndYear(newer.stamp_s)}</time>
      </span>
      <span class="muted">
        as {station.titleOfName(older)} and {station.titleOfName(newer)} saw it, {placeText(desk, change)}
      </span>
      {station.alignments.has(alignment) && (
        <button class="button button-small" onClick={() => ui.set({ alignment, session: null, tab: 'merges' })}>
          Evidence of this pair
        </button>
      )}
    </li>
  );
}

export function ChangesPanel({ desk }: { desk: Desk }) {
  const { station, ui } = desk;
  const { changes, changesFrom } = ui.now;
  const shown = changesSince(station.changes, changesFrom);
  if (station.changes.length === 0)
    return (
      <div class="empty">
        <p>No change of the mine is known.</p>
        <p class="muted">Merged sessions tell of changes when more than an hour lies between them and their robots stamp keyframes with dates.</p>
      </div>
    );
  return (
    <>
      <label class="check">
        <input type="checkbox" checked={changes} onChange={(event) => ui.set({ changes: event.currentTarget.checked })} />
        Show changes on the map
      </label>
      <label class="check">
        Since
        <input type="date" aria-label="Changes that may have come after this day" value={changesFrom} onInput={(event) => ui.set({ changesFrom: event.currentTarget.value })} />
        <span class="muted" role="status">
          {shown.length} of {station.changes.length}
        </span>
      </label>
      <ul class="notes">
        {shown.map((change) => (
          <Row key={changeKey(change)} desk={desk} change={change} />
        ))}
      </ul>
    </>
  );
}
