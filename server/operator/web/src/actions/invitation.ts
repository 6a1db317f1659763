// What an invited robot is told. Pure.

/** How the server says where robots come: it may listen on every address, and is then reached as this page was. */
export function robotAddress(listening: string | null, pageHost: string): string {
  const port = listening?.match(/:(\d+)$/)?.[1] ?? '7447';
  const host = listening?.slice(0, -port.length - 1) ?? '';
  const anywhere = ['', '0.0.0.0', '[::]', '::'].includes(host);
  return `${anywhere ? pageHost : host}:${port}`;
}

/** As one word of a shell. */
export const quoted = (word: string) => (/^[\w.-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`);
