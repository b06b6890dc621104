// What every page with a view in space has: its data, elements, and watchers of what is chosen.
const data = JSON.parse(document.getElementById("data").textContent);
const $ = (id) => document.getElementById(id);
const watchers = [];
const onChange = (watcher) => watchers.push(watcher);

function change(what) {
  Object.assign(state, what);
  watchers.forEach((watcher) => watcher(Object.keys(what)));
}

// An element with attributes and children.
function make(name, attributes, ...children) {
  const svg = ["svg", "path", "image", "g", "title"].includes(name);
  const element = svg ? document.createElementNS("http://www.w3.org/2000/svg", name) : document.createElement(name);
  for (const [key, value] of Object.entries(attributes || {})) element.setAttribute(key, value);
  element.append(...children);
  return element;
}

// Roots of which nothing is to be said.
const PLAIN = "#8a949c";
const rgb = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16) / 255);
const css = (colour) => `rgb(${colour.map((x) => Math.round(255 * x)).join(",")})`;

// An entry of a legend.
function legendKey(colour, text) {
  const swatch = make("span", { class: "swatch" });
  swatch.style.background = colour;
  return make("span", { class: "key" }, swatch, text);
}

const hasWebGL = () => {
  try {
    return Boolean(document.createElement("canvas").getContext("webgl"));
  } catch {
    return false;
  }
};
