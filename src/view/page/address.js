// What is shown stands in the address, so that it can be kept as a bookmark and comes back after a reload.
const live = data.live;
const given = new URLSearchParams(location.search);
const fieldOf = new Map(live.fields.map((field) => [field.name, field]));
const addressParts = [];
let writing = 0;

// `part` hands back entries of the address; what is as at the start is left out.
const addAddress = (part) => addressParts.push(part);

function writeAddress() {
  clearTimeout(writing);
  writing = setTimeout(() => {
    const entries = addressParts.flatMap((part) => part()).map(([name, value]) => [name, String(value)]);
    const text = new URLSearchParams(entries).toString();
    history.replaceState(null, "", location.pathname + (text ? `?${text}` : "") + location.hash);
  }, 200);
}

// A setting's value as the address gives it; undefined where it is none.
function givenValue(name) {
  const text = given.get(name), sample = fieldOf.get(name).default;
  if (text === null) return undefined;
  if (typeof sample === "number") return text.trim() !== "" && Number.isFinite(Number(text)) ? Number(text) : undefined;
  if (typeof sample === "boolean") return text === "true";
  return text;
}

const cameraText = ({ eye, center }) => [eye.x, eye.y, eye.z, center.x, center.y, center.z].map((x) => x.toFixed(3)).join(",");

function cameraOf(text) {
  const x = (text || "").split(",").map(Number);
  if (x.length !== 6 || !x.every(Number.isFinite)) return null;
  return { eye: { x: x[0], y: x[1], z: x[2] }, center: { x: x[3], y: x[4], z: x[5] }, up: { x: 0, y: 0, z: 1 } };
}

function tieAddress() {
  const option = (id, name) => {
    const value = given.get(name);
    if (value !== null && [...$(id).options].some((o) => o.value === value)) $(id).value = state[name] = value;
  };
  option("colour", "colour");
  option("shape", "shape");
  state.camera = cameraOf(given.get("camera"));
  if (given.get("tank") === "no") state.tank = $("tank").checked = false;
  addAddress(() => [
    ...(state.colour !== "order" ? [["colour", state.colour]] : []),
    ...(state.shape !== "tubes" ? [["shape", state.shape]] : []),
    ...(state.tank ? [] : [["tank", "no"]]),
    ...(state.chosen !== null ? [["root", state.chosen]] : []),
  ]);
  addAddress(() => (drawn && cameraText(scene.layout.scene.camera) !== cameraText(HOME) ? [["camera", cameraText(scene.layout.scene.camera)]] : []));
  onChange(writeAddress);
}
