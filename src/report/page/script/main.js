// Ties it together: what is seen first is drawn first.
tieSpace();
tieRoots();
tieGallery();
tieViewer();
drawLegend();
const ready = () => (document.documentElement.dataset.ready = "yes");
const drawRest = () => {
  tiePlots();
  if (hasWebGL()) return drawSpace().then(ready);
  document.body.classList.add("no-webgl");
  return ready();
};
if (typeof tieLive === "function") tieLive();
sketchSpace();
// Once the page is painted; a page in the background is drawn when somebody looks.
requestAnimationFrame(() => setTimeout(drawRest));
