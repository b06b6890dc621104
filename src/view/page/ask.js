// Asks the server to compute, to keep and to undo. While one question is on its way the newest next one waits, those between are dropped.
const here = location.pathname;
const changes = {};
const askedAt = new Map();
let mine = 0, onItsWay = false, waiting = null;

async function ask(what, body) {
  const answer = await fetch(here + what, { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(body) });
  const text = await answer.text();
  if (answer.ok) {
    const told = JSON.parse(text);
    document.documentElement.dataset.asked = told.turn;
    return told;
  }
  let said = text;
  try {
    said = JSON.parse(text).error;
  } catch {
    // A refusal in plain words.
  }
  throw new Error(said);
}

function say(text, isFault) {
  $("status").textContent = text;
  $("status").classList.toggle("fault", Boolean(isFault));
}

async function sendChanges(since) {
  waiting = { since, changes: { ...changes } };
  writeAddress();
  if (onItsWay) return;
  onItsWay = true;
  while (waiting) {
    const now = waiting;
    waiting = null;
    try {
      mine = (await ask("change", now.changes)).turn;
      askedAt.set(mine, now.since);
      tellShown();
    } catch (error) {
      say(error.message, true);
    }
  }
  onItsWay = false;
}

// How long it took from the event on the page until its root voxels are drawn; events may tell of a turn before the answer does.
let drawnTurn = 0, drawnAt = 0;
function tellShown() {
  if (!askedAt.has(drawnTurn)) return;
  document.documentElement.dataset.took = Math.round(drawnAt - askedAt.get(drawnTurn));
  document.documentElement.dataset.shown = drawnTurn;
}
