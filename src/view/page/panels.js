// Panels beside the picture: status, plan, photons and rays.

const END_REASONS = {
  passes: "all passes are made",
  time: "time was up",
  target: "the error is low enough",
  floor: "more passes cannot lower the error",
  interrupted: "stopped",
};

const PHASES = {
  loading: "reading the scene",
  failed: "the scene has errors",
  preview: "preview",
  pilots: "pilots",
  passes: "rendering",
  stopped: "stopped",
};

/** Returns a line about the state of the render. */
function statusText(state) {
  const parts = [];
  if (state.phase === "ended") parts.push(`ended: ${END_REASONS[state.ended] || "done"}`);
  else parts.push(PHASES[state.phase]);
  if (state.passes) {
    const of = state.pass_limit ? ` of ${state.pass_limit}` : "";
    parts.push(`pass ${state.passes}${of}`, duration(state.seconds));
    const last = state.curve[state.curve.length - 1];
    if (last) parts.push(`error ${percent(last.error)}`);
  }
  if (state.size[0]) parts.push(`${state.size[0]} × ${state.size[1]}`);
  parts.push(state.integrator);
  return parts.join(" · ");
}

let planShown = "";

/** Shows the plan with its reasons. */
function showPlan(state) {
  const text = JSON.stringify(state.plan);
  if (text === planShown) return;
  planShown = text;
  const host = byId("plan");
  if (!state.plan) {
    host.replaceChildren("after the pilots");
    return;
  }
  const rows = state.plan.effects.map((effect) => {
    const state = `${effect.on ? "on" : "off"}${effect.forced ? ", forced" : ""}`;
    const reason = element("td", {}, effect.reason);
    if (effect.flaw) reason.append(element("div", { class: "flaw" }, effect.flaw));
    return element("tr", { class: effect.on ? "on" : "off" }, element("th", { scope: "row" }, effect.name), element("td", {}, state), reason);
  });
  const notes = element("ul", {}, ...state.plan.notes.map((note) => element("li", {}, note.replaceAll(" %", "\u00a0%"))));
  host.replaceChildren(element("table", {}, element("tbody", {}, ...rows)), notes);
}

/** Shows counts and flux of photons, and counts of rays. */
function showPhotons(state) {
  const host = byId("photons");
  if (!state.passes) {
    host.replaceChildren("after the first pass");
    return;
  }
  const sum = (flux) => flux[0] + flux[1] + flux[2];
  const row = (label, ...cells) => element("tr", {}, element("th", { scope: "row" }, label), ...cells.map((cell) => element("td", { class: "n" }, cell)));
  const parts = [];
  const sets = [["all directions", state.unaimed], ["aimed", state.aimed]].filter(([, report]) => report.emitted);
  if (sets.length) {
    const reports = sets.map(([, report]) => report);
    const of = (flux) => (report) => (sum(report.audit.emitted) > 0 ? percent(sum(report.audit[flux]) / sum(report.audit.emitted)) : "–");
    const heads = sets.map(([name]) => element("th", { class: "n", scope: "col" }, name));
    parts.push(element("table", {},
      element("thead", {}, element("tr", {}, element("th", {}, "photon paths"), ...heads)),
      element("tbody", {},
        row("emitted", ...reports.map((r) => count(r.emitted))),
        row("stored photons", ...reports.map((r) => count(r.stored))),
        row("flux absorbed", ...reports.map(of("absorbed"))),
        row("flux escaped", ...reports.map(of("escaped"))),
        row("flux stopped", ...reports.map(of("stopped"))))));
  } else {
    parts.push(element("p", {}, "No photons are traced."));
  }
  const { counters } = state;
  const rays = [["camera rays", "camera_rays"], ["continuation rays", "continuation_rays"], ["shadow rays", "shadow_rays"],
    ["photon rays", "photon_rays"], ["density estimates", "gathers"], ["photons in estimates", "gathered_photons"]];
  const rate = (n) => (state.seconds > 0 ? `${count(n / state.seconds)}/s` : "–");
  const rows = rays.filter(([, key]) => counters[key]).map(([name, key]) => row(name, count(counters[key]), rate(counters[key])));
  parts.push(element("table", {}, element("tbody", {}, ...rows)));
  host.replaceChildren(...parts);
}
