// Draws into a texture in place of the screen, which a browser without a display lacks, and posts what the page shows.
(() => {
  let device, texture;
  GPUCanvasContext.prototype.configure = function (how) { device = how.device; };
  GPUCanvasContext.prototype.getCurrentTexture = function () {
    const usage = GPUTextureUsage.RENDER_ATTACHMENT | GPUTextureUsage.COPY_SRC;
    const format = navigator.gpu.getPreferredCanvasFormat();
    texture = device.createTexture({ size: [this.canvas.width, this.canvas.height], format, usage });
    return texture;
  };
  const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
  const post = (name, body) => fetch(name, { method: 'POST', body });
  async function rest(canvas) {
    for (;; await pause(20)) {
      const said = document.getElementById('status').textContent;
      if (said.includes('stays still')) throw new Error(said);
      if (canvas.getAttribute('aria-busy') === 'false') return;
    }
  }
  async function read() {
    const bytesPerRow = Math.ceil(texture.width / 64) * 256;
    const usage = GPUBufferUsage.COPY_DST | GPUBufferUsage.MAP_READ;
    const buffer = device.createBuffer({ size: bytesPerRow * texture.height, usage });
    const encoder = device.createCommandEncoder();
    encoder.copyTextureToBuffer({ texture }, { buffer, bytesPerRow }, [texture.width, texture.height]);
    device.queue.submit([encoder.finish()]);
    await buffer.mapAsync(GPUMapMode.READ);
    const all = new Uint8Array(buffer.getMappedRange());
    const rows = Array.from({ length: texture.height }, (_, y) => all.slice(y * bytesPerRow, y * bytesPerRow + 4 * texture.width));
    const pixels = new Uint8Array(rows.flatMap((row) => [...row]));
    if (texture.format.startsWith('bgra')) {
      for (let at = 0; at < pixels.length; at += 4) [pixels[at], pixels[at + 2]] = [pixels[at + 2], pixels[at]];
    }
    return pixels;
  }
  async function probe() {
    const canvas = document.getElementById('picture');
    const shown = async (name) => {
      await rest(canvas);
      await post(name, await read());
    };
    await shown('first');
    const point = (kind, x) => canvas.dispatchEvent(new PointerEvent(kind, { pointerId: 1, clientX: x, clientY: 60 }));
    point('pointerdown', 40);
    point('pointermove', 100);
    point('pointerup', 100);
    await shown('dragged');
    canvas.dispatchEvent(new KeyboardEvent('keydown', { key: 'r' }));
    await shown('reset');
    const labels = [...document.querySelectorAll('label')];
    const isParameter = (label) => !['zoom', 'samples', 'time'].includes(label.firstChild.textContent);
    const input = (labels.find(isParameter) ?? labels[0]).querySelector('input');
    if (input.type === 'color') input.value = '#3060ff';
    else input.value = Number(input.min) + 0.8 * (input.max - input.min);
    input.dispatchEvent(new Event('input'));
    await shown('slid');
  }
  addEventListener('load', () => probe().catch((error) => post('error', error.message)).then(() => post('done', '')));
})();
