// The code that a new robot needs once.

import { told, toast } from '../parts/toast';

export function Enrolment({ robot, enrolment }: { robot: string; enrolment: string }) {
  const copy = () =>
    void told(async () => {
      await navigator.clipboard.writeText(enrolment);
      toast('Copied.');
    });
  return (
    <>
      <p>Give this code to {robot} once. It also tells the robot which server to trust.</p>
      <div class="code-row">
        <code class="code">{enrolment}</code>
        <button type="button" class="button" onClick={copy} data-first>
          Copy
        </button>
      </div>
      <p class="muted">
        A recording instead of a robot: <code>headframe-replay --server HOST:PORT --robot {robot} --enrol CODE SESSION_DIR</code>
      </p>
    </>
  );
}
