// What is known between pairs of sessions, the ones that want a look first.

import type { Desk } from '../context';
import { Chip } from '../parts/chip';
import { sureness } from '../station/pairs';
import { mostRejected } from '../station/station';
import type { Alignment, State } from '../station/types';
import { Evidence } from './evidence';
import { NotKept } from './not_kept';
import { MergeGraph } from './graph';

/** Whom it would lay on each other against what they saw. */
export function contradiction(desk: Desk, { objection }: Alignment): string {
  const [a, b] = [objection?.a, objection?.b].map((id) => desk.station.sessions.get(id ?? -1));
  return a && b ? `contradicted by ${desk.station.titleOf(a)} and ${desk.station.titleOf(b)}` : '';
}

const order: State[] = ['candidate', 'retracted', 'verified', 'provisional', 'published', 'rejected'];

function Row({ desk, alignment }: { desk: Desk; alignment: Alignment }) {
  const { station, ui, colours } = desk;
  const probability = alignment.evidence.probability ?? 0;
  const words = sureness(alignment);
  const against = contradiction(desk, alignment);
  return (
    <li>
      <button class="pair" onClick={() => ui.set({ alignment: alignment.id, session: null })}>
        <span class="pair-names">
          {[alignment.a, alignment.b].map((name, at) => (
            <span key={at} class="pair-name">
              <span class="swatch" style={{ '--mark': colours.of(name, ui.isDark) }} aria-hidden="true" />
              {station.titleOfName(name)}
            </span>
          ))}
        </span>
        <span class="pair-facts">
          <Chip alignment={alignment} isDark={ui.isDark} />
          {alignment.decision !== 'none' && <span class="by-hand">by an operator: {alignment.decision}</span>}
          <span class="meter" title={words}>
            <i style={{ width: `${100 * probability}%` }} />
          </span>
          <span class="figure">{words}</span>
        </span>
        {against && <span class="against">{against}</span>}
      </button>
    </li>
  );
}

export function MergesPanel({ desk }: { desk: Desk }) {
  const { station, ui } = desk;
  if (ui.now.placed) return <NotKept desk={desk} answer={ui.now.placed} />;
  const selected = ui.now.alignment === null ? undefined : station.alignments.get(ui.now.alignment);
  if (selected) return <Evidence key={selected.id} desk={desk} alignment={selected} />;
  const all = [...station.alignments.values()].sort((x, y) => order.indexOf(x.state) - order.indexOf(y.state) || (y.evidence.probability ?? 0) - (x.evidence.probability ?? 0));
  const rejected = Math.max(station.rejected, all.filter(({ state }) => state === 'rejected').length);
  const showRejected = (shown: boolean): void => {
    ui.set({ showRejected: shown });
    void station.showRejected(shown).catch(() => {}); // the next revision fetches them
  };
  const shown = all.filter(({ state }) => state !== 'rejected' || ui.now.showRejected);
  return (
    <>
      <MergeGraph desk={desk} />
      {shown.length === 0 && (
        <div class="empty">
          <p>{station.sessions.size < 2 ? 'Merges need two sessions.' : 'No overlap has been found yet.'}</p>
          <p class="muted">
            {station.sessions.size < 2
              ? 'As soon as a second robot has driven, the server looks for places that both have seen.'
              : 'The server tries again as the robots drive on. A session of less than 50 m that still grows is not merged yet.'}
          </p>
        </div>
      )}
      {shown.length > 0 && (
        <ul class="pairs">
          {shown.map((alignment) => (
            <Row key={alignment.id} desk={desk} alignment={alignment} />
          ))}
        </ul>
      )}
      {rejected > 0 && (
        <label class="check">
          <input type="checkbox" checked={ui.now.showRejected} onChange={(event) => showRejected(event.currentTarget.checked)} />
          Show {rejected > mostRejected ? `the newest ${mostRejected} of ${rejected}` : rejected} {rejected === 1 ? 'pair' : 'pairs'} without a match
        </label>
      )}
    </>
  );
}
