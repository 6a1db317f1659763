// The slider of time over the map: a drive, or all of them, played again.

import type { Desk } from '../context';
import { duration, momentText, wallClock_s } from '../parts/format';
import { Icon } from '../parts/icons';
import { speeds } from '../time/player';

const steps = 2000; // of the slider

export function TimeBar({ desk }: { desk: Desk }) {
  const { player, station, ui } = desk;
  if (!player.open) return null;
  const { axis, position_s, playing } = player;
  const stamp_s = axis.toStamp(position_s);
  const begin_s = axis.toStamp(0);
  const moment = begin_s > wallClock_s ? momentText(stamp_s) : duration(stamp_s - begin_s);
  const one = station.sessions.get(ui.now.session ?? -1);
  const what = one ? station.titleOf(one) : `${station.paths.size} sessions`;
  const words = axis.length_s === 0 ? 'nothing was driven yet' : position_s >= axis.length_s ? `${moment}, all that there is` : moment;
  return (
    <div class="tools-time" role="group" aria-label={`Time: ${what}`}>
      <button class="button button-small button-icon" aria-label={playing ? 'Pause' : 'Play'} title={playing ? 'Pause' : 'Play'} disabled={axis.length_s === 0} onClick={() => player.play(!playing)}>
        <Icon name={playing ? 'pause' : 'play'} />
      </button>
      <input
        type="range"
        min={0}
        max={steps}
        step={1}
        value={axis.length_s > 0 ? Math.round((steps * position_s) / axis.length_s) : steps}
        onInput={(event) => player.seek((Number(event.currentTarget.value) / steps) * axis.length_s)}
        aria-label={`Moment that is shown of ${what}`}
        aria-valuetext={words}
      />
      <output>{moment}</output>
      <select aria-label="Speed" value={player.speed} onChange={(event) => player.setSpeed(Number(event.currentTarget.value))}>
        {speeds.map((speed) => (
          <option key={speed} value={speed}>
            {speed}×
          </option>
        ))}
      </select>
      <span class="muted time-of">{what}</span>
      <button class="button button-small button-icon" aria-label="Show all again" title="Show all again" onClick={() => player.show(false)}>
        <Icon name="close" />
      </button>
    </div>
  );
}
