// Sessions by date, by the robots' own clocks.

import type { Desk } from '../context';
import { clock, day, duration, metres, wallClock_s } from '../parts/format';
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

interface Group {
  title: string;
  spans: Span[];
}

/** By the day that they began, the newest first; those whose clocks tell no date together, at the end. */
function byDay(spans: Span[]): Group[] {
  const days = new Map<string, Span[]>();
  for (const span of spans.reverse()) {
    const title = span.from_s > wallClock_s ? day(new Date(1000 * span.from_s)) : 'Without a date';
    days.set(title, [span, ...(days.get(title) ?? [])]);
  }
  return [...days].map(([title, held]) => ({ title, spans: held }));
}

function Row({ desk, span, share }: { desk: Desk; span: Span; share: (stamp_s: number) => number }) {
  const { ui, station, colours } = desk;
  const { session, from_s, to_s } = span;
  const merged = (station.components.find(({ id }) => id === station.placed.get(session.id)?.component)?.sessions.length ?? 1) > 1;
  const transform_s = session.trigger_to_transform_ms === null ? '' : `, placed after ${duration(session.trigger_to_transform_ms / 1000)}`;
  return (
    <li style={{ '--mark': colours.of(session, ui.isDark) }}>
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
}

function Day({ desk, group: { title, spans }, alone }: { desk: Desk; group: Group; alone: boolean }) {
  const start_s = Math.min(...spans.map(({ from_s }) => from_s));
  const end_s = Math.max(...spans.map(({ to_s }) => to_s), start_s + 1);
  const share = (stamp_s: number) => (stamp_s - start_s) / (end_s - start_s);
  const ends = [start_s, end_s].map((stamp_s) => (start_s > wallClock_s ? clock(new Date(1000 * stamp_s)).slice(0, 5) : duration(stamp_s - start_s)));
  return (
    <section aria-label={title}>
      {(!alone || start_s > wallClock_s) && <h3 class="session-day">{title}</h3>}
      <div class="time-axis muted" aria-hidden="true">
        <span>{ends[0]}</span>
        <span>{ends[1]}</span>
      </div>
      <ul class="spans">
        {spans.map((span) => (
          <Row key={span.session.id} desk={desk} span={span} share={share} />
        ))}
      </ul>
    </section>
  );
}

export function SessionsPanel({ desk }: { desk: Desk }) {
  const groups = byDay(spansOf(desk));
  if (groups.length === 0)
    return (
      <div class="empty">
        <p>No session yet.</p>
        <p class="muted">Each run of a robot becomes one session. It appears with its first keyframe.</p>
      </div>
    );
  return (
    <div class="sessions">
      {groups.map((group) => (
        <Day key={group.title} desk={desk} group={group} alone={groups.length === 1} />
      ))}
      <p class="muted note">Times are those of the robots' clocks.</p>
    </div>
  );
}
