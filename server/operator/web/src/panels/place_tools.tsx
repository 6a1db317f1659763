// While an operator lays a session on another map by hand: which map, where it lies now, and off to the server.

import { useEffect, useRef, useState } from 'preact/hooks';
import { movedText, recordedOf, register } from '../actions/place';
import type { Desk } from '../context';
import { toast } from '../parts/toast';
import type { Session } from '../station/types';
import type { PlacingOf } from '../view/placing';

/** Maps that a session can be laid on: all but its own, the largest first. */
export function othersOf({ station }: Desk, { id }: Session): [number, Session[]][] {
  const maps = new Map<number, Session[]>();
  const componentOf = (session: number) => station.placed.get(session)?.component ?? -session;
  for (const session of station.sessions.values()) maps.set(componentOf(session.id), [...(maps.get(componentOf(session.id)) ?? []), session]);
  maps.delete(componentOf(id));
  return [...maps].sort(([, x], [, y]) => y.length - x.length || x[0].id - y[0].id);
}

export function beginPlacing(desk: Desk, session: Session): void {
  const [largest] = othersOf(desk, session);
  if (largest) desk.ui.set({ placing: { session: session.id, on: largest[0], onSession: null }, alignment: null });
}

/** "12:3": session 3 of map 12; "12:": whichever session of it comes to lie beside. */
const valueOf = ({ on, onSession }: PlacingOf) => `${on}:${onSession ?? ''}`;

function chosen(value: string, session: number): PlacingOf {
  const [on, onSession] = value.split(':');
  return { session, on: Number(on), onSession: onSession ? Number(onSession) : null };
}

function Maps({ desk, placing, session }: { desk: Desk; placing: PlacingOf; session: Session }) {
  const { station, ui } = desk;
  return (
    <select value={valueOf(placing)} aria-label="Map that it is laid on" onChange={(event) => ui.set({ placing: chosen(event.currentTarget.value, session.id), placed: null })}>
      {othersOf(desk, session).map(([on, members]) =>
        members.length === 1 ? (
          <option key={on} value={`${on}:`}>
            {station.titleOf(members[0])}
          </option>
        ) : (
          <optgroup key={on} label={`Map of ${members.length} sessions`}>
            <option value={`${on}:`}>the session beside it ({members.length})</option>
            {members.map((member) => (
              <option key={member.id} value={`${on}:${member.id}`}>
                {station.titleOf(member)}
              </option>
            ))}
          </optgroup>
        ),
      )}
    </select>
  );
}

/** Follows what is dragged, without the rest of the panels. */
function Figures({ desk }: { desk: Desk }) {
  const [, again] = useState(0);
  const placing = desk.view()?.placing;
  useEffect(() => {
    const look = () => again((count) => count + 1);
    look(); // it may have begun since this was drawn
    return placing?.onChange(look);
  }, [placing]);
  const asked = placing?.asked();
  if (!asked) return <output>{placing?.now && 'One of the two has no path yet.'}</output>;
  const [x, y, z, yaw] = asked.at.map((value) => value.toFixed(1).replace('-', '−'));
  const on = desk.station.sessions.get(asked.a);
  return (
    <output class="figure">
      at x {x} y {y} z {z} m, turned {yaw}° in the frame of {on ? desk.station.titleOf(on) : 'that map'}
    </output>
  );
}

export function PlaceTools({ desk, placing }: { desk: Desk; placing: PlacingOf }) {
  const { station, ui } = desk;
  const [fault, setFault] = useState('');
  const running = useRef<AbortController | null>(null);
  const [busy, setBusy] = useState(false);
  useEffect(() => () => running.current?.abort(), []);
  const session = station.sessions.get(placing.session);
  if (!session) return null;
  const send = async () => {
    const asked = desk.view()?.placing.asked();
    if (!asked || busy) return;
    const left = (running.current = new AbortController());
    setBusy(true);
    setFault('');
    try {
      const answer = await register(station, asked, left.signal);
      const pair = recordedOf(station, answer);
      if (answer.recorded && pair) {
        ui.set({ placing: null, placed: null, alignment: pair.id, session: null, survey: null, tab: 'merges', sheet: 'side' });
        toast(`${station.titleOf(session)}: ${movedText(answer)}`);
      } else {
        setFault(movedText(answer));
        ui.set({ placed: answer, alignment: null, survey: null, tab: 'merges' });
      }
    } catch (error) {
      if (!left.signal.aborted) setFault((error as Error).message);
    }
    if (!left.signal.aborted) setBusy(false);
  };
  return (
    <div class="tools tools-place" role="group" aria-label="Place by hand">
      <span>Lay {station.titleOf(session)} on</span>
      <Maps desk={desk} placing={placing} session={session} />
      <Figures desk={desk} />
      <button id="register" class="button button-small button-main" disabled={busy} onClick={() => void send()}>
        Register
      </button>
      <button class="button button-small" onClick={() => ui.set({ placing: null, placed: null })}>
        Give up
      </button>
      <p class={fault ? 'fault' : 'muted'} role="status">
        {fault || (busy ? 'The server registers it there…' : 'Drag it, turn it by its handle, or use arrow keys and [ ].')}
      </p>
    </div>
  );
}
