// The view in space: plotly.js draws, this turns it by buttons and keys and finds the root under the pointer.
const MANY_POINTS = 12000;
const sides = data.roots.reduce((sum, root) => sum + root.d.length, 0) > MANY_POINTS ? 4 : 6;
// A live page adds its own traces after these.
const TRACE = { roots: 0, tank: 1, repairs: 2, chosen: 3 };
const moreTraces = [];
let clickRoot = (id) => choose(id);
let mesh = emptyMesh(), bright = emptyMesh(), line = null, under = null, drawn = false;
const scene = $("view3d");

function rootsTrace() {
  if (state.shape === "tubes") {
    if (!mesh.x.length) data.roots.forEach((root) => addTube(mesh, root, sides));
    const { x, y, z, i, j, k } = mesh;
    const of = new Map(data.roots.map((root) => [root.id, pointColours(root)]));
    const colours = mesh.root.map((id, n) => [...of.get(id)[mesh.point[n]], 1]);
    return { type: "mesh3d", x, y, z, i, j, k, vertexcolor: colours, lighting: LIGHTING, flatshading: false, hoverinfo: "none" };
  }
  line = { x: [], y: [], z: [], root: [], point: [] };
  const colours = [];
  for (const root of data.roots) {
    pointColours(root).forEach((colour, k) => {
      const [x, y, z] = placed(root.xyz, k);
      line.x.push(x), line.y.push(y), line.z.push(z), line.root.push(root.id), line.point.push(k), colours.push(css(colour));
    });
    line.x.push(null), line.y.push(null), line.z.push(null), line.root.push(null), line.point.push(null), colours.push("#000");
  }
  return { type: "scatter3d", mode: "lines", x: line.x, y: line.y, z: line.z, line: { width: 4, color: colours }, hoverinfo: "none" };
}

function repairsTrace() {
  const place = (axis, sign) => data.repairs.map((repair) => sign * repair.at[axis]);
  return {
    type: "scatter3d", mode: "markers", x: place(0, 1), y: place(1, -1), z: place(2, -1), visible: state.colour === "repair",
    marker: { size: 3.5, color: data.repairs.map((repair) => KINDS[repair.kind]), line: { width: 0 }, opacity: 0.9 }, hoverinfo: "none",
  };
}

// The chosen root as a bright tube a little wider than itself.
function chosenTrace() {
  const root = rootOf.get(state.chosen);
  bright = emptyMesh();
  if (root) addTube(bright, root, 8, Math.max(0.35, data.tank.radius / 200));
  const { x, y, z, i, j, k } = bright;
  return { type: "mesh3d", x, y, z, i, j, k, color: "#ffffff", hoverinfo: "none", lighting: { ambient: 1, diffuse: 0 }, visible: Boolean(root) };
}

const traces = () => [rootsTrace(), tankTrace(data.tank, state.tank), repairsTrace(), chosenTrace(), ...moreTraces.map((trace) => trace())];

// The drawing from the side stands in the view's place until it is drawn.
function sketchSpace() {
  const side = document.querySelector("#space .paper svg").cloneNode(true);
  side.setAttribute("aria-hidden", "true");
  scene.append(make("div", { class: "sketch" }, side));
}

async function drawSpace() {
  startLibrary();
  await Plotly.newPlot(scene, traces(), layout(), { displayModeBar: false, responsive: true, scrollZoom: true, doubleClick: false });
  scene.querySelector(".sketch").remove();
  drawn = true;
  scene.on("plotly_hover", (event) => {
    under = found(event.points[0]);
    tell(under);
  });
  scene.on("plotly_unhover", () => (under = null));
  let down = null;
  scene.addEventListener("pointerdown", (event) => (down = [event.clientX, event.clientY]), true);
  scene.addEventListener("pointerup", (event) => {
    const still = down && Math.hypot(event.clientX - down[0], event.clientY - down[1]) < 5 && event.button === 0;
    // What lies under a finger is known a frame later only.
    if (still) setTimeout(() => under && under.id !== undefined && clickRoot(under.id, under.k), event.pointerType === "touch" ? 120 : 0);
  }, true);
}

// What a point of a trace is: a root with a point, or a repair.
function found(point) {
  if (point.curveNumber === TRACE.repairs) return { repair: data.repairs[point.pointNumber] };
  const of = { [TRACE.roots]: state.shape === "tubes" ? mesh : line, [TRACE.chosen]: bright }[point.curveNumber];
  return of ? { id: of.root[point.pointNumber], k: of.point[point.pointNumber] } : null;
}

function tell(what) {
  if (!what) return;
  if (what.repair) {
    $("view3d-help").textContent = `${data.kinds[what.repair.kind].name}: ${what.repair.why}` + (what.repair.mm ? ` (${what.repair.mm} mm)` : "");
    return;
  }
  const root = rootOf.get(what.id), k = what.k;
  if (!root) return;
  $("view3d-help").textContent =
    `Root ${root.id}, order ${root.order}: diameter ${root.d[k].toFixed(2)} ± ${root.sd[k].toFixed(2)} mm in ${root.views[k]} photographs, ` +
    `${depthOf(root.xyz[3 * k + 2]).toFixed(1)} mm deep, confidence ${root.confidence[k].toFixed(2)}`;
}

const layout = () => sceneLayout(state.camera || HOME, depthMarks(data.tank, state.tank));

function turn(how) {
  if (drawn) Plotly.relayout(scene, { "scene.camera": turned(scene.layout.scene.camera || HOME, how) });
}

function look(camera) {
  if (drawn) Plotly.relayout(scene, { "scene.camera": structuredClone(camera) });
}

const KEYS = {
  ArrowLeft: () => turn("left"), ArrowRight: () => turn("right"), ArrowUp: () => turn("up"), ArrowDown: () => turn("down"),
  "+": () => turn("in"), "=": () => turn("in"), "-": () => turn("out"), Home: () => look(HOME), ",": () => step(-1), ".": () => step(1),
};

function tieSpace() {
  document.querySelectorAll("[data-turn]").forEach((b) => b.addEventListener("click", () => turn(b.dataset.turn)));
  document.querySelectorAll("[data-view=side], [data-view=top]").forEach((b) => b.addEventListener("click", () => look(b.dataset.view === "top" ? TOP : HOME)));
  $("pan").addEventListener("click", () => {
    const on = $("pan").getAttribute("aria-pressed") !== "true";
    $("pan").setAttribute("aria-pressed", on);
    if (drawn) Plotly.relayout(scene, { "scene.dragmode": on ? "pan" : "orbit" });
  });
  $("save").addEventListener("click", () => drawn && Plotly.downloadImage(scene, { format: "png", width: 1600, height: 1600, filename: data.name }));
  scene.addEventListener("keydown", (event) => {
    const does = !event.ctrlKey && !event.metaKey && !event.altKey && KEYS[event.key];
    if (does) event.preventDefault(), does();
  });
  $("colour").addEventListener("change", (event) => change({ colour: event.target.value }));
  $("shape").addEventListener("change", (event) => change({ shape: event.target.value }));
  $("tank").addEventListener("change", (event) => change({ tank: event.target.checked }));
  onChange((what) => {
    drawLegend();
    if (!drawn) return;
    const fresh = traces(), old = scene.data, now = layout();
    // The roots themselves are the costly part: left alone where nothing of them changed.
    const only = what.length === 1 ? TRACE[what[0]] : undefined;
    Plotly.react(scene, fresh.map((trace, n) => (only !== undefined && n !== only ? old[n] : trace)), { ...now, scene: { ...now.scene, camera: scene.layout.scene.camera, dragmode: scene.layout.scene.dragmode } });
  });
}
