// Roots as lines on the photographs. Coordinates are tenths of a pixel; the centre of the top-left pixel is (0, 0).
const pathOf = (strokes) => strokes.map((s) => {
  let d = "";
  for (let k = 0; k < s.length; k += 2) d += `${k ? "L" : "M"}${s[k] / 10} ${s[k + 1] / 10}`;
  return d;
}).join("");

const frameOf = (view) => `-0.5 -0.5 ${view.size[0]} ${view.size[1]}`;

function linePath(view, [id, , strokes], width) {
  return make("path", { d: pathOf(strokes), "data-root": id, stroke: rootColour(rootOf.get(id)), "stroke-width": width });
}

function paint(path) {
  const root = rootOf.get(Number(path.dataset.root)), chosen = root.id === state.chosen;
  path.setAttribute("stroke", chosen ? "#ffffff" : rootColour(root));
  path.style.filter = chosen ? "drop-shadow(0 0 2px #000)" : "";
}

// The lines of a photograph, over all of it.
function overlayOf(view, width) {
  const svg = make("svg", { class: "lines", viewBox: frameOf(view), "aria-hidden": "true" });
  for (const line of view.lines) if (rootOf.has(line[0])) svg.append(linePath(view, line, width));
  svg.querySelectorAll("path").forEach(paint);
  return svg;
}

const gallery = [...document.querySelectorAll(".gallery .photo")];
const pictureOf = (n) => gallery[n].querySelector("img").src;

function drawLines(button) {
  if (!button.querySelector("svg")) button.append(overlayOf(data.views[Number(button.dataset.view)], 1.4));
}

function tieGallery() {
  const seen = new IntersectionObserver((entries) => {
    for (const entry of entries) if (entry.isIntersecting) drawLines(entry.target), seen.unobserve(entry.target);
  }, { rootMargin: "300px" });
  gallery.forEach((button) => {
    seen.observe(button);
    button.addEventListener("click", () => openViewer(Number(button.dataset.view)));
  });
  $("gallery-roots").addEventListener("change", (event) => document.body.classList.toggle("no-lines", !event.target.checked));
  addEventListener("beforeprint", () => gallery.forEach(drawLines));
  onChange((what) => {
    if (what.includes("colour") || what.includes("chosen")) document.querySelectorAll("svg.lines path").forEach(paint);
  });
}
