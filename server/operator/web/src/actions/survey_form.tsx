// What ties a session to the mine grid: three or more control points, or the transform itself.

import type { Survey, SurveyBody } from '../station/types';

const transformNumbers = 16;
const pointNumbers = 6;

/** before: the survey that there is; it is shown to be changed. */
export function SurveyForm({ before }: { before?: Survey }) {
  return (
    <>
      <label class="field">
        Three or more control points, one a line: name, x y z in the session's frame, x y z in the mine grid (m)
        <textarea
          name="survey"
          rows={6}
          spellcheck={false}
          required
          data-first
          defaultValue={before && textOf(before)}
          placeholder={'S1  0.00 0.00 1.20   7654321.10 512345.60 -412.30\nS2  25.10 3.20 1.15   7654340.00 512361.90 -412.40\nS3  ...'}
        />
      </label>
      <p class="muted">Or the 16 numbers of T_grid_session, row by row, where the survey is known already. {before ? surveyText(before) : ''}</p>
    </>
  );
}

export function bodyOf({ points, T_grid_session }: Survey): SurveyBody {
  return points.length > 0 ? { points: points.map(({ name, p_session, p_grid }) => ({ name, p_session, p_grid })) } : { T_grid_session };
}

function textOf({ points, T_grid_session }: Survey): string {
  if (points.length === 0) return [0, 4, 8, 12].map((at) => T_grid_session.slice(at, at + 4).join(' ')).join('\n');
  return points.map(({ name, p_session, p_grid }) => [name.replace(/[\s,;]+/g, '_'), ...p_session, ...p_grid].join(' ')).join('\n');
}

/** Throws with the line that is wrong. */
export function surveyBody(form: FormData): SurveyBody {
  const text = String(form.get('survey')).trim();
  const numbers = text.split(/[\s,;]+/).map(Number);
  if (numbers.length === transformNumbers && numbers.every(Number.isFinite)) return { T_grid_session: numbers };
  const lines = text
    .split('\n')
    .map((line) => line.trim())
    .filter((line) => line !== '');
  const points = lines.map((line, index) => {
    const [name, ...figures] = line.split(/[\s,;]+/);
    const values = figures.map(Number);
    if (values.length !== pointNumbers || !values.every(Number.isFinite))
      throw new Error(`Line ${index + 1} needs a name and six numbers; it has ${figures.length} after the name.`);
    return { name, p_session: values.slice(0, 3), p_grid: values.slice(3) };
  });
  if (points.length < 3) throw new Error(`Three control points are needed; there ${points.length === 1 ? 'is 1' : `are ${points.length}`}.`);
  return { points };
}

const cm = (metres: number) => `${(100 * metres).toFixed(1)} cm`;

/** How well the points fit; empty without points. */
export function surveyText({ rms_m, points }: Survey): string {
  if (rms_m === null) return '';
  const worst = points.reduce((x, y) => (y.residual_m > x.residual_m ? y : x));
  return `The points fit within ${cm(rms_m)} (rms); the worst is ${worst.name}, off by ${cm(worst.residual_m)}.`;
}
