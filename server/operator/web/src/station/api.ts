// Requests to the server that served this page.

import type { Keyframe } from './types';

const mostAtOnce = 4; // a browser gives a host six connections; some stay free for what the operator clicks

export class ApiError extends Error {
  constructor(
    readonly status: number,
    message: string,
  ) {
    super(message);
  }
}

export interface Asked {
  method?: 'GET' | 'POST' | 'DELETE';
  body?: unknown;
  signal?: AbortSignal;
  /** Shown with this request alone; all others are let in by the cookie that signing in has set. */
  token?: string;
}

/** Throws what the server says of the token. No script can read what it leaves here. */
export const signIn = (token: string) => ask('/api/v1/sign-in', { method: 'POST', token });
export const signOut = () => ask('/api/v1/sign-out', { method: 'POST' });

/** Throws ApiError with the server's own line for people; status 0: the server was not reached. */
export async function ask(path: string, { method = 'GET', body, signal, token }: Asked = {}): Promise<Response> {
  const headers: Record<string, string> = {};
  if (token) headers.Authorization = `Bearer ${token}`;
  let response: Response;
  try {
    response = await fetch(path, { method, headers, signal, body: body === undefined ? undefined : JSON.stringify(body) });
  } catch (cause) {
    if (signal?.aborted) throw cause;
    throw new ApiError(0, 'The server does not answer.');
  }
  if (response.ok) return response;
  const fault = await response.json().catch(() => null);
  throw new ApiError(response.status, fault?.error?.message ?? `The server answered ${response.status}.`);
}

export async function askJson<T>(path: string, asked?: Asked): Promise<T> {
  return (await ask(path, asked)).json();
}

let running = 0;
const waiting: (() => void)[] = [];

/** For what the view fetches by itself: only so many at a time, and a pause when the server says that it is too much. */
export async function inTurn<T>(work: () => Promise<T>): Promise<T> {
  if (running >= mostAtOnce) await new Promise<void>((resume) => waiting.push(resume));
  running++;
  try {
    return await work();
  } catch (error) {
    if (error instanceof ApiError && error.status === 429) await new Promise((resume) => setTimeout(resume, 2000));
    throw error;
  } finally {
    running--;
    waiting.shift()?.();
  }
}

interface Path {
  keyframes: number[][];
}

export const keyframesOf = ({ keyframes }: Path): Keyframe[] =>
  keyframes.map(([sequence, stamp_s, x, y, z, qx, qy, qz, qw]) => ({ sequence, stamp_s, position: [x, y, z], quaternion: [qx, qy, qz, qw] }));

export async function trajectory(session: number, from: number): Promise<Keyframe[]> {
  return keyframesOf(await askJson<Path>(`/api/v1/sessions/${session}/trajectory?from=${from}`));
}

export async function points(session: number, level: number, from: number, most: number): Promise<ArrayBuffer> {
  const path = `/api/v1/sessions/${session}/points?level=${level}&from=${from}&most=${most}`;
  return (await ask(path)).arrayBuffer();
}
