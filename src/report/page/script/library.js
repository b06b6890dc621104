// plotly.js stands in the page as text and starts when it is first needed: words, tables, photographs and drawings do not wait for it.
const nonce = document.currentScript.nonce;
function startLibrary() {
  if (window.Plotly) return;
  const script = make("script", nonce ? { nonce } : {});
  script.textContent = $("plotly").textContent;
  document.head.append(script);
}
