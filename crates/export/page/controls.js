// What a person changes: the camera by mouse, touch and keys, the time, and the parameters.

const TURN = 0.4, KEY_TURN = 5, ZOOM = 1.1, ZOOMS = [0.1, 30], LONGEST = 60;
const SAMPLES = [4, 1024], NUMBERS = ['azimuth', 'elevation', 'zoom', 'samples', 'time'];
const within = (value, [low, high]) => Math.max(low, Math.min(high, value));

// Digits of a number in an address, whose changes are too small to see.
const DIGITS = 4;

// The part of an address that says how a state differs from the first one.
export function toHash(state, first) {
  const entries = (own) => [...NUMBERS.map((name) => [name, own[name]]), ...own.parameters], before = new Map(entries(first));
  const rounded = (value) => (typeof value === 'number' ? String(Number(value.toPrecision(DIGITS))) : value);
  const changed = entries(state).filter(([name, value]) => value !== before.get(name));
  return new URLSearchParams(changed.map(([name, value]) => [name, rounded(value)])).toString();
}

// Sets a state to that of an address; what no control takes stays.
export function fromHash(state, hash, { parameters }) {
  for (const [name, text] of new URLSearchParams(hash)) {
    const own = parameters.find((own) => own.name === name), number = Number(text), isNumber = text && isFinite(number);
    if (NUMBERS.includes(name) && isNumber) state[name] = within(number, { zoom: ZOOMS, samples: SAMPLES }[name] ?? [-1e6, 1e6]);
    else if (own && (own.range ? isNumber : /^#[0-9a-f]{6}$/.test(text))) state.parameters.set(name, own.range ? within(number, own.range) : text);
  }
}

// Adds the controls of a scene. state: changed in place; changed: called after each change; start: gives a new state.
export function addControls({ scene, state, start, canvas, form, changed }) {
  const inputs = [];
  const add = (label, help, input, read, write, told = read) => {
    const row = document.createElement('label'), text = document.createElement('span'), output = document.createElement('output');
    text.textContent = label.replaceAll('_', ' ');
    row.title = help;
    row.append(text, input, output);
    form.append(row);
    const show = () => {
      input.value = read();
      output.textContent = input.type === 'range' ? String(Number(Number(told()).toPrecision(4))) : told();
    };
    input.addEventListener('input', () => {
      write(input.type === 'range' ? Number(input.value) : input.value);
      show();
      changed();
    });
    inputs.push(show);
  };
  const slider = ([min, max]) => Object.assign(document.createElement('input'), { type: 'range', min, max, step: 'any' });
  const zoomed = (value) => { state.zoom = within(value, ZOOMS); };
  add('zoom', '1 fits the object into the picture', slider(ZOOMS.map(Math.log)), () => Math.log(state.zoom),
    (value) => zoomed(Math.exp(value)), () => state.zoom);
  add('samples', 'Samples of a ray through the object', Object.assign(slider(SAMPLES.map(Math.log2)), { step: 0.25 }),
    () => Math.log2(state.samples), (value) => { state.samples = Math.round(2 ** value); }, () => state.samples);
  if (scene.moves) {
    add('time', 'Seconds', slider(scene.motion?.seconds ?? [Math.min(0, scene.time), scene.time + LONGEST]), () => state.time, (value) => { state.time = value; });
  }
  for (const { name, doc, range } of scene.parameters) {
    const input = range ? slider(range) : Object.assign(document.createElement('input'), { type: 'color' });
    add(name, doc, input, () => state.parameters.get(name), (value) => state.parameters.set(name, value));
  }
  const show = () => inputs.forEach((input) => input()), moved = () => { show(); changed(); };
  const turned = (right, down) => {
    state.azimuth -= right;
    state.elevation = within(state.elevation + down, [-90, 90]);
    moved();
  };

  const pointers = new Map();
  const spread = ([a, b] = [...pointers.values()]) => Math.hypot(a.x - b.x, a.y - b.y);
  canvas.addEventListener('pointerdown', (event) => {
    if (event.isTrusted) canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  });
  canvas.addEventListener('pointermove', (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const wide = pointers.size === 2 ? spread() : 0;
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (pointers.size === 1) return turned((event.clientX - before.x) * TURN, (event.clientY - before.y) * TURN);
    if (wide > 0) zoomed(state.zoom * spread() / wide);
    moved();
  });
  for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, (event) => pointers.delete(event.pointerId));
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    zoomed(state.zoom * Math.exp(-event.deltaY / 500));
    moved();
  }, { passive: false });

  const button = (label, key, act) => {
    const own = Object.assign(document.createElement('button'), { type: 'button', textContent: label, title: `Key ${key}` });
    own.addEventListener('click', act);
    form.querySelector('.buttons').append(own);
    return own;
  };
  const reset = () => { Object.assign(state, start(), { playing: false }); shown(); moved(); };
  const play = () => { state.playing = !state.playing; shown(); changed(); };
  const full = () => (document.fullscreenElement ? document.exitFullscreen() : canvas.parentElement.requestFullscreen());
  const player = scene.moves && button('Play', 'space', play);
  const shown = () => { if (player) player.textContent = state.playing ? 'Pause' : 'Play'; };
  button('Reset', 'R', reset);
  if (document.fullscreenEnabled) button('Full screen', 'F', full);

  const keys = {
    ArrowLeft: () => turned(-KEY_TURN, 0), ArrowRight: () => turned(KEY_TURN, 0), ArrowUp: () => turned(0, KEY_TURN),
    ArrowDown: () => turned(0, -KEY_TURN), '+': () => { zoomed(state.zoom * ZOOM); moved(); },
    '-': () => { zoomed(state.zoom / ZOOM); moved(); }, ' ': () => player && play(), r: reset, f: full,
  };
  canvas.addEventListener('keydown', (event) => {
    const act = keys[event.key];
    if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    act();
  });
  show();
  return show;
}
