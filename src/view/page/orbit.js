// Movement of the camera.

/** Camera position relative to the scene file: angles in radians, and ln of the relative distance. */
const cameraPosition = { yaw: 0, pitch: 0, zoom: 0 };
const RADIANS_PER_PIXEL = 0.006;
let isMoveDue = false;
let lastMove = -Infinity;

/** Sends the camera position to the program, at most twelve times a second. */
function sendPosition() {
  lastMove = performance.now();
  if (isMoveDue) return;
  isMoveDue = true;
  setTimeout(() => {
    isMoveDue = false;
    post("orbit", cameraPosition);
  }, 80);
}

const orbitDrag = {
  drag(dx, dy) {
    cameraPosition.yaw -= dx * RADIANS_PER_PIXEL;
    cameraPosition.pitch -= dy * RADIANS_PER_PIXEL;
    sendPosition();
  },
  wheel(amount) {
    cameraPosition.zoom += amount / 400;
    sendPosition();
  },
};

function toggleOrbit() {
  if (byId("camera").hidden) return;
  cameraDrag = cameraDrag ? null : orbitDrag;
  byId("orbit").setAttribute("aria-pressed", String(Boolean(cameraDrag)));
  stage.classList.toggle("orbiting", Boolean(cameraDrag));
}

function resetCamera() {
  if (byId("camera").hidden) return;
  Object.assign(cameraPosition, { yaw: 0, pitch: 0, zoom: 0 });
  sendPosition();
}

/** Takes over the camera position of the program, unless the user moves the camera on this page. */
function takePosition(position) {
  if (performance.now() - lastMove > 2000) Object.assign(cameraPosition, position);
}
