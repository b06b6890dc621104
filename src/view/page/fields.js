// The settings: a slider and a field for each number, a list for each word, with their help and defaults.
const GROUPS = { extract: "Extraction", trace: "Tracing", hierarchy: "Hierarchy" };
let fileValues = {};
const fieldRows = new Map();

// The nearest of 1, 2, 5 times a power of ten that is not greater.
function round(x) {
  const power = 10 ** Math.floor(Math.log10(x));
  return power * [5, 2, 1].find((n) => n * power <= x * (1 + 1e-9));
}

const valueOf = (name) => (name in changes ? changes[name] : fileValues[name]);

function fieldRow(field) {
  const id = `f-${field.name.replaceAll(".", "-")}`, row = make("div", { class: "field" });
  const term = make("button", { type: "button", class: "term", "aria-describedby": `${id}-about` }, make("code", {}, field.name));
  const about = make("span", { role: "tooltip", id: `${id}-about` }, field.about);
  row.append(make("div", { class: "name" }, make("span", {}, term, about), make("span", { class: "default" }, `default ${field.default}`)));
  const controls = make("div", { class: "controls" }), inputs = [];
  if (typeof field.default === "number") {
    const [least, most] = field.range, low = least ?? 0;
    const reach = 4 * (Math.abs(fileValues[field.name]) || Math.abs(field.default) || 1);
    const high = most ?? low + round(reach * 1.25), step = round((high - low) / 200);
    inputs.push(make("input", { type: "range", min: low, max: high, step, "aria-label": field.name, id }));
    inputs.push(make("input", { type: "number", step: "any", "aria-label": `${field.name}, exactly`, ...(least === null ? {} : { min: least }), ...(most === null ? {} : { max: most }) }));
  } else if (field.choices.length) {
    inputs.push(make("select", { "aria-label": field.name, id }, ...field.choices.map((word) => make("option", { value: word }, word))));
  } else {
    inputs.push(make("input", { type: "checkbox", "aria-label": field.name, id }));
  }
  for (const input of inputs) {
    input.addEventListener("input", (event) => {
      const value = typeof field.default === "number" ? (input.value === "" ? NaN : Number(input.value)) : field.choices.length ? input.value : input.checked;
      if (Number.isNaN(value)) return;
      setField(field.name, value, performance.now());
      for (const other of inputs) if (other !== event.target) other.value = value;
    });
  }
  controls.append(...inputs);
  row.append(controls);
  fieldRows.set(field.name, { row, inputs });
  return row;
}

function setShape(shape) {
  $("shape").value = shape;
  change({ shape });
}

// Roots are drawn again where root voxels hid them.
function showRoots() {
  if (state.shape === "voxels") setShape("tubes");
}

function setField(name, value, since) {
  if (value === fileValues[name]) delete changes[name];
  else changes[name] = value;
  // What follows a change at once is shown: root voxels of an extraction, roots of all else.
  if (!name.startsWith("extract.")) showRoots();
  else if (state.shape !== "voxels") setShape("voxels");
  markFields();
  sendChanges(since);
}

function markFields() {
  for (const [name, { row }] of fieldRows) row.classList.toggle("changed", name in changes);
  const any = Object.keys(changes).length > 0;
  $("reset").disabled = !any;
  $("keep").disabled = !any || live.readOnly;
}

function showFields() {
  for (const [name, { inputs }] of fieldRows) {
    for (const input of inputs) {
      if (input === document.activeElement) continue;
      if (input.type === "checkbox") input.checked = valueOf(name);
      else input.value = valueOf(name);
    }
  }
  markFields();
}

function tieFields() {
  for (const [section, title] of Object.entries(GROUPS)) {
    const rows = live.fields.filter((field) => field.name.startsWith(`${section}.`)).map(fieldRow);
    $("fields").append(make("details", section === "extract" ? { open: "" } : {}, make("summary", {}, title), ...rows));
  }
  $("reset").addEventListener("click", () => {
    Object.keys(changes).forEach((name) => delete changes[name]);
    showFields();
    sendChanges(performance.now());
  });
  const write = (what, body, done) => async () => {
    try {
      await ask(what, body());
      say(done);
    } catch (error) {
      say(error.message, true);
    }
  };
  $("keep").addEventListener("click", write("keep", () => changes, "Kept in the study file."));
  const undo = write("undo", () => ({}), "What was written last is taken back.");
  document.querySelectorAll("[data-undo]").forEach((button) => button.addEventListener("click", undo));
  addAddress(() => Object.entries(changes));
}
