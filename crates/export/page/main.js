// The page: loads the scene, draws it at low resolution while it moves and at full resolution when it rests.
import { initial, valuesAt } from './camera.js';
import { addControls, fromHash, toHash } from './controls.js';
import { openDevice, Renderer } from './gpu.js';
import { gunzip, unpack } from './texels.js';

// Milliseconds of a frame in motion, of a submission at rest, and of rest before the full picture.
const FRAME = 40, SUBMISSION = 100, REST = 150, MOST_PIXELS = 4e6;
const element = (id) => document.getElementById(id);

// Bytes of a file: of the page itself, where they are in it, or beside it.
async function bytesOf(file) {
  const own = element(`file:${file}`);
  if (own) return Uint8Array.from(atob(own.textContent.trim()), (character) => character.charCodeAt(0));
  const response = await fetch(file);
  if (!response.ok) throw new Error(`${file} is not there: ${response.status}`);
  return new Uint8Array(await response.arrayBuffer());
}

let isStopped = false;
const say = (text) => { if (!isStopped) element('status').textContent = text; };

// Shows the still picture again, and says why; the first reason counts.
function stop(error) {
  console.error(error);
  if (isStopped) return;
  document.body.classList.remove('live');
  element('picture').setAttribute('aria-busy', 'false');
  element('picture').tabIndex = -1;
  element('controls').inert = true;
  // Errors of the browser itself are in its own words.
  const reason = error.constructor === Error ? error.message : 'The graphics device of this browser stopped drawing; load the page again to try once more.';
  say(`${reason} The picture stays still.`);
  isStopped = true;
}

async function run() {
  const canvas = element('picture');
  canvas.setAttribute('aria-busy', 'true');
  const device = await openDevice(stop);
  say('Loading');
  const text = async (file) => new TextDecoder().decode(await bytesOf(file));
  const scene = JSON.parse(await text('scene.json'));
  const wgsl = new Map(await Promise.all(scene.programs.map(async ({ wgsl: file }) => [file, await text(file)])));
  const levels = async (image) => unpack(image, await gunzip(await bytesOf(image.file.packed)));
  const renderer = await Renderer.make(device, scene, canvas, (program) => wgsl.get(program.wgsl), levels);

  const start = () => initial(scene), state = { ...start(), playing: false };
  fromHash(state, location.hash.slice(1), scene);
  let version = 0, moved = -Infinity, wake = () => {}, divisor = 2;
  const changed = () => { if (isStopped) return; version++; moved = performance.now(); canvas.setAttribute('aria-busy', 'true'); wake(); };
  const fit = () => {
    const { width, height } = canvas.getBoundingClientRect(), ratio = window.devicePixelRatio;
    const less = Math.min(1, Math.sqrt(MOST_PIXELS / Math.max(1, width * height * ratio * ratio)));
    const size = [width, height].map((side) => Math.max(1, Math.round(side * ratio * less)));
    if (size[0] === canvas.width && size[1] === canvas.height) return;
    [canvas.width, canvas.height] = size;
    changed();
  };

  // Draws a sub-frame; gives the milliseconds, or nothing if the scene has changed meanwhile.
  async function pass(size, subFrame, { part, first, isCut }) {
    const own = version, values = valuesAt(scene, state, size, subFrame), began = performance.now();
    await renderer.castShadows(values);
    renderer.programs.get('picture').fill(values);
    for (let row = 0, rows = isCut ? 16 : size[1]; row < size[1];) {
      const end = Math.min(size[1], row + rows), before = performance.now();
      renderer.draw('picture', renderer.mean, { rows: [row, end], first: first && row === 0, part });
      await device.queue.onSubmittedWorkDone();
      if (isCut && own !== version) return undefined;
      rows = Math.max(1, Math.round(rows * Math.min(4, SUBMISSION / (performance.now() - before + 1))));
      row = end;
    }
    return performance.now() - began;
  }

  const present = () => {
    if (isStopped) return;
    renderer.show();
    document.body.classList.add('live');
    say('');
  };

  async function move() {
    const size = [canvas.width, canvas.height].map((side) => Math.ceil(side / divisor));
    renderer.begin(size);
    const took = await pass(size, [0, 0, 0, scene.sub_frames[0][3]], { part: 1, first: true });
    present();
    if (took > FRAME && divisor < 16) divisor *= 2;
    else if (took < FRAME / 5 && divisor > 1) divisor /= 2;
  }

  async function rest() {
    const size = [canvas.width, canvas.height], all = scene.sub_frames;
    for (const some of all.length > 1 ? [[[0, 0, 0, all[0][3]]], all] : [all]) {
      renderer.begin(size);
      for (const [index, own] of some.entries()) {
        if (await pass(size, own, { part: 1 / some.length, first: index === 0, isCut: true }) === undefined) return false;
      }
      present();
    }
    return true;
  }

  const shown = addControls({ scene, state, start, canvas, form: element('controls'), changed });
  new ResizeObserver(fit).observe(canvas);
  fit();
  for (let done = -1, last = performance.now(), isFirst = true; ; isFirst = false) {
    const now = await new Promise(requestAnimationFrame);
    if (isStopped) return;
    if (state.playing) {
      state.time += Math.min(0.1, (now - last) / 1000);
      if (state.time > scene.motion?.seconds[1]) [state.time] = scene.motion.seconds;
      shown();
      changed();
    }
    last = now;
    const own = version;
    if (done === own) {
      await new Promise((resolve) => { wake = resolve; });
      last = performance.now();
      continue;
    }
    if (isFirst || (performance.now() - moved > REST && !state.playing)) {
      if (!await rest()) continue;
      done = own;
      history.replaceState(null, '', `#${toHash(state, start())}`);
      if (own === version) canvas.setAttribute('aria-busy', 'false');
    } else {
      await move();
    }
  }
}

run().catch(stop);
