// Opens report.html in a browser and uses it. Arguments: the browser, the results folder.
import { copyFileSync, existsSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { check, checkAccess, drawing, end, recorded, start, test } from "./harness.mjs";

const [executablePath, results] = process.argv.slice(2);
// Alone in a folder, as on a memory stick.
const folder = mkdtempSync(join(tmpdir(), "report-"));
copyFileSync(join(results, "report.html"), join(folder, "report.html"));
const address = pathToFileURL(join(folder, "report.html")).href;

function csv(name) {
  const [head, ...rows] = readFileSync(join(results, name), "utf8").trim().split("\n").map((line) => line.split(","));
  return rows.map((row) => Object.fromEntries(head.map((column, n) => [column, row[n]])));
}
const perRoot = csv("per_root.csv");

async function open(browser, options = {}) {
  const page = await recorded(browser, options);
  // Whether a frame with the roots in it comes before plotly.js starts.
  if (options.javaScriptEnabled !== false) {
    await page.addInitScript(() => {
      const look = () => {
        if (window.Plotly) return;
        if (document.querySelector("#view3d .sketch svg path")) window.sketchedFirst = true;
        requestAnimationFrame(look);
      };
      requestAnimationFrame(look);
    });
  }
  await page.goto(address);
  if (options.javaScriptEnabled !== false) await page.waitForSelector("html[data-ready=yes]", { timeout: 60000 });
  return page;
}

// A shown number is the file's to at least three digits.
function same(shown, exact) {
  const number = Number(shown.replace("−", "-"));
  return exact === "" ? shown === "–" : Math.abs(number - Number(exact)) <= 6e-4 * Math.abs(Number(exact));
}

async function panelShows(page, id) {
  const row = perRoot.find((row) => row.root_id === String(id));
  check((await page.textContent("#chosen-title")) === `Root ${id}`, `root ${id} is not the chosen one`);
  for (const [column, exact] of Object.entries(row)) {
    if (column === "root_id") continue;
    const cell = page.locator(`#chosen-body td[data-column="${column}"]`);
    check((await cell.getAttribute("data-value")) === exact, `${column} of root ${id} is not the file's`);
    const shown = (await cell.evaluate((td) => td.firstChild.textContent)).trim();
    check(same(shown, exact), `${column} of root ${id} is shown as ${shown}, the file says ${exact}`);
  }
}

const browser = await start(executablePath, drawing);
const begun = Date.now();
const page = await open(browser);
const opened = Date.now() - begun;

await test("the roots are drawn before plotly.js starts, and no drawing stays behind", async () => {
  check(await page.evaluate(() => window.sketchedFirst), "they were not");
  check((await page.locator(".sketch").count()) === 0, "the drawing is still there");
});
await test("a root chosen from the list shows its row of per_root.csv", async () => {
  for (const row of perRoot) {
    await page.selectOption("#choose", row.root_id);
    await panelShows(page, row.root_id);
  }
  return `${perRoot.length} roots`;
});
await test("keys choose the root after and before", async () => {
  await page.selectOption("#choose", perRoot[0].root_id);
  await page.focus("#view3d");
  await page.keyboard.press(".");
  await panelShows(page, perRoot[1].root_id);
  await page.keyboard.press(",");
  await panelShows(page, perRoot[0].root_id);
});
await test("keys turn the view", async () => {
  const eye = () => page.evaluate(() => JSON.stringify(document.getElementById("view3d").layout.scene.camera.eye));
  const before = await eye();
  await page.keyboard.press("ArrowLeft");
  await page.waitForTimeout(200);
  check((await eye()) !== before, "the camera stands still");
  await page.keyboard.press("Home");
});
await test("a root clicked in the view is chosen", async () => {
  await page.selectOption("#choose", "");
  await page.locator("#view3d").scrollIntoViewIfNeeded();
  await page.waitForTimeout(500);
  const box = await page.locator("#view3d").boundingBox();
  for (let down = 0.15; down < 0.85; down += 0.04) {
    for (let right = 0.3; right < 0.7; right += 0.02) {
      await page.mouse.move(box.x + box.width * right, box.y + box.height * down);
      await page.waitForTimeout(40);
      const told = /^Root (\d+),/.exec(await page.textContent("#view3d-help"));
      if (!told) continue;
      await page.mouse.down();
      await page.mouse.up();
      await page.waitForFunction(() => document.getElementById("chosen-title").textContent.startsWith("Root "));
      await panelShows(page, told[1]);
      return `root ${told[1]}`;
    }
  }
  throw new Error("no root was found under the pointer");
});
await test("the photographs that show a root best have it drawn on them", async () => {
  const crops = page.locator("#chosen-body .best svg");
  check((await crops.count()) > 0, "there is none");
  for (const svg of await crops.all()) {
    check((await svg.locator("image").getAttribute("href")).startsWith("data:image/jpeg;base64,"), "a picture is missing");
    check((await svg.locator("path").last().getAttribute("d")).startsWith("M"), "a line is missing");
  }
});
await test("every way to colour and to draw gives a legend and no fault", async () => {
  for (const shape of ["lines", "tubes"]) {
    await page.selectOption("#shape", shape);
    for (const colour of ["root", "d", "depth", "confidence", "repair", "order"]) {
      await page.selectOption("#colour", colour);
      check((await page.textContent("#legend")).length > 3, `no legend by ${colour}`);
    }
  }
});
await test("a photograph opens large, its roots go on and off, the slider bares it", async () => {
  await page.locator(".gallery .photo").nth(1).click();
  const svg = page.locator("#viewer-picture svg.lines");
  check(await page.locator("#viewer").evaluate((dialog) => dialog.open), "it does not open");
  check((await svg.locator("path").count()) > 0, "no root is drawn on it");
  await page.uncheck("#viewer-roots");
  check(!(await svg.isVisible()), "the roots stay");
  await page.check("#viewer-roots");
  await page.locator("#viewer-split").fill("40");
  check((await svg.evaluate((svg) => svg.style.clipPath)).includes("40%"), "the slider does nothing");
  const before = await page.textContent("#viewer-title");
  await page.click("#viewer-after");
  check((await page.textContent("#viewer-title")) !== before, "there is no next one");
  await page.keyboard.press("Escape");
  check(!(await page.locator("#viewer").evaluate((dialog) => dialog.open)), "it does not close");
});
await test("the traits are those of traits.csv, each with its definition", async () => {
  for (const { trait, value } of csv("traits.csv")) {
    const cell = page.locator(`[data-trait="${trait}"]`);
    check(same(await cell.textContent(), value), `${trait} is shown as ${await cell.textContent()}, the file says ${value}`);
  }
  if (existsSync(join(results, "trait_spread.csv"))) {
    for (const { trait, sd } of csv("trait_spread.csv")) {
      const shown = (await page.locator(`[data-trait="${trait}"] + td`).textContent()).trim();
      const near = Math.abs(Number(shown) - Number(sd)) <= 0.051 * Math.abs(Number(sd));
      check(sd === "" ? shown === "–" : near, `the deviation of ${trait} is shown as ${shown}, the file says ${sd}`);
    }
  }
  const term = page.locator(".traits .term").first();
  await term.focus();
  check(await page.locator(`[id="${await term.getAttribute("aria-describedby")}"]`).isVisible(), "focus shows no definition");
});
await test("the plots are drawn where they are looked at", async () => {
  for (const id of ["plot-diameter", "plot-order", "plot-angle", "plot-depth"]) {
    await page.locator(`#${id}`).scrollIntoViewIfNeeded();
    await page.waitForSelector(`#${id} .bars path`, { state: "attached", timeout: 20000 });
  }
});
await test("a heading sorts the table of all roots", async () => {
  await page.click('#root-table [data-column="3"]');
  const shown = await page.locator("#root-table tbody td:nth-child(4)").evaluateAll((cells) => cells.map((td) => Number(td.dataset.value)));
  check(shown.every((x, n) => n === 0 || shown[n - 1] <= x), "lengths do not rise");
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
    await page.selectOption("#choose", perRoot[0].root_id);
    await checkAccess(page, () => page.locator(".gallery .photo").first().click());
    await page.context().close();
  });
}
await test("without scripts traits, photographs and drawings of the roots are there", async () => {
  const page = await open(browser, { javaScriptEnabled: false });
  for (const what of [".traits table", ".gallery img", "#space .paper svg"]) check(await page.locator(what).first().isVisible(), `no ${what}`);
  await page.context().close();
});
await browser.close();

const plain = await start(executablePath, ["--disable-gpu", "--disable-3d-apis"]);
await test("without WebGL drawings stand in for the view in space", async () => {
  const page = await open(plain);
  check(await page.locator("#space .paper svg").first().isVisible(), "there are none");
  await page.selectOption("#choose", perRoot[0].root_id);
  await panelShows(page, perRoot[0].root_id);
  check(page.faults.length === 0, page.faults.join("; "));
});
await plain.close();
rmSync(folder, { recursive: true });

console.log(`opened in ${(opened / 1000).toFixed(1)} s on this machine, ${(readFileSync(join(results, "report.html")).length / 1e6).toFixed(1)} MB`);
end();
