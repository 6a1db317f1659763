// Control points that tie a session to the mine grid: three or more, one a line.

export function SurveyForm() {
  return (
    <label class="field">
      Three or more control points, one a line: name, x y z in the session's frame, x y z in the mine grid (m)
      <textarea
        name="points"
        rows={6}
        spellcheck={false}
        required
        data-first
        placeholder={'S1  0.00 0.00 1.20   7654321.10 512345.60 -412.30\nS2  25.10 3.20 1.15   7654340.00 512361.90 -412.40\nS3  ...'}
      />
    </label>
  );
}

export interface SurveyPoint {
  name: string;
  p_session: number[];
  p_grid: number[];
}

/** Throws with the line that is wrong. */
export function surveyBody(form: FormData): { points: SurveyPoint[] } {
  const lines = String(form.get('points'))
    .split('\n')
    .map((line) => line.trim())
    .filter((line) => line !== '');
  const points = lines.map((line, index) => {
    const [name, ...figures] = line.split(/[\s,;]+/);
    const values = figures.map(Number);
    if (values.length !== 6 || values.some((value) => !Number.isFinite(value)))
      throw new Error(`Line ${index + 1} needs a name and six numbers; it has ${figures.length} after the name.`);
    return { name, p_session: values.slice(0, 3), p_grid: values.slice(3) };
  });
  if (points.length < 3) throw new Error(`Three control points are needed; there ${points.length === 1 ? 'is 1' : `are ${points.length}`}.`);
  return { points };
}

export function surveyText(answer: { rms_m?: number; residuals?: { name: string; residual_m: number }[] }): string {
  const rms = answer.rms_m === undefined ? '' : `They fit within ${(100 * answer.rms_m).toFixed(1)} cm (rms).`;
  const worst = [...(answer.residuals ?? [])].sort((x, y) => y.residual_m - x.residual_m)[0];
  return worst ? `${rms} Worst: ${worst.name}, ${(100 * worst.residual_m).toFixed(1)} cm.` : rms;
}
