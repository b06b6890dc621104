// Ties it together: what is seen first is drawn first.
tieViews();
tieRows();
drawLegend();
views.forEach(({ scene }, n) => {
  const side = document.querySelectorAll("#space .paper svg")[n].cloneNode(true);
  side.setAttribute("aria-hidden", "true");
  scene.append(make("div", { class: "sketch" }, side));
});
async function drawAll() {
  if (hasWebGL()) {
    startLibrary();
    for (const view of views) await drawView(view);
  } else {
    document.body.classList.add("no-webgl");
  }
  document.documentElement.dataset.ready = "yes";
}
// Once the page is painted; a page in the background is drawn when somebody looks.
requestAnimationFrame(() => setTimeout(drawAll));
