// Asks for the operator's token. It stays in this tab only, and goes with it.

import { ask } from './parts/dialog';
import { token } from './station/api';

/** fault: what was wrong with the last one; empty for the first. Settles once there is a token to try. */
export async function askForToken(fault: string): Promise<void> {
  await ask({
    title: 'Operator’s token',
    action: 'Open',
    insist: true,
    body: (
      <>
        {fault && (
          <p class="dialog-fault" role="alert">
            {fault}
          </p>
        )}
        <label class="field">
          Token
          <input name="token" type="password" required autocomplete="off" data-first />
        </label>
        <p class="muted">
          The server made it at its first start: it is in <code>operator.token</code> in its data directory. This page keeps it until its tab is closed.
        </p>
      </>
    ),
    run: async (form) => {
      const value = String(form.get('token')).trim();
      if (!/^[\w-]+$/.test(value)) throw new Error('A token has letters, digits, dashes and underscores only.');
      token.set(value);
    },
  });
}
