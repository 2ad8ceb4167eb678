// The device: programs, images, the shadow volume and the picture.
import { channelsOf, stored } from './texels.js';

const SCREEN = `@vertex fn screen(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
  return vec4f(f32((i << 1u) & 2u) * 2.0 - 1.0, f32(i & 2u) * 2.0 - 1.0, 0.5, 1.0);
}`;
// Composites the mean over the background, and encodes sRGB as the renderer does.
const PRESENT = `${SCREEN}
@group(0) @binding(0) var mean: texture_2d<f32>;
@group(0) @binding(1) var smooth_sampler: sampler;
@group(0) @binding(2) var<uniform> background: vec4f;
@group(0) @binding(3) var<uniform> size: vec4f;
fn encode(c: vec3f) -> vec3f {
  let low = clamp(c, vec3f(0.0), vec3f(1.0));
  return select(1.055 * pow(low, vec3f(1.0 / 2.4)) - 0.055, 12.92 * low, low <= vec3f(0.0031308));
}
@fragment fn present(@builtin(position) at: vec4f) -> @location(0) vec4f {
  let own = textureSampleLevel(mean, smooth_sampler, at.xy * size.xy, 0.0);
  let whole = own + background * (1.0 - own.a);
  return vec4f(encode(whole.rgb / max(whole.a, 1e-6)) * whole.a, whole.a);
}`;
const FEATURES = ['texture-formats-tier1', 'float32-filterable'];
const MEAN = 'rgba16float', SEGMENTS = 'rgba32float';

// Opens the device; failed: called with each later error of it.
export async function openDevice(failed) {
  if (!navigator.gpu) throw new Error('This browser has no WebGPU, or not for this page.');
  const adapter = await navigator.gpu.requestAdapter({ powerPreference: 'high-performance' });
  if (!adapter) throw new Error('This browser found no device for WebGPU.');
  const requiredFeatures = FEATURES.filter((name) => adapter.features.has(name));
  const { maxBufferSize } = adapter.limits;
  const device = await adapter.requestDevice({ requiredFeatures, requiredLimits: { maxBufferSize } });
  device.lost.then(({ reason, message }) => {
    if (reason === 'destroyed') return;
    console.error(message);
    failed(new Error('This browser lost its graphics device; load the page again.'));
  });
  device.addEventListener('uncapturederror', ({ error }) => failed(error));
  return device;
}

async function pipelineOf(device, layout, code, [vertex, fragment], target) {
  const module = device.createShaderModule({ code });
  const stage = (entryPoint) => ({ module: entryPoint === 'screen' ? device.createShaderModule({ code: SCREEN }) : module, entryPoint });
  return device.createRenderPipelineAsync({ layout, vertex: stage(vertex), fragment: { ...stage(fragment), targets: [target] } });
}

// A program with its bindings and uniform buffers.
class Program {
  static async make(device, own, code, scene, target) {
    const visibility = GPUShaderStage.FRAGMENT;
    const viewDimension = ({ binding }) => {
      const image = scene.images.find((image) => image.binding === binding);
      return image ? `${image.axes}d` : '3d';
    };
    const layout = device.createBindGroupLayout({ entries: [
      ...own.blocks.map(({ binding }) => ({ binding, visibility, buffer: {} })),
      ...own.images.map((image) => ({ binding: image.binding, visibility, texture: { viewDimension: viewDimension(image) } })),
      ...own.samplers.map(({ binding }) => ({ binding, visibility, sampler: {} })),
    ] });
    const whole = device.createPipelineLayout({ bindGroupLayouts: [layout] });
    const program = new Program();
    program.pipeline = await pipelineOf(device, whole, code, ['screen', own.entry], target);
    const usage = GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST;
    const buffers = own.blocks.map((block) => device.createBuffer({ size: block.bytes, usage }));
    program.fill = (values) => own.blocks.forEach((block, i) => {
      const floats = new Float32Array(block.bytes / 4);
      block.members.forEach(({ name, offset }) => floats.set(values[name], offset / 4));
      device.queue.writeBuffer(buffers[i], 0, floats);
    });
    program.bind = (images, samplers) => device.createBindGroup({ layout, entries: [
      ...own.blocks.map(({ binding }, i) => ({ binding, resource: { buffer: buffers[i] } })),
      ...own.images.map(({ binding, name }) => ({ binding, resource: images.get(name) })),
      ...own.samplers.map(({ binding, name }) => ({ binding, resource: samplers.get(name) })),
    ] });
    return program;
  }
}

function upload(device, image, levels) {
  const [format] = stored(image, levels[0].texels, device.features);
  const usage = GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.COPY_DST;
  const texture = device.createTexture({
    size: levels[0].size, dimension: `${image.axes}d`, format, mipLevelCount: levels.length, usage,
  });
  levels.forEach(({ size, texels }, mipLevel) => {
    const [, data] = stored(image, texels, device.features);
    const bytesPerRow = size[0] * channelsOf(image) * data.BYTES_PER_ELEMENT;
    device.queue.writeTexture({ texture, mipLevel }, data, { bytesPerRow, rowsPerImage: size[1] }, size);
  });
  return texture;
}

// A scene on the device. wgsl: text by name of the program; levels: unpacked levels by name of the image.
export class Renderer {
  static async make(device, scene, canvas, wgsl, levels) {
    const own = new Renderer();
    Object.assign(own, { device, scene, canvas, context: canvas.getContext('webgpu'), cast: '' });
    const format = navigator.gpu.getPreferredCanvasFormat();
    own.context.configure({ device, format, alphaMode: 'premultiplied' });
    const add = { srcFactor: 'constant', dstFactor: 'one', operation: 'add' };
    const targets = { picture: { format: MEAN, blend: { color: add, alpha: add } }, shadow: { format: SEGMENTS } };
    own.programs = new Map(await Promise.all(scene.programs.map(async (program) =>
      [program.name, await Program.make(device, program, wgsl(program), scene, targets[program.name])])));
    own.present = await pipelineOf(device, 'auto', PRESENT, ['screen', 'present'], { format });
    own.images = new Map();
    for (const image of scene.images) own.images.set(image.name, upload(device, image, await levels(image)).createView());
    own.samplers = new Map(scene.samplers.map(({ name, address, anisotropy }) => [name, device.createSampler({
      addressModeU: address, addressModeV: address, addressModeW: address, maxAnisotropy: anisotropy,
      magFilter: 'linear', minFilter: 'linear', mipmapFilter: 'linear',
    })]));
    own.smooth = device.createSampler({ magFilter: 'linear', minFilter: 'linear' });
    const usage = GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST;
    [own.background, own.size] = [0, 1].map(() => device.createBuffer({ size: 16, usage }));
    device.queue.writeBuffer(own.background, 0, new Float32Array(scene.background ? [...scene.background, 1] : 4));
    return own;
  }

  // Begins a picture of this size.
  begin([width, height]) {
    if (this.mean && this.mean.width === width && this.mean.height === height) return;
    const usage = GPUTextureUsage.RENDER_ATTACHMENT | GPUTextureUsage.TEXTURE_BINDING;
    this.mean = this.device.createTexture({ size: [width, height], format: MEAN, usage });
  }

  // Casts the shadows for these values, unless they are those of the latest picture.
  async castShadows(values) {
    const program = this.programs.get('shadow');
    if (!program) return;
    const { picture_scale, ray_scale, jitter_seed, ...rest } = values, key = JSON.stringify(rest);
    if (key === this.cast) return;
    const side = values.shadow_side[0], squares = Math.ceil(side / 4), columns = Math.ceil(Math.sqrt(squares));
    const size = [columns * side, Math.ceil(squares / columns) * side], bytesPerRow = Math.ceil(size[0] / 16) * 256;
    const usage = GPUTextureUsage.RENDER_ATTACHMENT | GPUTextureUsage.COPY_SRC;
    const target = this.device.createTexture({ size, format: SEGMENTS, usage });
    const buffer = this.device.createBuffer({
      size: bytesPerRow * size[1], usage: GPUBufferUsage.COPY_DST | GPUBufferUsage.MAP_READ,
    });
    program.fill(values);
    this.draw('shadow', target, { rows: [0, size[1]], first: true });
    const encoder = this.device.createCommandEncoder();
    encoder.copyTextureToBuffer({ texture: target }, { buffer, bytesPerRow }, size);
    this.device.queue.submit([encoder.finish()]);
    await buffer.mapAsync(GPUMapMode.READ);
    const segments = new Float32Array(buffer.getMappedRange()), row = bytesPerRow / 4, rays = side * side;
    const texels = new Uint16Array(rays * (side + 1)).fill(65535), light = new Float32Array(rays).fill(1);
    for (let layer = 0; layer < side; layer++) {
      const square = layer >> 2, corner = (square / columns | 0) * side * row + (square % columns) * side * 4 + layer % 4;
      for (let ray = 0; ray < rays; ray++) {
        light[ray] *= segments[corner + (ray / side | 0) * row + ray % side * 4];
        texels[rays * (layer + 1) + ray] = light[ray] * 65535 + 0.5;
      }
    }
    buffer.destroy();
    target.destroy();
    const image = { axes: 3, format: 'r16unorm' };
    this.shadow?.destroy();
    this.shadow = upload(this.device, image, [{ size: [side, side, side + 1], texels }]);
    this.images.set('shadow_image', this.shadow.createView());
    this.cast = key;
  }

  // Draws rows of a program into a texture.
  draw(name, texture, { rows: [from, to], first, part = 1 }) {
    const program = this.programs.get(name), encoder = this.device.createCommandEncoder();
    const pass = encoder.beginRenderPass({ colorAttachments: [
      { view: texture.createView(), loadOp: first ? 'clear' : 'load', storeOp: 'store', clearValue: [0, 0, 0, 0] },
    ] });
    pass.setPipeline(program.pipeline);
    pass.setBindGroup(0, program.bind(this.images, this.samplers));
    pass.setScissorRect(0, from, texture.width, to - from);
    pass.setBlendConstant([part, part, part, part]);
    pass.draw(3);
    pass.end();
    this.device.queue.submit([encoder.finish()]);
  }

  // Shows the mean so far.
  show() {
    const { device, canvas } = this, encoder = device.createCommandEncoder();
    device.queue.writeBuffer(this.size, 0, new Float32Array([1 / canvas.width, 1 / canvas.height, 0, 0]));
    const view = this.context.getCurrentTexture().createView();
    const pass = encoder.beginRenderPass({ colorAttachments: [{ view, loadOp: 'clear', storeOp: 'store' }] });
    pass.setPipeline(this.present);
    const resources = [this.mean.createView(), this.smooth, { buffer: this.background }, { buffer: this.size }];
    const entries = resources.map((resource, binding) => ({ binding, resource }));
    pass.setBindGroup(0, device.createBindGroup({ layout: this.present.getBindGroupLayout(0), entries }));
    pass.draw(3);
    pass.end();
    device.queue.submit([encoder.finish()]);
  }
}
