// Histograms and the depth profile; below each its numbers as a table. Colours are the style sheet's.
const PLOT = {
  margin: { l: 56, r: 12, t: 26, b: 44 }, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", showlegend: false, dragmode: false,
  font: { family: "system-ui, sans-serif", size: 12 }, bargap: 0.06,
};
const axis = (title, more) => ({ title: { text: title, standoff: 8 }, fixedrange: true, zeroline: false, automargin: true, ...more });

// Bins of equal width from 0, each with the sum of the weights in it.
function bins(pairs, width, count) {
  const sums = Array(count).fill(0);
  for (const [value, weight] of pairs) if (Number.isFinite(value)) sums[Math.min(Math.max(Math.floor(value / width), 0), count - 1)] += weight;
  return sums;
}

function plot(id, traces, more, label, columns, rows) {
  const place = $(id);
  place.setAttribute("role", "img");
  place.setAttribute("aria-label", label);
  startLibrary();
  Plotly.react(place, traces, { ...PLOT, ...more }, { displayModeBar: false, responsive: true });
  const cell = (name, text) => make(name, name === "th" ? { scope: "col" } : {}, String(text));
  const head = make("thead", {}, make("tr", {}, ...columns.map((column) => cell("th", column))));
  const body = make("tbody", {}, ...rows.map((row) => make("tr", {}, ...row.map((value) => cell("td", value)))));
  if (place.nextElementSibling) place.nextElementSibling.remove();
  place.after(make("details", {}, make("summary", {}, "Numbers"), make("table", {}, head, body)));
}

function plotDiameters() {
  const all = data.roots.flatMap(steps).map(([length, d]) => [d, length]);
  const most = Math.max(0.1, ...all.map(([d]) => d));
  const width = [0.05, 0.1, 0.2, 0.5, 1, 2].find((w) => most / w <= 30) || most / 30;
  const sums = bins(all, width, Math.max(1, Math.ceil(most / width + 1e-9)));
  const digits = width < 0.1 ? 2 : 1, edge = (k) => (k * width).toFixed(digits);
  const bar = { type: "bar", x: sums.map((_, k) => (k + 0.5) * width), y: sums, width, hovertemplate: "%{customdata}: %{y:.1f} mm<extra></extra>", customdata: sums.map((_, k) => `${edge(k)} to ${edge(k + 1)} mm`) };
  const top = sums.indexOf(Math.max(...sums));
  plot("plot-diameter", [bar], { xaxis: axis("Diameter, mm"), yaxis: axis("Length, mm") },
    `Histogram of diameters weighted by length: most of it between ${edge(top)} and ${edge(top + 1)} mm, up to ${most.toFixed(2)} mm`,
    ["Diameter, mm", "Length, mm"], sums.map((sum, k) => [`${edge(k)}–${edge(k + 1)}`, sum.toFixed(1)]));
}

function plotOrders() {
  const orders = [...new Set(data.roots.map((root) => root.order))].sort((a, b) => a - b);
  const of = orders.map((order) => data.roots.filter((root) => root.order === order));
  const lengths = of.map((roots) => roots.flatMap(steps).reduce((sum, s) => sum + s[0], 0));
  const bar = { type: "bar", x: orders.map(String), y: lengths, text: of.map((roots) => `${roots.length} ${roots.length === 1 ? "root" : "roots"}`), textposition: "outside", cliponaxis: false, hovertemplate: "order %{x}: %{y:.0f} mm<extra></extra>" };
  plot("plot-order", [bar], { xaxis: axis("Order", { type: "category" }), yaxis: axis("Length, mm") },
    `Length by order: ${orders.map((order, k) => `order ${order}: ${lengths[k].toFixed(0)} mm in ${of[k].length} roots`).join("; ")}`,
    ["Order", "Length, mm", "Roots"], orders.map((order, k) => [order, lengths[k].toFixed(1), of[k].length]));
}

function plotAngles() {
  const column = data.perRoot.columns.findIndex((c) => c.name === "emergence_angle_deg");
  const angles = data.perRoot.rows.map((row) => row[column]).filter((cell) => cell !== "" && cell !== undefined).map(Number);
  const sums = bins(angles.map((angle) => [angle, 1]), 10, 18);
  const bar = { type: "bar", x: sums.map((_, k) => 10 * k + 5), y: sums, width: 10, customdata: sums.map((_, k) => `${10 * k}° to ${10 * k + 10}°`), hovertemplate: "%{customdata}: %{y} roots<extra></extra>" };
  plot("plot-angle", [bar], { xaxis: axis("Angle from straight down, degrees", { range: [0, 180], dtick: 30 }), yaxis: axis("Roots") },
    `Histogram of emergence angles of ${angles.length} roots, mean ${mean(angles).toFixed(0)} degrees`,
    ["Angle, degrees", "Roots"], sums.map((sum, k) => [`${10 * k}–${10 * k + 10}`, sum]));
}

function plotDepth() {
  const column = (name) => data.profile.rows.map((row) => Number(row[data.profile.columns.indexOf(name)]));
  const [from, to, length, tips] = ["depth_from_mm", "depth_to_mm", "length_mm", "tips"].map(column);
  const middle = from.map((a, k) => (a + to[k]) / 2), names = from.map((a, k) => `${a} to ${to[k]} mm`);
  const bar = { type: "bar", orientation: "h", x: length, y: middle, width: from.map((a, k) => to[k] - a), customdata: names, hovertemplate: "%{customdata}: %{x:.1f} mm<extra></extra>" };
  const dots = { type: "scatter", mode: "markers", x: tips, y: middle, xaxis: "x2", marker: { size: 8, symbol: "diamond" }, customdata: names, hovertemplate: "%{customdata}: %{x} tips<extra></extra>" };
  plot("plot-depth", [bar, dots], {
    xaxis: axis("Length, mm (bars)", { rangemode: "tozero" }), xaxis2: axis("Tips (diamonds)", { overlaying: "x", side: "top", rangemode: "tozero", showgrid: false }),
    yaxis: axis("Depth under the water, mm", { autorange: "reversed" }), margin: { ...PLOT.margin, t: 46 },
  }, `Root length by depth in layers of ${(to[0] - from[0]) || 0} mm, down to ${to[to.length - 1] || 0} mm`,
  ["Depth, mm", "Length, mm", "Tips"], from.map((a, k) => [`${a}–${to[k]}`, length[k].toFixed(1), tips[k]]));
}

const draws = { "plot-diameter": plotDiameters, "plot-order": plotOrders, "plot-angle": plotAngles, "plot-depth": plotDepth };
const drawnPlots = new Set();

function drawPlot(id) {
  drawnPlots.add(id);
  if (!data.roots.length) $(id).textContent = "No root was traced.";
  else draws[id]();
}

// Each is drawn when it comes near, all of them for paper.
function tiePlots() {
  const seen = new IntersectionObserver((entries) => {
    for (const entry of entries) if (entry.isIntersecting) drawPlot(entry.target.id), seen.unobserve(entry.target);
  }, { rootMargin: "400px" });
  Object.keys(draws).forEach((id) => seen.observe($(id)));
  addEventListener("beforeprint", () => Object.keys(draws).filter((id) => !drawnPlots.has(id)).forEach(drawPlot));
}
