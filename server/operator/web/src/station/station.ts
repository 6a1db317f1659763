// What the page knows of the server: kept by its events, and by a look now and then at what no event tells.

import { ApiError, ask, askJson, inTurn, trajectory } from './api';
import { Feed, type LinkState } from './feed';
import { dayAndTime, wallClock_s } from '../parts/format';
import { Log, type ServerEntry } from './log';
import { readOverview } from './overview';
import { SiteChoice } from './sites';
import type { Alignment, Atlas, Change, Component, Keyframe, Me, Note, Pending, Session, SessionName, StationEvent, Status, Survey, Transform } from './types';

const lookAround_ms = 2000;
const together_ms = 300; // changes of the atlas within it are one request
export const mostRejected = 1000; // pairs that came to nothing, the newest: to show all of some years would take too long

export interface Placed {
  component: number;
  T_component_session: Transform;
}

export interface ControlPoint {
  session: number;
  name: string;
  p_session: [number, number, number];
}

export const nameOf = ({ robot, session }: SessionName) => `${robot}/${session}`;

/** Everything is replaced, never changed in place, so that a view can tell by identity what is new. */
export class Station {
  link: LinkState = 'connecting';
  /** Counts the times that the server was away: what was fetched before may be out of date. */
  epoch = 0;
  /** All there are, and those of the site that is looked at. */
  private all = new Map<number, Session>();
  sessions = new Map<number, Session>();
  components: Component[] = [];
  placed = new Map<number, Placed>();
  /** Those that came to nothing are in it while showRejected() asks for them, or as they happen. */
  alignments = new Map<number, Alignment>();
  rejected = 0;
  paths = new Map<number, Keyframe[]>();
  /** Counts the paths whose stand-ins have gone. */
  completed = 0;
  /** Whose path has become shorter: what was drawn of it has to go. */
  readonly shortened = new Set<number>();
  private readonly moves = new Map<number, number>();
  revision = 0;
  pending: Pending = { attempts: 0, keyframes: 0, awaited_submaps: 0 };
  status: Status | null = null;
  /** The one set last at the end. */
  surveys: Survey[] = [];
  /** Points of the survey that is worked on. */
  draft: ControlPoint[] = [];
  /** What operators wrote on the map, the newest at the end. */
  notes: Note[] = [];
  /** Of the mine, between sessions; the newest first. */
  changes: Change[] = [];
  me: Me | null = null;
  routes = new Set<string>();
  /** The server wants a token, and robots enrol. */
  token = false;
  readonly log = new Log();

  private readonly feed: Feed;
  private readonly listeners: (() => void)[] = [];
  private readonly ids = new Map<string, number>();
  private readonly following = new Set<number>();
  /** Whose paths have stand-ins. */
  private readonly thin = new Set<number>();
  private readonly earlyPoints = new Map<number, ArrayBuffer>();
  private overviewRead = false;
  private atlasDue = false;
  private rejectedShown = false;
  private readonly choice = new SiteChoice();

  /** askForToken gets why whoever had signed in has to do so again, and settles when somebody has. */
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

  get sites(): string[] {
    return this.choice.names(this.all);
  }

  /** The one that is looked at; null: all. */
  get site(): string | null {
    return this.choice.of(this.all);
  }

  lookAtSite(site: string | null): void {
    this.choice.choose(site);
    this.keep(this.all);
    this.changed();
  }

  private keep(all: Map<number, Session>): void {
    this.all = all;
    const shown = this.choice.shown(all);
    if (shown.size !== this.sessions.size || [...shown.keys()].some((id) => !this.sessions.has(id))) this.refreshAtlasSoon();
    this.sessions = shown;
  }

  private shows({ a, b }: Alignment): boolean {
    return this.site === null || (this.sessionOf(a) !== undefined && this.sessionOf(b) !== undefined);
  }

  idOf(name: SessionName): number | undefined {
    return this.ids.get(nameOf(name));
  }

  sessionOf(name: SessionName): Session | undefined {
    return this.sessions.get(this.idOf(name) ?? -1);
  }

  /** What to call a session: its label, or its robot; where the robot has several, with the time of its first keyframe, or
   * the session's name where the robot's clock tells none, or two began in the same minute. */
  titleOf(session: Session): string {
    if (session.label) return session.label;
    const others = [...this.sessions.values()].filter((other) => other.robot === session.robot && other.id !== session.id);
    if (others.length === 0) return session.robot;
    const began = this.beganAt(session.id);
    const told = began && others.every(({ id }) => this.beganAt(id) !== began);
    return `${session.robot} · ${told ? began : session.session}`;
  }

  /** By its robot's clock; empty where that counts from a start of its own. */
  beganAt(session: number): string {
    const stamp_s = this.paths.get(session)?.[0]?.stamp_s ?? 0;
    return stamp_s > wallClock_s ? dayAndTime(stamp_s) : '';
  }

  /** The server names sessions in full; on the page they are called as everywhere on it. */
  titled(text: string): string {
    let out = text;
    for (const session of this.sessions.values()) out = out.replaceAll(nameOf(session), this.titleOf(session));
    return out;
  }

  titleOfName(name: SessionName): string {
    const session = this.sessionOf(name);
    return session ? this.titleOf(session) : nameOf(name);
  }

  /** Whether the server has this route, and this operator may use it, as its description spells it: "POST /api/v1/merge", "GET /api/v1/export?format=las". */
  can(route: string): boolean {
    return this.routes.has(route) && (this.me?.may.includes(route.split('?')[0]) ?? true);
  }

  /** The first points of a session, if the overview had it. To be had once. */
  takeEarlyPoints(id: number): ArrayBuffer | undefined {
    const found = this.earlyPoints.get(id);
    this.earlyPoints.delete(id);
    return found;
  }

  async refreshAtlas(): Promise<void> {
    this.takeAtlas(await askJson<Atlas>('/api/v1/atlas'));
    if (this.rejectedShown) await this.readRejected();
    this.changed();
  }

  /** Pairs that came to nothing are many in a database of some years: they are fetched when somebody asks for them. */
  async showRejected(shown: boolean): Promise<void> {
    this.rejectedShown = shown;
    await this.refreshAtlas();
  }

  private async readRejected(): Promise<void> {
    const { alignments } = await askJson<{ alignments: Alignment[] }>(`/api/v1/alignments?state=rejected&most=${mostRejected}`);
    this.alignments = new Map([...this.alignments, ...alignments.filter((alignment) => this.shows(alignment)).map((alignment) => [alignment.id, alignment] as const)]);
  }

  async refreshSurveys(): Promise<void> {
    this.surveys = (await askJson<{ surveys: Survey[] }>('/api/v1/survey')).surveys;
    this.changed();
  }

  /** T_grid_component by the survey of one of its sessions, the one that counts; null: none was surveyed. */
  gridOf(component: number): Transform | null {
    return this.surveys.filter((survey) => survey.component === component).at(-1)?.T_grid_component ?? null;
  }

  /** All control points that there are, those that are worked on instead of their session's. */
  controlPoints(): ControlPoint[] {
    const worked = this.draft[0]?.session;
    const set = this.surveys
      .filter(({ session_id }) => session_id !== worked)
      .flatMap(({ session_id, points }) => points.map(({ name, p_session }) => ({ session: session_id, name, p_session: p_session as [number, number, number] })));
    return [...set, ...this.draft];
  }

  async refreshNotes(): Promise<void> {
    if (!this.can('GET /api/v1/notes')) return;
    this.notes = (await askJson<{ notes: Note[] }>('/api/v1/notes')).notes;
    this.changed();
  }

  async refreshChanges(): Promise<void> {
    if (!this.can('GET /api/v1/changes')) return;
    const { changes } = await askJson<{ changes: Change[] }>('/api/v1/changes');
    if (JSON.stringify(changes) === JSON.stringify(this.changes)) return;
    this.changes = changes;
    this.changed();
  }

  private async readLog(): Promise<void> {
    this.log.take((await askJson<{ entries: ServerEntry[] }>('/api/v1/log?most=1000')).entries);
    this.changed();
  }

  async refreshSessions(): Promise<void> {
    this.takeSessions((await askJson<{ sessions: Session[] }>('/api/v1/sessions')).sessions);
    this.changed();
  }

  /** A session that no component holds has come since the atlas was read: a revision tells of merges only. */
  private refreshAtlasSoon(): void {
    if (this.atlasDue) return;
    this.atlasDue = true;
    setTimeout(() => {
      this.atlasDue = false;
      void this.refreshAtlas().catch(() => {}); // the next look around tries again
    }, together_ms);
  }

  private async takeOverview(): Promise<void> {
    await readOverview({
      snapshot: (event) => this.on(event),
      session: (id, path, points, thin) => {
        this.paths.set(id, path);
        if (thin) this.thin.add(id);
        this.earlyPoints.set(id, points);
        this.changed();
      },
    });
    this.overviewRead = true;
    for (const id of this.all.keys()) void this.followPath(id);
  }

  private async admit(): Promise<void> {
    for (;;) {
      this.token = (await askJson<{ token: boolean }>('/healthz')).token;
      try {
        this.status = await askJson<Status>('/api/v1/status');
        break;
      } catch (error) {
        if (!(error instanceof ApiError) || (error.status !== 401 && error.status !== 429)) throw error;
        await this.askForToken(this.me ? `The server says: ${error.message}.` : '');
      }
    }
    void this.readRoutes().catch(() => {}); // with the next connection, then
  }

  private async readRoutes(): Promise<void> {
    const description = await askJson<{ paths: Record<string, Record<string, { parameters?: { name: string; schema?: { enum?: string[] } }[] }>> }>('/api/v1/openapi.json');
    const routes = new Set<string>();
    for (const [path, methods] of Object.entries(description.paths))
      for (const [method, { parameters = [] }] of Object.entries(methods)) {
        routes.add(`${method.toUpperCase()} ${path}`);
        for (const { name, schema } of parameters) {
          routes.add(`${method.toUpperCase()} ${path}?${name}`);
          for (const value of schema?.enum ?? []) routes.add(`${method.toUpperCase()} ${path}?${name}=${value}`);
        }
      }
    if (routes.has('GET /api/v1/me')) this.me = await askJson<Me>('/api/v1/me');
    this.routes = routes; // not before it is known who asks: nobody tries what is not theirs
    this.changed();
    void this.refreshSurveys().catch(() => {});
    void this.refreshNotes().catch(() => {});
    void this.refreshChanges().catch(() => {});
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
        void this.readLog().catch(() => {}); // with the next snapshot, then
        break;
      case 'robot_connected':
      case 'robot_left':
      case 'keyframes':
      case 'renamed':
        this.takeSession(event);
        break;
      case 'live':
        this.keep(new Map(this.all).set(event.id, { ...this.all.get(event.id), ...event }));
        break;
      case 'alignment':
        if (this.shows(event.alignment)) this.alignments = new Map(this.alignments).set(event.alignment.id, event.alignment);
        break;
      case 'log':
        this.log.take([event.entry]);
        if (event.entry.kind === 'note') void this.refreshNotes().catch(() => {}); // with the next note or connection, then
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

  private takeSessions(rows: Session[]): void {
    this.keep(new Map(rows.map((row) => [row.id, { ...this.all.get(row.id), ...row }])));
    for (const row of rows) {
      if (this.ids.get(nameOf(row)) !== row.id) this.forgetPath(row.id); // another server's, with ids of its own
      this.ids.set(nameOf(row), row.id);
      this.shorten(row);
      void this.followPath(row.id);
    }
  }

  private forgetPath(id: number): void {
    this.paths.delete(id);
    this.thin.delete(id);
  }

  /** A session that was split ends where its odometry jumped; what followed is another's. One whose past was moved is read anew. */
  private shorten({ id, keyframes, moves = 0 }: Session): void {
    const path = this.paths.get(id);
    const moved = (this.moves.get(id) ?? moves) !== moves;
    this.moves.set(id, moves);
    if (!path || (path.length <= keyframes && !moved)) return;
    this.paths.set(id, moved ? [] : path.slice(0, keyframes));
    if (moved) this.thin.delete(id);
    this.shortened.add(id);
  }

  private takeSession(row: Session): void {
    this.keep(new Map(this.all).set(row.id, { ...this.all.get(row.id), ...row }));
    this.ids.set(nameOf(row), row.id);
    if (!this.placed.has(row.id)) this.refreshAtlasSoon();
    this.shorten(row);
    void this.followPath(row.id);
  }

  private takeAtlas(atlas: Atlas): void {
    const placed = new Map<number, Placed>();
    for (const component of atlas.components)
      for (const placement of component.sessions) {
        const id = this.idOf(placement);
        if (id !== undefined) placed.set(id, { component: component.id, T_component_session: placement.T_component_session });
      }
    if (this.can('GET /api/v1/survey')) void this.refreshSurveys().catch(() => {}); // where components lie in the grid
    void this.refreshChanges().catch(() => {}); // with the next atlas, then
    this.revision = atlas.revision;
    this.components = atlas.components.filter(({ sessions }) => sessions.some((placement) => this.sessionOf(placement)));
    this.placed = placed;
    this.alignments = new Map(atlas.alignments.filter((alignment) => this.shows(alignment)).map((alignment) => [alignment.id, alignment]));
    this.rejected = atlas.rejected ?? 0;
  }

  /** Fetches the whole path of each that has stand-ins in it. */
  completePaths(ids: Iterable<number>): void {
    for (const id of ids) if (this.thin.delete(id)) void this.completePath(id);
  }

  private async completePath(id: number): Promise<void> {
    try {
      const whole = await inTurn(() => trajectory(id, 1));
      const known = this.paths.get(id) ?? [];
      if (known[0]?.sequence !== whole[0]?.sequence) return; // another server's by now
      this.paths.set(id, [...whole.slice(0, known.length), ...known.slice(whole.length)]);
      this.completed++;
      this.changed();
    } catch {
      this.thin.add(id); // whoever asks next tries again
    }
  }

  /** Fetches what the path lacks; one request a session at a time. */
  private async followPath(id: number): Promise<void> {
    if (!this.overviewRead || this.following.has(id)) return;
    this.following.add(id);
    try {
      while ((this.all.get(id)?.keyframes ?? 0) > (this.paths.get(id)?.length ?? 0)) {
        const known = this.paths.get(id) ?? [];
        const more = await inTurn(() => trajectory(id, (known.at(-1)?.sequence ?? 0) + 1));
        if (more.length === 0) break;
        if ((this.paths.get(id) ?? known).length !== known.length) continue; // it was shortened meanwhile
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
      if ([...this.all.values()].some(({ id, component }) => (component ?? undefined) !== this.placed.get(id)?.component)) this.refreshAtlasSoon();
      await this.refreshSurveys(); // others set them too
      this.status = await (await ask('/api/v1/status')).json();
      this.changed();
    } catch {
      // the feed notices a server that is gone
    }
  }
}
