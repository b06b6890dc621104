// Ties it together: what is seen first is drawn first.
const hasWebGL = () => {
  try {
    return Boolean(document.createElement("canvas").getContext("webgl"));
  } catch {
    return false;
  }
};

tieSpace();
tieRoots();
tieGallery();
tieViewer();
drawLegend();
tiePlots();
const ready = () => (document.documentElement.dataset.ready = "yes");
if (hasWebGL()) {
  drawSpace().then(ready);
} else {
  document.body.classList.add("no-webgl");
  ready();
}
