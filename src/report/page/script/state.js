// The result, and what is chosen of it. Whoever wants to know of a change asks with `onChange`.
const rootOf = new Map(data.roots.map((root) => [root.id, root]));
const state = { chosen: null, colour: "order", shape: "tubes", tank: true, camera: null };

function choose(id) {
  change({ chosen: rootOf.has(id) ? id : null });
}

// The root before (-1) or after (1) the chosen one.
function step(by) {
  const at = data.roots.findIndex((root) => root.id === state.chosen);
  const n = data.roots.length;
  if (n) choose(data.roots[at < 0 ? (by > 0 ? 0 : n - 1) : (at + by + n) % n].id);
}

const depthOf = (z) => z - data.tank.water;
const mean = (list) => list.reduce((sum, x) => sum + x, 0) / (list.length || 1);

// Steps of a root's centreline as [length, diameter, depth] of each.
function steps(root) {
  const p = root.xyz, all = [];
  for (let k = 1; k < root.d.length; k++) {
    const [a, b] = [3 * k - 3, 3 * k];
    const length = Math.hypot(p[b] - p[a], p[b + 1] - p[a + 1], p[b + 2] - p[a + 2]);
    all.push([length, (root.d[k - 1] + root.d[k]) / 2, depthOf((p[a + 2] + p[b + 2]) / 2)]);
  }
  return all;
}
