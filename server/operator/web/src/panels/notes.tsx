// What operators wrote on the map and measured in it, the newest first.

import { routes } from '../actions/actions';
import type { Desk } from '../context';
import { clock, day } from '../parts/format';

export function NotesPanel({ desk }: { desk: Desk }) {
  const { station, actions } = desk;
  const view = desk.view();
  if (station.notes.length === 0)
    return (
      <div class="empty">
        <p>Nothing is written on the map yet.</p>
        <p class="muted">Measure, and save what was measured; or write a note at a place of the map. All who work with this server see it.</p>
      </div>
    );
  return (
    <ul class="notes">
      {[...station.notes].reverse().map((note) => {
        const at = new Date(1000 * note.at_s);
        return (
          <li key={note.id}>
            <button class="log-link" onClick={() => view?.lookAtNote(note)}>
              {view?.noteText(note) ?? note.text}
            </button>
            <span class="muted">
              {note.by ?? 'an operator'}, {day(at)} {clock(at).slice(0, 5)}
            </span>
            {station.can(routes.unnote) && (
              <button class="button button-small" onClick={() => void actions.unnote(note)}>
                Take away…
              </button>
            )}
          </li>
        );
      })}
    </ul>
  );
}
