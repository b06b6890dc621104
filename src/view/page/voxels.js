// The root voxels as points beside the traced roots as lines.
TRACE.voxels = 3 + moreTraces.push(voxelsTrace);
data.voxels = { x: [], y: [], z: [] };
let voxelsText = null;

function voxelsTrace() {
  const { x, y, z } = data.voxels;
  return { type: "scatter3d", mode: "markers", x, y, z, marker: { size: 2.2, color: "#ffb14a", line: { width: 0 } }, hoverinfo: "skip", visible: state.shape === "voxels" };
}

function takeVoxels({ turn, count, pieces, xyz }) {
  const isDrawn = () => {
    [drawnTurn, drawnAt] = [turn, performance.now()];
    tellShown();
  };
  $("voxels-told").textContent = `${count.toLocaleString("en")} root voxels in ${pieces.toLocaleString("en")} pieces`;
  if (xyz === voxelsText) return isDrawn();
  voxelsText = xyz;
  const bytes = Uint8Array.from(atob(xyz), (c) => c.charCodeAt(0)), all = new Float32Array(bytes.buffer);
  const axis = (n, sign) => Float32Array.from({ length: count }, (_, k) => sign * all[3 * k + n]);
  data.voxels = { x: axis(0, 1), y: axis(1, -1), z: axis(2, -1) };
  if (drawn) scene.once("plotly_afterplot", () => requestAnimationFrame(isDrawn));
  change({ voxels: turn });
  if (!drawn) isDrawn();
}
