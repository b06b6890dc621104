// What a view in space shows beside roots: the tank and depths, the layout, cameras and how they are turned.
const HOME = { eye: { x: 0.02, y: -2.05, z: 0.38 }, center: { x: 0, y: 0, z: 0 }, up: { x: 0, y: 0, z: 1 } };
const TOP = { eye: { x: 0, y: -0.01, z: 2.2 }, center: { x: 0, y: 0, z: 0 }, up: { x: 0, y: 0, z: 1 } };
const LIGHTING = { ambient: 0.7, diffuse: 0.6, specular: 0.15, roughness: 0.7, fresnel: 0.05 };

function tankTrace(tank, visible) {
  const { radius, floor, water, belts } = tank, x = [], y = [], z = [];
  const ring = (height) => {
    for (let k = 0; k <= 72; k++) x.push(radius * Math.cos((k * Math.PI) / 36)), y.push(radius * Math.sin((k * Math.PI) / 36)), z.push(-height);
    x.push(null), y.push(null), z.push(null);
  };
  [0, water, floor, ...belts.flat().filter((h) => h > 0 && h < floor)].forEach(ring);
  for (let k = 0; k < 4; k++) {
    const [a, b] = [radius * Math.cos((k * Math.PI) / 2), radius * Math.sin((k * Math.PI) / 2)];
    x.push(a, a, null), y.push(b, b, null), z.push(0, -floor, null);
  }
  return { type: "scatter3d", mode: "lines", x, y, z, line: { width: 1.5, color: "#66727b" }, hoverinfo: "skip", visible };
}

// Depths beside the tank. As annotations: text in the scene itself takes plotly.js half a second.
function depthMarks(tank, visible) {
  const { radius, floor, water } = tank, every = floor > 150 ? 50 : 20, marks = [];
  for (let depth = 0; depth <= floor - water; depth += every) {
    const text = depth ? `${depth} mm` : "water";
    marks.push({ x: radius * 1.03, y: 0, z: -water - depth, text, showarrow: false, xanchor: "left", font: { color: "#98a4ad", size: 11 }, visible });
  }
  return marks;
}

// Ticks and titles that nobody sees would still be cut into triangles, which takes half a second.
const BARE = { visible: false, showspikes: false, title: { text: "" }, tickmode: "array", tickvals: [], ticktext: [] };
const sceneLayout = (camera, annotations) => ({
  margin: { l: 0, r: 0, t: 0, b: 0 }, paper_bgcolor: "rgba(0,0,0,0)", showlegend: false, hovermode: "closest", uirevision: "kept",
  font: { family: "system-ui, sans-serif" },
  scene: {
    aspectmode: "data", dragmode: "orbit", camera, bgcolor: "rgba(0,0,0,0)", hovermode: "closest",
    xaxis: BARE, yaxis: BARE, zaxis: BARE,
    annotations,
  },
});

// The camera turned, tilted or moved nearer.
function turned(from, how) {
  const camera = structuredClone(from), { eye, center } = camera, [dx, dy, dz] = [eye.x - center.x, eye.y - center.y, eye.z - center.z];
  let reach = Math.hypot(dx, dy, dz), around = Math.atan2(dy, dx), up = Math.asin(dz / reach);
  if (how === "left") around -= Math.PI / 12;
  if (how === "right") around += Math.PI / 12;
  if (how === "up") up = Math.min(up + Math.PI / 18, 1.55);
  if (how === "down") up = Math.max(up - Math.PI / 18, -1.55);
  if (how === "in") reach /= 1.25;
  if (how === "out") reach *= 1.25;
  const flat = reach * Math.cos(up);
  camera.eye = { x: center.x + flat * Math.cos(around), y: center.y + flat * Math.sin(around), z: center.z + reach * Math.sin(up) };
  camera.up = { x: 0, y: 0, z: 1 };
  return camera;
}
