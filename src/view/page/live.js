// Ties what a live page adds to what the report has. Called before anything is drawn.
function tieLive() {
  $("shape").append(make("option", { value: "voxels" }, "root voxels"));
  document.querySelector("nav ul li:nth-child(2)").after(make("li", {}, make("a", { href: "#slices" }, "Slices")));
  tieAddress();
  tieSlices();
  tieCorrect();
  const marks = make("input", { type: "checkbox", id: "viewer-voxels" });
  document.querySelector("#viewer .tools").prepend(make("label", { class: "check" }, marks, " Root voxels"));
  // Made when it is looked at; the turn is there for the browser to ask anew.
  viewerImage = (n) => (marks.checked ? `${here}overlay/${n}?turn=${drawnTurn}` : pictureOf(n));
  marks.addEventListener("change", drawViewer);
  onChange((what) => what.includes("voxels") && viewer.open && marks.checked && drawViewer());
  const root = Number(given.get("root"));
  if (given.has("root") && rootOf.has(root)) setTimeout(() => choose(root));
  follow();
  const camera = setInterval(() => {
    if (!drawn) return;
    clearInterval(camera);
    scene.on("plotly_relayout", writeAddress);
  }, 200);
}
