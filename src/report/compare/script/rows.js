// What became of each root: entries of each result but the first, and their rows. A chosen one is [place of the result less one, entry].
const rows = [...document.querySelectorAll(".differing tbody tr")];
const keyOf = (row) => [Number(row.closest("table").dataset.other), Number(row.dataset.entry)];
const isPair = (entry) => entry.first !== null && entry.other !== null && data.fates.findIndex((f) => f.name === entry.fate) < 3;

// In every result the place of the root that is marked for the chosen entry; null where it has none.
function marks() {
  const none = views.map(() => null);
  if (!state.chosen) return none;
  const [other, k] = state.chosen, entry = data.entries[other][k];
  const elsewhere = (n) => data.entries[n].find((e) => e.first === entry.first && e.is_of_first)?.other ?? null;
  return none.map((_, n) => {
    if (n === 0) return entry.first;
    if (n - 1 === other) return entry.other;
    return entry.first === null ? null : elsewhere(n - 1);
  });
}

// The entry of a root of a result: of the first's roots, where it differs most.
function entryOf(n, place) {
  const rank = (entry) => data.fates.findIndex((f) => f.name === entry.fate);
  if (n > 0) {
    const k = data.entries[n - 1].findIndex((e) => e.other === place && (isPair(e) || !e.is_of_first));
    return [n - 1, k];
  }
  const all = data.entries.map((entries, other) => [other, entries.findIndex((e) => e.first === place && e.is_of_first)]);
  return all.reduce((best, one) => (rank(data.entries[one[0]][one[1]]) > rank(data.entries[best[0]][best[1]]) ? one : best));
}

// An entry in words.
function words([other, k]) {
  const entry = data.entries[other][k], letter = data.results[other + 1].letter;
  const a = entry.first === null ? null : data.results[0].roots[entry.first].id;
  const b = entry.other === null ? null : data.results[other + 1].roots[entry.other].id;
  if (entry.fate === "part") return entry.is_of_first ? `Root ${a} of A is a part of root ${b} in ${letter}.` : `Root ${b} of ${letter} is a part of root ${a} in A.`;
  if (entry.fate === "only") return entry.is_of_first ? `Root ${a} is in A only, not in ${letter}.` : `Root ${b} is in ${letter} only.`;
  const what = entry.differs.length ? `another ${entry.differs.join(", ")}` : "no difference";
  return `Root ${a} of A is root ${b} of ${letter}: ${what}.`;
}

const tell = (n, place) => ($("told").textContent = words(entryOf(n, place)));

// The row before (-1) or after (1) the chosen one.
function stepRow(by) {
  const at = rows.findIndex((row) => row.classList.contains("chosen")), n = rows.length;
  if (n) change({ chosen: keyOf(rows[at < 0 ? (by > 0 ? 0 : n - 1) : (at + by + n) % n]) });
}

function tieRows() {
  rows.forEach((row) => row.addEventListener("click", () => {
    change({ chosen: row.classList.contains("chosen") ? null : keyOf(row) });
    $("space").scrollIntoView();
  }));
  onChange((what) => {
    if (!what.includes("chosen")) return;
    for (const row of rows) {
      const chosen = Boolean(state.chosen) && keyOf(row).join() === state.chosen.join();
      row.classList.toggle("chosen", chosen);
      row.querySelector("button").setAttribute("aria-pressed", chosen);
    }
    $("told").textContent = state.chosen ? words(state.chosen) : "No root is chosen.";
  });
}
