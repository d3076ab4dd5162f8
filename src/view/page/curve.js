// The curve of the estimated error against time, with its forecast.

const PLOT = { width: 400, height: 230, left: 44, right: 10, top: 10, bottom: 30 };

/** Tick values within a range: 1, 2 and 5 times powers of ten, or finer steps if these are too few. */
function ticks(low, high) {
  const within = (steps) => {
    const found = [];
    for (let power = Math.floor(Math.log10(low)); power <= Math.ceil(Math.log10(high)); power++) {
      const values = steps.map((step) => step * 10 ** power);
      found.push(...values.filter((value) => value >= low * 0.999 && value <= high * 1.001));
    }
    return found;
  };
  const found = within([1, 2, 5]);
  if (found.length < 2) return within([1, 1.5, 2, 2.5, 3, 4, 5, 6, 7, 8, 9]);
  const powers = within([1]);
  return found.length > 8 && powers.length > 1 ? powers : found;
}

/** Tick values [s] of the time axis within a range: round numbers of seconds, minutes or hours. */
function timeTicks(low, high) {
  const units = [[1, low, Math.min(high, 59)], [60, Math.max(low, 60), Math.min(high, 3599)], [3600, Math.max(low, 3600), high]];
  return units.flatMap(([unit, from, to]) => {
    if (from > to) return [];
    const round = unit < 3600 ? [30, ...ticks(from / unit, to / unit).filter((value) => value < 50)] : ticks(from / unit, to / unit);
    return [...new Set(round)].map((value) => value * unit).filter((t) => t >= from && t <= to).sort((a, b) => a - b);
  });
}

function timeTick(seconds) {
  if (seconds < 60) return `${digits(seconds)} s`;
  if (seconds < 3600) return `${digits(seconds / 60)} min`;
  return `${digits(seconds / 3600)} h`;
}

/** Draws the error curve of a render state into its panel. */
function showCurve(state) {
  const { curve, forecast } = state;
  const host = byId("curve");
  if (!curve.length) {
    host.replaceChildren();
    return;
  }
  const last = curve[curve.length - 1];
  const passSeconds = last.seconds / last.passes;
  const predicted = forecast ? forecast.curve.map(([passes, error]) => [passes * passSeconds, error]) : [];
  const times = [...curve.map((p) => p.seconds), ...predicted.map((p) => p[0])].filter((t) => t > 0);
  // Parts below a tenth of the error would flatten the rest of the curve.
  const sizes = curve.flatMap((p) => [p.error, p.high, ...[p.low, p.noise, p.bias].filter((part) => part >= p.error / 10)]);
  if (forecast) sizes.push(forecast.target, ...predicted.map((p) => p[1]));
  const positive = sizes.filter((e) => e > 0 && Number.isFinite(e));
  if (!positive.length || !times.length) {
    host.replaceChildren();
    return;
  }
  const [t0, t1] = [Math.min(...times) * 0.9, Math.max(...times) * 1.1];
  const [e0, e1] = [Math.min(...positive) * 0.8, Math.max(...positive) * 1.25];
  const x = (t) => PLOT.left + (Math.log(t / t0) / Math.log(t1 / t0)) * (PLOT.width - PLOT.left - PLOT.right);
  const y = (e) => PLOT.top + (Math.log(e1 / Math.max(e, e0)) / Math.log(e1 / e0)) * (PLOT.height - PLOT.top - PLOT.bottom);
  const path = (points) => points.map(([t, e], i) => `${i ? "L" : "M"}${x(t).toFixed(1)} ${y(e).toFixed(1)}`).join("");
  const svg = svgElement("svg", { viewBox: `0 0 ${PLOT.width} ${PLOT.height}`, role: "img", "aria-label": "Estimated error against time" });
  for (const value of ticks(e0, e1)) {
    svg.append(svgElement("line", { class: "grid", x1: PLOT.left, x2: PLOT.width - PLOT.right, y1: y(value), y2: y(value) }));
    svg.append(svgElement("text", { x: PLOT.left - 5, y: y(value) + 4, "text-anchor": "end" }, percent(value)));
  }
  let free = -Infinity;
  const round = timeTicks(t0, t1).filter((value) => x(value) <= PLOT.width - 18);
  for (const value of round.length ? round : [Math.sqrt(t0 * t1)]) {
    svg.append(svgElement("line", { class: "grid", x1: x(value), x2: x(value), y1: PLOT.top, y2: PLOT.height - PLOT.bottom }));
    if (x(value) < free) continue;
    free = x(value) + 46;
    svg.append(svgElement("text", { x: x(value), y: PLOT.height - PLOT.bottom + 18, "text-anchor": "middle" }, timeTick(value)));
  }
  const points = (key) => curve.filter((p) => p[key] >= e0 && p.seconds > 0).map((p) => [p.seconds, p[key]]);
  const [high, low] = [points("high"), curve.filter((p) => p.high > 0).map((p) => [p.seconds, Math.max(p.low, e0)])];
  if (high.length > 1) svg.append(svgElement("path", { class: "band", d: `${path(high)}L${path(low.reverse()).slice(1)}Z` }));
  for (const key of ["bias", "noise", "error"]) svg.append(svgElement("path", { class: key, d: path(points(key)) }));
  if (forecast) {
    svg.append(svgElement("path", { class: "forecast", d: path(predicted.filter((p) => p[1] > 0)) }));
    const level = y(forecast.target);
    svg.append(svgElement("line", { class: "target", x1: PLOT.left, x2: PLOT.width - PLOT.right, y1: level, y2: level }));
    const [from, middle, to] = forecast.passes.map((passes) => (passes === null ? null : passes * passSeconds));
    if (middle !== null) {
      const end = to === null ? PLOT.width - PLOT.right : x(to);
      svg.append(svgElement("line", { class: "range", x1: x(Math.max(from, t0)), x2: end, y1: level, y2: level }));
    }
  }
  svg.append(svgElement("circle", { class: "dot", cx: x(last.seconds), cy: y(last.error), r: 3.5 }));
  const key = element("div", { class: "key" }, element("span", { class: "e" }, "error"), element("span", { class: "i" }, "its interval"), element("span", { class: "n" }, "noise"), element("span", { class: "b" }, "bias"));
  if (forecast) key.append(element("span", { class: "f" }, "forecast"), element("span", { class: "t" }, "target, when expected"));
  host.replaceChildren(svg, key);
}

/** Returns a sentence about the newest error estimate and its forecast. */
function errorText(state) {
  const { curve, forecast } = state;
  if (!curve.length) return state.phase === "passes" ? "after four passes" : "not estimated yet";
  const last = curve[curve.length - 1];
  let text = `${percent(last.error)} after ${last.passes} passes (noise ${percent(last.noise)}, bias ${percent(last.bias)}); `
    + `the true error is probably between ${percent(last.low)} and ${percent(last.high)}.`;
  if (!forecast || state.phase === "ended") return text;
  const passSeconds = last.seconds / last.passes;
  const left = (passes) => duration(Math.max(passes - last.passes, 0) * passSeconds);
  const [low, median, high] = forecast.passes;
  const target = percent(forecast.target);
  if (forecast.floor !== null) text += ` ${target} is never reached: ${percent(forecast.floor)} is bias that stays.`;
  else if (median === null) text += ` ${target}: cannot tell yet, at least ${left(low)}.`;
  else text += ` ${target} is expected in ${left(median)} (${high === null ? `at least ${left(low)}` : `${left(low)} to ${left(high)}`}).`;
  return text;
}
