// Connection to the program, keys and buttons.

let state = null;
let isFetching = false;

/** Returns the report of the newest frame that has the layer; null without one. */
function newestFrame() {
  if (SURFACE_LAYERS.includes(viewer.layer)) return state.surfaces;
  return COLOR_LAYERS.includes(viewer.layer) ? state.picture : state.maps;
}

/** Returns the sequence number of the newest frame that has the layer; 0 without one. */
function newestSequence() {
  const frame = newestFrame();
  return frame && frame.layers.includes(viewer.layer) ? frame.sequence : 0;
}

/** Fetches the bytes of a layer; null if there is no newer frame, or if the connection breaks. */
async function layerBytes(path) {
  const response = await answer(path);
  if (!response || response.status === 204) return null;
  return response.arrayBuffer().catch(() => null);
}

/** Fetches the newest frame of the layer. One request runs at a time. */
async function fetchFrame() {
  if (isFetching || !state) return;
  const layer = viewer.layer;
  const after = viewer.shown && viewer.shown.layer === layer ? viewer.shown.frame.sequence : 0;
  // A request for an error map makes the program render it again. A request for a surface layer
  // makes the program render the surface layers, if there are none.
  const isSurface = SURFACE_LAYERS.includes(layer);
  const isWish = isSurface ? !state.surfaces : !COLOR_LAYERS.includes(layer);
  if (!isWish && newestSequence() <= after) return;
  isFetching = true;
  const bytes = await layerBytes(`layer/${layer}?after=${after}`);
  if (bytes && layer === viewer.layer) showFrame(decodeFrame(bytes, layer));
  isFetching = false;
  const shown = viewer.shown && viewer.shown.layer === viewer.layer ? viewer.shown.frame.sequence : 0;
  if (viewer.layer !== layer || (newestSequence() > shown && newestSequence() > after)) setTimeout(fetchFrame, 50);
}

let isFetchingReference = false;

/** Fetches the reference picture once. */
async function fetchReference() {
  if (isFetchingReference || viewer.others.reference) return;
  isFetchingReference = true;
  const bytes = await layerBytes("layer/reference");
  if (bytes) {
    viewer.others.reference = makePicture(decodeFrame(bytes, "picture"), "picture");
    viewer.other = viewer.other || "reference";
    listOthers();
    paint();
  }
  isFetchingReference = false;
}

/** Lists the layers that exist. */
function listLayers() {
  const groups = state.picture ? state.picture.layers.filter((name) => name !== "picture") : [];
  const maps = state.maps ? state.maps.layers : state.curve.length ? ["noise"] : [];
  const surfaces = ["passes", "stopped", "ended"].includes(state.phase) ? SURFACE_LAYERS : [];
  const names = ["picture", ...maps, ...groups, ...surfaces];
  if (!names.includes(viewer.layer)) names.push(viewer.layer);
  const select = byId("layer");
  if (names.join() === Array.from(select.options, (option) => option.value).join()) return;
  select.replaceChildren(...names.map((name) => element("option", { value: name }, LAYER_NAMES[name])));
  select.value = viewer.layer;
}

function setLayer(layer) {
  viewer.layer = layer;
  byId("layer").value = layer;
  paint();
  fetchFrame();
}

function showState(next) {
  state = next;
  document.body.dataset.phase = state.phase;
  document.body.dataset.passes = state.passes;
  document.body.dataset.render = state.render;
  document.body.dataset.sequence = state.picture ? state.picture.sequence : 0;
  const name = state.scene.split(/[\\/]/).pop();
  document.title = `${name} – Caustica`;
  byId("scene").textContent = name;
  byId("scene").title = `${state.scene}, Caustica ${state.version}`;
  byId("status").textContent = statusText(state);
  byId("camera").hidden = !state.interactive;
  takePosition(state.orbit);
  const isPaused = state.phase === "stopped" || state.phase === "ended";
  byId("stop").textContent = isPaused && state.interactive ? "Resume" : "Stop";
  byId("stop").disabled = isPaused ? !state.interactive : state.phase !== "passes" && state.phase !== "pilots";
  const canSave = Boolean(state.picture && !state.picture.preview);
  byId("save-png").disabled = byId("save-exr").disabled = !canSave;
  if (state.size[0]) viewer.size = state.size;
  else if (state.picture && !viewer.size[0]) viewer.size = [state.picture.width, state.picture.height];
  listLayers();
  byId("error-text").textContent = errorText(state);
  showCurve(state);
  showPlan(state);
  showPhotons(state);
  showSource(state);
  fetchFrame();
  if (state.reference) fetchReference();
}

const post = (name, body) => answer(`request/${name}`, { method: "POST", body: body ? JSON.stringify(body) : "" });

function stopOrResume() {
  if (byId("stop").disabled) return;
  post(byId("stop").textContent === "Resume" ? "resume" : "stop");
}

/** Saves the newest picture as a file of the browser. */
function save(kind) {
  if (byId(`save-${kind}`).disabled) return;
  const link = element("a", { href: `save/picture.${kind}?exposure=${viewer.exposure}&tone=${viewer.tone}`, download: "" });
  document.body.append(link);
  link.click();
  link.remove();
}

function nextOption(id) {
  const select = byId(id);
  return select.options[(select.selectedIndex + 1) % select.options.length].value;
}

const ARROWS = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

const KEYS = {
  " ": stopOrResume,
  s: () => save("png"),
  e: () => save("exr"),
  l: () => setLayer(nextOption("layer")),
  "[": () => setExposure(viewer.exposure - 0.5),
  "]": () => setExposure(viewer.exposure + 0.5),
  t: () => setTone(nextOption("tone")),
  "+": () => zoomBy(2),
  "=": () => zoomBy(2),
  "-": () => zoomBy(0.5),
  0: fitPicture,
  1: () => setZoom(1 / (devicePixelRatio || 1)),
  p: pinPicture,
  f: () => setMode("flip"),
  d: () => setMode("split"),
  o: toggleOrbit,
  r: resetCamera,
  "?": () => byId("keys").showModal(),
};

document.addEventListener("keydown", (event) => {
  if (event.altKey || event.ctrlKey || event.metaKey || byId("keys").open) return;
  if (event.target.closest("select, input, pre, #panels")) return;
  if (event.key === " " && event.target.closest("button")) return;
  const arrow = ARROWS[event.key];
  if (arrow) {
    if (cameraDrag) cameraDrag.drag(-20 * arrow[0], -20 * arrow[1]);
    else panBy(40 * arrow[0], 40 * arrow[1]);
  } else if (KEYS[event.key]) {
    KEYS[event.key]();
  } else {
    return;
  }
  event.preventDefault();
});

byId("stop").addEventListener("click", stopOrResume);
byId("save-png").addEventListener("click", () => save("png"));
byId("save-exr").addEventListener("click", () => save("exr"));
byId("help").addEventListener("click", () => byId("keys").showModal());
byId("layer").addEventListener("change", (event) => setLayer(event.target.value));
byId("orbit").addEventListener("click", toggleOrbit);
byId("reset").addEventListener("click", resetCamera);
startViewer();

const events = new EventSource("events");
events.addEventListener("message", (event) => showState(JSON.parse(event.data)));
events.addEventListener("error", () => {
  const isOver = state && state.phase === "ended" && !state.interactive;
  byId("status").textContent = isOver ? `${statusText(state)} · the program has ended` : "the program does not answer";
  byId("stop").disabled = true;
});
