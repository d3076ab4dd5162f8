// Text of the scene file, with its errors and warnings.

const MAX_LINES = 4000;

let sourceRevision = 0;

/** Fetches and shows the text of the scene, if there is a new version. */
async function showSource(state) {
  byId("problems").hidden = !state.problems;
  if (state.source_revision === sourceRevision) return;
  sourceRevision = state.source_revision;
  const response = await answer("source");
  const source = response ? await response.json().catch(() => null) : null;
  // A newer revision may have been asked for meanwhile.
  if (!source || sourceRevision !== state.source_revision) return;
  const place = (problem) => (problem.line ? `line ${problem.line}, column ${problem.column}: ` : "");
  byId("problem-list").replaceChildren(...source.problems.map((problem) =>
    element("li", {}, place(problem) + problem.message, element("small", {}, problem.remedy))));
  byId("warning-list").replaceChildren(...source.warnings.map((warning) => element("li", {}, warning)));
  byId("source-panel").hidden = !source.text && !source.warnings.length;
  const wrong = new Set(source.problems.map((problem) => problem.line));
  const lines = source.text.split("\n").slice(0, MAX_LINES);
  byId("source").hidden = !source.text;
  byId("source").replaceChildren(...lines.map((line, i) => {
    const shown = element("div", wrong.has(i + 1) ? { class: "wrong" } : {}, element("span", { class: "number" }, String(i + 1)), line);
    return shown;
  }));
  const first = byId("source").querySelector(".wrong");
  if (first) byId("source").scrollTop = first.offsetTop - byId("source").offsetTop - 60;
}
