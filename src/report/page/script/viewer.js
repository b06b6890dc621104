// One photograph large: roots on and off, and a slider between the bare photograph and the drawn one.
const viewer = $("viewer");
let shown = 0, viewerImage = pictureOf, afterViewer = () => {};

function openViewer(n) {
  shown = n;
  drawViewer();
  if (!viewer.open) viewer.showModal();
}

function drawViewer() {
  const view = data.views[shown], picture = $("viewer-picture");
  const image = make("img", { src: viewerImage(shown), alt: `Photograph ${view.name} of the tank, from ${view.from} degrees` });
  const svg = overlayOf(view, 2), handle = make("div", { class: "handle" });
  svg.querySelectorAll("path").forEach((path) => {
    const root = rootOf.get(Number(path.dataset.root));
    path.append(make("title", {}, `Root ${root.id}, order ${root.order}`));
    path.addEventListener("click", () => choose(root.id));
  });
  picture.replaceChildren(image, svg, handle);
  $("viewer-title").textContent = `${view.name}, from ${view.from}°`;
  layViewer();
}

function layViewer() {
  const picture = $("viewer-picture"), view = data.views[shown];
  const svg = picture.querySelector("svg"), handle = picture.querySelector(".handle");
  if (!svg) return;
  const split = Number($("viewer-split").value), only = $("viewer-only").checked;
  svg.style.display = $("viewer-roots").checked ? "" : "none";
  svg.style.clipPath = `inset(0 0 0 ${split}%)`;
  handle.style.left = `${split}%`;
  handle.style.display = split > 0 && split < 100 ? "" : "none";
  svg.querySelectorAll("path").forEach((path) => {
    path.style.display = only && state.chosen !== null && Number(path.dataset.root) !== state.chosen ? "none" : "";
  });
  const full = $("viewer-zoom").getAttribute("aria-pressed") === "true";
  // As large as fits, or twice as large to move about in.
  const fits = `min(100%, calc(76vh * ${view.size[0] / view.size[1]}))`;
  picture.style.width = full ? `max(200%, ${view.size[0]}px)` : fits;
  const n = view.lines.filter((line) => rootOf.has(line[0])).length;
  $("viewer-note").textContent =
    `${n} of ${data.roots.length} roots in sight` + (state.chosen !== null ? `; root ${state.chosen} is drawn in white.` : "; click a line to choose its root.");
  afterViewer();
}

function tieViewer() {
  const go = (by) => openViewer((shown + by + data.views.length) % data.views.length);
  $("viewer-before").addEventListener("click", () => go(-1));
  $("viewer-after").addEventListener("click", () => go(1));
  $("viewer-close").addEventListener("click", () => viewer.close());
  $("viewer-zoom").addEventListener("click", () => {
    $("viewer-zoom").setAttribute("aria-pressed", $("viewer-zoom").getAttribute("aria-pressed") !== "true");
    layViewer();
  });
  for (const id of ["viewer-roots", "viewer-only", "viewer-split"]) $(id).addEventListener("input", layViewer);
  viewer.addEventListener("click", (event) => event.target === viewer && viewer.close());
  viewer.addEventListener("keydown", (event) => {
    const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (by && event.target.tagName !== "INPUT" && event.target.id !== "viewer-frame") event.preventDefault(), go(by);
  });
  onChange((what) => what.includes("chosen") && layViewer());
}
