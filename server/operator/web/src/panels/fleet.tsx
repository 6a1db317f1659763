// Which robots may come in: invited, enrolled, revoked; when each was last heard of, and what it may send.

import { useEffect, useState } from 'preact/hooks';
import { routes } from '../actions/actions';
import { siteOfRobot } from '../actions/site';
import type { Desk } from '../context';
import { clock, day, duration } from '../parts/format';
import { askJson } from '../station/api';
import type { RobotList, RobotRow } from '../station/types';

const again_ms = 3000;

const when = (unix_s: number) => `${day(new Date(1000 * unix_s))} ${clock(new Date(1000 * unix_s)).slice(0, 5)}`;

function stateText({ state, enrolled_s, code_expires_s }: RobotRow): string {
  if (state === 'invited') return `invited, its code is good until ${when(code_expires_s ?? 0)}`;
  if (state === 'enrolled') return `enrolled ${when(enrolled_s ?? 0)}`;
  return state === 'revoked' ? 'revoked: it can not come in' : 'its code was never used and is no longer good';
}

/** By the log, which is there over restarts. */
function seenText({ station }: Desk, robot: string): string {
  const own = [...station.sessions.values()].filter((session) => session.robot === robot);
  const here = own.find(({ connected }) => connected);
  if (here) return here.link_age_s === null ? 'connected' : `connected, heard ${duration(here.link_age_s)} ago`;
  const ids = new Set(own.map(({ id }) => id));
  const left = station.log.entries.find(({ session, kind }) => kind === 'left' && session !== undefined && ids.has(session));
  return left ? `last seen ${when(Number(left.at) / 1000)}` : 'not seen yet';
}

function Row({ desk, row, changed }: { desk: Desk; row: RobotRow; changed: () => void }) {
  const { actions, station } = desk;
  const behind = [...station.sessions.values()].filter(({ robot }) => robot === row.robot).reduce((sum, { backlog }) => sum + backlog, 0);
  const after = (work: Promise<void>) => void work.then(changed);
  return (
    <li class={`fleet-row fleet-${row.state}`}>
      <strong>{row.robot}</strong>
      <span class="muted">{stateText(row)}</span>
      {row.state !== 'invited' && (
        <span class="muted">
          {seenText(desk, row.robot)}
          {behind > 0 && `, ${behind} keyframes behind`}
        </span>
      )}
      {row.site && <span class="muted">drives at {row.site}</span>}
      {row.rate_kib_s !== null && <span class="muted">sends {row.rate_kib_s} KiB/s at most</span>}
      <span class="actions">
        {station.can(routes.rate) && (
          <button class="button button-small" onClick={() => after(actions.limitRate(row))}>
            Rate…
          </button>
        )}
        {station.can(routes.robotSite) && (
          <button class="button button-small" onClick={() => after(siteOfRobot(station, row))}>
            Site…
          </button>
        )}
        {row.state !== 'enrolled' && (
          <button class="button button-small" onClick={() => after(actions.invite(row.robot))}>
            Invite again…
          </button>
        )}
        {row.state !== 'revoked' && station.can(routes.revoke) && (
          <button class="button button-small button-danger" onClick={() => after(actions.revoke(row.robot))}>
            Revoke…
          </button>
        )}
      </span>
    </li>
  );
}

/** Nothing where robots come in without enrolling. */
export function Fleet({ desk }: { desk: Desk }) {
  const [robots, setRobots] = useState<RobotRow[] | null>(null);
  const { link } = desk.station;
  const [asked, ask] = useState(0);
  const secured = desk.station.token;
  useEffect(() => {
    if (link !== 'live' || !secured) return;
    let here = true;
    const look = () =>
      void askJson<RobotList>('/api/v1/robots').then(
        (list) => here && setRobots(list.robots),
        () => {}, // with the next look
      );
    look();
    const timer = setInterval(() => !document.hidden && look(), again_ms);
    return () => {
      here = false;
      clearInterval(timer);
    };
  }, [link, asked, secured]);
  if (!robots?.length) return null;
  return (
    <details class="fleet">
      <summary>
        Who may come in <span class="muted">{robots.filter(({ state }) => state === 'enrolled').length} enrolled</span>
      </summary>
      <ul>
        {robots.map((row) => (
          <Row key={row.robot} desk={desk} row={row} changed={() => ask(asked + 1)} />
        ))}
      </ul>
    </details>
  );
}
