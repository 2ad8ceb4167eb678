// Matrices of four columns, as the programs have them, and vectors.

export const multiply = (a, b) => Array.from({ length: 16 }, (_, i) =>
  [0, 1, 2, 3].reduce((sum, k) => sum + a[4 * k + (i & 3)] * b[4 * (i >> 2) + k], 0));

export const transpose = (a) => a.map((_, i) => a[4 * (i & 3) + (i >> 2)]);

// A turn by degrees about x (0) or y (1).
export function turn(axis, degrees) {
  const angle = degrees * Math.PI / 180, c = Math.cos(angle), s = Math.sin(angle);
  return axis === 0 ? [1, 0, 0, 0, 0, c, s, 0, 0, -s, c, 0, 0, 0, 0, 1] : [c, 0, -s, 0, 0, 1, 0, 0, s, 0, c, 0, 0, 0, 0, 1];
}

export const scale = ([x, y, z]) => [x, 0, 0, 0, 0, y, 0, 0, 0, 0, z, 0, 0, 0, 0, 1];
export const shift = ([x, y, z]) => [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, y, z, 1];

export const apply = (m, [x, y, z]) => [0, 1, 2].map((i) => m[i] * x + m[4 + i] * y + m[8 + i] * z + m[12 + i]);

export const minus = (a, b) => a.map((value, i) => value - b[i]);
export const plus = (a, b, factor = 1) => a.map((value, i) => value + factor * b[i]);
export const length = (a) => Math.hypot(...a);

// The shortest turn of a unit vector to +z.
export function turnToZ([x, y, z]) {
  if (z < -1 + 1e-9) return [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1];
  const k = 1 / (1 + z);
  return [1 - x * x * k, -x * y * k, x, 0, -x * y * k, 1 - y * y * k, y, 0, -x, -y, z, 0, 0, 0, 0, 1];
}
