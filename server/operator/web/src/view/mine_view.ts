// The 3D view: what the station says, drawn as the operator chose.

import { Box3, BufferGeometry, Float32BufferAttribute, LineBasicMaterial, LineSegments, Vector3 } from 'three';
import { awaitedOf } from '../station/pairs';
import type { Station } from '../station/station';
import type { Change, Note, Session } from '../station/types';
import type { Desk } from '../context';
import { type Ages, agesOf, sharesOf } from '../time/ages';
import { countUntil } from '../time/axis';
import type { Player } from '../time/player';
import type { Ui } from '../ui';
import { ChangeMarks } from './change_marks';
import { Chunk } from './chunk';
import { cloudMaterial, colourBy, shared, vector } from './cloud_material';
import { type Budget, Clouds } from './clouds';
import { boxAround, type Clip, setClip } from './clip';
import { Edges } from './edges';
import { Frames } from './frames';
import { matrixOf } from './layout';
import { type Label, Labels } from './labels';
import { Cursor, type Spot } from './cursor';
import { Decor, type Framed } from './decor';
import { noteText } from './figures';
import { moved } from './grid';
import { Measure, onGround } from './measure';
import { lookOf, mixed, type RobotColours } from './palette';
import { NoteMarks } from './note_marks';
import { type Picked, pick } from './pick';
import { PlaceHandles } from './place_handles';
import { Placing } from './placing';
import { Robots } from './robots';
import { type Section, SectionMaker } from './section';
import { Stage } from './stage';

const themes = {
  dark: { paper: '#12161b', ink: '#f2f5f7', rim: '#12161b', outline: '#2b323b', written: '#97a2ae', grid: '#97a2ae38' },
  light: { paper: '#f3f4f2', ink: '#14181d', rim: '#ffffff', outline: '#cfd3d2', written: '#57616c', grid: '#57616c33' },
};
const rested_ms = 120; // of the pointer, before the points under it are looked through
const dragged_px = 4; // further, and a press was no click

// What the colours of heights span, from the lowest and highest path: a sensor rides about so high, walls end about there.
const floor_m = 1.5;
const wall_m = 3;
const alone_ms = 1500; // at the most
const mostDrawn = 3_000_000; // in a frame
const mostFrameLabels = 12; // more lie over each other; the robots' own labels do then

export interface Shown {
  /** Keyframes of each session at the last frame. */
  keyframes: Map<number, number>;
  /** The number of each session's last keyframe at the moment that is shown. */
  until: Map<number, number>;
  points: number;
  drawn: number;
  /** When the graphics card had drawn the first frame with points, since the page was asked for. */
  firstPicture_ms: number | null;
  /** Of the last frame. */
  frame_ms: number;
}

export class MineView {
  readonly stage: Stage;
  readonly measure: Measure;
  readonly placing: Placing;
  /** What is on the screen; for the tests and the bench. */
  readonly shown: Shown = { keyframes: new Map(), until: new Map(), points: 0, drawn: 0, firstPicture_ms: null, frame_ms: 0 };
  private readonly frames: Frames;
  private readonly clouds: Clouds;
  private readonly sections: SectionMaker;
  private readonly robots: Robots;
  private readonly edges: Edges;
  private readonly labels: Labels;
  private readonly notes: NoteMarks;
  private readonly changes: ChangeMarks;
  private readonly decor: Decor;
  private readonly handles: PlaceHandles;
  private readonly cursor: Cursor;
  /** Takes the next points that are clicked, in place of everything else. */
  private taker: ((found: Picked | null) => void) | null = null;
  private resting = 0;
  private readonly outlines = new LineSegments(new BufferGeometry(), new LineBasicMaterial());
  private outlinesAt = -1;
  private reachedAt = 0;
  private framedByHand = false;
  private dirty = true;
  private lastTold = '';
  private readonly begun = performance.now();
  private readonly station: Station;
  private readonly ui: Ui;
  private readonly colours: RobotColours;
  private readonly player: Player;

  constructor(
    canvas: HTMLCanvasElement,
    layer: HTMLElement,
    desk: Desk,
    private readonly onPicked: () => void,
  ) {
    ({ station: this.station, ui: this.ui, colours: this.colours, player: this.player } = desk);
    const { station, ui } = this;
    this.stage = new Stage(
      canvas,
      () => (this.framedByHand = true),
      (frame_ms, moved) => this.tookFrame(frame_ms, moved),
    );
    this.stage.prepare(new Chunk(cloudMaterial(), true).points);
    this.frames = new Frames(station, (id) => this.clouds?.clouds.get(id)?.reach);
    this.clouds = new Clouds(this.stage.scene, station, this.frames, this.stage, budget(this.stage.renderer.getContext()));
    this.sections = new SectionMaker(this.clouds, this.frames);
    this.robots = new Robots(station, this.frames, this.stage);
    this.edges = new Edges(station, this.frames, this.stage);
    this.labels = new Labels(layer, this.stage);
    this.measure = new Measure(this.stage, this.frames, (id) => this.componentOf(id));
    this.notes = new NoteMarks(this.stage, this.frames, (id) => this.componentOf(id));
    this.changes = new ChangeMarks(this.stage, this.frames, station);
    this.decor = new Decor(layer, this.stage);
    this.placing = new Placing(station, this.frames);
    this.placing.onChange(() => this.stage.draw());
    this.handles = new PlaceHandles(canvas, layer, this.stage, this.frames, this.placing);
    this.cursor = new Cursor(layer);
    this.outlines.frustumCulled = false;
    this.stage.signs.add(this.outlines);
    this.stage.onFrame(() => this.frame());
    const mark = () => {
      this.dirty = true;
      this.stage.draw();
    };
    station.onChange(() => {
      const told = this.told();
      if (told === this.lastTold) return; // the panels show more of the station, such as how long ago a robot was heard
      this.lastTold = told;
      mark();
    });
    ui.onChange(mark);
    this.player.onChange(mark);
    setTimeout(() => this.stage.draw(), alone_ms); // with all that waited for points
    let pressed = { x: 0, y: 0 };
    canvas.addEventListener('pointerdown', ({ offsetX: x, offsetY: y }) => (pressed = { x, y }));
    canvas.addEventListener('click', ({ offsetX: x, offsetY: y }) => Math.hypot(x - pressed.x, y - pressed.y) <= dragged_px && this.onClick(x, y));
    canvas.addEventListener('pointermove', ({ offsetX: x, offsetY: y, buttons }) => {
      if (buttons === 0) this.onPointer(x, y);
      else if (ui.now.follow !== null && Math.hypot(x - pressed.x, y - pressed.y) > dragged_px) ui.set({ follow: null });
    });
    canvas.addEventListener('pointerleave', () => {
      clearTimeout(this.resting);
      this.cursor.show(null);
    });
  }

  /** Everything in sight, and again whenever the map grows, until the operator moves the view. */
  frameAll(): void {
    this.framedByHand = false;
    this.stage.frame(this.contents(), lowerTools_px());
  }

  /** Of the middle of the view, or what was clicked: a point to measure from, or of a survey. */
  takePoint(x = this.stage.size.x / 2, y = this.stage.size.y / 2): void {
    if (this.dirty) this.sync(); // what was just hidden or shown is so for this click
    const { measureOf } = this.ui.now;
    const found = pick(x, y, this.stage, this.clouds, this.frames) ?? (onGround(measureOf) ? this.ground(x, y) : null);
    if (this.taker) this.taker(found);
    else this.measure.take(found, measureOf);
    const [p, q] = this.measure.corners();
    if (!this.taker && measureOf === 'box' && found && q) this.ui.set({ clip: this.boxOf(found.session, p, q) });
    this.dirty = true;
    this.onPicked();
  }

  /** null: clicks are what they always are. */
  give(taker: ((found: Picked | null) => void) | null): void {
    this.taker = taker;
    this.cursor.hold(null);
  }

  get giving(): boolean {
    return this.taker !== null;
  }

  /** Metres of the scale bar. */
  get bar_m(): number {
    return this.decor.bar_m;
  }

  noteText(note: Note): string {
    return noteText(note, this.notes.placesOf(note));
  }

  lookAtNote(note: Note): void {
    const [place] = this.notes.placesOf(note);
    if (place) this.goTo(place);
  }

  lookAtChange(change: Change): void {
    const place = this.changes.placeOf(change);
    if (place) this.goTo(place);
  }

  look(session: number): void {
    const place = this.robots.positionOf(session);
    if (place) this.goTo(place);
  }

  private goTo(place: Vector3): void {
    const shift = place.sub(this.stage.target);
    this.stage.target.add(shift);
    this.stage.camera.position.add(shift);
    this.framedByHand = true;
    this.stage.pan(0, 0);
  }

  /** Between which there may be points, for the slice. */
  heights(): [number, number] {
    const [low, high] = this.frames.heights();
    return [low - 3, high + 4];
  }

  private onClick(x: number, y: number): void {
    if (this.ui.now.placing) return;
    if (this.ui.now.measuring || this.taker) return this.takePoint(x, y);
    const found = pick(x, y, this.stage, this.clouds, this.frames);
    this.cursor.hold(found && this.spotOf(found));
    if (this.ui.now.session !== null || this.ui.now.alignment !== null) this.ui.set({ session: null });
  }

  /** Coordinates follow the pointer at once from above, and have their height when it rests. */
  private onPointer(x: number, y: number): void {
    if (this.cursor.holds || this.ui.now.placing) return;
    clearTimeout(this.resting);
    const flat = this.flatSpot(x, y);
    if (flat) this.cursor.show(flat);
    this.resting = window.setTimeout(() => {
      const found = pick(x, y, this.stage, this.clouds, this.frames);
      this.cursor.show(found ? this.spotOf(found) : flat);
    }, rested_ms);
  }

  /** From above, where a map's plot is: a place of the first of its sessions. */
  private ground(x: number, y: number): Picked | null {
    if (this.stage.way !== 'top') return null;
    const place = this.stage.onGround(x, y);
    for (const [component, { box }] of this.frames.plots) {
      const session = this.membersOf(component)[0]?.id;
      const T = this.frames.of(session);
      if (!T || !(box.containsPoint(place) || this.frames.plots.size === 1)) continue;
      return { session, p_session: new Vector3(place.x, place.y, 0).applyMatrix4(T.clone().invert()) };
    }
    return null;
  }

  private boxOf(session: number, p: Vector3, q: Vector3): Clip {
    const component = this.componentOf(session);
    const offset = this.offsetOf(component);
    return boxAround(component, p.clone().sub(offset), q.clone().sub(offset));
  }

  private offsetOf(component: number): Vector3 {
    const offset = this.frames.plots.get(component)?.offset;
    return new Vector3(offset?.x ?? 0, offset?.y ?? 0, 0);
  }

  /** Along the line that is measured; null: there is none. */
  section(): Section | null {
    const { measuring, measureOf, sectionWidth_m, slice_m } = this.ui.now;
    const corners = measuring && measureOf === 'section' ? this.measure.corners() : [];
    if (corners.length < 2) return null;
    const component = this.componentOf(this.measure.ends[0].session);
    return this.sections.of({
      component,
      members: this.membersOf(component).map(({ id }) => id),
      offset: this.offsetOf(component),
      corners,
      width_m: sectionWidth_m,
      slice_m,
      T_grid_component: this.station.gridOf(component),
    });
  }

  /** From the component's frame into the mine's grid; null: it was not surveyed. */
  intoGrid(component: number): ((place: [number, number, number]) => [number, number, number]) | null {
    const T = this.station.gridOf(component);
    return T && (([x, y, z]) => moved(T, x, y, z));
  }

  /** From above, where a map's plot is; its height is not known. */
  private flatSpot(x: number, y: number): Spot | null {
    if (this.stage.way !== 'top') return null;
    const place = this.stage.onGround(x, y);
    for (const [component, { box, offset }] of this.frames.plots)
      if (box.containsPoint(place) || this.frames.plots.size === 1)
        return { map: this.mapName(component), p_component: [place.x - offset.x, place.y - offset.y, null], T_grid_component: this.station.gridOf(component) };
    return null;
  }

  private spotOf({ session, p_session }: Picked): Spot | null {
    const placed = this.station.placed.get(session);
    if (!placed) return null;
    const { x, y, z } = p_session.clone().applyMatrix4(matrixOf(placed.T_component_session));
    return { map: this.mapName(placed.component), p_component: [x, y, z], T_grid_component: this.station.gridOf(placed.component) };
  }

  private componentOf(session: number): number {
    return this.station.placed.get(session)?.component ?? -session;
  }

  private mapName(component: number): string {
    const members = this.membersOf(component);
    return members.length === 1 ? `map of ${this.station.titleOf(members[0])}` : `map of ${members.length} sessions`;
  }

  private membersOf(component: number): Session[] {
    return [...this.station.sessions.values()].filter(({ id }) => this.componentOf(id) === component);
  }

  private frame(): boolean {
    const now = performance.now();
    if (this.dirty || this.clouds.reached !== this.reachedAt) this.sync();
    const playing = this.player.step(now);
    const moving = this.frames.step(now);
    if (this.ui.now.follow === null && !this.framedByHand && (moving || this.outlinesAt !== this.frames.version)) this.stage.frame(this.contents(), lowerTools_px());
    if (this.outlinesAt !== this.frames.version) this.drawOutlines();
    this.clouds.showUntil((id) => this.lastShown(id));
    this.robots.beforeFrame((id) => this.player.until(id));
    this.followRobot();
    this.clouds.beforeFrame();
    this.handles.beforeFrame();
    this.stage.signs.visible = !this.awaitsPoints();
    if (this.stage.signs.visible) {
      this.edges.beforeFrame((id) => this.lastShown(id));
      this.measure.beforeFrame(this.ui.now.measureOf);
      this.notes.beforeFrame();
      this.changes.beforeFrame(this.ui.now, ({ id, stamp_s }) => this.player.until(id) >= stamp_s);
      this.decor.draw(this.framed(), this.ui.now.grid);
      this.labels.set(this.allLabels());
      this.labels.place();
    }
    this.note();
    return moving || playing;
  }

  /** The number of the last keyframe of a session at the moment that is shown; 0: it has not begun; Infinity: all are shown. */
  private lastShown(session: number): number {
    const until_s = this.player.until(session);
    if (until_s === Infinity) return Infinity;
    const path = this.station.paths.get(session) ?? [];
    return path[countUntil(path, until_s) - 1]?.sequence ?? 0;
  }

  private followRobot(): void {
    const place = this.ui.now.follow === null ? undefined : this.robots.positionOf(this.ui.now.follow);
    if (!place) return;
    this.framedByHand = true;
    this.stage.follow(place);
  }

  /** From when to when the colours of age go. */
  ages(): Ages {
    const { session } = this.ui.now;
    const path = this.station.paths.get(session ?? -1);
    return agesOf(path ? [path] : this.station.paths.values());
  }

  private tookFrame(frame_ms: number, moved: boolean): void {
    this.shown.frame_ms = frame_ms;
    this.clouds.tookFrame(frame_ms, this.shown.drawn, moved);
    if (this.shown.firstPicture_ms !== null || this.shown.drawn === 0) return;
    this.shown.firstPicture_ms = performance.now();
    this.stage.draw();
  }

  /** All that the view shows of the station, to be compared. */
  private told(): string {
    const { epoch, link, revision, completed, sessions, paths, alignments, surveys } = this.station;
    const rows = [...sessions.values()].map((row) => [row.id, row.connected, row.clouds, this.station.titleOf(row), paths.get(row.id)?.length]);
    const pairs = [...alignments.values()].map((pair) => [pair.id, pair.state, pair.decision, pair.T_a_b, awaitedOf(pair)]);
    return JSON.stringify([epoch, link, revision, completed, rows, pairs, surveys, this.station.draft, this.station.notes.map(({ id }) => id), this.station.changes, this.station.components.length]);
  }

  /** The first points are drawn alone: lines, arrows, names and panels would hold them up. */
  awaitsPoints(): boolean {
    if (this.shown.firstPicture_ms !== null || performance.now() - this.begun > alone_ms) return false;
    return [...this.station.sessions.values()].some(({ clouds }) => clouds > 0);
  }

  private note(): void {
    this.shown.points = this.clouds.loadedPoints;
    this.shown.drawn = this.clouds.drawnPoints;
    for (const id of this.shown.keyframes.keys())
      if (!this.station.sessions.has(id)) this.forgetShown(id);
    for (const [id, path] of this.station.paths) {
      if (!this.station.sessions.has(id)) continue;
      this.shown.keyframes.set(id, path.length);
      this.shown.until.set(id, Math.min(this.lastShown(id), path.at(-1)?.sequence ?? 0));
    }
  }

  private forgetShown(id: number): void {
    this.shown.keyframes.delete(id);
    this.shown.until.delete(id);
  }

  private sync(): void {
    this.dirty = false;
    const { isDark, now } = this.ui;
    this.colours.know(this.station.sessions.values());
    const theme = isDark ? themes.dark : themes.light;
    this.stage.paint(theme.paper);
    shared.paper.value.copy(vector(theme.paper));
    colourBy(now.colourBy);
    shared.roof.value = now.roof_m ?? 1e6;
    shared.slice.value.set(...(now.slice_m ?? [-1e6, 1e6]));
    if (now.clip && !this.frames.plots.has(now.clip.component)) setTimeout(() => this.ui.set({ clip: null })); // its map became part of another
    setClip(now.clip, this.offsetOf(now.clip?.component ?? 0));
    this.clouds.sync(); // its first points count for the frames
    this.reachedAt = this.clouds.reached;
    this.frames.sync();
    this.syncPlacing();
    const [low, high] = this.frames.heights();
    shared.heights.value.set(low - floor_m, high + Math.min(now.roof_m ?? wall_m, wall_m));
    const ages = this.ages();
    this.clouds.paint((id) => ({
      colour: this.colourOf(this.station.sessions.get(id)!),
      faded: this.fadedOf(id),
      ages: sharesOf(this.station.paths.get(id) ?? [], ages),
    }));
    this.robots.sync((session) => ({
      colour: mixed(this.colourOf(session), theme.ink, 0.15),
      paper: theme.paper,
      rim: theme.rim,
      faded: this.fadedOf(session.id),
    }));
    this.handles.paint(theme.ink);
    this.edges.sync(isDark, now.alignment);
    this.measure.paint(theme.ink);
    this.notes.sync(this.station.notes, theme.written);
    this.changes.sync(isDark, now.change);
    this.decor.paint(theme.written, theme.grid);
    this.outlines.material.color.setStyle(theme.outline, 'srgb-linear');
  }

  /** Takes up what the operator places, with both maps in sight, and lets go of it when one of the two is another map now. */
  private syncPlacing(): void {
    const { placing } = this.ui.now;
    if (placing && !this.placing.holds) return void setTimeout(() => this.ui.set({ placing: null, placed: null }));
    if (!this.placing.begin(placing)) return;
    if (!placing) {
      this.frames.sync();
      return this.frameAll();
    }
    const laid = this.frames.laidMap;
    const box = this.frames.box(placing.on);
    if (laid) for (const x of [laid.box.min.x, laid.box.max.x]) for (const y of [laid.box.min.y, laid.box.max.y]) box.expandByPoint(new Vector3(x, y, 0).applyMatrix4(laid.T_world_component).setZ(0));
    box.max.y += (box.max.y - box.min.y) / 5; // for the handle and the tools
    this.framedByHand = true;
    this.stage.frame(box, lowerTools_px());
  }

  private colourOf(session: Session): string {
    return this.colours.of(session, this.ui.isDark);
  }

  /** What is not selected steps back. */
  private fadedOf(session: number): number {
    const { session: one, alignment, placing } = this.ui.now;
    if (placing) return [placing.on, this.componentOf(placing.session)].includes(this.componentOf(session)) ? 0 : 0.75;
    const pair = alignment === null ? undefined : this.station.alignments.get(alignment);
    if (pair?.objection && [pair.objection.a, pair.objection.b].includes(session)) return 0; // who contradicts it
    if (pair) return [pair.a, pair.b].some((name) => this.station.idOf(name) === session) ? 0 : 0.75;
    return one === null || one === session ? 0 : 0.65;
  }

  private framed(): Framed[] {
    return [...this.frames.plots].map(([component, plot]) => ({ plot, T_grid_component: this.station.gridOf(component) }));
  }

  private contents(): Box3 {
    const box = this.frames.box();
    if (box.isEmpty()) return box;
    const [low, high] = this.heights();
    box.min.z = box.max.z = (low + high) / 2;
    return box;
  }

  private drawOutlines(): void {
    this.outlinesAt = this.frames.version;
    const places: number[] = [];
    if (this.frames.plots.size > 1)
      for (const { box } of this.frames.plots.values()) {
        const corners = [box.min.x, box.min.y, box.max.x, box.min.y, box.max.x, box.max.y, box.min.x, box.max.y];
        for (let i = 0; i < 4; i++)
          for (const at of [i, (i + 1) % 4]) places.push(corners[2 * at], corners[2 * at + 1], 0);
      }
    this.outlines.geometry.dispose();
    this.outlines.geometry = new BufferGeometry();
    this.outlines.geometry.setAttribute('position', new Float32BufferAttribute(places, 3));
  }

  private allLabels(): Label[] {
    return [...this.robotLabels(), ...this.verdictLabels(), ...this.frameLabels(), ...this.controlLabels(), ...this.notes.labels(() => this.ui.set({ tab: 'notes', survey: null, sheet: 'side' })), ...this.changeLabels(), ...this.measure.labels(this.ui.now.measureOf)];
  }

  private changeLabels(): Label[] {
    return this.changes.labels(this.ui.now.change, (change) => this.ui.set({ change, tab: 'changes', survey: null, sheet: 'side' }));
  }

  private robotLabels(): Label[] {
    const labels: Label[] = [];
    for (const session of this.station.sessions.values()) {
      const place = this.robots.positionOf(session.id);
      if (!place) continue;
      labels.push({
        key: `robot-${session.id}`,
        place,
        text: this.station.titleOf(session),
        kind: session.connected ? 'robot' : 'away',
        colour: this.colourOf(session),
        rank: session.id === this.ui.now.session ? 1 : session.connected ? 2 : 4,
        describe: `${this.station.titleOf(session)}, ${session.connected ? 'connected' : 'not connected'}: select`,
        onClick: (off) => {
          this.ui.set({ session: session.id, alignment: null, ...(off ? {} : { sheet: 'robots' }) });
          if (off) this.look(session.id);
        },
      });
    }
    return labels;
  }

  private verdictLabels(): Label[] {
    return [...this.edges.badges()].map(([alignment, place]) => {
      const look = lookOf(alignment);
      const pair = `${this.station.titleOfName(alignment.a)} and ${this.station.titleOfName(alignment.b)}`;
      return {
        key: `verdict-${alignment.id}`,
        place,
        text: look.glyph,
        kind: 'verdict',
        colour: this.ui.isDark ? look.dark : look.light,
        rank: alignment.id === this.ui.now.alignment ? 1 : 3,
        describe: `${pair}: ${look.word}; show the evidence`,
        onClick: () => this.ui.set({ alignment: alignment.id, session: null, survey: null, tab: 'merges', sheet: 'side' }),
      };
    });
  }

  /** Control points of the surveys that there are, and of the one that is worked on. */
  private controlLabels(): Label[] {
    return this.station.controlPoints().flatMap(({ session, name, p_session }) => {
      const T = this.frames.of(session);
      if (!T) return [];
      return [{ key: `control-${session}-${name}`, place: new Vector3(...p_session).applyMatrix4(T), text: `▲ ${name}`, kind: 'control' as const, rank: 2 }];
    });
  }

  private frameLabels(): Label[] {
    if (this.frames.plots.size < 2 || this.frames.plots.size > mostFrameLabels) return [];
    return [...this.frames.plots].map(([id, { box }]) => {
      const members = this.membersOf(id);
      const surveyed = this.station.gridOf(id) ? ', surveyed' : '';
      const text = members.length === 1 ? `${this.station.titleOf(members[0])}: own frame, not merged${surveyed}` : `Map of ${members.length} sessions${surveyed}`;
      return { key: `frame-${id}`, place: new Vector3(box.min.x, box.max.y, 0), text, kind: 'frame', rank: 5 };
    });
  }
}

/** What the tools at the lower edge cover. */
function lowerTools_px(): number {
  const height = document.querySelector<HTMLElement>('.tools-bottom')?.offsetHeight ?? 0;
  return height > 0 ? height + 24 : 0;
}

/** #points=N says how many are kept. Software rendering shows itself by its name; it gets fewer. */
function budget(gl: WebGLRenderingContext | WebGL2RenderingContext): Budget {
  const asked = Number(new URLSearchParams(location.hash.slice(1)).get('points'));
  if (asked > 0) return { loaded: asked, drawn: Math.min(asked, mostDrawn), leastDrawn: Math.min(asked, 100_000) };
  const details = gl.getExtension('WEBGL_debug_renderer_info');
  const renderer = details ? String(gl.getParameter(details.UNMASKED_RENDERER_WEBGL)) : '';
  if (/swiftshader|llvmpipe|software/i.test(renderer)) return { loaded: 100_000, drawn: 100_000, leastDrawn: 40_000 };
  return { loaded: 6_000_000, drawn: mostDrawn, leastDrawn: 200_000 };
}
