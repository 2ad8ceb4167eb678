// Values of the uniform blocks for a state of the page. The renderer has the same in src/render/camera.
import { apply, length, minus, multiply, plus, scale, shift, transpose, turn, turnToZ } from './matrix.js';

const FARTHEST = 300, WIDEST = 80 * Math.PI / 180, STRIDE = 2;

const linear = (code) => (code <= 0.04045 ? code / 12.92 : ((code + 0.055) / 1.055) ** 2.4);
const colorOf = (hex) => [1, 3, 5].map((at) => linear(parseInt(hex.slice(at, at + 2), 16) / 255)).concat(1);

// The state that the scene describes.
export function initial(scene) {
  const { view_angles: [azimuth, elevation], view_zoom: [zoom], view_samples: [samples] } = scene.values;
  const parameters = scene.parameters.map((own) => [own.name, own.value ?? own.color]);
  return { azimuth, elevation, zoom, samples, time: scene.time, parameters: new Map(parameters) };
}

// Values at a place of the range of a parameter.
function along({ range: [low, high] }, table, value) {
  const at = (value - low) / (high - low || 1) * (table.length - 1);
  const cell = Math.max(0, Math.min(table.length - 2, Math.floor(at)));
  return table[cell].map((from, i) => from + (at - cell) * (table[cell + 1][i] - from));
}

// The values of the scene at a time.
function atTime({ values, motion }, time) {
  if (!motion) return { ...values, time: [time] };
  const [from, to] = motion.seconds, own = motion.repeats ? time - Math.floor(time / to) * to : time;
  const place = Math.max(from, Math.min(to, own)), now = { ...values, time: [own] };
  for (const [name, table] of Object.entries(motion.values)) now[name] = along({ range: motion.seconds }, table, place);
  return now;
}

function withParameters(scene, state, values) {
  for (const own of scene.parameters) {
    const value = state.parameters.get(own.name);
    if ((own.value ?? own.color) === value) continue;
    values[own.member] = own.color === undefined ? [value] : colorOf(value);
    for (const [name, table] of Object.entries(own.follow)) {
      values[name] = plus(plus(values[name], along(own, table, value)), along(own, table, own.value), -1);
    }
  }
  return values;
}

// Values for a picture of this size; subFrame: its offset, time and seed.
export function valuesAt(scene, state, [width, height], subFrame) {
  const [right, down, later, seed] = subFrame;
  const values = withParameters(scene, state, atTime(scene, state.time + later));
  const number = (name) => values[`view_${name}`][0], vector = (name) => values[`view_${name}`];
  const aspect = width / height, fit = Math.min(aspect, 1), start = scene.values;
  const half = number('half_height') / state.zoom / number('zoom') * start.view_zoom[0];
  const [azimuth, elevation] = vector('angles').map((own, i) => own + [state.azimuth, state.elevation][i] - start.view_angles[i]);
  const angle = number('field_of_view') * Math.PI / 360, radius = number('radius'), isParallel = number('parallel') > 0;
  const distance = isParallel ? 2 * radius + number('near') : half / fit / Math.sin(angle);
  const y = isParallel ? half / fit : Math.tan(angle), rays = [y * aspect, y];
  const [panX, panY] = vector('pan').map((pan, i) => pan / (rays[i] * (isParallel ? 1 : distance)));
  const stretch = vector('stretch'), center = vector('center'), eye = [0, 0, -distance];
  const rotation = multiply(multiply(turn(0, elevation), turn(1, -azimuth)), vector('turn'));
  const object = multiply(shift(eye), multiply(rotation, multiply(scale(stretch), shift(center.map((c) => -c)))));
  const back = multiply(scale(stretch.map((s) => 1 / s)), transpose(rotation));
  const texture = multiply(shift(center), multiply(back, shift([0, 0, distance])));

  const samples = Math.round(number('samples') + state.samples - start.view_samples[0]), step = 2 * radius / samples;
  const depth = (plane) => distance - radius + (plane + 0.5) * step;
  const skipped = Math.max(0, Math.min(samples, Math.ceil((number('near') - distance + radius) / step - 0.5)));
  const corner = [(Math.abs(panX) + 1) * rays[0], (Math.abs(panY) + 1) * rays[1], 1];
  const longest = step * (isParallel ? 1 : length(corner)) / Math.min(...stretch);
  const light = plus(eye, vector('light'));
  Object.assign(values, {
    object_matrix: object, texture_matrix: texture, ray_scale: [...rays, 0, 0],
    picture_scale: [2 / width, 2 / height, right * 2 / width - panX, down * 2 / height + panY],
    step_size: [step], first_depth: [depth(skipped)], slice_count: [samples - skipped],
    sample_reach: [number('reach_steps') * longest], box_margin: [number('margin_steps') * longest], jitter_seed: [seed],
  });
  for (const name of Object.keys(values).filter((own) => own.startsWith('place_matrix'))) {
    const suffix = name.slice('place_matrix'.length);
    values[`normal_matrix${suffix}`] = transpose(multiply(values[name], texture));
    values[`light_position${suffix}`] = [...light, 1];
  }
  return values.shadow_side ? Object.assign(values, shadowSpace(values, object, light, step)) : values;
}

// The space of the shadow volume: rays from the light.
function shadowSpace(values, object, lightEye, step) {
  const [low, high] = [values.box_min, values.box_max];
  const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((corner) =>
    apply(object, [0, 1, 2].map((axis) => (corner >> axis & 1 ? high : low)[axis])));
  const center = apply(object, [0, 1, 2].map((axis) => 0.5 * (low[axis] + high[axis])));
  const radius = Math.max(...corners.map((corner) => length(minus(corner, center))));
  const away = minus(lightEye, center), distance = length(away);
  const light = plus(center, away, Math.min(FARTHEST * radius / distance, 1));
  const axis = distance > 0 ? minus(center, light).map((c) => c / length(minus(center, light))) : [0, 0, -1];
  const matrix = multiply(turnToZ(axis), shift(light.map((c) => -c)));
  const seen = corners.map((corner) => apply(matrix, corner));
  const angle = Math.max(...seen.map(([x, y, z]) => Math.atan2(Math.hypot(x, y), z))), outside = angle < WIDEST;
  const near = outside ? Math.max(0, Math.min(...seen.map((p) => p[2]))) : 0;
  const far = Math.max(near + 1e-3, ...seen.map(length)), side = values.shadow_side[0];
  const steps = Math.ceil((far - near) / (side * STRIDE * step));
  const rim = 4 * (outside ? Math.sin(angle / 4) * (1 + 1 / side) : Math.SQRT1_2);
  const bias = Math.max(Math.SQRT2 * rim * (near + far) / side, (far - near) / side);
  return {
    shadow_matrix: matrix, shadow_rim: [rim], shadow_near: [near], shadow_far: [far], shadow_bias: [bias],
    shadow_steps: [Math.max(1, Math.min(values.view_shadow_most_steps[0], steps))],
  };
}
