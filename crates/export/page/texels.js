// Texels of the images: unpacked as crates/export/src/packed.rs packs them.

const KINDS = { 1: Uint8Array, 2: Uint16Array, 4: Uint32Array };

export async function gunzip(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

const sizeOf = (image, level) => image.size.map((side, axis) => (axis < image.axes ? Math.max(side >> level, 1) : 1));
export const channelsOf = (image) => (image.format.startsWith('rgba') ? 4 : 1);
const bitsOf = (image) => Number(image.format.match(/\d+/)[0]);

// The levels of an image: size and texels of each.
export function unpack(image, packed) {
  const channels = channelsOf(image), bytes = bitsOf(image) / 8, Kind = KINDS[bytes];
  let at = 0;
  return Array.from({ length: image.levels }, (_, level) => {
    const [x, y, z] = sizeOf(image, level), count = x * y * z, texels = new Kind(count * channels);
    for (let channel = 0; channel < channels; channel++, at += bytes * count) {
      const values = channels === 1 ? texels : new Kind(count);
      for (let i = 0; i < count; i++) {
        let code = packed[at + i];
        for (let byte = 1; byte < bytes; byte++) code |= packed[at + byte * count + i] << 8 * byte;
        values[i] = code >>> 1 ^ -(code & 1);
      }
      add(values, x, y, z);
      const lost = image.file.left_out[channel];
      if (channels > 1) for (let i = 0; i < count; i++) texels[i * channels + channel] = values[i] << lost;
    }
    return { size: [x, y, z], texels };
  });
}

// Sums of the differences: along each axis in turn.
function add(values, x, y, z) {
  for (const [step, across] of [[1, x], [x, y], [x * y, z]]) {
    if (across === 1) continue;
    const row = step * across;
    for (let start = 0; start < values.length; start += row) {
      for (let i = start + step; i < start + row; i++) values[i] += values[i - step];
    }
  }
}

// The format in which a device filters an image, and its texels in that format.
export function stored(image, texels, features) {
  const bits = bitsOf(image), isFloat = image.format.endsWith('float');
  const name = image.format.slice(0, image.format.indexOf(String(bits)));
  if (bits === 8 || (bits === 16 && (isFloat || features.has('texture-formats-tier1')))) return [image.format, texels];
  const numbers = isFloat ? new Float32Array(texels.buffer) : Float32Array.from(texels, (code) => code / 65535);
  if (features.has('float32-filterable')) return [`${name}32float`, numbers];
  if (typeof Float16Array === 'undefined') throw new Error('This browser filters no images of 16 or 32 bits; a newer one does.');
  return [`${name}16float`, Float16Array.from(numbers)];
}
