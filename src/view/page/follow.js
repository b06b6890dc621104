// Takes what the server tells: new roots take the place of the old ones in all views, tables and plots.
const have = { ...live.have };
const KEPT_WITHIN_MM = 2;

function replaceSection(id, html) {
  const old = $(id), open = old ? [...old.querySelectorAll("details")].map((fold) => fold.open) : [];
  if (old && html) old.outerHTML = html;
  else if (old) old.remove();
  else if (html) $("traits").insertAdjacentHTML("afterend", html);
  if ($(id)) $(id).querySelectorAll("details").forEach((fold, n) => (fold.open = Boolean(open[n])));
}

// The middle of a root, and the root whose line passes it nearest.
const middleOf = (root) => root && root.xyz.slice(3 * (root.d.length >> 1), 3 * (root.d.length >> 1) + 3);
function rootAt(place) {
  let best = null, nearest = KEPT_WITHIN_MM;
  for (const root of place ? data.roots : []) {
    for (let k = 0; k < root.d.length; k++) {
      const far = Math.hypot(root.xyz[3 * k] - place[0], root.xyz[3 * k + 1] - place[1], root.xyz[3 * k + 2] - place[2]);
      if (far < nearest) [best, nearest] = [root.id, far];
    }
  }
  return best;
}

function takeSections(sections) {
  for (const id of ["figures", "glance", "traits", "corrections", "roots", "provenance"]) replaceSection(id, sections[id]);
  $("sides").innerHTML = sections.sides;
  tieTable();
  if (state.chosen !== null) rowOf(state.chosen)?.classList.add("chosen");
}

function takeRoots(fresh, turn) {
  const place = middleOf(rootOf.get(state.chosen));
  for (const key of ["roots", "kinds", "repairs", "perRoot", "profile"]) data[key] = fresh[key];
  rootOf.clear();
  data.roots.forEach((root) => rootOf.set(root.id, root));
  mesh = emptyMesh();
  Object.keys(ranges).forEach((name) => delete ranges[name]);
  // Lines of roots that are no more; those of the new ones come next.
  data.views.forEach((view) => (view.lines = []));
  document.querySelectorAll("svg.lines").forEach((svg) => svg.remove());
  const option = (root) => make("option", { value: root.id }, `Root ${root.id}, order ${root.order}`);
  $("choose").replaceChildren(make("option", { value: "" }, "none"), ...data.roots.map(option));
  drawnPlots.forEach(drawPlot);
  change({ roots: turn, chosen: rootAt(place) });
}

function takeViews(views) {
  views.forEach((view, n) => (data.views[n].lines = view.lines));
  document.querySelectorAll("svg.lines").forEach((svg) => svg.remove());
  const near = (button) => {
    const { top, bottom } = button.getBoundingClientRect();
    return bottom > -300 && top < innerHeight + 300;
  };
  const rest = gallery.filter((button) => !near(button));
  gallery.filter(near).forEach(drawLines);
  const seen = new IntersectionObserver((entries) => {
    for (const entry of entries) if (entry.isIntersecting) drawLines(entry.target), seen.unobserve(entry.target);
  }, { rootMargin: "300px" });
  rest.forEach((button) => seen.observe(button));
  if (state.chosen !== null) showChosen();
  if (viewer.open) drawViewer();
}

// Each kind of news once, however often it is told.
function fresh(kind, message) {
  if (have[kind] === message.digest) return false;
  have[kind] = message.digest;
  return true;
}

function follow() {
  const news = new EventSource(`${here}events`);
  const on = (kind, take) => news.addEventListener(kind, (event) => take(JSON.parse(event.data)));
  let isFirst = true;
  on("file", ({ values, kept }) => {
    fileValues = values;
    for (const name of Object.keys(changes)) if (changes[name] === values[name]) delete changes[name];
    document.querySelectorAll("[data-undo]").forEach((button) => (button.disabled = kept === 0 || live.readOnly));
    if (!fieldRows.size) tieFields();
    showFields();
  });
  on("begun", ({ turn, changes: told }) => {
    const asked = Object.fromEntries(live.fields.map(({ name }) => [name, givenValue(name)]).filter(([, value]) => value !== undefined));
    // The address says what this page is to show, before what another shows.
    if (isFirst && Object.keys(asked).length) {
      isFirst = false;
      Object.assign(changes, asked);
      showFields();
      return sendChanges(performance.now());
    }
    isFirst = false;
    if (!onItsWay && turn >= mine) {
      Object.keys(changes).forEach((name) => delete changes[name]);
      Object.assign(changes, told);
      showFields();
      writeAddress();
    }
    if (turn) say("Computing…");
  });
  on("progress", ({ node, done, total }) => say(`Computing ${node}${total ? `, ${Math.round((100 * done) / total)} %` : ""}…`));
  on("voxels", takeVoxels);
  on("roots", (message) => {
    // The roots go on in the table that the sections bring.
    takeSections(message.sections);
    if (fresh("roots", message)) takeRoots(message.content, message.turn);
    tellOutcome(message);
  });
  on("views", (message) => fresh("views", message) && takeViews(message.content));
  on("ended", ({ turn, error, help }) => {
    document.documentElement.dataset.ended = turn;
    if (error) tellOutcome({ turn, error });
    say(error ? error + (help ? `: ${help}` : "") : Object.keys(changes).length ? "Shown; not kept in the study file." : "As the study file says.", error);
  });
  news.addEventListener("error", () => say("The server does not answer: is rootvox view still running?", true));
}
