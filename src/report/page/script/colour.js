// Colours of roots and of their points. Ramps are viridis and plasma without their darkest parts, which the dark ground would swallow.
const VIRIDIS = ["#2f6c8e", "#25858e", "#1e9c89", "#33b479", "#5cc863", "#9bd93c", "#dde318", "#fde725"];
const PLASMA = ["#b12a90", "#c8437b", "#dc5d67", "#ec7853", "#f7963f", "#fdb52e", "#fbd524", "#f0f921"];
const KINDS = ["#56b4e9", "#e69f00", "#cc79a7", "#009e73", "#f0e442", "#0072b2", "#d55e00", "#ffffff"];

const rampColour = (ramp, share) => {
  const at = Math.min(Math.max(share, 0), 1) * (ramp.length - 1), k = Math.min(Math.floor(at), ramp.length - 2);
  const [a, b] = [rgb(ramp[k]), rgb(ramp[k + 1])];
  return a.map((x, c) => x + (at - k) * (b[c] - x));
};

// The value that a ramp shows at point k of a root.
const VALUES = {
  d: { title: "Diameter", unit: "mm", ramp: PLASMA, of: (root, k) => root.d[k] },
  depth: { title: "Depth", unit: "mm", ramp: VIRIDIS, of: (root, k) => depthOf(root.xyz[3 * k + 2]) },
  confidence: { title: "Confidence", unit: "", ramp: VIRIDIS, range: [0, 1], of: (root, k) => root.confidence[k] },
};

const ranges = {};
function range(name) {
  if (VALUES[name].range) return VALUES[name].range;
  if (!ranges[name]) {
    const all = data.roots.flatMap((root) => root.d.map((_, k) => VALUES[name].of(root, k))).sort((a, b) => a - b);
    // A few outliers would take the whole ramp.
    const at = (share) => all[Math.round(share * (all.length - 1))] ?? 0;
    ranges[name] = [at(0.01), Math.max(at(0.99), at(0.01) + 1e-6)];
  }
  return ranges[name];
}

// Colours of all points of a root, as [r, g, b] of 0 to 1 each.
function pointColours(root) {
  const value = VALUES[state.colour];
  if (value) {
    const [low, high] = range(state.colour);
    return root.d.map((_, k) => rampColour(value.ramp, (value.of(root, k) - low) / (high - low)));
  }
  if (state.colour === "repair") return root.repair.map((kind) => rgb(kind < 0 ? PLAIN : KINDS[kind]));
  const one = rgb(state.colour === "root" ? root.colour : root.orderColour);
  return root.d.map(() => one);
}

// One colour for a root's line on a photograph: of its mean where points differ.
function rootColour(root) {
  const value = VALUES[state.colour];
  if (!value) return state.colour === "root" ? root.colour : root.orderColour;
  const [low, high] = range(state.colour);
  return css(rampColour(value.ramp, (mean(root.d.map((_, k) => value.of(root, k))) - low) / (high - low)));
}

function drawLegend() {
  const legend = $("legend"), value = VALUES[state.colour];
  legend.replaceChildren();
  if (value) {
    const [low, high] = range(state.colour), bar = make("span", { class: "ramp" });
    bar.style.background = `linear-gradient(to right, ${value.ramp.join(",")})`;
    const digits = high - low < 5 ? 2 : 0;
    legend.append(value.title, make("span", { class: "key" }, low.toFixed(digits), bar, `${high.toFixed(digits)} ${value.unit}`));
  } else if (state.colour === "order") {
    const orders = [...new Set(data.roots.map((root) => root.order))].sort((a, b) => a - b);
    for (const order of orders) legend.append(legendKey(data.roots.find((root) => root.order === order).orderColour, `order ${order}`));
  } else if (state.colour === "root") {
    legend.append("Each root has a colour of its own, as in overlays/*-roots.jpg.");
  } else {
    legend.append(legendKey(PLAIN, "as the ridge shows it"));
    data.kinds.forEach((kind, k) => {
      const n = data.repairs.filter((repair) => repair.kind === k).length;
      if (n) legend.append(legendKey(KINDS[k], `${kind.name} (${n}): ${kind.about}`));
    });
  }
}
