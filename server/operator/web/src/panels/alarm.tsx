// A merge that was withdrawn: robots were told transforms that are not true any more. It stays until somebody has seen it.

import type { Desk } from '../context';
import { clock } from '../parts/format';

export function Alarm({ desk }: { desk: Desk }) {
  const { station, ui } = desk;
  const [newest, ...others] = station.log.alarms;
  if (!newest) return null;
  const seen = () => {
    station.log.seen();
    station.changed();
  };
  const { alignment_id: alignment } = newest;
  return (
    <div class="alarm" role="alert">
      <span>
        {clock(new Date(1000 * newest.at_s))} {station.titled(newest.text)}
        {others.length > 0 && ` ${others.length} more ${others.length === 1 ? 'merge was' : 'merges were'} withdrawn, see Events.`}
      </span>
      {alignment !== null && station.alignments.has(alignment) && (
        <button class="button button-small" onClick={() => ui.set({ alignment, session: null, survey: null, tab: 'merges', sheet: 'side' })}>
          Why
        </button>
      )}
      <button class="button button-small" onClick={seen}>
        Seen
      </button>
    </div>
  );
}
