// What happened since the page was opened.

import type { Desk } from '../context';
import { clock } from '../parts/format';

export function LogPanel({ desk }: { desk: Desk }) {
  const { entries } = desk.station.log;
  if (entries.length === 0)
    return (
      <div class="empty">
        <p>Nothing has happened since this page was opened.</p>
        <p class="muted">Robots that come and go, what the server finds and what you decide is written down here.</p>
      </div>
    );
  return (
    <div role="log" aria-label="Events, newest first">
      <ol class="log">
        {entries.map(({ id, at, tone, text, session, alignment }) => {
          const known = alignment !== undefined ? desk.station.alignments.has(alignment) : session !== undefined && desk.station.sessions.has(session);
          return (
            <li key={id} class={`tone-${tone}`}>
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
