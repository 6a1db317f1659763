// Mines that share the server: which one a session was driven in, and which one a robot drives in from now on.

import { ask as confirmed } from '../parts/dialog';
import { toast } from '../parts/toast';
import { ask } from '../station/api';
import type { Station } from '../station/station';
import type { RobotRow, Session } from '../station/types';

const of = (site: string) => (site ? `of the site ${site}` : 'of no site');

function Field({ station, value, label }: { station: Station; value: string; label: string }) {
  return (
    <label class="field">
      {label}
      <input name="site" value={value} maxLength={60} pattern="[^\/]*" title="No slash" autocomplete="off" list="sites" data-first />
      <datalist id="sites">
        {station.sites.filter(Boolean).map((site) => (
          <option key={site} value={site} />
        ))}
      </datalist>
    </label>
  );
}

const siteIn = (form: FormData) => String(form.get('site') ?? '').trim();

export async function siteOfSession(station: Station, session: Session): Promise<void> {
  const title = station.titleOf(session);
  let site = '';
  const acted = await confirmed({
    title: `Where ${title} was driven`,
    action: 'Set',
    body: (
      <>
        <Field station={station} value={session.site ?? ''} label="Site, a name for the mine; empty: none" />
        <p>Sessions of two sites are never merged. What merged it with sessions of another site is undone, but for what an operator confirmed.</p>
      </>
    ),
    run: async (form) => {
      site = siteIn(form);
      await ask(`/api/v1/sessions/${session.id}/site?site=${encodeURIComponent(site)}`, { method: 'POST' });
      await station.refreshSessions();
    },
  });
  if (acted) toast(`${title} is ${of(site)}.`);
}

export async function siteOfRobot(station: Station, { robot, site: old }: RobotRow): Promise<void> {
  let site = '';
  const acted = await confirmed({
    title: `Where ${robot} drives`,
    action: 'Set',
    body: <Field station={station} value={old ?? ''} label="Site of the sessions that it begins from now on; empty: none" />,
    run: async (form) => {
      site = siteIn(form);
      await ask(`/api/v1/sites?robot=${encodeURIComponent(robot)}&site=${encodeURIComponent(site)}`, { method: 'POST' });
    },
  });
  if (acted) toast(`What ${robot} begins is ${of(site)}.`);
}
