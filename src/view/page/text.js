// Helpers for elements, requests, and texts of numbers.

const byId = (id) => document.getElementById(id);

/** Makes an element with attributes and children. Texts are never read as HTML. */
function element(name, attributes, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes || {})) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

const SVG = "http://www.w3.org/2000/svg";

/** Makes an SVG element with attributes and a text. */
function svgElement(name, attributes, text) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  return made;
}

/** Fetches from the program. Returns null without a response of status 200 to 299. */
async function answer(path, options) {
  try {
    const response = await fetch(path, options);
    return response.ok ? response : null;
  } catch {
    return null;
  }
}

/** Returns the text of a number with three digits. */
function digits(value) {
  if (!Number.isFinite(value)) return String(value);
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e5 || size < 1e-3) return value.toExponential(2);
  return String(Number(value.toPrecision(3)));
}

/** Returns a relative error in percent; a no-break space keeps the sign with the number. */
function percent(value) {
  if (!Number.isFinite(value)) return "unknown";
  const hundredths = 100 * value;
  return `${hundredths >= 10 ? hundredths.toFixed(0) : hundredths >= 1 ? hundredths.toFixed(1) : digits(hundredths)}\u00a0%`;
}

/** Returns the text of a duration given in seconds. */
function duration(seconds) {
  if (seconds < 9.95) return `${seconds.toFixed(1)} s`;
  const whole = Math.round(seconds);
  if (whole < 60) return `${whole} s`;
  if (whole < 600) return `${Math.floor(whole / 60)} min ${whole % 60} s`;
  if (whole < 3600) return `${Math.floor(whole / 60)} min`;
  if (whole < 172800) return `${Math.floor(whole / 3600)} h ${Math.floor(whole / 60) % 60} min`;
  return `${Math.floor(whole / 86400)} d`;
}

/** Returns the text of a count in units, thousands, millions or billions. */
function count(value) {
  for (const [unit, letter] of [[1e9, "G"], [1e6, "M"], [1e3, "k"]]) {
    if (value >= unit) return `${digits(value / unit)} ${letter}`;
  }
  return String(Math.round(value));
}
