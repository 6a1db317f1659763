// What the page knows of the server: kept by its events, and by a look now and then at what no event tells.

import { ApiError, ask, askJson, inTurn, token, trajectory } from './api';
import { Feed, type LinkState } from './feed';
import { Log } from './log';
import { readOverview } from './overview';
import type { Alignment, Atlas, Component, Keyframe, Pending, Session, SessionName, StationEvent, Status, Transform } from './types';

const lookAround_ms = 2000;

export interface Placed {
  component: number;
  T_component_session: Transform;
}

export const nameOf = ({ robot, session }: SessionName) => `${robot}/${session}`;

/** Everything is replaced, never changed in place, so that a view can tell by identity what is new. */
export class Station {
  link: LinkState = 'connecting';
  /** Counts the times that the server was away: what was fetched before may be out of date. */
  epoch = 0;
  sessions = new Map<number, Session>();
  components: Component[] = [];
  placed = new Map<number, Placed>();
  alignments = new Map<number, Alignment>();
  paths = new Map<number, Keyframe[]>();
  revision = 0;
  pending: Pending = { attempts: 0, keyframes: 0, awaited_submaps: 0 };
  status: Status | null = null;
  routes = new Set<string>();
  readonly log = new Log();

  private readonly feed: Feed;
  private readonly listeners: (() => void)[] = [];
  private readonly ids = new Map<string, number>();
  private readonly following = new Set<number>();
  private readonly earlyPoints = new Map<number, ArrayBuffer>();
  private overviewRead = false;

  /** askForToken gets what was wrong with the last one, if there was one, and settles when there is another to try. */
  constructor(private readonly askForToken: (fault: string) => Promise<void>) {
    this.feed = new Feed({
      admit: () => this.admit(),
      event: (event) => this.on(event),
      link: (state) => this.onLink(state),
    });
  }

  /** The overview has all for a first picture; events follow it. */
  start(): void {
    void this.takeOverview().then(() => this.feed.open());
    setInterval(() => void this.lookAround(), lookAround_ms);
  }

  onChange(listener: () => void): void {
    this.listeners.push(listener);
  }

  changed(): void {
    for (const listener of this.listeners) listener();
  }

  idOf(name: SessionName): number | undefined {
    return this.ids.get(nameOf(name));
  }

  sessionOf(name: SessionName): Session | undefined {
    return this.sessions.get(this.idOf(name) ?? -1);
  }

  /** What to call a session: its label, or its robot, with the session's name where the robot has several. */
  titleOf(session: Session): string {
    if (session.label) return session.label;
    const several = [...this.sessions.values()].some((other) => other.robot === session.robot && other.id !== session.id);
    return several ? `${session.robot} · ${session.session}` : session.robot;
  }

  titleOfName(name: SessionName): string {
    const session = this.sessionOf(name);
    return session ? this.titleOf(session) : nameOf(name);
  }

  /** Whether the server has this route, as its description spells it: "POST /api/v1/merge", "GET /api/v1/export?format=las". */
  can(route: string): boolean {
    return this.routes.has(route);
  }

  /** The first points of a session, if the overview had it. To be had once. */
  takeEarlyPoints(id: number): ArrayBuffer | undefined {
    const found = this.earlyPoints.get(id);
    this.earlyPoints.delete(id);
    return found;
  }

  async refreshAtlas(): Promise<void> {
    this.takeAtlas(await askJson<Atlas>('/api/v1/atlas'));
    this.changed();
  }

  async refreshSessions(): Promise<void> {
    this.takeSessions((await askJson<{ sessions: Session[] }>('/api/v1/sessions')).sessions);
    this.changed();
  }

  private async takeOverview(): Promise<void> {
    await readOverview({
      snapshot: (event) => this.on(event),
      session: (id, path, points) => {
        this.paths.set(id, path);
        this.earlyPoints.set(id, points);
        this.changed();
      },
    });
    this.overviewRead = true;
    for (const id of this.sessions.keys()) void this.followPath(id);
  }

  private async admit(): Promise<void> {
    for (;;) {
      if (!token.get() && (await askJson<{ token: boolean }>('/healthz')).token) await this.askForToken('');
      try {
        this.status = await askJson<Status>('/api/v1/status');
        break;
      } catch (error) {
        if (!(error instanceof ApiError) || (error.status !== 401 && error.status !== 429)) throw error;
        token.clear();
        await this.askForToken(`The server says: ${error.message}.`);
      }
    }
    void this.readRoutes().catch(() => {}); // with the next connection, then
  }

  private async readRoutes(): Promise<void> {
    const description = await askJson<{ paths: Record<string, Record<string, { parameters?: { name: string; schema?: { enum?: string[] } }[] }>> }>('/api/v1/openapi.json');
    for (const [path, methods] of Object.entries(description.paths))
      for (const [method, { parameters = [] }] of Object.entries(methods)) {
        this.routes.add(`${method.toUpperCase()} ${path}`);
        for (const { name, schema } of parameters) {
          this.routes.add(`${method.toUpperCase()} ${path}?${name}`);
          for (const value of schema?.enum ?? []) this.routes.add(`${method.toUpperCase()} ${path}?${name}=${value}`);
        }
      }
    this.changed();
  }

  private onLink(state: LinkState): void {
    if (state === 'live' && this.link === 'away') {
      this.epoch++;
      this.log.add('good', 'The server is back.');
    }
    if (state === 'away' && this.link === 'live') this.log.add('bad', 'The link to the server broke.');
    if (state === 'away') this.earlyPoints.clear();
    this.link = state;
    this.changed();
  }

  private on(event: StationEvent): void {
    switch (event.type) {
      case 'snapshot':
        this.takeSessions(event.sessions.sessions);
        this.takeAtlas(event.atlas);
        if (event.atlas.pending) this.pending = event.atlas.pending;
        break;
      case 'robot_connected':
      case 'robot_left':
        this.takeSession(event);
        this.log.add(
          event.type === 'robot_left' ? 'doubt' : 'plain',
          `${event.robot} ${event.type === 'robot_left' ? 'left' : 'connected'}.`,
          { session: event.id },
        );
        break;
      case 'keyframes':
        if (event.complete && this.sessions.get(event.id)?.complete === false)
          this.log.add('plain', `${event.robot} finished its session: ${event.keyframes} keyframes.`, { session: event.id });
        this.takeSession(event);
        break;
      case 'renamed':
        this.takeSession(event);
        break;
      case 'alignment':
        this.onAlignment(event.alignment);
        break;
      case 'revision':
        void this.refreshAtlas().catch(() => {});
        break;
      case 'pending':
        this.pending = event.pending;
        break;
    }
    this.changed();
  }

  private onAlignment(alignment: Alignment): void {
    const known = this.alignments.get(alignment.id);
    this.alignments = new Map(this.alignments).set(alignment.id, alignment);
    if (known?.state === alignment.state && known.decision === alignment.decision) return;
    const pair = `${this.titleOfName(alignment.a)} and ${this.titleOfName(alignment.b)}`;
    const [tone, text] = ({
      published: ['good', `${pair} are merged.`],
      verified: ['good', `${pair} are verified.`],
      candidate: ['doubt', `${pair} may overlap; not sure enough to merge.`],
      rejected: ['plain', `${pair}: no overlap found.`],
      retracted: ['bad', `${pair} were taken apart again.`],
    } as const)[alignment.state];
    this.log.add(tone, text, { alignment: alignment.id });
  }

  private takeSessions(rows: Session[]): void {
    this.sessions = new Map(rows.map((row) => [row.id, { ...this.sessions.get(row.id), ...row }]));
    for (const row of rows) {
      if (this.ids.get(nameOf(row)) !== row.id) this.paths.delete(row.id); // another server's, with ids of its own
      this.ids.set(nameOf(row), row.id);
      void this.followPath(row.id);
    }
  }

  private takeSession(row: Session): void {
    this.sessions = new Map(this.sessions).set(row.id, { ...this.sessions.get(row.id), ...row });
    this.ids.set(nameOf(row), row.id);
    void this.followPath(row.id);
  }

  private takeAtlas(atlas: Atlas): void {
    const placed = new Map<number, Placed>();
    for (const component of atlas.components)
      for (const placement of component.sessions) {
        const id = this.idOf(placement);
        if (id !== undefined) placed.set(id, { component: component.id, T_component_session: placement.T_component_session });
      }
    if (this.revision && atlas.revision !== this.revision)
      this.log.add('plain', `Revision ${atlas.revision}: ${atlas.components.length} ${atlas.components.length === 1 ? 'map' : 'maps'}.`);
    this.revision = atlas.revision;
    this.components = atlas.components;
    this.placed = placed;
    this.alignments = new Map(atlas.alignments.map((alignment) => [alignment.id, alignment]));
  }

  /** Fetches what the path lacks; one request a session at a time. */
  private async followPath(id: number): Promise<void> {
    if (!this.overviewRead || this.following.has(id)) return;
    this.following.add(id);
    try {
      while ((this.sessions.get(id)?.keyframes ?? 0) > (this.paths.get(id)?.length ?? 0)) {
        const known = this.paths.get(id) ?? [];
        const more = await inTurn(() => trajectory(id, (known.at(-1)?.sequence ?? 0) + 1));
        if (more.length === 0) break;
        this.paths.set(id, [...known, ...more]);
        this.changed();
      }
    } catch {
      // the next event of this session tries again
    } finally {
      this.following.delete(id);
    }
  }

  private async lookAround(): Promise<void> {
    if (document.hidden || this.link !== 'live') return;
    try {
      await this.refreshSessions();
      this.status = await (await ask('/api/v1/status')).json();
      this.changed();
    } catch {
      // the feed notices a server that is gone
    }
  }
}
