// A plane through a volume, with the roots that it cuts.
let plane = null, sliceOnItsWay = false, sliceWaiting = false;
const sliceSettings = ["of", "at", "tilt", "turn"];
const sliceInput = (name) => $(`slice-${name}`);

async function drawSlice() {
  const told = { at: "mm from the middle", tilt: "° from level", turn: "°" };
  for (const name of ["at", "tilt", "turn"]) $(`slice-${name}-told`).textContent = `${sliceInput(name).value} ${told[name]}`;
  sliceWaiting = true;
  writeAddress();
  if (sliceOnItsWay) return;
  sliceOnItsWay = true;
  while (sliceWaiting) {
    sliceWaiting = false;
    const asked = new URLSearchParams(sliceSettings.map((name) => [name, sliceInput(name).value]));
    try {
      const answer = await fetch(`${here}slice?${asked}`), said = await answer.json();
      if (!answer.ok) throw new Error(said.error);
      plane = said;
      showSlice();
    } catch (error) {
      $("slice-told").textContent = error.message;
    }
  }
  sliceOnItsWay = false;
}

function showSlice() {
  const [rows, columns] = plane.size, name = sliceInput("of").selectedOptions[0].textContent;
  const image = make("img", { src: `data:image/png;base64,${plane.png}`, alt: "", width: columns, height: rows });
  $("slice").replaceChildren(image);
  $("slice").style.aspectRatio = `${columns} / ${rows}`;
  $("slice").style.width = `min(100%, calc(78vh * ${columns / rows}))`;
  const reach = Math.floor(plane.reach);
  Object.assign(sliceInput("at"), { min: -reach, max: reach });
  const cut = sliceRoots();
  $("slice").setAttribute("aria-label", `Slice through the ${name}: ${cut} roots cut`);
  const level = Math.abs(plane.normal[2]) > 0.999;
  $("slice-told").textContent = (level ? `${depthOf(plane.centre[2]).toFixed(1)} mm under the water. ` : "") + `${cut} of ${data.roots.length} roots are cut; a pixel is ${plane.px} mm wide.`;
}

// Draws the roots in: where they pass through the plane a circle as thick as the root, where they run in it a line.
function sliceRoots() {
  $("slice").querySelectorAll("svg").forEach((svg) => svg.remove());
  const [rows, columns] = plane.size, svg = document.createElementNS("http://www.w3.org/2000/svg", "svg"), cut = new Set();
  svg.setAttribute("viewBox", `0 0 ${columns} ${rows}`);
  svg.setAttribute("aria-hidden", "true");
  const add = (name, root, attributes) => {
    const shape = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries({ ...attributes, stroke: root.id === state.chosen ? "#ffffff" : rootColour(root) })) shape.setAttribute(key, value);
    svg.append(shape);
    cut.add(root.id);
  };
  const at = (p) => [dot(p, plane.across) / plane.px + columns / 2, dot(p, plane.down) / plane.px + rows / 2];
  for (const root of data.roots) {
    let before = null;
    for (let k = 0; k < root.d.length; k++) {
      const p = minus(root.xyz.slice(3 * k, 3 * k + 3), plane.centre), far = dot(p, plane.normal), radius = root.d[k] / 2;
      if (before && Math.abs(far) <= radius && Math.abs(before.far) <= radius) {
        const [[x1, y1], [x2, y2]] = [at(before.p), at(p)];
        add("line", root, { x1, y1, x2, y2 });
      } else if (before && far * before.far < 0) {
        const share = before.far / (before.far - far), [cx, cy] = at(before.p.map((x, n) => x + share * (p[n] - x)));
        add("circle", root, { cx, cy, r: Math.max(radius / plane.px, 0.8) });
      }
      before = { p, far };
    }
  }
  if ($("slice-roots").checked) $("slice").append(svg);
  return cut.size;
}

function tieSlices() {
  for (const name of sliceSettings) {
    const value = given.get(`slice-${name}`);
    if (value !== null) sliceInput(name).value = value;
    sliceInput(name).addEventListener("input", drawSlice);
  }
  document.querySelectorAll("[data-plane]").forEach((button) => button.addEventListener("click", () => {
    [sliceInput("turn").value, sliceInput("tilt").value] = button.dataset.plane.split(",");
    drawSlice();
  }));
  $("slice-roots").addEventListener("change", () => plane && sliceRoots());
  onChange((what) => plane && ["roots", "chosen", "colour"].some((one) => what.includes(one)) && showSlice());
  const seen = new IntersectionObserver((entries) => entries.some((entry) => entry.isIntersecting) && (seen.disconnect(), drawSlice()), { rootMargin: "200px" });
  seen.observe($("slices"));
  const start = { of: "rootness", at: "0", tilt: "0", turn: "-90" };
  addAddress(() => sliceSettings.filter((name) => sliceInput(name).value !== start[name]).map((name) => [`slice-${name}`, sliceInput(name).value]));
}
