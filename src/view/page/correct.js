// Corrections by click: what is wrong, then the places; the server writes them into the study's file of corrections.
// A field is a place on a root: any of it ("whole": the one that is farthest from all other roots), where the click was ("here": where it runs alone),
// or the nearer end ("end").
const TOOLS = {
  remove: [["at", "whole", "the root that goes, with all that springs from it"]],
  "remove-stretch": [["from", "here", "where the stretch begins"], ["to", "here", "where it ends, on the same root"]],
  cut: [["at", "here", "where the root ends"]],
  join: [["from", "end", "a root near the end to join"], ["to", "end", "the root to join it with, near its end"]],
  parent: [["at", "whole", "the root that hangs wrong"], ["parent", "here", "the place on its parent"]],
  order: [["at", "whole", "the root that has the order below"]],
  base: [["at", "end", "a root near the end that is the plant's base"]],
  checked: [["at", "whole", "the root that is right"]],
};
const TIES = {
  parent: [["parent", "here", "the place that the new root springs from"]],
  continues: [["continues", "end", "the root that goes on in the new one, near its end"]],
  none: [],
};
const ALONE_MM = 0.5;
let tool = null, awaited = null, told = null;
data.places = [];
TRACE.places = 3 + moreTraces.push(placesTrace);

// The places that are given so far.
function placesTrace() {
  const axis = (n, sign) => data.places.map((place) => sign * place[n]);
  return { type: "scatter3d", mode: "markers", x: axis(0, 1), y: axis(1, -1), z: axis(2, -1), marker: { size: 7, color: "#ffffff", symbol: "cross", line: { width: 0 } }, hoverinfo: "skip" };
}

function markPlaces(places) {
  if (!places.length && !data.places.length) return;
  data.places = places;
  change({ places: places.length });
}

const placeOf = (root, k) => root.xyz.slice(3 * k, 3 * k + 3);
const endOf = (root, k) => placeOf(root, k < root.d.length / 2 ? 0 : root.d.length - 1);

// From a point of a root to the nearest line of another, mm.
function aloneMm(root, k) {
  const [x, y, z] = placeOf(root, k);
  let least = Infinity;
  for (const other of data.roots) {
    if (other === root) continue;
    for (let n = 0; n + 1 < other.d.length; n++) {
      const [a, b] = [placeOf(other, n), placeOf(other, n + 1)], along = b.map((v, c) => v - a[c]), off = [x - a[0], y - a[1], z - a[2]];
      const dot = (u, v) => u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
      const t = Math.min(1, Math.max(0, dot(off, along) / (dot(along, along) || 1)));
      least = Math.min(least, Math.hypot(...off.map((v, c) => v - t * along[c])));
    }
  }
  return least;
}

// The point of a root that is farthest from all others: there nothing else can be meant.
function clearPlace(root) {
  const alone = root.d.map((_, k) => aloneMm(root, k));
  return placeOf(root, alone.indexOf(Math.max(...alone)));
}

// The point of a root nearest to the clicked one where it runs alone: where roots meet, a place does not tell which is meant.
function herePlace(root, k) {
  const nearest = root.d.map((_, n) => n).sort((a, b) => Math.abs(a - k) - Math.abs(b - k));
  return placeOf(root, nearest.find((n) => aloneMm(root, n) > ALONE_MM) ?? k);
}

const nextField = () => tool && tool.fields.find(([field]) => !(field in tool.entry));

function tellTool(text) {
  const field = nextField(), said = $("correct-told");
  said.textContent = text || (field ? `Click ${field[2]}.` : "");
  said.hidden = !said.textContent;
  document.querySelectorAll("[data-correct]").forEach((b) => b.setAttribute("aria-pressed", Boolean(tool) && b.dataset.correct === tool.kind));
  $("correct-cancel").hidden = !tool;
  $("correct-chosen").disabled = !field || state.chosen === null || field[1] !== "whole";
}

function setTool(fresh) {
  tool = fresh;
  markPlaces([]);
  tellTool();
}

async function sendCorrection(entry) {
  const record = { by: $("correct-by").value.trim(), note: $("correct-note").value.trim() };
  setTool(null);
  try {
    tellTool("Written; computing…");
    awaited = (await ask("correct", { ...entry, ...Object.fromEntries(Object.entries(record).filter(([, text]) => text)) })).turn;
    $("correct-note").value = "";
    tellOutcome();
  } catch (error) {
    tellTool(`Not written: ${error.message}`);
  }
}

function givePlace(root, k) {
  const field = nextField();
  if (!field) return;
  tool.entry[field[0]] = { whole: clearPlace, here: herePlace, end: endOf }[field[1]](root, k);
  markPlaces(tool.fields.map(([name]) => tool.entry[name]).filter(Boolean));
  if (nextField()) return tellTool();
  const { kind, entry } = tool;
  sendCorrection({ kind, ...entry, ...(kind === "order" ? { order: Number($("correct-order").value) } : {}) });
}

// What became of the correction that was written last; news of it may come before the answer to who wrote it.
function tellOutcome(message) {
  if (message) told = { turn: message.turn, error: message.error, last: ((message.sections || {}).outcomes || []).at(-1) };
  if (awaited === null || !told || told.turn < awaited) return;
  awaited = null;
  const { error, last } = told;
  tellTool(error ? `Not computed: ${error}` : last ? `${last.applied ? "Done" : "Not applied"}: ${last.kind}: ${last.found}.` : "");
}

function tieCorrect() {
  if (live.readOnly) return $("correct").remove();
  // What to click is told where it is clicked.
  scene.before($("correct-told"));
  document.querySelectorAll("[data-correct]").forEach((button) => button.addEventListener("click", () => {
    const { correct: kind } = button.dataset;
    if (tool && tool.kind === kind) return setTool(null);
    showRoots();
    if (kind === "add") return beginAdding();
    setTool({ kind, fields: TOOLS[kind], entry: {} });
    const { top } = scene.getBoundingClientRect();
    if (top < 0 || top > innerHeight / 2) $("correct-told").scrollIntoView();
  }));
  $("correct-cancel").addEventListener("click", () => setTool(null));
  $("correct-chosen").addEventListener("click", () => givePlace(rootOf.get(state.chosen), 0));
  clickRoot = (id, k) => {
    choose(id);
    if (tool) givePlace(rootOf.get(id), k);
  };
  onChange((what) => what.includes("chosen") && tool && tellTool());
  // Places of roots that were computed anew are no places of theirs.
  onChange((what) => what.includes("roots") && tool && setTool(tool.kind === "add" ? tool : { ...tool, entry: {} }));
  document.querySelectorAll("[data-undo]").forEach((button) => button.addEventListener("click", () => setTool(null)));
  tieAdding();
  tellTool();
}
