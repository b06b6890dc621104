// The views in space, one per result, linked: they have one camera, and a root that is chosen is marked in all that have it.
const MANY_POINTS = 12000;
const state = { chosen: null, colour: "fate", tank: true };
const TRACE = { roots: 0, tank: 1, chosen: 2 };
const views = data.results.map((result, n) => ({ n, result, scene: $(`view-${n}`), mesh: null, bright: emptyMesh(), under: null, drawn: false }));
const tubeSides = data.results.some((result) => result.roots.reduce((sum, root) => sum + root.d.length, 0) > MANY_POINTS) ? 4 : 6;
let camera = HOME;

function rootsTrace(view) {
  const { roots } = view.result;
  if (!view.mesh) {
    view.mesh = emptyMesh();
    // A tube tells its root by the place in the list.
    roots.forEach((root, place) => addTube(view.mesh, { ...root, id: place }, tubeSides));
  }
  const colours = roots.map((root) => [...rgb(state.colour === "order" ? root.orderColour : data.fates[root.fate].colour), 1]);
  const { x, y, z, i, j, k, root } = view.mesh;
  return { type: "mesh3d", x, y, z, i, j, k, vertexcolor: root.map((place) => colours[place]), lighting: LIGHTING, flatshading: false, hoverinfo: "none" };
}

// The chosen root as a bright tube a little wider than itself.
function chosenTrace(view) {
  const place = marks()[view.n], root = place === null ? null : view.result.roots[place];
  view.bright = emptyMesh();
  if (root) addTube(view.bright, { ...root, id: place }, 8, Math.max(0.35, data.tank.radius / 200));
  const { x, y, z, i, j, k } = view.bright;
  return { type: "mesh3d", x, y, z, i, j, k, color: "#ffffff", hoverinfo: "none", lighting: { ambient: 1, diffuse: 0 }, visible: Boolean(root) };
}

const tracesOf = (view) => [rootsTrace(view), tankTrace(view.result.tank, state.tank), chosenTrace(view)];
// A narrow view has no room for depths.
const LEAST_PX = 260;
const layoutOf = (view) => sceneLayout(structuredClone(camera), depthMarks(view.result.tank, state.tank && view.scene.clientWidth > LEAST_PX));

const alike = (a, b) => ["eye", "center", "up"].every((part) => ["x", "y", "z"].every((axis) => Math.abs(a[part][axis] - b[part][axis]) < 1e-6));

// All views from one camera.
function look(from) {
  camera = structuredClone(from);
  for (const view of views) {
    if (view.drawn && !alike(view.scene.layout.scene.camera, camera)) Plotly.relayout(view.scene, { "scene.camera": structuredClone(camera) });
  }
}

let wanted = null;
function follow(event) {
  const given = event["scene.camera"];
  // What a view was told by another comes back from it.
  if (!given || alike(given, camera)) return;
  if (!wanted) requestAnimationFrame(() => { look(wanted); wanted = null; });
  wanted = given;
}

async function drawView(view) {
  await Plotly.newPlot(view.scene, tracesOf(view), layoutOf(view), { displayModeBar: false, responsive: true, scrollZoom: true, doubleClick: false });
  view.scene.querySelector(".sketch").remove();
  view.drawn = true;
  view.scene.on("plotly_relayouting", follow);
  view.scene.on("plotly_relayout", follow);
  view.scene.on("plotly_hover", (event) => {
    const { curveNumber, pointNumber } = event.points[0], mesh = { [TRACE.roots]: view.mesh, [TRACE.chosen]: view.bright }[curveNumber];
    view.under = mesh ? mesh.root[pointNumber] : null;
    if (view.under !== null) tell(view.n, view.under);
  });
  view.scene.on("plotly_unhover", () => (view.under = null));
  let down = null;
  view.scene.addEventListener("pointerdown", (event) => (down = [event.clientX, event.clientY]), true);
  view.scene.addEventListener("pointerup", (event) => {
    const still = down && Math.hypot(event.clientX - down[0], event.clientY - down[1]) < 5 && event.button === 0;
    // What lies under a finger is known a frame later only.
    if (still) setTimeout(() => view.under !== null && change({ chosen: entryOf(view.n, view.under) }), event.pointerType === "touch" ? 120 : 0);
  }, true);
}

function drawLegend() {
  $("legend").replaceChildren();
  if (state.colour === "fate") {
    data.fates.forEach(({ colour, about }) => $("legend").append(legendKey(colour, about)));
    if (views.length > 2) $("legend").append("In A: the greatest difference to any other.");
    return;
  }
  const roots = data.results.flatMap((result) => result.roots);
  for (const order of [...new Set(roots.map((root) => root.order))].sort((a, b) => a - b)) {
    $("legend").append(legendKey(roots.find((root) => root.order === order).orderColour, `order ${order}`));
  }
}

const KEYS = {
  ArrowLeft: () => look(turned(camera, "left")), ArrowRight: () => look(turned(camera, "right")),
  ArrowUp: () => look(turned(camera, "up")), ArrowDown: () => look(turned(camera, "down")),
  "+": () => look(turned(camera, "in")), "=": () => look(turned(camera, "in")), "-": () => look(turned(camera, "out")),
  Home: () => look(HOME), ",": () => stepRow(-1), ".": () => stepRow(1),
};

function tieViews() {
  document.querySelectorAll("[data-turn]").forEach((b) => b.addEventListener("click", () => look(turned(camera, b.dataset.turn))));
  document.querySelectorAll("[data-view]").forEach((b) => b.addEventListener("click", () => look(b.dataset.view === "top" ? TOP : HOME)));
  $("colour").addEventListener("change", (event) => change({ colour: event.target.value }));
  $("tank").addEventListener("change", (event) => change({ tank: event.target.checked }));
  for (const { scene } of views) {
    scene.addEventListener("keydown", (event) => {
      const does = !event.ctrlKey && !event.metaKey && !event.altKey && KEYS[event.key];
      if (does) event.preventDefault(), does();
    });
  }
  onChange((what) => {
    drawLegend();
    for (const view of views.filter((view) => view.drawn)) {
      const { data: old } = view.scene, fresh = { chosen: chosenTrace, tank: () => tankTrace(view.result.tank, state.tank), colour: rootsTrace };
      const traces = [what.includes("colour") ? fresh.colour(view) : old[0], what.includes("tank") ? fresh.tank() : old[1], what.includes("chosen") ? fresh.chosen(view) : old[2]];
      Plotly.react(view.scene, traces, layoutOf(view));
    }
  });
}
