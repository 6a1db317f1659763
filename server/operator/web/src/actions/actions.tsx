// What the operator may do. Everything is asked once more in a dialog; what can be taken back is, with one click.

import { ask as confirmed } from '../parts/dialog';
import { bytes } from '../parts/format';
import { toast, told } from '../parts/toast';
import { ask, askJson } from '../station/api';
import { doubtOf } from '../station/pairs';
import type { Station } from '../station/station';
import type { Alignment, Note, RobotList, RobotRow, Session, Survey, SurveyBody } from '../station/types';
import { ExportForm, exportPath, hideProgress, showProgress } from './export_form';
import type { Saved } from '../view/measure';
import type { Picked } from '../view/pick';
import { Enrolment, NewToken } from './enrolment';
import { robotAddress } from './invitation';
import { fitText } from './survey_text';
import { download } from './download';

export type Decision = 'confirm' | 'refuse' | 'retract';

export const routes = {
  decide: 'POST /api/v1/alignments/{id}/{decision}',
  merge: 'POST /api/v1/merge',
  export: 'GET /api/v1/export',
  anchor: 'POST /api/v1/sessions/{id}/anchor',
  rename: 'POST /api/v1/sessions/{id}/rename',
  requestClouds: 'POST /api/v1/sessions/{id}/request-clouds',
  survey: 'POST /api/v1/survey',
  plan: 'GET /api/v1/plan',
  overlay: 'GET /api/v1/alignments/{id}/overlay',
  invite: 'POST /api/v1/robots/add',
  rate: 'POST /api/v1/robots/rate',
  revoke: 'POST /api/v1/robots/revoke',
  note: 'POST /api/v1/notes',
  unnote: 'DELETE /api/v1/notes/{id}',
  site: 'POST /api/v1/sessions/{id}/site',
  robotSite: 'POST /api/v1/sites',
  operators: 'GET /api/v1/operators',
  place: 'POST /api/v1/place',
};

/** Which decisions the server will take, by its own rules. */
export function fitting(alignment: Alignment): Decision[] {
  if (!((alignment.evidence.inlier_fraction ?? 0) > 0)) return [];
  const inForce = alignment.state === 'published' || alignment.decision === 'confirmed';
  const decisions: Decision[] = [];
  if (alignment.decision !== 'confirmed') decisions.push('confirm');
  if (!inForce && alignment.decision !== 'refused') decisions.push('refuse');
  if (inForce) decisions.push('retract');
  return decisions;
}

const decisions: Record<Decision, { title: string; action: string; what: string; done: string; tone?: 'danger' }> = {
  confirm: {
    title: 'Confirm this alignment?',
    action: 'Confirm',
    what: 'They are merged at this placement, whatever the evidence says, and the robots get their new transforms at once.',
    done: 'confirmed',
  },
  refuse: {
    title: 'Refuse this alignment?',
    action: 'Refuse',
    what: 'They are not merged at this placement. It comes up again only with much more evidence.',
    done: 'refused',
    tone: 'danger',
  },
  retract: {
    title: 'Take this merge apart?',
    action: 'Take apart',
    what: 'The merge is taken back, and the robots are told at once. Maps that hang together through it alone come apart.',
    done: 'taken apart',
    tone: 'danger',
  },
};

export class Actions {
  /** Lines that offer to undo a decision; each goes when it was undone elsewhere. */
  private readonly offers = new Map<number, () => void>();

  constructor(private readonly station: Station) {}

  async decide(alignment: Alignment, decision: Decision): Promise<void> {
    const { title, action, what, done, tone } = decisions[decision];
    const pair = this.pairOf(alignment);
    const doubt = decision === 'confirm' ? doubtOf(alignment) : '';
    const acted = await confirmed({
      title,
      action,
      tone: doubt ? 'danger' : tone,
      body: (
        <>
          <p class="dialog-pair">{pair}</p>
          {doubt && <p class="dialog-fault">{doubt}</p>}
          <p>{what}</p>
        </>
      ),
      run: async () => {
        await ask(`/api/v1/alignments/${alignment.id}/${decision}`, { method: 'POST' });
        await this.station.refreshAtlas();
      },
    });
    if (!acted) return;
    this.offers.get(alignment.id)?.();
    this.offers.set(alignment.id, toast(`${pair}: ${done}.`, { offer: { word: 'Undo', run: () => void this.undo(alignment) } }));
  }

  /** One click: what is undone can be decided again. */
  async undo(alignment: Alignment): Promise<void> {
    await told(async () => {
      await ask(`/api/v1/alignments/${alignment.id}/undo`, { method: 'POST' });
      await this.station.refreshAtlas();
      this.offers.get(alignment.id)?.();
      toast(`${this.pairOf(alignment)}: the decision was undone.`);
    });
  }

  async mergeNow(): Promise<void> {
    const acted = await confirmed({
      title: 'Look for merges now?',
      action: 'Merge now',
      body: <p>Every session is compared with all others again. Nothing is merged without evidence; it may take some seconds.</p>,
      run: async () => void (await ask('/api/v1/merge', { method: 'POST' })),
    });
    if (!acted) return;
    toast('The server looks for merges. What it finds appears here.');
  }

  async anchor(session: Session): Promise<void> {
    const title = this.station.titleOf(session);
    const component = this.station.placed.get(session.id)?.component;
    const before = this.station.components.find(({ id }) => id === component)?.anchor;
    const acted = await confirmed({
      title: `Anchor the map to ${title}?`,
      action: 'Anchor',
      body: <p>The frame of {title} becomes the frame of its map. All robots of the map get new transforms at once.</p>,
      run: () => this.setAnchor(session.id),
    });
    if (!acted) return;
    const old = before && this.station.sessionOf(before);
    const undo = old && old.id !== session.id ? { word: 'Undo', run: () => void told(() => this.setAnchor(old.id)) } : undefined;
    toast(`The map is anchored to ${title}.`, { offer: undo });
  }

  async rename(session: Session): Promise<void> {
    const old = session.label ?? '';
    const acted = await confirmed({
      title: `Rename ${session.robot}/${session.session}`,
      action: 'Rename',
      body: (
        <label class="field">
          Name, as it is shown to operators; empty for the robot's own
          <input name="name" value={old} maxLength={60} autocomplete="off" data-first />
        </label>
      ),
      run: async (form) => this.setName(session.id, String(form.get('name')).trim()),
    });
    if (!acted) return;
    toast('Renamed.', { offer: { word: 'Undo', run: () => void told(() => this.setName(session.id, old)) } });
  }

  async requestClouds(session: Session): Promise<void> {
    const title = this.station.titleOf(session);
    const missing = session.keyframes - session.clouds;
    const acted = await confirmed({
      title: `Ask ${title} for its clouds?`,
      action: 'Request clouds',
      body: <p>{missing} of {session.keyframes} keyframes have no cloud here. The robot sends them as its link allows, after its keyframes.</p>,
      run: async () => void (await ask(`/api/v1/sessions/${session.id}/request-clouds`, { method: 'POST' })),
    });
    if (!acted) return;
    toast(`${title} was asked for its clouds.`);
  }

  async export(component?: number): Promise<void> {
    let done = '';
    await told(() => this.station.refreshAtlas());
    const acted = await confirmed({
      title: 'Export a map',
      action: 'Export',
      body: <ExportForm station={this.station} component={component} />,
      run: async (form, left) => {
        const { path, name } = exportPath(form, this.station);
        showProgress(null);
        try {
          done = `${name}: ${bytes(await download(path, name, showProgress, left))}`;
        } catch (error) {
          hideProgress();
          throw error;
        }
      },
    });
    if (!acted) return;
    this.noteDone(`You: exported ${done}.`);
    toast(`Exported ${done}.`);
  }

  /** Throws what the server has against it; refused (403): the points do not fit each other, unless `accept`. */
  async placeInGrid(session: Session, body: SurveyBody, before: Survey | undefined, accept: boolean): Promise<Survey> {
    const survey = await this.setSurvey(session.id, body, accept);
    await this.station.refreshSurveys();
    const title = this.station.titleOf(session);
    const fit = fitText(survey);
    const undo = () => void told(() => this.restoreSurvey(session.id, before));
    toast(`${title} lies in the mine grid. ${fit}`, { offer: { word: 'Undo', run: undo } });
    return survey;
  }

  async invite(known = ''): Promise<void> {
    let robot = '';
    let enrolment = '';
    const acted = await confirmed({
      title: 'Invite a robot',
      action: 'Invite',
      body: (
        <label class="field">
          Name of the robot
          <input name="robot" required maxLength={128} autocomplete="off" value={known} data-first />
        </label>
      ),
      run: async (form) => {
        robot = String(form.get('robot')).trim();
        enrolment = (await askJson<{ enrolment: string }>(`/api/v1/robots/add?robot=${encodeURIComponent(robot)}`, { method: 'POST' })).enrolment;
      },
    });
    if (!acted) return;
    const { robots, address } = await askJson<RobotList>('/api/v1/robots').catch(() => ({ robots: [], address: null }));
    const expires_s = robots.find((row) => row.robot === robot)?.code_expires_s ?? null;
    const body = <Enrolment robot={robot} enrolment={enrolment} server={robotAddress(address, location.hostname)} expires_s={expires_s} />;
    await confirmed({ title: `${robot} is invited`, body, wide: true });
  }

  async limitRate({ robot, rate_kib_s }: RobotRow): Promise<void> {
    const acted = await confirmed({
      title: `What ${robot} may send`,
      action: 'Set',
      body: (
        <label class="field">
          KiB per second at most, from now on; 0: what its link carries
          <input name="rate" type="number" min={0} max={1e9} step={1} required value={rate_kib_s ?? 0} data-first />
        </label>
      ),
      run: async (form) => void (await ask(`/api/v1/robots/rate?robot=${encodeURIComponent(robot)}&kib_s=${Number(form.get('rate'))}`, { method: 'POST' })),
    });
    if (acted) toast(`The rate of ${robot} was set.`);
  }

  async revoke(robot: string): Promise<void> {
    const acted = await confirmed({
      title: `Revoke ${robot}?`,
      action: 'Revoke',
      tone: 'danger',
      body: <p>It is cut off now, and comes in again only after it was invited anew. What it has mapped stays.</p>,
      run: async () => void (await ask(`/api/v1/robots/revoke?robot=${encodeURIComponent(robot)}`, { method: 'POST' })),
    });
    if (acted) toast(`${robot} is cut off.`);
  }

  /** For all to see; whether it was done. */
  async note(kind: Saved, ends: Picked[]): Promise<boolean> {
    const places = ends.map(({ session, p_session }) => ({ session_id: session, p_session: p_session.toArray() }));
    const acted = await confirmed({
      title: kind === 'note' ? 'Write on the map' : 'Save this measurement',
      action: 'Save',
      body: (
        <label class="field">
          {kind === 'note' ? 'What others should know of this place' : 'What it is; may be empty'}
          <input name="text" maxLength={150} required={kind === 'note'} autocomplete="off" data-first />
        </label>
      ),
      run: async (form) => {
        await ask('/api/v1/notes', { method: 'POST', body: { kind, text: String(form.get('text')).trim(), places } });
        await this.station.refreshNotes();
      },
    });
    if (acted) toast('Saved, for all who work with this server.');
    return acted;
  }

  async unnote({ id, kind, text, places }: Note): Promise<void> {
    const acted = await confirmed({
      title: 'Take this away?',
      action: 'Take away',
      tone: 'danger',
      body: <p>{text || 'What was measured here'}: nobody sees it any more.</p>,
      run: async () => {
        await ask(`/api/v1/notes/${id}`, { method: 'DELETE' });
        await this.station.refreshNotes();
      },
    });
    if (!acted) return;
    const again = async () => {
      await ask('/api/v1/notes', { method: 'POST', body: { kind, text, places } });
      await this.station.refreshNotes();
    };
    toast('Taken away.', { offer: { word: 'Undo', run: () => void told(again) } });
  }

  async addOperator(): Promise<void> {
    let added = { name: '', token: '' };
    const acted = await confirmed({
      title: 'Add an operator',
      action: 'Add',
      body: (
        <div class="form">
          <label class="field">
            Name
            <input name="name" required maxLength={60} autocomplete="off" data-first />
          </label>
          <label class="field">
            May
            <select name="role">
              <option value="view">look at everything and export it</option>
              <option value="operate" selected>
                operate: decide on merges, name, survey, write notes
              </option>
              <option value="administer">administer: robots and operators as well, delete sessions</option>
            </select>
          </label>
          <label class="field">
            Days that the token is good for
            <input name="days" type="number" min={1} max={3650} step={1} required value={30} />
          </label>
        </div>
      ),
      run: async (form) => {
        const query = ['name', 'role', 'days'].map((key) => `${key}=${encodeURIComponent(String(form.get(key)).trim())}`).join('&');
        added = await askJson(`/api/v1/operators/add?${query}`, { method: 'POST' });
      },
    });
    if (!acted) return;
    await confirmed({ title: `${added.name} may come in`, body: <NewToken name={added.name} token={added.token} />, wide: true });
  }

  async revokeOperator(name: string): Promise<void> {
    const acted = await confirmed({
      title: `Revoke the token of ${name}?`,
      action: 'Revoke',
      tone: 'danger',
      body: <p>It ends now, on every page that is open with it.</p>,
      run: async () => void (await ask(`/api/v1/operators/revoke?name=${encodeURIComponent(name)}`, { method: 'POST' })),
    });
    if (acted) toast(`The token of ${name} ended.`);
  }

  private setSurvey(session: number, body: SurveyBody, accept: boolean): Promise<Survey> {
    return askJson(`/api/v1/survey?session=${session}${accept ? '&accept=true' : ''}`, { method: 'POST', body });
  }

  private async restoreSurvey(session: number, before: Survey | undefined): Promise<void> {
    const { points, T_grid_session } = before ?? { points: [], T_grid_session: [] };
    const body = points.length > 0 ? { points: points.map(({ name, p_session, p_grid }) => ({ name, p_session, p_grid })) } : { T_grid_session };
    if (before) await this.setSurvey(session, body, true);
    else await ask(`/api/v1/survey?session=${session}`, { method: 'DELETE' });
    await this.station.refreshSurveys();
  }

  private async setAnchor(session: number): Promise<void> {
    await ask(`/api/v1/sessions/${session}/anchor`, { method: 'POST' });
    await this.station.refreshAtlas();
  }

  private async setName(session: number, name: string): Promise<void> {
    await ask(`/api/v1/sessions/${session}/rename?name=${encodeURIComponent(name)}`, { method: 'POST' });
    await this.station.refreshSessions();
  }

  private pairOf({ a, b }: Alignment): string {
    return `${this.station.titleOfName(a)} and ${this.station.titleOfName(b)}`;
  }

  private noteDone(text: string, about: { session?: number; alignment?: number } = {}): void {
    this.station.log.add('operator', text, about);
    this.station.changed();
  }
}
