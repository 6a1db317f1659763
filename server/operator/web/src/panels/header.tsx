// The line at the top: how all is, at a glance, and what concerns the whole mine.

import type { Desk } from '../context';
import { routes } from '../actions/actions';
import { compact, dayAndTime, duration } from '../parts/format';
import { Icon, Logo } from '../parts/icons';
import { signOut } from '../station/api';
import { mayWords } from './people';
import type { Theme } from '../ui';

const nextTheme: Record<Theme, Theme> = { auto: 'dark', dark: 'light', light: 'auto' };
const themeWords: Record<Theme, string> = { auto: 'as the system', dark: 'dark', light: 'light' };
const themeIcons = { auto: 'auto', dark: 'moon', light: 'sun' } as const;

function Link({ desk }: { desk: Desk }) {
  const { link, status } = desk.station;
  const words = { connecting: 'Connecting', live: 'Live', away: 'Server away' }[link];
  const about = link === 'live' && status ? `headframe-server ${status.version}, up ${duration(status.uptime_s)}` : 'trying again';
  return (
    <span class={`pill pill-${link}`} role="status" title={about}>
      <i aria-hidden="true" />
      {words}
    </span>
  );
}

/** Nothing where there is one mine alone. */
function Site({ desk }: { desk: Desk }) {
  const { station, ui } = desk;
  const { sites, site } = station;
  if (sites.length < 2) return null;
  return (
    <select
      aria-label="Site"
      value={site === null ? 'all' : `of ${site}`}
      onChange={({ currentTarget: { value } }) => {
        ui.set({ session: null, alignment: null, follow: null });
        station.lookAtSite(value === 'all' ? null : value.slice(3));
      }}
    >
      <option value="all">All sites</option>
      {sites.map((name) => (
        <option key={name} value={`of ${name}`}>
          {name || 'No site'}
        </option>
      ))}
    </select>
  );
}

function Pending({ desk }: { desk: Desk }) {
  const { attempts, keyframes, awaited_submaps } = desk.station.pending;
  if (attempts + keyframes + awaited_submaps === 0) return null;
  const words = [
    attempts ? `${attempts} ${attempts === 1 ? 'comparison' : 'comparisons'}` : '',
    keyframes ? `${keyframes} keyframes` : '',
    awaited_submaps ? `${awaited_submaps} clouds asked for` : '',
  ].filter(Boolean);
  return (
    <span class="pending" title={words.join(', ')}>
      <i aria-hidden="true" />
      Working: {words[0]}
    </span>
  );
}

export function Header({ desk }: { desk: Desk }) {
  const { station, ui, actions } = desk;
  const sessions = [...station.sessions.values()];
  const merged = station.components.filter((component) => component.sessions.length > 1);
  const together = merged.reduce((sum, component) => sum + component.sessions.length, 0);
  const hold = station.status?.links.hold;
  return (
    <header class="top">
      <h1>
        <Logo />
        <span>headframe</span>
      </h1>
      <Link desk={desk} />
      <Site desk={desk} />
      <dl class="glance">
        <div>
          <dt>robots connected</dt>
          <dd>
            {sessions.filter(({ connected }) => connected).length}
            <small> of {new Set(sessions.map(({ robot }) => robot)).size}</small>
          </dd>
        </div>
        <div>
          <dt>sessions merged</dt>
          <dd>
            {together}
            <small> of {sessions.length}</small>
          </dd>
        </div>
        <div>
          <dt>keyframes</dt>
          <dd>{compact(sessions.reduce((sum, session) => sum + session.keyframes, 0))}</dd>
        </div>
        <div>
          <dt>{station.revision === 1 ? 'revision' : 'revisions'}</dt>
          <dd>{station.revision}</dd>
        </div>
      </dl>
      <Pending desk={desk} />
      {station.me?.name && (
        <span class="muted not-phone" title={station.me.expires_s === null ? '' : `until ${dayAndTime(station.me.expires_s)}`}>
          {station.me.name}, {mayWords[station.me.role]}
        </span>
      )}
      {hold && (
        <span class="hold" role="alert">
          {hold}
        </span>
      )}
      <span class="spacer" />
      {station.can(routes.merge) && (
        <button class="button" disabled={sessions.length < 2} onClick={() => void actions.mergeNow()}>
          <Icon name="merge" /> Merge now
        </button>
      )}
      {station.can(routes.export) && (
        <button class="button" disabled={sessions.length === 0} onClick={() => void actions.export()}>
          <Icon name="export" /> Export
        </button>
      )}
      <button
        class="button button-icon"
        aria-label={`Colours: ${themeWords[ui.now.theme]}; change`}
        title={`Colours: ${themeWords[ui.now.theme]}`}
        onClick={() => ui.set({ theme: nextTheme[ui.now.theme] })}
      >
        <Icon name={themeIcons[ui.now.theme]} />
      </button>
      {station.token && (
        <button class="button not-phone" onClick={() => void signOut().finally(() => location.reload())}>
          Sign out
        </button>
      )}
    </header>
  );
}
