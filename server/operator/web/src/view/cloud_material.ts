// How points are drawn. One program; what all clouds share lies in shared uniforms.

import { Color, ShaderMaterial, Vector2, Vector3, Vector4 } from 'three';
import { ramp } from './palette';

export type ColourBy = 'robot' | 'height' | 'age';
const modes: Record<ColourBy, number> = { robot: 0, height: 1, age: 2 };

const vertex = /* glsl */ `
attribute vec2 seen; // height over the sensor that saw it (m), sequence of its keyframe
uniform vec2 heights, slice;
uniform vec2 ages; // share of keyframe 0, and of each further one
uniform vec3 paper, ink, ramp[${ramp.length}];
uniform vec4 clip; // middle, cosine and sine of a rectangle outside of which nothing is shown
uniform vec2 clipHalf;
uniform float until; // the last keyframe whose points are shown
uniform float mode, roof, pixelsPerUnit, perspective, cube, faded;
varying vec3 colour;

vec3 along(float share) {
  float at = clamp(share, 0.0, 1.0) * ${(ramp.length - 1).toFixed(1)};
  vec3 found = ramp[0];
  for (int i = 1; i < ${ramp.length}; i++) found = mix(found, ramp[i], clamp(at - float(i - 1), 0.0, 1.0));
  return found;
}

void main() {
  vec4 world = modelMatrix * vec4(position, 1.0);
  vec4 eye = viewMatrix * world;
  gl_Position = projectionMatrix * eye;
  vec2 off = world.xy - clip.xy;
  off = abs(vec2(dot(off, clip.zw), dot(off, vec2(-clip.w, clip.z))));
  bool cut = off.x > clipHalf.x || off.y > clipHalf.y || seen.y > until || seen.x > roof || world.z < slice.x || world.z > slice.y;
  if (cut) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  float pixels = cube * pixelsPerUnit / (perspective > 0.5 ? -eye.z : 1.0);
  gl_PointSize = clamp(pixels, 1.6, 7.0);
  // The floor recedes, the walls stand out: from above it reads as a plan.
  float wall = smoothstep(-2.0, 0.6, seen.x);
  if (mode < 0.5) colour = mix(paper, ink, mix(0.30, 1.0, wall));
  else if (mode < 1.5) colour = along((world.z - heights.x) / max(heights.y - heights.x, 0.1)) * mix(0.72, 1.0, wall);
  else colour = along(ages.x + ages.y * seen.y) * mix(0.72, 1.0, wall);
  colour = mix(colour, paper, faded);
}`;

const fragment = /* glsl */ `
varying vec3 colour;
void main() {
  vec2 off = gl_PointCoord - 0.5;
  if (dot(off, off) > 0.25) discard;
  gl_FragColor = vec4(colour, 1.0);
}`;

export const shared = {
  heights: { value: new Vector2(0, 1) },
  slice: { value: new Vector2(-1e6, 1e6) },
  clip: { value: new Vector4(0, 0, 1, 0) },
  clipHalf: { value: new Vector2(1e9, 1e9) },
  paper: { value: new Vector3() },
  ramp: { value: ramp.map((hex) => vector(hex)) },
  mode: { value: 0 },
  roof: { value: 1e6 },
  pixelsPerUnit: { value: 1 },
  perspective: { value: 1 },
};

/** As they are on the screen: the renderer is told not to convert. */
export function vector(hex: string): Vector3 {
  const { r, g, b } = new Color().setStyle(hex, 'srgb-linear');
  return new Vector3(r, g, b);
}

export const colourBy = (by: ColourBy) => void (shared.mode.value = modes[by]);

export function cloudMaterial(): ShaderMaterial {
  return new ShaderMaterial({
    vertexShader: vertex,
    fragmentShader: fragment,
    uniforms: {
      ...shared,
      ink: { value: new Vector3() },
      ages: { value: new Vector2(0, 0) },
      until: { value: 1e9 },
      cube: { value: 1 },
      faded: { value: 0 },
    },
  });
}
