// The chosen root: its row of per_root.csv as the table of all roots shows it, and the photographs that show it best.
const BEST = 4;
const MARGIN_PX = 24;

function rowOf(id) {
  return document.querySelector(`#root-table tr[data-root="${id}"]`);
}

function rowTable(id) {
  const cells = [...rowOf(id).children].slice(1);
  const rows = data.perRoot.columns.slice(1).map((column, n) => {
    const term = make("button", { type: "button", class: "term", "aria-describedby": `c-${column.name}` }, column.label);
    const about = make("span", { role: "tooltip", id: `c-${column.name}` }, column.about, " ", make("code", {}, column.name));
    const value = make("td", { "data-column": column.name, "data-value": cells[n].dataset.value }, cells[n].textContent || "–");
    if (cells[n].textContent && column.unit) value.append(" ", make("span", { class: "unit" }, column.unit));
    return make("tr", {}, make("th", { scope: "row" }, term, about), value);
  });
  return make("table", {}, make("tbody", {}, ...rows));
}

// The part of a photograph about a root, with the root on it.
function cropOf(n, line) {
  const view = data.views[n], u = [], v = [];
  for (const stroke of line[2]) for (let k = 0; k < stroke.length; k += 2) u.push(stroke[k] / 10), v.push(stroke[k + 1] / 10);
  const [left, right, top, bottom] = [Math.min(...u), Math.max(...u), Math.min(...v), Math.max(...v)];
  const side = Math.max(right - left, bottom - top) + 2 * MARGIN_PX;
  const box = `${(left + right - side) / 2} ${(top + bottom - side) / 2} ${side} ${side}`;
  const svg = make("svg", { viewBox: box, "aria-hidden": "true" });
  svg.append(make("image", { href: pictureOf(n), x: -0.5, y: -0.5, width: view.size[0], height: view.size[1] }));
  const dark = linePath(view, line, 3.5), bright = linePath(view, line, 1.6);
  dark.setAttribute("stroke", "#000");
  dark.setAttribute("opacity", 0.45);
  svg.append(dark, bright);
  const button = make("button", { type: "button", class: "photo", "aria-label": `Photograph ${view.name} with root ${line[0]}: open large` }, svg);
  button.addEventListener("click", () => openViewer(n));
  return make("figure", {}, button, make("figcaption", {}, `${view.name}, ${view.from}°: ${Math.round(line[1])} px`));
}

function bestViews(id) {
  const all = data.views.map((view, n) => [n, view.lines.find((line) => line[0] === id)]).filter(([, line]) => line);
  return all.sort((a, b) => b[1][1] - a[1][1] || a[0] - b[0]).slice(0, BEST);
}

function showChosen() {
  const id = state.chosen, body = $("chosen-body");
  $("choose").value = id === null ? "" : String(id);
  document.querySelectorAll("#root-table tr.chosen").forEach((row) => row.classList.remove("chosen"));
  if (id === null) {
    $("chosen-title").textContent = "Chosen root";
    body.replaceChildren(make("p", {}, "No root is chosen."));
    return;
  }
  rowOf(id).classList.add("chosen");
  $("chosen-title").textContent = `Root ${id}`;
  const best = bestViews(id);
  const title = make("h4", {}, best.length ? "Photographs that show it best (length in clear sight)" : "No photograph shows it past the wall and the belts.");
  body.replaceChildren(make("div", { class: "best" }, ...best.map(([n, line]) => cropOf(n, line))), rowTable(id));
  body.prepend(title);
}

function tieTable() {
  const table = $("root-table"), tbody = table.tBodies[0];
  tbody.addEventListener("click", (event) => {
    const button = event.target.closest("[data-choose]");
    if (!button) return;
    choose(Number(button.dataset.choose));
    $("space").scrollIntoView();
  });
  const key = (row, n) => {
    const cell = row.children[n], text = n ? cell.dataset.value : row.dataset.root;
    return text === "" ? NaN : Number(text);
  };
  table.tHead.addEventListener("click", (event) => {
    const button = event.target.closest("[data-column]");
    if (!button) return;
    const n = Number(button.dataset.column), head = button.parentElement;
    const down = head.getAttribute("aria-sort") === "ascending";
    table.tHead.querySelectorAll("[aria-sort]").forEach((th) => th.removeAttribute("aria-sort"));
    head.setAttribute("aria-sort", down ? "descending" : "ascending");
    const rows = [...tbody.rows].map((row) => [key(row, n), row]);
    // What has no value stands last either way.
    rows.sort(([a], [b]) => Number.isNaN(a) - Number.isNaN(b) || (down ? b - a : a - b) || 0);
    tbody.append(...rows.map(([, row]) => row));
  });
}

function tieRoots() {
  $("choose").addEventListener("change", (event) => choose(event.target.value === "" ? null : Number(event.target.value)));
  tieTable();
  onChange((what) => what.includes("chosen") && showChosen());
  onChange((what) => what.includes("colour") && state.chosen !== null && showChosen());
}
