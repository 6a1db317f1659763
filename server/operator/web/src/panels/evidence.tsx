// Why two sessions are or are not merged: in words, figures and pictures; and what to do about it.

import { useEffect, useState } from 'preact/hooks';
import { type Decision, fitting, routes } from '../actions/actions';
import type { Desk } from '../context';
import { Chip } from '../parts/chip';
import { percent } from '../parts/format';
import { Icon } from '../parts/icons';
import { askJson } from '../station/api';
import { nameOf } from '../station/station';
import type { Alignment, Explanation, Overlay } from '../station/types';
import { sureness } from '../station/pairs';
import { contradiction } from './merges';
import { OverlayPicture, ResidualHistogram } from './evidence_pictures';

const words: Record<Decision, string> = { confirm: 'Confirm…', refuse: 'Refuse…', retract: 'Take apart…' };
const overlayPoints = 12000;

const speaks: Record<string, { glyph: string; word: string }> = {
  for: { glyph: '+', word: 'in favour' },
  against: { glyph: '−', word: 'against' },
  neither: { glyph: '·', word: 'neither' },
};

/** Fetched anew whenever the alignment is another state of itself. */
function useAnswer<T>(path: string | null, basis: string): { answer: T | null; fault: string } {
  const [state, set] = useState<{ answer: T | null; fault: string }>({ answer: null, fault: '' });
  useEffect(() => {
    if (path === null) return;
    const gone = new AbortController();
    askJson<T>(path, { signal: gone.signal }).then(
      (answer) => set({ answer, fault: '' }),
      (error: Error) => !gone.signal.aborted && set((old) => ({ ...old, fault: error.message })),
    );
    return () => gone.abort();
  }, [path, basis]);
  return state;
}

function Findings({ explanation }: { explanation: Explanation }) {
  return (
    <ul class="findings">
      {explanation.findings.map(({ evidence, speaks: side, text }) => {
        const { glyph, word } = speaks[side] ?? speaks.neither;
        return (
          <li key={evidence} class={`finding finding-${side}`}>
            <span class="finding-glyph" role="img" aria-label={word} title={word}>
              {glyph}
            </span>
            {text}
          </li>
        );
      })}
    </ul>
  );
}

/** Of a pair that is held back: the merges that it stands against, each a click away. */
function Rivals({ desk, alignment }: { desk: Desk; alignment: Alignment }) {
  const against = contradiction(desk, alignment);
  if (alignment.state !== 'verified') return null;
  const { station, ui } = desk;
  const { objection } = alignment;
  const ids = new Set([station.idOf(alignment.a), station.idOf(alignment.b), objection?.a, objection?.b]);
  const rivals = [...station.alignments.values()].filter((other) => other.state === 'published' && [other.a, other.b].every((name) => ids.has(station.idOf(name))));
  return (
    <div class="rivals">
      <p>
        Held back: {against ? `it is ${against}, who would lie on each other` : 'merges that are better founded contradict it'}
        {objection ? ` where ${percent(objection.violation)} of the points lie in what the other saw to be free` : ''}. Most such pairs are look-alikes.
      </p>
      {rivals.map((rival) => (
        <button key={rival.id} class="log-link" onClick={() => ui.set({ alignment: rival.id })}>
          It stands against: {station.titleOfName(rival.a)} and {station.titleOfName(rival.b)}, merged
        </button>
      ))}
    </div>
  );
}

/** In words: what it comes to, what is missing, what was measured. Pictures stand between them. */
export function Outcome({ desk: { station }, explanation }: { desk: Desk; explanation: Explanation }) {
  return (
    <>
      <p class="outcome">{station.titled(explanation.outcome)}.</p>
      {explanation.decision && <p class="by-hand">{explanation.decision}</p>}
      {explanation.missing.length > 0 && (
        <>
          <h4>What keeps them apart</h4>
          <ul class="missing">
            {explanation.missing.map((line) => (
              <li key={line}>{station.titled(line)}</li>
            ))}
          </ul>
        </>
      )}
    </>
  );
}

export function Measured({ explanation }: { explanation: Explanation }) {
  if (explanation.findings.length === 0) return null;
  return (
    <>
      <h4>What was measured</h4>
      <Findings explanation={explanation} />
    </>
  );
}

export function Evidence({ desk, alignment }: { desk: Desk; alignment: Alignment }) {
  const { station, ui, colours } = desk;
  const basis = `${alignment.state} ${alignment.decision} ${alignment.evidence.probability} ${alignment.T_a_b.join()}`;
  const [a, b] = [nameOf(alignment.a), nameOf(alignment.b)].map(encodeURIComponent);
  const { answer: explanation, fault } = useAnswer<Explanation>(`/api/v1/explain?a=${a}&b=${b}`, basis);
  const { answer: overlay } = useAnswer<Overlay>(
    station.can(routes.overlay) && (alignment.evidence.inlier_fraction ?? 0) > 0 ? `/api/v1/alignments/${alignment.id}/overlay?most=${overlayPoints}` : null,
    basis,
  );
  const names = [station.titleOfName(alignment.a), station.titleOfName(alignment.b)];
  const inks = [alignment.a, alignment.b].map((name) => colours.of(name, ui.isDark));
  const runnerUp = alignment.evidence.runner_up;
  return (
    <article class="evidence" aria-label={`Evidence: ${names.join(' and ')}`}>
      <button class="back" onClick={() => ui.set({ alignment: null })}>
        <Icon name="back" /> All pairs
      </button>
      <h3>
        {names.map((name, at) => (
          <span key={at} class="pair-name">
            <span class="swatch" style={{ '--mark': inks[at] }} aria-hidden="true" />
            {name}
          </span>
        ))}
      </h3>
      <p class="pair-facts">
        <Chip alignment={alignment} isDark={ui.isDark} />
        <span class="meter">
          <i style={{ width: `${100 * (alignment.evidence.probability ?? 0)}%` }} />
        </span>
        <span class="figure">{sureness(alignment)}</span>
      </p>
      <div class="actions">
        {(station.can(routes.decide) ? fitting(alignment) : []).map((decision) => (
          <button
            key={decision}
            class={`button ${decision !== 'confirm' ? 'button-danger' : alignment.state === 'candidate' ? 'button-main' : ''}`}
            onClick={() => void desk.actions.decide(alignment, decision)}
          >
            {words[decision]}
          </button>
        ))}
        {alignment.decision !== 'none' && station.can(routes.decide) && (
          <button class="button" onClick={() => void desk.actions.undo(alignment)}>
            Undo the decision
          </button>
        )}
      </div>
      <Rivals desk={desk} alignment={alignment} />
      {fault && <p class="fault">{fault}</p>}
      {explanation && <Outcome desk={desk} explanation={explanation} />}
      {overlay && (
        <>
          <OverlayPicture overlay={overlay} T_a_b={alignment.T_a_b} names={names} inks={inks} isDark={ui.isDark} probability={alignment.evidence.probability ?? 0} />
          <ResidualHistogram overlay={overlay} />
        </>
      )}
      {!overlay?.runner_up && (runnerUp ?? 0) > 0 && <p class="muted">The best different placement has probability {percent(runnerUp!)}.</p>}
      {explanation && <Measured explanation={explanation} />}
    </article>
  );
}
