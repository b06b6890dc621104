// Opens a page of `rootvox compare` in a browser and uses it. Arguments: the browser, the page, the results folders it was made of.
import { copyFileSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { check, checkAccess, drawing, end, recorded, start, test } from "./harness.mjs";

const [executablePath, made, ...results] = process.argv.slice(2);
// Alone in a folder, as on a memory stick.
const folder = mkdtempSync(join(tmpdir(), "compare-"));
copyFileSync(made, join(folder, "compare.html"));
const address = pathToFileURL(join(folder, "compare.html")).href;

async function open(browser, options = {}) {
  const page = await recorded(browser, options);
  await page.goto(address);
  if (options.javaScriptEnabled !== false) await page.waitForSelector("html[data-ready=yes]", { timeout: 120000 });
  return page;
}

const browser = await start(executablePath, drawing);
const begun = Date.now();
const page = await open(browser);
const opened = Date.now() - begun;
const data = JSON.parse(await page.textContent("#data"));
const count = data.results.length;

const cameras = () => page.evaluate((count) => {
  const of = (n) => document.getElementById(`view-${n}`).layout.scene.camera;
  return Array.from({ length: count }, (_, n) => ["eye", "center", "up"].flatMap((part) => ["x", "y", "z"].map((axis) => of(n)[part][axis])));
}, count);
const apart = (a, b) => Math.max(...a.map((x, k) => Math.abs(x - b[k])));
// All views look alike, and otherwise than before.
async function allTurned(before) {
  await page.waitForTimeout(400);
  const now = await cameras();
  check(apart(now[0], before[0]) > 0.05, "the first view stands still");
  now.forEach((camera, n) => check(apart(camera, now[0]) < 1e-3, `view ${n} looks otherwise than view 0`));
}
// Depths that the marked root of each view reaches; null where none is marked.
const marked = () => page.evaluate((count) => Array.from({ length: count }, (_, n) => {
  const { visible, z } = document.getElementById(`view-${n}`).data[2];
  return visible ? [Math.min(...z), Math.max(...z)].map((z) => -z) : null;
}), count);
// Whether what is marked in a view is its root at a place.
function isMarked(depths, n, place) {
  const root = data.results[n].roots[place], z = root.xyz.filter((_, k) => k % 3 === 2), wide = Math.max(...root.d) + data.tank.radius / 100;
  return depths && Math.abs(depths[1] - Math.min(...z)) < wide && Math.abs(depths[0] - Math.max(...z)) < wide;
}

await test("every result has a view, and no drawing stays behind", async () => {
  check((await page.locator(".view .main-svg").count()) >= count, "a view is not drawn");
  check((await page.locator(".sketch").count()) === 0, "a drawing is still there");
  return `${count} results`;
});
await test("keys and buttons turn all views", async () => {
  for (const by of [() => page.focus("#view-1").then(() => page.keyboard.press("ArrowLeft")), () => page.click('[data-turn="up"]')]) {
    const before = await cameras();
    await by();
    await allTurned(before);
  }
  await page.focus("#view-0");
  await page.keyboard.press("Home");
});
await test("one view dragged turns the others with it", async () => {
  for (const n of [0, count - 1]) {
    await page.locator(`#view-${n}`).scrollIntoViewIfNeeded();
    const box = await page.locator(`#view-${n}`).boundingBox(), before = await cameras();
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + 50, y + 8, { steps: 8 });
    await page.waitForTimeout(600);
    const during = await cameras();
    check(apart(during[count - 1 - n], before[0]) > 0.02, "the other view waits for the end of the drag");
    await page.mouse.move(x + 90, y + 8, { steps: 8 });
    await page.mouse.up();
    await allTurned(before);
  }
});
await test("a row marks its root in every view that has it", async () => {
  const rows = page.locator(".differing tbody tr");
  check((await rows.count()) > 0, "no root differs");
  const seen = {};
  for (const row of await rows.all()) {
    const other = Number(await row.evaluate((tr) => tr.closest("table").dataset.other)), entry = data.entries[other][await row.getAttribute("data-entry")];
    await row.locator("td").first().click();
    const depths = await marked();
    for (const [n, place] of [[0, entry.first], [other + 1, entry.other]]) {
      check(place === null ? !depths[n] : isMarked(depths[n], n, place), `${await row.innerText()}: ${depths[n]} is marked in view ${n}`);
    }
    check(await row.locator("button").getAttribute("aria-pressed") === "true", "its button does not tell");
    seen[entry.fate] = (seen[entry.fate] || 0) + 1;
  }
  await page.focus("#view-0");
  await page.keyboard.press(".");
  check(await rows.first().evaluate((row) => row.classList.contains("chosen")), "full stop does not go on to the first row");
  return Object.entries(seen).map(([fate, n]) => `${n} ${fate}`).join(", ");
});
await test("a root clicked in a view is told and marked", async () => {
  await page.click('[data-view="side"]');
  await page.locator("#view-1").scrollIntoViewIfNeeded();
  await page.waitForTimeout(500);
  const box = await page.locator("#view-1").boundingBox();
  for (let down = 0.15; down < 0.85; down += 0.04) {
    for (let right = 0.3; right < 0.7; right += 0.02) {
      await page.mouse.move(box.x + box.width * right, box.y + box.height * down);
      await page.waitForTimeout(40);
      if (!(await page.evaluate(() => document.querySelector("#view-1 .nsewdrag, #view-1 canvas") && document.getElementById("told").textContent.includes("of B")))) continue;
      const told = await page.textContent("#told");
      await page.mouse.down();
      await page.mouse.up();
      await page.waitForTimeout(300);
      const id = Number(/root (\d+) of B|Root (\d+) of B/i.exec(told).slice(1).find(Boolean));
      check(isMarked((await marked())[1], 1, data.results[1].roots.findIndex((root) => root.id === id)), `${told} is not marked`);
      return told;
    }
  }
  throw new Error("no root was found under the pointer");
});
await test("the traits are those of traits.csv", async () => {
  let compared = 0;
  for (const [n, folder] of results.entries()) {
    const [, ...lines] = readFileSync(join(folder, "traits.csv"), "utf8").trim().split("\n");
    for (const [trait, exact] of lines.map((line) => line.split(","))) {
      const shown = (await page.textContent(`[data-trait="${trait}"][data-result="${n}"]`)).replace("−", "-");
      check(exact === "" ? shown === "–" : Math.abs(Number(shown) - Number(exact)) <= 6e-4 * Math.abs(Number(exact)), `${trait} of ${folder} is shown as ${shown}, the file says ${exact}`);
      compared++;
    }
  }
  return `${compared} values`;
});
await test("no fault is told, and nothing is asked for outside the file", async () => {
  check(page.faults.length === 0, page.faults.join("; "));
  const strange = page.asked.filter((url) => url !== address && !/^(data|blob):/.test(url));
  check(strange.length === 0, strange.join(", "));
});
for (const [name, options] of [
  ["1440 px, light", { colorScheme: "light" }],
  ["390 px, dark", { colorScheme: "dark", viewport: { width: 390, height: 844 }, hasTouch: true }],
]) {
  await test(`axe-core finds no serious fault at ${name}`, async () => {
    const page = await open(browser, options);
    await checkAccess(page, () => page.locator(".differing tbody button").first().click());
    if (process.env.PICTURES) await page.screenshot({ path: join(process.env.PICTURES, `compare-${name.replace(/\W+/g, "-")}.png`), fullPage: true });
    await page.context().close();
  });
}
await test("without scripts drawings, differences and traits are there", async () => {
  const page = await open(browser, { javaScriptEnabled: false });
  for (const what of ["#space .paper svg", ".differing", ".compared"]) check(await page.locator(what).first().isVisible(), `no ${what}`);
  await page.context().close();
});
await browser.close();

const plain = await start(executablePath, ["--disable-gpu", "--disable-3d-apis"]);
await test("without WebGL drawings stand in for the views, and rows still tell", async () => {
  const page = await open(plain);
  check(await page.locator("#space .paper svg").first().isVisible(), "there are none");
  await page.locator(".differing tbody button").first().click();
  check(/root \d+/i.test(await page.textContent("#told")), "nothing is told");
  check(page.faults.length === 0, page.faults.join("; "));
});
await plain.close();
rmSync(folder, { recursive: true });

console.log(`opened in ${(opened / 1000).toFixed(1)} s on this machine, ${(readFileSync(made).length / 1e6).toFixed(1)} MB`);
end();
