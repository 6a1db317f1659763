// Asks for the operator's token, and signs in with it: the browser gets a cookie for it, until it is closed.

import { ask } from './parts/dialog';
import { signIn } from './station/api';

/** fault: why it is asked for again; empty at first. Settles once somebody has signed in. */
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
          The server made it at its first start: it is in <code>operator.token</code> in its data directory. This browser stays signed in until it is closed, or twelve hours unused.
        </p>
      </>
    ),
    run: async (form) => {
      const value = String(form.get('token')).trim();
      if (!/^[\w-]+$/.test(value)) throw new Error('A token has letters, digits, dashes and underscores only.');
      await signIn(value).catch((error) => {
        throw new Error(`The server says: ${error.message}.`);
      });
    },
  });
}
