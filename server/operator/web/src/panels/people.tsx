// Operators with a name: what each may do, and until when. Shown to those who may say so.

import { useEffect, useState } from 'preact/hooks';
import { routes } from '../actions/actions';
import type { Desk } from '../context';
import { clock, day } from '../parts/format';
import { askJson } from '../station/api';
import type { OperatorRow } from '../station/types';

export const mayWords: Record<OperatorRow['role'], string> = { view: 'may look', operate: 'may operate', administer: 'may administer' };

function untilText(expires_s: number): string {
  const at = new Date(1000 * expires_s);
  return `${Date.now() < Number(at) ? 'until' : 'ended'} ${day(at)} ${clock(at).slice(0, 5)}`;
}

export function People({ desk }: { desk: Desk }) {
  const { station, actions } = desk;
  const [people, setPeople] = useState<OperatorRow[]>([]);
  const [asked, ask] = useState(0);
  const may = station.token && station.can(routes.operators);
  useEffect(() => {
    if (!may || station.link !== 'live') return;
    const gone = new AbortController();
    void askJson<{ operators: OperatorRow[] }>('/api/v1/operators', { signal: gone.signal }).then(
      ({ operators }) => setPeople(operators),
      () => {}, // with the next look
    );
    return () => gone.abort();
  }, [may, station.link, asked, station.log.entries[0]?.key]);
  if (!may) return null;
  const after = (work: Promise<void>) => void work.then(() => ask(asked + 1));
  return (
    <details class="fleet">
      <summary>
        Operators <span class="muted">{people.length} by name</span>
      </summary>
      <ul>
        {people.map(({ name, role, expires_s }) => (
          <li key={name} class="fleet-row">
            <strong>{name}</strong>
            <span class="muted">
              {mayWords[role]}, {untilText(expires_s)}
            </span>
            <span class="actions">
              <button class="button button-small button-danger" onClick={() => after(actions.revokeOperator(name))}>
                Revoke…
              </button>
            </span>
          </li>
        ))}
        <li class="fleet-row">
          <span class="actions">
            <button class="button button-small" onClick={() => after(actions.addOperator())}>
              Add an operator…
            </button>
          </span>
        </li>
      </ul>
    </details>
  );
}
