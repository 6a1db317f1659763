// What happened, also before the page was opened.

import type { Desk } from '../context';
import { clock, day } from '../parts/format';

const shown = 300; // newest; the rest is in the server's file

export function LogPanel({ desk }: { desk: Desk }) {
  const { doneOnly } = desk.ui.now;
  const { entries: all } = desk.station.log;
  const entries = doneOnly ? all.filter(({ tone }) => tone === 'operator') : all;
  if (all.length === 0)
    return (
      <div class="empty">
        <p>Nothing has happened yet.</p>
        <p class="muted">Robots that come and go, what the server finds and what operators decide is written down here, and stays over a restart of the server.</p>
      </div>
    );
  return (
    <div role="log" aria-label="Events, newest first">
      <label class="check">
        <input type="checkbox" checked={doneOnly} onChange={(event) => desk.ui.set({ doneOnly: event.currentTarget.checked })} />
        Only what operators did
      </label>
      <ol class="log">
        {entries.slice(0, shown).map(({ key, at, tone, text: full, session, alignment }, index) => {
          const text = desk.station.titled(full);
          const dated = index === 0 || day(entries[index - 1].at) !== day(at);
          const known = alignment !== undefined ? desk.station.alignments.has(alignment) : session !== undefined && desk.station.sessions.has(session);
          return (
            <li key={key} class={`tone-${tone}`}>
              {dated && <span class="log-day">{day(at)}</span>}
              <time>{clock(at)}</time>
              {known ? (
                <button class="log-link" onClick={() => desk.ui.set(alignment !== undefined ? { alignment, session: null, tab: 'merges' } : { session, alignment: null })}>
                  {text}
                </button>
              ) : (
                <span>{text}</span>
              )}
            </li>
          );
        })}
      </ol>
    </div>
  );
}
