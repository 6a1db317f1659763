// Who is there, how well we hear them, how far behind they are.

import { useEffect, useRef, useState } from 'preact/hooks';
import type { Desk } from '../context';
import { routes } from '../actions/actions';
import { siteOfSession } from '../actions/site';
import { bytes, compact, duration, metres, percent } from '../parts/format';
import { Icon } from '../parts/icons';
import type { Live, Session } from '../station/types';
import { Fleet } from './fleet';
import { People } from './people';
import { beginPlacing, othersOf } from './place_tools';
import { Servers } from './servers';

/** Heard within so many seconds: four bars, three, two; later one; away none. */
const heard_s = [4, 10, 20];

export function linkBars({ connected, link_age_s }: Session): number {
  if (!connected) return 0;
  const age = link_age_s ?? 0;
  return 4 - heard_s.filter((limit) => age > limit).length;
}

function LinkBar({ session }: { session: Session }) {
  const bars = linkBars(session);
  const age = session.link_age_s;
  const words = session.connected ? `link ${bars} of 4${age === null ? '' : `, heard ${duration(age)} ago`}` : 'not connected';
  return (
    <span class={`link-bar link-${bars}`} role="img" aria-label={words} title={words}>
      {[1, 2, 3, 4].map((step) => (
        <i key={step} class={step <= bars ? 'on' : ''} />
      ))}
    </span>
  );
}

/** Robots say every five seconds at least that they live. */
const quiet_s = 12;

/** What the robot says of itself, and how long ago that was: one that stands still is seen to live. */
function Alive({ live }: { live: Live }) {
  const [now_ms, look] = useState(Date.now());
  const said = useRef({ live, at_ms: Date.now() - 1000 * live.age_s });
  if (said.current.live !== live) said.current = { live, at_ms: Date.now() - 1000 * live.age_s };
  useEffect(() => {
    const timer = setInterval(() => look(Date.now()), 1000);
    return () => clearInterval(timer);
  }, []);
  const age_s = Math.max(0, (now_ms - said.current.at_ms) / 1000);
  const words = [`alive ${duration(age_s)} ago`, live.battery === null ? '' : `battery ${percent(live.battery)}`, live.health ?? ''];
  return <span class={age_s > quiet_s ? 'robot-alive behind' : 'robot-alive'}>{words.filter(Boolean).join(', ')}</span>;
}

function Row({ desk, session }: { desk: Desk; session: Session }) {
  const { station, ui, colours } = desk;
  const open = ui.now.session === session.id;
  const placed = station.placed.get(session.id);
  const together = station.components.find(({ id }) => id === placed?.component)?.sessions.length ?? 1;
  return (
    <li class={open ? 'robot robot-open' : 'robot'} style={{ '--mark': colours.of(session, ui.isDark) }}>
      <button
        class="robot-head"
        aria-expanded={open}
        onClick={() => {
          ui.set({ session: open ? null : session.id, alignment: null });
          if (!open) desk.view()?.look(session.id);
        }}
      >
        <span class={session.connected ? 'swatch' : 'swatch swatch-away'} aria-hidden="true" />
        <span class="robot-name">{station.titleOf(session)}</span>
        <LinkBar session={session} />
        <span class="robot-figures">
          <span>{compact(session.keyframes)} keyframes</span>
          {session.backlog > 0 ? <span class="behind">{compact(session.backlog)} behind</span> : <span>{session.complete ? 'finished' : session.connected ? 'up to date' : 'away'}</span>}
          <span class="end">{session.connected ? `${bytes(session.bytes_per_s ?? 0)}/s` : metres(session.distance_m ?? 0)}</span>
        </span>
        {session.connected && session.live && <Alive live={session.live} />}
      </button>
      {open && (
        <div class="robot-more">
          <dl class="facts">
            <dt>Session</dt>
            <dd>{session.session}</dd>
            <dt>Sensor</dt>
            <dd>
              {session.sensor.model || 'not said'}, {session.sensor.beams} beams
            </dd>
            <dt>Descriptors</dt>
            <dd>
              {session.family.name} {session.family.version}
            </dd>
            <dt>Clouds</dt>
            <dd>
              {session.clouds} of {session.keyframes}
            </dd>
            <dt>Driven</dt>
            <dd>{(session.distance_m ?? 0).toFixed(0)} m</dd>
            {session.site && <dt>Site</dt>}
            {session.site && <dd>{session.site}</dd>}
            {session.why_cut && <dt>Odometry</dt>}
            {session.why_cut && <dd>{session.why_cut}</dd>}
            <dt>Map</dt>
            <dd>
              {together > 1 ? `merged, ${together} sessions` : 'own frame'}
              {placed && station.gridOf(placed.component) ? ', surveyed' : ''}
            </dd>
          </dl>
          <div class="actions">
            <button class="button button-small" aria-pressed={ui.now.follow === session.id} onClick={() => ui.set({ follow: ui.now.follow === session.id ? null : session.id, sheet: null })}>
              Follow
            </button>
            <button class="button button-small" onClick={() => (ui.set({ sheet: null }), desk.player.play(true))}>
              Play
            </button>
            {station.can(routes.rename) && <button class="button button-small" onClick={() => void desk.actions.rename(session)}>Rename…</button>}
            {station.can(routes.site) && <button class="button button-small" onClick={() => void siteOfSession(station, session)}>Site…</button>}
            {station.can(routes.anchor) && together > 1 && session.id !== placed?.component && (
              <button class="button button-small" onClick={() => void desk.actions.anchor(session)}>Anchor here…</button>
            )}
            {station.can(routes.requestClouds) && session.clouds < session.keyframes && (
              <button class="button button-small" disabled={!session.connected} title={session.connected ? '' : 'The robot is away'} onClick={() => void desk.actions.requestClouds(session)}>
                Request clouds…
              </button>
            )}
            {station.can(routes.place) && othersOf(desk, session).length > 0 && (
              <button class="button button-small" title="Lay its map on another, roughly" onClick={() => (ui.set({ sheet: null }), beginPlacing(desk, session))}>
                Place by hand
              </button>
            )}
            {station.can(routes.survey) && <button class="button button-small" onClick={() => ui.set({ survey: session.id, sheet: 'side' })}>Survey…</button>}
            {placed && <button class="button button-small" onClick={() => void desk.actions.export(placed.component)}>Export…</button>}
          </div>
        </div>
      )}
    </li>
  );
}

function Empty({ desk }: { desk: Desk }) {
  return (
    <div class="empty">
      <p>No robot has been here yet.</p>
      <p class="muted">Invite one, and give it the code that you get. A recording will do as well, played with headframe-replay.</p>
      {desk.station.can(routes.invite) && (
        <button class="button" onClick={() => void desk.actions.invite()}>
          <Icon name="plus" /> Invite a robot…
        </button>
      )}
    </div>
  );
}

export function RobotsPanel({ desk }: { desk: Desk }) {
  const sessions = [...desk.station.sessions.values()].sort((x, y) => Number(y.connected) - Number(x.connected) || x.robot.localeCompare(y.robot, 'en', { numeric: true }) || y.id - x.id);
  const connected = sessions.filter((session) => session.connected).length;
  return (
    <section class="panel robots" aria-label="Robots">
      <header class="panel-head">
        <h2>Robots</h2>
        <span class="muted">
          {connected} of {sessions.length} connected
        </span>
        {sessions.length > 0 && desk.station.can(routes.invite) && (
          <button class="button button-icon" aria-label="Invite a robot" title="Invite a robot" onClick={() => void desk.actions.invite()}>
            <Icon name="plus" />
          </button>
        )}
      </header>
      {sessions.length === 0 ? (
        desk.station.link === 'live' && <Empty desk={desk} />
      ) : (
        <ul class="robot-list">
          {sessions.map((session) => (
            <Row key={session.id} desk={desk} session={session} />
          ))}
        </ul>
      )}
      <Fleet desk={desk} />
      <People desk={desk} />
      <Servers desk={desk} />
    </section>
  );
}
