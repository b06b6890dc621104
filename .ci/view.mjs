// Opens `rootvox view` in a browser and uses it. Arguments: the browser, the program, a study file, a folder for its store and pictures.
import { spawn } from "node:child_process";
import { copyFileSync, existsSync, mkdirSync, readFileSync, rmSync } from "node:fs";
import { join, resolve } from "node:path";
import { check, checkAccess, drawing, end, recorded, start, test } from "./harness.mjs";

const [executablePath, program, study, folder, ...more] = process.argv.slice(2);
mkdirSync(folder, { recursive: true });
rmSync(join(folder, "corrections.toml"), { force: true });
const copy = join(folder, "study.toml");
copyFileSync(study, copy);

const server = spawn(resolve(program), ["view", copy, "--no-open", ...more], { env: { ROOTVOX_CACHE: join(folder, "cache"), ...process.env }, stdio: ["ignore", "pipe", "inherit"] });
const address = await new Promise((found, lost) => {
  server.stdout.once("data", (text) => found(String(text).trim()));
  server.once("exit", (code) => lost(new Error(`rootvox view ended with ${code}`)));
});
process.on("exit", () => server.kill());
const browser = await start(executablePath, drawing);

async function open(where = address, options = {}) {
  const page = await recorded(browser, options);
  await page.goto(where);
  await page.waitForSelector("html[data-ready=yes]", { timeout: 60000 });
  await page.waitForFunction(() => document.querySelectorAll("#fields .field").length > 20);
  return page;
}

const told = (page) => page.textContent("#voxels-told");
const shown = (page) => page.evaluate(() => Number(document.documentElement.dataset.shown || 0));
// Moves a slider and waits until the root voxels of that change are drawn; hands back how long it took, ms.
async function slide(page, name, value) {
  const before = await shown(page);
  await page.locator(`input[type=range][aria-label="${name}"]`).evaluate((input, value) => {
    input.value = value;
    input.dispatchEvent(new Event("input", { bubbles: true }));
  }, value);
  await page.waitForFunction((before) => Number(document.documentElement.dataset.shown || 0) > before, before, { timeout: 120000 });
  return page.evaluate(() => Number(document.documentElement.dataset.took));
}
// Waits until all that was asked for is there.
async function ended(page) {
  await page.waitForTimeout(300);
  await page.waitForFunction(() => document.documentElement.dataset.ended === document.documentElement.dataset.asked, null, { timeout: 120000 });
}

const page = await open();
await test("every setting has a slider or a list, its help, and its default", async () => {
  const fields = await page.locator("#fields .field").count();
  const about = await page.locator("#fields [role=tooltip]").evaluateAll((all) => all.filter((one) => one.textContent.length > 10).length);
  check(about === fields, `${about} of ${fields} have help`);
  const term = page.locator("#fields .term").first();
  await term.focus();
  check(await page.locator(`[id="${await term.getAttribute("aria-describedby")}"]`).isVisible(), "focus shows no help");
  return `${fields} settings`;
});
await test("a slider on extract.high shows other root voxels, twenty times", async () => {
  const times = [];
  await slide(page, "extract.high", 1.5);
  await ended(page);
  // High and low in turn, so that every change gives others; none of them was computed before.
  for (let n = 0; n < 20; n++) {
    const before = await told(page);
    times.push(await slide(page, "extract.high", (n % 2 ? 0.8 + 0.02 * n : 2.1 + 0.02 * n).toFixed(2)));
    check((await told(page)) !== before, `${before} as before`);
    await ended(page);
  }
  times.sort((a, b) => a - b);
  return `from the event to the drawn voxels: median ${(times[9] + times[10]) / 2} ms, ${times[0]} to ${times[19]} ms`;
});
await test("of ten changes in a second the last is shown", async () => {
  for (let n = 0; n < 10; n++) {
    await page.locator('input[type=range][aria-label="extract.high"]').evaluate((input, value) => {
      input.value = value;
      input.dispatchEvent(new Event("input", { bubbles: true }));
    }, (2 + 0.1 * n).toFixed(1));
    await page.waitForTimeout(90);
  }
  await ended(page);
  check(page.url().includes("extract.high=2.9"), `the address is ${page.url()}`);
  const now = await told(page), again = await open(page.url());
  await ended(again);
  check((await told(again)) === now, `the address shows ${await told(again)}, not ${now}`);
  check((await again.inputValue('input[type=range][aria-label="extract.high"]')) === "2.9", "the slider does not follow the address");
  check((await again.inputValue("#shape")) === "voxels", "the way to draw does not follow the address");
  await again.context().close();
});
await test("tracing gives new roots in the view, the tables, the numbers and on photographs", async () => {
  const rows = () => page.locator("#root-table tbody tr").count();
  const before = [await rows(), await page.textContent("#figures")];
  await page.evaluate(() => document.querySelectorAll("#fields details").forEach((fold) => (fold.open = true)));
  await slide(page, "trace.high", 2);
  await ended(page);
  const after = [await rows(), await page.textContent("#figures")];
  check(after[0] !== before[0] && after[1] !== before[1], `${before} and ${after}`);
  check((await page.locator("#choose option").count()) === after[0] + 1, "the list of roots is another");
  check((await page.inputValue("#shape")) === "tubes", "the roots are not drawn");
  await page.locator(".gallery .photo").first().click();
  const lines = await page.locator("#viewer-picture svg.lines path").count();
  check(lines > 0 && lines <= after[0], `${lines} lines on the photograph`);
  const bare = await page.getAttribute("#viewer-picture img", "src");
  await page.check("#viewer-voxels");
  const picture = page.locator("#viewer-picture img");
  check((await picture.getAttribute("src")) !== bare, "the photograph with root voxels is the bare one");
  await picture.evaluate((img) => img.decode());
  await page.keyboard.press("Escape");
});
await test("slices by any plane have the roots drawn in", async () => {
  await page.locator("#slices").scrollIntoViewIfNeeded();
  await page.waitForSelector("#slice img");
  const first = await page.getAttribute("#slice img", "src");
  await page.click("[data-plane='0,90']");
  await page.waitForFunction((first) => document.querySelector("#slice img").src !== first, first);
  await page.locator("#slice-tilt").fill("63");
  await page.locator("#slice-at").fill("3");
  await page.waitForFunction(() => /[1-9]\d* of \d+ roots are cut/.test(document.querySelector("#slice-told").textContent));
  check((await page.locator("#slice svg > *").count()) > 0, "no root is drawn in");
});
await test("keep writes the study file, undo takes it back", async () => {
  const before = readFileSync(copy, "utf8");
  await page.click("#keep");
  await page.waitForFunction(() => !document.getElementById("undo").disabled);
  const kept = readFileSync(copy, "utf8");
  check(kept.includes("high = 2.9") && kept.includes(before.split("\n")[0]), kept);
  await page.waitForFunction(() => document.getElementById("keep").disabled);
  await page.click("#undo");
  await page.waitForFunction(() => !document.getElementById("keep").disabled);
  check(readFileSync(copy, "utf8") === before, "the file is another");
});
await test("a fault of the settings is told, and the next change computes", async () => {
  await slide(page, "extract.low", 2.95).catch(() => {});
  await page.locator('input[type=range][aria-label="extract.high"]').evaluate((input) => {
    input.value = 0.5;
    input.dispatchEvent(new Event("input", { bubbles: true }));
  });
  await page.waitForFunction(() => document.querySelector("#status.fault") !== null, null, { timeout: 60000 });
  check((await page.textContent("#status")).includes("extract.low"), await page.textContent("#status"));
  await page.click("#reset");
  await page.waitForFunction(() => document.querySelector("#status").textContent === "As the study file says.", null, { timeout: 60000 });
});
const corrections = join(folder, "corrections.toml");
const rows = () => page.locator("#root-table tbody tr").evaluateAll((all) => all.map((row) => row.textContent));
// Waits for what became of the correction that was made last.
async function outcome(kind) {
  await page.waitForFunction((kind) => new RegExp(`^(Done|Not applied|Not written|Not computed)(: ${kind}|: )`).test(document.querySelector("#correct-told").textContent), kind, { timeout: 60000 });
  const said = await page.textContent("#correct-told");
  check(said.startsWith(`Done: ${kind}`), said);
  return said;
}
// Takes the last correction back and waits until all is as before.
async function undo(before) {
  await page.click("#correct [data-undo]");
  await page.waitForFunction((before) => [...document.querySelectorAll("#root-table tbody tr")].map((row) => row.textContent).join() === before.join(), before, { timeout: 60000 });
}
// Where the view shows the vertices of the roots' surfaces, every so many of them; px of the page.
const vertices = (every) => page.evaluate((every) => {
  const view = document.getElementById("view3d"), { left, top, width, height } = view.getBoundingClientRect();
  const { glplot, dataScale } = view._fullLayout.scene._scene, { x, y, z } = view.data[0];
  const { model, view: turned, projection } = glplot.cameraParams;
  const times = (m, p) => [0, 1, 2, 3].map((row) => m[row] * p[0] + m[4 + row] * p[1] + m[8 + row] * p[2] + m[12 + row] * p[3]);
  const all = [];
  for (let n = 0; n < x.length; n += every) {
    const [u, v, , w] = [model, turned, projection].reduce((p, m) => times(m, p), [x[n] * dataScale[0], y[n] * dataScale[1], z[n] * dataScale[2], 1]);
    all.push([left + width * (0.5 + (0.5 * u) / w), top + height * (0.5 - (0.5 * v) / w)]);
  }
  return all;
}, every);
// Points at roots in the view until one that `fits` its number, order and place on the page, and clicks it; hands back number and place.
async function clickRoot(fits, every = 89) {
  await page.locator("#view3d").scrollIntoViewIfNeeded();
  await page.waitForTimeout(300);
  for (const place of await vertices(every)) {
    // What was told of the root before would still stand there.
    await page.evaluate(() => (document.querySelector("#view3d-help").textContent = ""));
    await page.mouse.move(...place);
    await page.waitForTimeout(80);
    const told = /^Root (\d+), order (\d+)/.exec(await page.textContent("#view3d-help"));
    if (!told || !(await fits(Number(told[1]), Number(told[2]), place))) continue;
    await page.mouse.down();
    await page.mouse.up();
    return [Number(told[1]), place];
  }
  throw new Error(`no such root was found under the pointer, to ${await page.textContent("#correct-told")}`);
}

await test("a root is removed by a click in the view, and comes back", async () => {
  const before = await rows();
  await page.fill("#correct-by", "Ada");
  await page.click("[data-correct=remove]");
  check((await page.textContent("#correct-told")).startsWith("Click"), "it does not say what to click");
  const [id] = await clickRoot((_, order) => order > 0);
  const said = await outcome("remove");
  const after = await rows();
  const text = readFileSync(corrections, "utf8");
  check(text.includes('kind = "remove"') && text.includes('by = "Ada"') && text.includes('when = "20'), text);
  check(readFileSync(copy, "utf8").includes('file = "corrections.toml"'), "the study does not name the file");
  check(after.length < before.length && (await page.locator(`#root-table tr[data-root="${id}"]`).count()) === 0, "it is still there");
  // Others are as they were, but for what its parent counts of laterals.
  check(after.filter((row) => !before.includes(row)).length <= 1, "other roots changed");
  check(await page.locator("#corrections table").first().isVisible(), "the correction is not listed");
  await undo(before);
  check(!existsSync(corrections) && !readFileSync(copy, "utf8").includes("corrections"), "the files are not as before");
  return said;
});
await test("a root is hung on another by two clicks", async () => {
  const before = await rows();
  await page.click("[data-correct=parent]");
  const [child] = await clickRoot((_, order) => order > 0);
  await page.waitForFunction(() => document.querySelector("#correct-told").textContent.includes("on its parent"));
  const table = await page.locator("#root-table tbody tr").evaluateAll((all) => all.map((row) => [row.dataset.root, row.children[1].dataset.value]));
  const isBelow = (id) => {
    for (let at = String(id), n = 0; n < 20 && at !== "-1"; n++) {
      if (at === String(child)) return true;
      at = (table.find(([root]) => root === at) || [])[1];
      if (at === undefined) return false;
    }
    return false;
  };
  const [parent] = await clickRoot((id) => !isBelow(id) && (table.find(([root]) => root === String(child)) || [])[1] !== String(id));
  const said = await outcome("parent");
  const now = await page.locator(`#root-table tr[data-root="${child}"] td`).first().textContent();
  check(now === String(parent), `its parent is ${now}, not ${parent}`);
  const changed = (await rows()).filter((row) => !before.includes(row)).length;
  check(changed >= 1 && changed < before.length / 2, `${changed} rows changed`);
  await undo(before);
  return said;
});
await test("every other kind is made by clicks", async () => {
  const before = await rows(), told = [];
  for (const [kind, clicks] of [["checked", 1], ["order", 1], ["base", 1], ["cut", 1], ["remove-stretch", 2]]) {
    if (kind === "order") await page.fill("#correct-order", "3");
    await page.click(`[data-correct=${kind}]`);
    const wanted = kind === "base" ? 0 : 1;
    const [first, [u, v]] = await clickRoot((_, order) => order === wanted);
    // The second place is on the same root, further along it.
    if (clicks === 2) await clickRoot((id, _, place) => id === first && Math.hypot(place[0] - u, place[1] - v) > 15, 7);
    await page.waitForFunction(() => /^(Done|Not )/.test(document.querySelector("#correct-told").textContent), null, { timeout: 60000 });
    told.push(await page.textContent("#correct-told"));
    check(readFileSync(corrections, "utf8").includes(`kind = "${kind}"`), `${kind} is not written`);
    await undo(before);
  }
  check(told.every((said) => said.startsWith("Done")), told.join("; "));
  return told.map((said) => said.slice(0, 60)).join("; ");
});
await test("a root is added by clicking its places in two photographs", async () => {
  const before = await rows();
  // A root whose ends two photographs show at about the same heights, as the same places are in a level ring of cameras: it is taken out
  // and clicked in again.
  const found = await page.evaluate(() => {
    dispatchEvent(new Event("beforeprint"));
    const photos = [...document.querySelectorAll(".gallery .photo")];
    const from = photos.map((photo) => Number(/from (\d+)°/.exec(photo.parentElement.textContent)[1]));
    const ends = (photo, id) => {
      const path = photo.querySelector(`path[data-root="${id}"]`);
      if (!path || path.getAttribute("d").split("M").length !== 2) return null;
      const places = path.getAttribute("d").slice(1).split("L").map((place) => place.split(" ").map(Number));
      return [places[0], places.at(-1)];
    };
    let best = null;
    for (const { dataset } of [...document.querySelectorAll("#root-table tbody tr")].slice(1)) {
      const seen = photos.map((photo) => ends(photo, dataset.root));
      seen.forEach((one, i) => seen.forEach((other, j) => {
        const apart = Math.abs(((from[i] - from[j] + 540) % 360) - 180);
        if (i >= j || !one || !other || apart < 20 || apart > 70 || Math.abs(one[1][1] - one[0][1]) < 40) return;
        const off = Math.max(...[0, 1].map((n) => Math.abs(one[n][1] - other[n][1])));
        if (!best || off < best.off) best = { off, id: Number(dataset.root), clicks: [[i, one], [j, other]] };
      }));
    }
    return best;
  });
  check(found && found.off < 2, JSON.stringify(found));
  await page.selectOption("#choose", String(found.id));
  await page.click("[data-correct=remove]");
  await page.click("#correct-chosen");
  await outcome("remove");
  await ended(page);
  const removed = await rows();
  await page.selectOption("#correct-tie", "none");
  await page.click("[data-correct=add]");
  for (const [n, line] of found.clicks) {
    const name = /Photograph (.*): open large/.exec(await page.locator(".gallery .photo").nth(n).getAttribute("aria-label"))[1];
    for (let k = 0; k < 100 && !(await page.textContent("#viewer-title")).startsWith(name); k++) await page.click("#viewer-after");
    for (const [x, y] of line) {
      const place = await page.locator("#viewer-picture svg.clicks").evaluate((svg, [x, y]) => {
        const { x: left, y: top } = new DOMPoint(x, y).matrixTransform(svg.getScreenCTM());
        return [left, top];
      }, [x, y]);
      await page.mouse.click(...place);
    }
    check((await page.locator("#viewer-picture .clicks path").count()) === 2, "the clicks are not drawn");
    check((await page.locator("#add-done").isDisabled()) === (n === found.clicks[0][0]), "two photographs are enough, one is not");
  }
  await page.screenshot({ path: join(folder, "adding.png") });
  await page.click("#add-done");
  const said = await outcome("add");
  check(readFileSync(corrections, "utf8").includes("photo = "), readFileSync(corrections, "utf8"));
  const after = await rows();
  check(after.length === removed.length + 1 && removed.every((row) => after.includes(row)), "other roots changed");
  await ended(page);
  await undo(removed);
  await undo(before);
  check(!existsSync(corrections), "the file is still there");
  return said;
});
await test("no fault is told, and nothing is asked for outside the server", async () => {
  check(page.faults.length === 0, page.faults.join("; "));
  const strange = page.asked.filter((url) => !url.startsWith(address) && !/^(data|blob):/.test(url));
  check(strange.length === 0, strange.join(", "));
});
for (const [name, options] of [
  ["1440-light", { colorScheme: "light" }],
  ["1440-dark", { colorScheme: "dark" }],
  ["390-light", { colorScheme: "light", viewport: { width: 390, height: 844 }, hasTouch: true }],
  ["390-dark", { colorScheme: "dark", viewport: { width: 390, height: 844 }, hasTouch: true }],
]) {
  await test(`axe-core finds no serious fault at ${name}`, async () => {
    const page = await open(address, options);
    await page.locator("#slices").scrollIntoViewIfNeeded();
    await page.waitForSelector("#slice img");
    await page.screenshot({ path: join(folder, `slices-${name}.png`) });
    await page.locator("#space").scrollIntoViewIfNeeded();
    await page.evaluate(() => document.getElementById("space").scrollIntoView());
    await page.waitForTimeout(300);
    await page.screenshot({ path: join(folder, `space-${name}.png`) });
    await checkAccess(page);
    await page.context().close();
  });
}
await browser.close();
await test("Ctrl-C ends it", async () => {
  const ended = new Promise((done) => server.once("exit", done));
  server.kill("SIGINT");
  check((await ended) === 0, "it ends with an error");
});
end();
