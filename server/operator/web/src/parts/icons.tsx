// Small drawings, 16 by 16, in the colour of the text; words stand beside them or in their button's label.

const paths = {
  merge: 'M3 3v3c0 3 5 2 5 5v2M13 3v3c0 3-5 2-5 5M5.5 10.5 8 13l2.5-2.5',
  export: 'M8 2v8M4.8 7 8 10.2 11.2 7M2.5 11v2.5h11V11',
  plus: 'M8 3v10M3 8h10',
  sun: 'M8 5a3 3 0 1 0 0 6 3 3 0 0 0 0-6M8 1v1.5M8 13.5V15M1 8h1.5M13.5 8H15M3 3l1 1M12 12l1 1M3 13l1-1M12 4l1-1',
  moon: 'M13 9.8A5.5 5.5 0 0 1 6.2 3 5.5 5.5 0 1 0 13 9.8Z',
  auto: 'M8 2.5a5.5 5.5 0 1 0 0 11ZM8 2.5a5.5 5.5 0 0 1 0 11',
  fit: 'M2.5 6V2.5H6M10 2.5h3.5V6M13.5 10v3.5H10M6 13.5H2.5V10',
  measure: 'M2 11 11 2l3 3-9 9ZM5 8l1.5 1.5M7.5 5.5 9 7M10 3l1.5 1.5',
  top: 'M2.5 2.5h11v11h-11ZM2.5 8h11M8 2.5v11',
  free: 'M8 1.8 13.5 5v6L8 14.2 2.5 11V5ZM2.5 5 8 8l5.5-3M8 8v6.2',
  back: 'M9.5 3.5 5 8l4.5 4.5',
  target: 'M8 4.5a3.5 3.5 0 1 0 0 7 3.5 3.5 0 0 0 0-7M8 1v3M8 12v3M1 8h3M12 8h3',
  keys: 'M1.5 4h13v8h-13ZM4 6.5h.5M7 6.5h.5M10 6.5h.5M5 9.5h6',
  play: 'M5 3v10l8-5Z',
  pause: 'M5.5 3v10M10.5 3v10',
  time: 'M8 2a6 6 0 1 0 0 12A6 6 0 0 0 8 2M8 4.5V8l2.5 2',
  change: 'M8 2.5a5.5 5.5 0 1 0 0 11 5.5 5.5 0 1 0 0-11M5.5 6.5h5M8 4v5M5.5 11h5',
  close: 'M4 4l8 8M12 4l-8 8',
};

export type IconName = keyof typeof paths;

export function Icon({ name }: { name: IconName }) {
  return (
    <svg class="icon" viewBox="0 0 16 16" aria-hidden="true">
      <path d={paths[name]} />
    </svg>
  );
}

export function Logo() {
  return (
    <svg class="logo" viewBox="0 0 24 24" aria-hidden="true">
      <path d="M5 21.5 10.8 7h2.4L19 21.5M7.6 15h8.8M12 21.5V7" />
      <circle cx="12" cy="4.8" r="2.4" />
    </svg>
  );
}
