// What the operator API says, as JSON. Lengths in metres, transforms 16 numbers, row-major; null: not measured.

import type { ServerEntry } from './log';

export type Transform = number[];

export interface SessionName {
  robot: string;
  session: string;
}

/** What a robot said last of itself; never part of the map. */
export interface Live {
  age_s: number;
  stamp_s: number;
  T_session_sensor: Transform | null;
  /** 0: empty, 1: full. */
  battery: number | null;
  health: string | null;
}

export interface Session extends SessionName {
  id: number;
  label?: string | null;
  family: { name: string; version: number };
  sensor: { model: string; beams: number; fov_up_deg: number; fov_down_deg: number; max_range_m: number };
  connected: boolean;
  complete: boolean;
  /** Where its odometry jumped, and what became of the rest. */
  why_cut?: string | null;
  /** The mine it was driven in; null: the server has one alone. */
  site?: string | null;
  keyframes: number;
  /** How often its past was moved: another number, and its keyframes and points lie elsewhere. */
  moves?: number;
  clouds: number;
  bytes_received: number;
  backlog: number;
  bytes_per_s: number | null;
  link_age_s: number | null;
  live?: Live | null;
  distance_m: number | null;
  trigger_to_transform_ms: number | null;
  component?: number | null;
}

export type State = 'candidate' | 'provisional' | 'verified' | 'published' | 'retracted' | 'rejected';
export type Ruling = 'none' | 'confirmed' | 'refused' | 'retracted' | 'placed';

export interface Alignment {
  id: number;
  a: SessionName;
  b: SessionName;
  state: State;
  verdict: State;
  decision: Ruling;
  T_a_b: Transform;
  /** What holds it back: two sessions, by their ids, that it would lay on each other where they contradict each other. */
  objection?: { a: number; b: number; violation: number } | null;
  evidence: Record<string, number | null>;
}

export interface Placement extends SessionName {
  T_component_session: Transform;
}

export interface Component {
  id: number;
  anchor: SessionName;
  sessions: Placement[];
}

export interface Pending {
  attempts: number;
  keyframes: number;
  awaited_submaps: number;
}

export interface Atlas {
  revision: number;
  components: Component[];
  alignments: Alignment[];
  /** How many pairs came to nothing; they are not in `alignments`. */
  rejected?: number;
}

export interface Status {
  version: string;
  uptime_s: number;
  revision: number;
  bytes_received: number;
  pending: Pending;
  links: { hold: string | null; failed: number; refused: number };
}

export interface Finding {
  evidence: string;
  value: number | null;
  speaks: string;
  text: string;
}

export interface Explanation {
  a: SessionName;
  b: SessionName;
  outcome: string;
  decision: string;
  findings: Finding[];
  missing: string[];
}

/** What came of a session that was laid on another by hand. */
export interface PlaceAnswer {
  recorded: boolean;
  /** By registration; null: nothing registered. */
  moved_m: number | null;
  turned_deg: number | null;
  explanation: Explanation;
}

export interface Overlay {
  a: [number, number, number][];
  b: [number, number, number][];
  residuals_m: number[];
  bin_m: number;
  runner_up: { T_a_b: Transform; probability: number } | null;
}

export interface SurveyPoint {
  name: string;
  p_session: number[];
  p_grid: number[];
}

/** Control points, or the transform itself. */
export type SurveyBody = { points: SurveyPoint[] } | { T_grid_session: Transform };

export interface Survey {
  session_id: number;
  component?: number;
  T_grid_component?: Transform;
  T_grid_session: Transform;
  points: (SurveyPoint & { residual_m: number })[];
  rms_m: number | null;
  /** The point that does not fit the others, and why it is held for wrong. */
  suspect?: { name: string; text: string } | null;
}

export interface SeenBy extends SessionName {
  id: number;
  stamp_s: number;
}

/** What is gone or new in the mine, and between whose visits. */
export interface Change {
  kind: 'excavated' | 'filled';
  alignment: number;
  component: number | null;
  /** Its middle, in the component's frame. */
  p: [number, number, number];
  /** Length, width, height. */
  size_m: [number, number, number];
  older: SeenBy;
  newer: SeenBy;
}

export interface NotePlace {
  session_id: number;
  p_session: [number, number, number];
}

/** What an operator wrote or measured. */
export interface Note {
  id: number;
  kind: 'note' | 'distance' | 'line' | 'area';
  text: string;
  by: string | null;
  at_s: number;
  places: NotePlace[];
}

export interface OperatorRow {
  name: string;
  role: 'view' | 'operate' | 'administer';
  expires_s: number;
}

/** One that serves, or waits to take over. */
export interface ServerRow {
  name: string;
  robots: string;
  http: string;
  role: 'active' | 'standby';
  self: boolean;
  since_s: number;
  heard_ago_s: number;
  relayed?: number; // connections that it passes on to the one that serves
  searched?: number; // pairs of sessions that it has searched for the one that serves
}

/** Who works with this page. */
export interface Me {
  name: string | null;
  role: OperatorRow['role'];
  expires_s: number | null;
  may: string[];
}

export interface Keyframe {
  sequence: number;
  stamp_s: number;
  position: [number, number, number];
  quaternion: [number, number, number, number];
}

export type StationEvent =
  | { type: 'snapshot'; sessions: { sessions: Session[] }; atlas: Atlas & { pending?: Pending } }
  | ({ type: 'robot_connected' | 'robot_left' | 'keyframes' | 'renamed' | 'live' } & Session)
  | { type: 'alignment'; alignment: Alignment }
  | { type: 'revision'; revision: number; components: number }
  | { type: 'pending'; pending: Pending }
  | { type: 'log'; entry: ServerEntry };

/** A robot as it may come in or not. */
export interface RobotRow {
  robot: string;
  state: 'invited' | 'enrolled' | 'revoked' | 'expired';
  enrolled_s: number | null;
  code_expires_s: number | null;
  site: string | null;
  rate_kib_s: number | null;
}

export interface RobotList {
  fingerprint: string;
  /** HOST:PORT where robots come. */
  address: string | null;
  robots: RobotRow[];
}
