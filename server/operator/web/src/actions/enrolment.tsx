// The code that a new robot needs once, and the line that uses it.

import { clock } from '../parts/format';
import { told, toast } from '../parts/toast';
import { quoted } from './invitation';

function Copied({ text, first }: { text: string; first?: boolean }) {
  const copy = () =>
    void told(async () => {
      await navigator.clipboard.writeText(text);
      toast('Copied.');
    });
  return (
    <div class="code-row">
      <code class="code">{text}</code>
      <button type="button" class="button" onClick={copy} data-first={first}>
        Copy
      </button>
    </div>
  );
}

export function Enrolment({ robot, enrolment, server, expires_s }: { robot: string; enrolment: string; server: string; expires_s: number | null }) {
  const until = expires_s === null ? 'for an hour' : `until ${clock(new Date(1000 * expires_s)).slice(0, 5)}, for an hour`;
  return (
    <>
      <p>
        Give this code to {robot} once. It is good {until}, and also tells the robot which server to trust.
      </p>
      <Copied text={enrolment} first />
      <p class="muted">A recording instead of a robot, SESSION_DIR being its folder:</p>
      <Copied text={`headframe-replay --server ${server} --robot ${quoted(robot)} --enrol ${enrolment} SESSION_DIR`} />
    </>
  );
}

/** An operator's token, once. */
export function NewToken({ name, token }: { name: string; token: string }) {
  return (
    <>
      <p>Give this token to {name}. It is not shown again; the page asks for it, and so does the command headframe.</p>
      <Copied text={token} first />
    </>
  );
}
