// The servers of this base station: which serves, and which wait to take over from it. Shown where there are several, or
// were while the page was open.

import { useEffect, useState } from 'preact/hooks';
import type { Desk } from '../context';
import { duration, momentText } from '../parts/format';
import { askJson } from '../station/api';
import type { ServerRow } from '../station/types';

const every_ms = 5000;

export function Servers({ desk }: { desk: Desk }) {
  const { station } = desk;
  const [servers, setServers] = useState<ServerRow[]>([]);
  const [several, setSeveral] = useState(false);
  useEffect(() => {
    if (station.link !== 'live') return;
    const gone = new AbortController();
    const look = () =>
      void askJson<{ servers: ServerRow[] }>('/api/v1/servers', { signal: gone.signal }).then(
        (answer) => {
          setServers(answer.servers);
          if (answer.servers.length > 1) setSeveral(true);
        },
        () => {}, // with the next look
      );
    look();
    const timer = setInterval(look, every_ms);
    return () => {
      clearInterval(timer);
      gone.abort();
    };
  }, [station.link]);
  if (!several) return null;
  const waiting = servers.filter(({ role }) => role === 'standby').length;
  return (
    <details class="fleet">
      <summary>
        Servers <span class="muted">{waiting === 0 ? 'none stands by' : `${waiting} ${waiting === 1 ? 'stands' : 'stand'} by`}</span>
      </summary>
      <ul>
        {servers.map(({ name, role, robots, since_s, heard_ago_s, relayed, searched, self }) => (
          <li key={name + robots} class="fleet-row">
            <strong>{name}</strong>
            <span class="muted">
              {role === 'active' ? 'serves' : 'stands by'} for robots on {robots}, since {momentText(since_s)}
              {self ? '' : `, heard ${duration(heard_ago_s)} ago`}
              {relayed ? `, relays ${relayed} ${relayed === 1 ? 'connection' : 'connections'}` : ''}
              {searched ? `, has searched ${searched} ${searched === 1 ? 'pair' : 'pairs'} of sessions` : ''}
            </span>
          </li>
        ))}
      </ul>
    </details>
  );
}
