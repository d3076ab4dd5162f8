// The picture: zoom, pan, comparison, values under the pointer.

const LAYER_NAMES = {
  picture: "Picture",
  direct: "Direct light",
  indirect: "Indirect light",
  caustic: "Caustic light",
  noise: "Noise",
  bias: "Bias",
  "radius.caustic": "Radius, caustic",
  "radius.global": "Radius, global",
  "photons.caustic": "Photons, caustic",
  "photons.global": "Photons, global",
  albedo: "Albedo",
  normal: "Normal",
  depth: "Depth",
  position: "Position",
  object: "Object",
  material: "Material",
  motion: "Motion",
};

/** Units of the maps' values. */
const LAYER_UNITS = {
  noise: "W/(m² sr)",
  bias: "W/(m² sr)",
  "radius.caustic": "units of length",
  "radius.global": "units of length",
  "photons.caustic": "photons",
  "photons.global": "photons",
  depth: "units of length",
  motion: "pixels",
};

/** Layers with properties of the visible surfaces. The program renders them on request. */
const SURFACE_LAYERS = ["albedo", "normal", "depth", "position", "object", "material", "motion"];

const viewer = {
  layer: "picture",
  tone: "srgb",
  exposure: 0,
  /** Size of the full picture; a preview is drawn at this size too. */
  size: [0, 0],
  /** The newest frame, with the canvas in which it is drawn. */
  shown: null,
  /** Pictures to compare with, by name. */
  others: {},
  other: "",
  mode: "none",
  /** Position of the divider in the stage, from 0 to 1. */
  divider: 0.5,
  /** Zoom in CSS pixels per picture pixel; null to fit the picture into the stage. */
  zoom: null,
  /** Picture point at the center of the stage. */
  center: null,
  pointer: null,
};

const stage = byId("stage");
const canvas = byId("canvas");
const look = (layer) => ({ layer, exposure: viewer.exposure, tone: viewer.tone });

/** Returns the zoom, the picture point at the center, and the zoom that fits the picture in. */
function view() {
  const [width, height] = viewer.size;
  const { clientWidth, clientHeight } = stage;
  const fit = Math.min(clientWidth / width, clientHeight / height);
  return { zoom: viewer.zoom || fit, center: viewer.zoom ? viewer.center : [width / 2, height / 2], fit };
}

/** Returns the picture point that is shown at a point of the stage. */
function pictureAt(x, y) {
  const { zoom, center } = view();
  return [center[0] + (x - stage.clientWidth / 2) / zoom, center[1] + (y - stage.clientHeight / 2) / zoom];
}

/** Multiplies the zoom, and keeps the picture point at stage point (x, y) where it is. */
function zoomBy(factor, x = stage.clientWidth / 2, y = stage.clientHeight / 2) {
  const { zoom, fit } = view();
  setZoom(Math.min(Math.max(zoom * factor, Math.min(fit, 1) / 4), 64), x, y);
}

function setZoom(zoom, x = stage.clientWidth / 2, y = stage.clientHeight / 2) {
  const [px, py] = pictureAt(x, y);
  viewer.zoom = zoom;
  viewer.center = [px - (x - stage.clientWidth / 2) / zoom, py - (y - stage.clientHeight / 2) / zoom];
  paint();
}

function panBy(dx, dy) {
  const { zoom, center } = view();
  viewer.zoom = zoom;
  viewer.center = [center[0] - dx / zoom, center[1] - dy / zoom];
  paint();
}

/** Returns the picture to compare with, if it shows the same layer; else null. */
function otherPicture() {
  const other = viewer.others[viewer.other];
  return other && viewer.shown && other.layer === viewer.shown.layer ? other : null;
}

/** Draws the frame of a picture into its canvas, and stores the range of its colour map. */
function render(picture) {
  picture.range = drawFrame(picture.canvas, picture.frame, look(picture.layer));
  picture.key = JSON.stringify(look(picture.layer));
  return picture;
}

const makePicture = (frame, layer) => render({ frame, layer, canvas: document.createElement("canvas") });

let isPaintDue = false;

/** Schedules painting of the stage for the next refresh of the screen. */
function paint() {
  if (isPaintDue) return;
  isPaintDue = true;
  requestAnimationFrame(() => {
    isPaintDue = false;
    paintNow();
  });
}

function paintNow() {
  const ratio = devicePixelRatio || 1;
  const [width, height] = [Math.round(stage.clientWidth * ratio), Math.round(stage.clientHeight * ratio)];
  if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
  const context = canvas.getContext("2d");
  context.clearRect(0, 0, width, height);
  if (!viewer.shown) return;
  const { zoom, center } = view();
  // Whole pixels, so that a picture at 1:1 is shown exactly.
  const [left, top] = [width / 2 - center[0] * zoom * ratio, height / 2 - center[1] * zoom * ratio].map(Math.round);
  const drawPicture = (picture) => {
    if (picture.key !== JSON.stringify(look(picture.layer))) render(picture);
    context.imageSmoothingEnabled = picture.frame.width < viewer.size[0] || zoom * ratio < 1;
    context.drawImage(picture.canvas, left, top, viewer.size[0] * zoom * ratio, viewer.size[1] * zoom * ratio);
  };
  const other = otherPicture();
  const isSplit = other && viewer.mode === "split";
  drawPicture(other && viewer.mode === "flip" ? other : viewer.shown);
  if (isSplit) {
    const x = Math.round(viewer.divider * width);
    context.save();
    context.beginPath();
    context.rect(x, 0, width - x, height);
    context.clip();
    context.clearRect(x, 0, width - x, height);
    drawPicture(other);
    context.restore();
    context.fillStyle = "#fff";
    context.fillRect(x - 1, 0, 2, height);
    context.fillStyle = "#000";
    context.fillRect(x + 1, 0, 1, height);
  }
  showOverlay(other);
  showLegend();
  showValues();
  // Tests and scripts read these attributes to learn what the canvas shows.
  Object.assign(canvas.dataset, { layer: viewer.shown.layer, sequence: viewer.shown.frame.sequence, zoom });
}

function showOverlay(other) {
  const overlay = byId("overlay");
  const named = { pinned: "pinned", reference: "reference" }[viewer.other] || "";
  const texts = { flip: `showing: ${named}`, split: `now | ${named}` };
  const frame = viewer.shown.frame;
  let text = other ? texts[viewer.mode] || "" : "";
  if (viewer.layer !== viewer.shown.layer) text = `waiting for ${LAYER_NAMES[viewer.layer].toLowerCase()}`;
  if (!text && viewer.layer === "picture" && frame.width < viewer.size[0]) text = `preview, ${frame.width} × ${frame.height}`;
  if (!text && viewer.shown.range && viewer.shown.range.isZero) text = "0 everywhere";
  overlay.textContent = text;
  overlay.hidden = !text;
}

/** Shows the colours of a map and the values at their ends. */
function showLegend() {
  const { range } = viewer.shown;
  byId("legend").hidden = !range;
  if (!range) return;
  byId("legend-low").textContent = digits(range.low);
  byId("legend-high").textContent = `${digits(range.high)} ${LAYER_UNITS[viewer.shown.layer]}`;
  const context = byId("ramp").getContext("2d");
  const image = context.createImageData(128, 1);
  for (let i = 0; i < 128; i++) image.data.set([...range.ramp.subarray(6 * i, 6 * i + 3), 255], 4 * i);
  context.putImageData(image, 0, 0);
}

/** Shows the values of the pixel under the pointer, of both pictures. */
function showValues() {
  const output = byId("values");
  if (!viewer.pointer || !viewer.shown) {
    output.textContent = "\u00a0";
    return;
  }
  const [px, py] = pictureAt(...viewer.pointer).map(Math.floor);
  const [width, height] = viewer.size;
  if (px < 0 || py < 0 || px >= width || py >= height) {
    output.textContent = "\u00a0";
    return;
  }
  const valuesOf = (picture) => {
    const { frame } = picture;
    const [x, y] = [Math.floor((px * frame.width) / width), Math.floor((py * frame.height) / height)];
    const text = NUMBER_LAYERS.includes(picture.layer) ? String : digits;
    return pixelValues(frame, x, y).map((value) => text(value)).join("  ");
  };
  let text = `(${px}, ${py})  ${valuesOf(viewer.shown)}`;
  const other = otherPicture();
  if (other) text += `   ${viewer.other}: ${valuesOf(other)}`;
  output.textContent = text;
}

/** Shows a new frame of the layer. */
function showFrame(frame) {
  const old = viewer.shown;
  const reused = old && old.layer === viewer.layer ? old.canvas : document.createElement("canvas");
  viewer.shown = render({ frame, layer: viewer.layer, canvas: reused });
  paint();
}

/** Keeps the shown picture for comparison. */
function pinPicture() {
  if (!viewer.shown) return;
  viewer.others.pinned = makePicture(viewer.shown.frame, viewer.shown.layer);
  viewer.other = "pinned";
  listOthers();
  paint();
}

function listOthers() {
  const select = byId("other");
  const names = Object.keys(viewer.others);
  select.replaceChildren(...names.map((name) => element("option", { value: name }, name)));
  if (!names.length) select.append(element("option", { value: "" }, "nothing"));
  select.value = viewer.other;
  for (const id of ["other", "flip", "split"]) byId(id).disabled = !names.length;
}

function setMode(mode) {
  viewer.mode = viewer.mode === mode || !viewer.other ? "none" : mode;
  for (const id of ["flip", "split"]) byId(id).setAttribute("aria-pressed", String(viewer.mode === id));
  paint();
}

function setExposure(stops) {
  viewer.exposure = Math.min(Math.max(stops, -10), 10);
  byId("exposure").value = viewer.exposure;
  byId("exposure-value").textContent = `${viewer.exposure > 0 ? "+" : ""}${viewer.exposure}`;
  paint();
}

function setTone(tone) {
  viewer.tone = tone;
  byId("tone").value = tone;
  paint();
}

/** Handler of drags and wheel turns while they move the camera; null while they pan and zoom. */
let cameraDrag = null;

/** Connects pointer, wheel and buttons of the picture. */
function startViewer() {
  listOthers();
  new ResizeObserver(paint).observe(stage);
  const pointers = new Map();
  let isDividing = false;
  const isNearDivider = (x) => viewer.mode === "split" && otherPicture() && Math.abs(x - viewer.divider * stage.clientWidth) < 12;
  const at = (event) => {
    const box = stage.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  stage.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    stage.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, at(event));
    isDividing = isNearDivider(at(event)[0]);
    stage.classList.add("dragging");
  });
  stage.addEventListener("pointermove", (event) => {
    const [x, y] = at(event);
    viewer.pointer = [x, y];
    stage.classList.toggle("splitting", Boolean(isNearDivider(x)));
    const old = pointers.get(event.pointerId);
    if (!old) {
      showValues();
      return;
    }
    if (pointers.size === 2) {
      const [fixed] = [...pointers].filter(([id]) => id !== event.pointerId).map(([, point]) => point);
      const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);
      zoomBy(distance([x, y], fixed) / Math.max(distance(old, fixed), 1), ...fixed);
    } else if (isDividing) {
      viewer.divider = Math.min(Math.max(x / stage.clientWidth, 0), 1);
      paint();
    } else if (cameraDrag) {
      cameraDrag.drag(x - old[0], y - old[1]);
    } else {
      panBy(x - old[0], y - old[1]);
    }
    pointers.set(event.pointerId, [x, y]);
  });
  const release = (event) => {
    pointers.delete(event.pointerId);
    if (!pointers.size) stage.classList.remove("dragging");
  };
  stage.addEventListener("pointerup", release);
  stage.addEventListener("pointercancel", release);
  stage.addEventListener("pointerleave", () => {
    viewer.pointer = null;
    showValues();
  });
  stage.addEventListener("wheel", (event) => {
    event.preventDefault();
    const amount = Math.min(Math.max(event.deltaY * (event.deltaMode ? 16 : 1), -100), 100);
    if (cameraDrag) cameraDrag.wheel(amount);
    else zoomBy(2 ** (-amount / 150), ...at(event));
  }, { passive: false });
  byId("zoom-in").addEventListener("click", () => zoomBy(2));
  byId("zoom-out").addEventListener("click", () => zoomBy(0.5));
  byId("zoom-fit").addEventListener("click", fitPicture);
  byId("zoom-one").addEventListener("click", () => setZoom(1 / (devicePixelRatio || 1)));
  byId("pin").addEventListener("click", pinPicture);
  byId("flip").addEventListener("click", () => setMode("flip"));
  byId("split").addEventListener("click", () => setMode("split"));
  byId("other").addEventListener("change", (event) => {
    viewer.other = event.target.value;
    paint();
  });
  byId("exposure").addEventListener("input", (event) => setExposure(Number(event.target.value)));
  byId("tone").addEventListener("change", (event) => setTone(event.target.value));
}

function fitPicture() {
  viewer.zoom = null;
  paint();
}
