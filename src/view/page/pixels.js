// Frames of half floats or numbers, and their conversion to display bytes.

const HEADER_BYTES = 20;

/** Table of the values of all half floats, indexed by their bits. */
const HALF_VALUES = (() => {
  const values = new Float32Array(65536);
  for (let bits = 0; bits < 65536; bits++) {
    const exponent = (bits >> 10) & 31;
    const fraction = bits & 1023;
    let value;
    if (exponent === 31) value = fraction ? NaN : Infinity;
    else if (exponent) value = 2 ** (exponent - 15) * (1 + fraction / 1024);
    else value = 2 ** -24 * fraction;
    values[bits] = bits & 32768 ? -value : value;
  }
  return values;
})();

/** Layers with numbers of objects or materials. The program sends them as 32-bit floats. */
const NUMBER_LAYERS = ["object", "material"];

/**
 * Decodes the frame of a layer from the bytes of the program. The values of `NUMBER_LAYERS` are numbers.
 * The values of other layers are the bits of half floats.
 */
function decodeFrame(buffer, layer) {
  const head = new DataView(buffer, 0, HEADER_BYTES);
  const [sequence, width, height, channels] = [0, 4, 8, 12].map((at) => head.getUint32(at, true));
  const scale = head.getFloat32(16, true);
  const Values = NUMBER_LAYERS.includes(layer) ? Float32Array : Uint16Array;
  const values = new Values(buffer, HEADER_BYTES, width * height * channels);
  return { sequence, width, height, channels, scale, values };
}

/** Returns the values of one pixel of a frame, one for each channel. */
function pixelValues(frame, x, y) {
  const at = (y * frame.width + x) * frame.channels;
  const values = Array.from(frame.values.subarray(at, at + frame.channels));
  return frame.values instanceof Float32Array ? values : values.map((bits) => HALF_VALUES[bits] * frame.scale);
}

const srgb = (c) => (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055);
const clamp = (c) => Math.min(Math.max(c, 0), 1);

/** Tone curves: map a linear value after exposure to its byte in a PNG, before rounding down. */
const TONE_CURVES = {
  srgb: (c) => 255 * srgb(clamp(c)) + 0.5,
  filmic: (c) => {
    const x = Math.min(Math.max(c, 0), 8);
    return 255 * srgb(clamp((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14))) + 0.5;
  },
  course: (c) => 255 * clamp(c),
};

let toneKey = "";
const toneTable = new Uint8Array(65536);

/** Returns a table of the display bytes of all half floats, for a scale and a tone curve. */
function toneBytes(scale, tone) {
  const key = `${scale} ${tone}`;
  if (key !== toneKey) {
    const curve = TONE_CURVES[tone];
    for (let bits = 0; bits < 65536; bits++) {
      const value = HALF_VALUES[bits] * scale;
      toneTable[bits] = Number.isNaN(value) ? 0 : Math.floor(curve(value));
    }
    toneKey = key;
  }
  return toneTable;
}

/** Nine colours of the map magma (Smith and van der Walt 2015, CC0), from dark to light. */
const MAGMA = [0x000004, 0x1d1147, 0x51127c, 0x822681, 0xb63679, 0xe65164, 0xfb8861, 0xfec287, 0xfcfdbf];
/** Five colours of Brewer's map RdBu (colorbrewer2.org) from blue to red. */
const BLUE_RED = [0x0571b0, 0x92c5de, 0xf7f7f7, 0xf4a582, 0xca0020];

/** 256 colours of a colour map, as bytes of red, green and blue. */
function rampBytes(steps) {
  const bytes = new Uint8Array(768);
  for (let i = 0; i < 256; i++) {
    const position = (i / 255) * (steps.length - 1);
    const step = Math.min(Math.floor(position), steps.length - 2);
    for (let c = 0; c < 3; c++) {
      const [low, high] = [steps[step], steps[step + 1]].map((color) => (color >> (16 - 8 * c)) & 255);
      bytes[3 * i + c] = Math.round(low + (high - low) * (position - step));
    }
  }
  return bytes;
}

const SEQUENTIAL = rampBytes(MAGMA);
const DIVERGING = rampBytes(BLUE_RED);

/** Returns the mean over the channels of each pixel of a frame. */
function channelMeans(frame) {
  const { channels, scale, values } = frame;
  const means = new Float32Array(values.length / channels);
  for (let i = 0; i < means.length; i++) {
    let sum = 0;
    for (let c = 0; c < channels; c++) sum += HALF_VALUES[values[i * channels + c]];
    means[i] = (sum * scale) / channels;
  }
  return means;
}

/** Returns the 99 % quantile of the absolute nonzero values; 1 if all are 0. */
function typicalSize(values) {
  const step = Math.max(1, Math.floor(values.length / 20000));
  const sizes = [];
  for (let i = 0; i < values.length; i += step) {
    const size = Math.abs(values[i]);
    if (size > 0 && Number.isFinite(size)) sizes.push(size);
  }
  sizes.sort((a, b) => a - b);
  return sizes.length ? sizes[Math.floor(0.99 * (sizes.length - 1))] : 1;
}

/** Returns the length of the vector at each pixel of a frame. */
function vectorLengths(frame) {
  const { channels, scale, values } = frame;
  const lengths = new Float32Array(values.length / channels);
  for (let i = 0; i < lengths.length; i++) {
    const at = i * channels;
    lengths[i] = scale * Math.hypot(...Array.from(values.subarray(at, at + channels), (bits) => HALF_VALUES[bits]));
  }
  return lengths;
}

/** Layers with red, green and blue, to which exposure and tone curve apply. */
const COLOR_LAYERS = ["picture", "direct", "indirect", "caustic"];

/** Returns an RGB colour in bytes for an ID: black for 0, else unlike those of neighbouring IDs. */
function numberColor(number) {
  if (!number) return [0, 0, 0];
  // Multiples of the golden ratio spread the hues.
  const hue = 6 * ((number * 0.618034) % 1);
  const light = 150 + 35 * (number % 4);
  return [0, 4, 2].map((offset) => Math.round(light * clamp(Math.abs(((hue + offset) % 6) - 3) - 1)) + 40);
}

/** Draws vectors as RGB colours: normals from −1 to 1, others from each component's least to largest value. */
function drawVectors(bytes, frame, isNormal) {
  const { scale, values } = frame;
  const [low, high] = [[-1, -1, -1], [1, 1, 1]];
  if (!isNormal) {
    low.fill(Infinity);
    high.fill(-Infinity);
    for (let i = 0; i < values.length; i++) {
      const value = HALF_VALUES[values[i]] * scale;
      if (value < low[i % 3]) low[i % 3] = value;
      if (value > high[i % 3]) high[i % 3] = value;
    }
  }
  for (let from = 0, to = 0; from < values.length; from += 3, to += 4) {
    for (let c = 0; c < 3; c++) {
      const value = HALF_VALUES[values[from + c]] * scale;
      bytes[to + c] = Math.round(255 * clamp((value - low[c]) / (high[c] - low[c] || 1)));
    }
    bytes[to + 3] = 255;
  }
}

/**
 * Draws a frame into a canvas of its size. `look` holds the layer, the exposure in stops and the tone
 * curve. Returns the range of values of the colour map and whether all values are 0; null for a layer
 * that is drawn without a colour map.
 */
function drawFrame(canvas, frame, look) {
  const { width, height, values } = frame;
  if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
  const context = canvas.getContext("2d");
  const image = context.createImageData(width, height);
  const bytes = image.data;
  let range = null;
  if (COLOR_LAYERS.includes(look.layer) || look.layer === "albedo") {
    const table = toneBytes(frame.scale * 2 ** look.exposure, look.tone);
    for (let from = 0, to = 0; from < values.length; from += 3, to += 4) {
      bytes[to] = table[values[from]];
      bytes[to + 1] = table[values[from + 1]];
      bytes[to + 2] = table[values[from + 2]];
      bytes[to + 3] = 255;
    }
  } else if (look.layer === "normal" || look.layer === "position") {
    drawVectors(bytes, frame, look.layer === "normal");
  } else if (NUMBER_LAYERS.includes(look.layer)) {
    for (let i = 0; i < values.length; i++) {
      bytes.set([...numberColor(values[i]), 255], 4 * i);
    }
  } else {
    const isSigned = look.layer === "bias";
    const means = look.layer === "motion" ? vectorLengths(frame) : channelMeans(frame);
    const ramp = isSigned ? DIVERGING : SEQUENTIAL;
    const most = typicalSize(means) * 2 ** -look.exposure;
    range = { low: isSigned ? -most : 0, high: most, ramp, isZero: means.every((mean) => mean === 0) };
    for (let i = 0; i < means.length; i++) {
      const t = (means[i] - range.low) / (range.high - range.low);
      const at = 3 * Math.round(255 * clamp(Number.isNaN(t) ? 0 : t));
      bytes[4 * i] = ramp[at];
      bytes[4 * i + 1] = ramp[at + 1];
      bytes[4 * i + 2] = ramp[at + 2];
      bytes[4 * i + 3] = 255;
    }
  }
  context.putImageData(image, 0, 0);
  return range;
}
