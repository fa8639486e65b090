// SPDX-License-Identifier: BSD-3-Clause
// Headless Chromium, driven through chromedriver by plain WebDriver (W3C); needs only node.
import { spawn } from "node:child_process";
import { mkdtempSync, readdirSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

// Arguments that keep Chromium from using the network; WebGL is drawn by the processor.
const kFlags = ["--headless=new", "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
  "--disable-component-update", "--disable-sync", "--disable-extensions", "--disable-dev-shm-usage", "--hide-scrollbars",
  "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--force-device-scale-factor=1"];

/** The Shift key in mouse events of the browser. */
export const kShift = 8;

export class Browser {
  /** `network`: requests to the network are recorded, for `requests`. */
  static async open(chromedriver, chromium, { network = false } = {}) {
    const browser = new Browser();
    browser.profile = mkdtempSync(join(tmpdir(), "report-browser-"));
    // Port 0: any free port, which it then prints.
    browser.driver = spawn(chromedriver, ["--port=0"], { stdio: ["ignore", "pipe", "inherit"] });
    // The caller waits for this script for five minutes: it must have ended by then.
    setTimeout(() => {
      console.log("FAIL not done after 280 s");
      browser.driver.kill();
      browser.kill();
      process.exit(1);
    }, 280_000).unref();
    browser.base = await new Promise((resolve, reject) => {
      let said = "";
      browser.driver.stdout.on("data", (data) => {
        said += data;
        const port = /started successfully on port (\d+)/.exec(said)?.[1];
        if (port) resolve(`http://127.0.0.1:${port}`);
      });
      browser.driver.on("exit", (code) => reject(new Error(`chromedriver ended with ${code}: ${said}`)));
      browser.driver.on("error", reject);
    });
    const { sessionId } = await browser.request("POST", "/session", {
      capabilities: { alwaysMatch: {
        "goog:chromeOptions": { binary: chromium, args: [...kFlags, `--user-data-dir=${browser.profile}`] },
        "goog:loggingPrefs": { browser: "ALL", ...(network ? { performance: "ALL" } : {}) },
      } },
    });
    browser.session = `/session/${sessionId}`;
    return browser;
  }

  async request(method, path, body) {
    const response = await fetch(this.base + path, { method, body: method === "POST" ? JSON.stringify(body ?? {}) : undefined });
    const { value } = await response.json();
    if (value?.error) throw new Error(`${path}: ${value.error}: ${value.message}`);
    return value;
  }

  go(url) {
    return this.request("POST", `${this.session}/url`, { url });
  }

  devtools(cmd, params) {
    return this.request("POST", `${this.session}/goog/cdp/execute`, { cmd, params });
  }

  /** Size of the page's window. */
  resize(width, height) {
    return this.devtools("Emulation.setDeviceMetricsOverride", { width, height, deviceScaleFactor: 1, mobile: false });
  }

  mouse(type, [x, y], clickCount = 0, modifiers = 0) {
    const pressed = type === "mouseMoved" ? {} : { button: "left", clickCount };
    return this.devtools("Input.dispatchMouseEvent", { type, x, y, modifiers, ...pressed });
  }

  /** Moves the mouse to a position, presses, moves to another, and releases; `clicks` times, with keys held. */
  async press(from, to = from, clicks = 1, modifiers = 0) {
    await this.mouse("mouseMoved", from, 0, modifiers);
    for (let click = 1; click <= clicks; ++click) {
      await this.mouse("mousePressed", from, click, modifiers);
      if (to !== from) await this.devtools("Input.dispatchMouseEvent", { type: "mouseMoved", x: to[0], y: to[1], button: "left", buttons: 1, modifiers });
      await this.mouse("mouseReleased", to, click, modifiers);
    }
  }

  /** `repeats`: number of repetitions, as for a key that is held down. */
  async key(key, text, modifiers = 0, repeats = 0) {
    for (let i = 0; i <= repeats; ++i) {
      await this.devtools("Input.dispatchKeyEvent", { type: "keyDown", key, text, modifiers, autoRepeat: i > 0 });
    }
    await this.devtools("Input.dispatchKeyEvent", { type: "keyUp", key, modifiers });
  }

  /** Returns the value of the body of a function; waits for promises. */
  run(script, ...args) {
    return this.request("POST", `${this.session}/execute/sync`, { script, args });
  }

  /** Waits until the body of a function returns a true value. */
  async until(script, what, limit_s = 15) {
    const end = Date.now() + 1000 * limit_s;
    while (!(await this.run(script))) {
      if (Date.now() > end) throw new Error(`not within ${limit_s} s: ${what}`);
      await new Promise((resolve) => setTimeout(resolve, 50));
    }
  }

  /** Returns a PNG as a buffer. */
  async screenshot() {
    return Buffer.from(await this.request("GET", `${this.session}/screenshot`), "base64");
  }

  /** Returns the console messages since the last call. */
  log() {
    return this.request("POST", `${this.session}/se/log`, { type: "browser" });
  }

  /** Returns the addresses of all requests of the pages since the last call. */
  async requests() {
    const entries = await this.request("POST", `${this.session}/se/log`, { type: "performance" });
    const messages = entries.map((entry) => JSON.parse(entry.message).message);
    return messages.filter((m) => m.method === "Network.requestWillBeSent").map((m) => m.params.request.url);
  }

  /** Ends Chromium if it does not answer: a killed driver leaves it running. */
  kill() {
    for (const pid of readdirSync("/proc").filter((name) => /^\d+$/.test(name))) {
      try {
        if (readFileSync(`/proc/${pid}/cmdline`, "latin1").includes(this.profile)) process.kill(Number(pid), "SIGKILL");
      } catch {
        // It has already exited.
      }
    }
    rmSync(this.profile, { recursive: true, force: true, maxRetries: 5 });
  }

  async close() {
    try {
      if (this.session) await this.request("DELETE", this.session);
    } finally {
      this.driver.removeAllListeners("exit");
      this.driver.kill();
      rmSync(this.profile, { recursive: true, force: true, maxRetries: 5 });
    }
  }
}
