// The result, and what is chosen of it. Whoever wants to know of a change asks with `onChange`.
const data = JSON.parse(document.getElementById("data").textContent);
const $ = (id) => document.getElementById(id);
const rootOf = new Map(data.roots.map((root) => [root.id, root]));
const state = { chosen: null, colour: "order", shape: "tubes", tank: true, camera: null };
const watchers = [];
const onChange = (watcher) => watchers.push(watcher);

function change(what) {
  Object.assign(state, what);
  watchers.forEach((watcher) => watcher(Object.keys(what)));
}

function choose(id) {
  change({ chosen: rootOf.has(id) ? id : null });
}

// The root before (-1) or after (1) the chosen one.
function step(by) {
  const at = data.roots.findIndex((root) => root.id === state.chosen);
  const n = data.roots.length;
  if (n) choose(data.roots[at < 0 ? (by > 0 ? 0 : n - 1) : (at + by + n) % n].id);
}

// An element with attributes and children.
function make(name, attributes, ...children) {
  const svg = ["svg", "path", "image", "g", "title"].includes(name);
  const element = svg ? document.createElementNS("http://www.w3.org/2000/svg", name) : document.createElement(name);
  for (const [key, value] of Object.entries(attributes || {})) element.setAttribute(key, value);
  element.append(...children);
  return element;
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
