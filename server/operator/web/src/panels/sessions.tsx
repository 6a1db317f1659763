// Sessions over time, by the robots' own clocks.

import type { Desk } from '../context';
import { dayAndTime, duration, metres, wallClock_s } from '../parts/format';
import type { Session } from '../station/types';

interface Span {
  session: Session;
  from_s: number;
  to_s: number;
}

function spansOf(desk: Desk): Span[] {
  const spans: Span[] = [];
  for (const session of desk.station.sessions.values()) {
    const path = desk.station.paths.get(session.id);
    if (path?.length) spans.push({ session, from_s: path[0].stamp_s, to_s: path.at(-1)!.stamp_s });
  }
  return spans.sort((x, y) => x.from_s - y.from_s || x.session.id - y.session.id);
}

function stampText(stamp_s: number, start_s: number): string {
  if (start_s < wallClock_s) return duration(stamp_s - start_s);
  return dayAndTime(stamp_s);
}

export function SessionsPanel({ desk }: { desk: Desk }) {
  const spans = spansOf(desk);
  if (spans.length === 0)
    return (
      <div class="empty">
        <p>No session yet.</p>
        <p class="muted">Each run of a robot becomes one session. It appears with its first keyframe.</p>
      </div>
    );
  const start_s = Math.min(...spans.map(({ from_s }) => from_s));
  const end_s = Math.max(...spans.map(({ to_s }) => to_s), start_s + 1);
  const share = (stamp_s: number) => (stamp_s - start_s) / (end_s - start_s);
  return (
    <div class="sessions">
      <div class="time-axis muted" aria-hidden="true">
        <span>{stampText(start_s, start_s)}</span>
        <span>{stampText(end_s, start_s)}</span>
      </div>
      <ul class="spans">
        {spans.map(({ session, from_s, to_s }) => {
          const { ui, station, colours } = desk;
          const merged = (station.components.find(({ id }) => id === station.placed.get(session.id)?.component)?.sessions.length ?? 1) > 1;
          const transform_s = session.trigger_to_transform_ms === null ? '' : `, placed after ${duration(session.trigger_to_transform_ms / 1000)}`;
          return (
            <li key={session.id} style={{ '--mark': colours.of(session, ui.isDark) }}>
              <button
                class={ui.now.session === session.id ? 'span span-open' : 'span'}
                onClick={() => {
                  ui.set({ session: session.id, alignment: null });
                  desk.view()?.look(session.id);
                }}
              >
                <span class="span-name">{station.titleOf(session)}</span>
                <span class="span-track" aria-hidden="true">
                  <i class={session.connected && !session.complete ? 'growing' : ''} style={{ left: `${100 * share(from_s)}%`, width: `${Math.max(100 * (share(to_s) - share(from_s)), 1)}%` }} />
                </span>
                <span class="muted span-facts">
                  {session.keyframes} keyframes, {metres(session.distance_m ?? 0)}, {merged ? 'merged' : 'own frame'}
                  {transform_s}
                </span>
              </button>
            </li>
          );
        })}
      </ul>
      <p class="muted note">Times are those of the robots' clocks.</p>
    </div>
  );
}
