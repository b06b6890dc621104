// A root added by clicking its places, base first, in two or more photographs, in the same order in each. Then what it hangs on is
// clicked in the view in space.
let clicks = null;

function drawClicks() {
  const picture = $("viewer-picture"), view = data.views[shown];
  picture.querySelectorAll(".clicks").forEach((marks) => marks.remove());
  for (const id of ["add-back", "add-done", "add-cancel"]) $(id).hidden = !clicks;
  $("add-begin").setAttribute("aria-pressed", Boolean(clicks));
  picture.classList.toggle("adding", Boolean(clicks));
  if (!clicks) return;
  const own = clicks.get(view.name) || [], many = [...clicks].filter(([, places]) => places.length);
  const arm = view.size[0] / 150, svg = make("svg", { class: "clicks", viewBox: frameOf(view), "aria-hidden": "true" });
  own.forEach(([u, v]) => svg.append(make("path", { d: `M${u - arm} ${v}h${2 * arm}M${u} ${v - arm}v${2 * arm}` })));
  picture.append(svg);
  $("add-back").disabled = !own.length;
  $("add-done").disabled = !(many.length > 1 && many.every(([, places]) => places.length === many[0][1].length && places.length > 1));
  $("viewer-note").textContent = "Click places along the root, base first, the same ones in two photographs or more. " +
    (many.map(([name, places]) => `${name}: ${places.length}`).join(", ") || "None yet") + ".";
}

function beginAdding() {
  setTool(null);
  clicks = new Map();
  if (viewer.open) drawViewer();
  else openViewer(shown);
}

function endAdding() {
  clicks = null;
  drawViewer();
}

// The entry is there but for what the root hangs on.
function addClicked() {
  const seen = [...clicks].filter(([, places]) => places.length);
  const entry = { clicks: seen[0][1].map((_, n) => seen.map(([photo, places]) => ({ photo, px: places[n] }))) };
  viewer.close();
  setTool({ kind: "add", fields: TIES[$("correct-tie").value], entry });
  if (nextField()) $("correct-told").scrollIntoView({ block: "center" });
  else sendCorrection({ kind: "add", ...entry });
}

function tieAdding() {
  const button = (id, text) => make("button", { type: "button", id }, text);
  const group = make("span", { class: "buttons", role: "group", "aria-label": "Add a root" });
  group.append(button("add-begin", "Add a root"), button("add-back", "Take back"), button("add-done", "Done"), button("add-cancel", "Cancel"));
  document.querySelector("#viewer .tools").append(group);
  $("add-begin").addEventListener("click", () => (clicks ? endAdding() : beginAdding()));
  $("add-back").addEventListener("click", () => {
    clicks.get(data.views[shown].name).pop();
    drawClicks();
  });
  $("add-done").addEventListener("click", addClicked);
  $("add-cancel").addEventListener("click", endAdding);
  $("viewer-picture").addEventListener("click", (event) => {
    if (!clicks) return;
    event.stopPropagation();
    const svg = document.querySelector("#viewer-picture svg.clicks"), { name } = data.views[shown];
    const { x, y } = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    clicks.set(name, [...(clicks.get(name) || []), [x, y].map((c) => Math.round(10 * c) / 10)]);
    drawClicks();
  }, true);
  viewer.addEventListener("close", () => {
    clicks = null;
    drawClicks();
  });
  afterViewer = drawClicks;
  drawClicks();
}
