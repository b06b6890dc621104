// What the browser tests share: the browser, tests one by one, what axe-core says of a page.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { chromium } from "playwright-core";

const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const flags = [
  "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync",
];
// Draws in space without a graphics card.
export const drawing = ["--disable-gpu", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"];

export function start(executablePath, more) {
  return chromium.launch({ executablePath, headless: true, args: [...flags, ...more] });
}

let passed = 0, failed = 0;
export async function test(name, body) {
  try {
    const said = await body();
    passed++;
    console.log(`ok: ${name}${said ? ` (${said})` : ""}`);
  } catch (error) {
    failed++;
    console.log(`FAILED: ${name}: ${error.message}`);
  }
}
export function check(holds, message) {
  if (!holds) throw new Error(message);
}
// Tells how many passed, and ends.
export function end() {
  console.log(`${passed} passed, ${failed} failed`);
  process.exit(failed ? 1 : 0);
}

// A page with a record of what went wrong and of all it asked for.
export async function recorded(browser, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 }, ...options });
  const page = await context.newPage();
  page.faults = [];
  page.asked = [];
  page.on("console", (message) => message.type() === "error" && page.faults.push(message.text()));
  page.on("pageerror", (error) => page.faults.push(error.message));
  page.on("request", (request) => page.asked.push(request.url()));
  page.on("websocket", (socket) => page.asked.push(socket.url()));
  return page;
}

// Serious faults of the page as it stands, and again after `more`; nor may it be wider than the window.
export async function checkAccess(page, more) {
  for (const fold of await page.locator("details").all()) await fold.evaluate((details) => (details.open = true));
  await page.evaluate(axe);
  const look = () => page.evaluate(() => window.axe.run(document, { resultTypes: ["violations"] }));
  const found = (await look()).violations;
  if (more) {
    await more();
    found.push(...(await look()).violations);
  }
  const serious = found.filter((fault) => ["serious", "critical"].includes(fault.impact));
  const lines = serious.map((fault) => `${fault.id} (${fault.nodes.slice(0, 3).map((node) => node.target.join(" ")).join(", ")})`);
  check(serious.length === 0, lines.join("; "));
  const [width, wanted] = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
  check(width <= wanted, `the page is ${width} px wide`);
}
