// Headless Chromium, driven through chromedriver by plain WebDriver (W3C); nothing beyond node itself.
import { spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

// The closed ones keep Chromium from talking to the network; WebGL is drawn by the processor.
const kFlags = ["--headless=new", "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
  "--disable-component-update", "--disable-sync", "--disable-extensions", "--disable-dev-shm-usage", "--hide-scrollbars",
  "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--force-device-scale-factor=1"];

export class Browser {
  static async open(chromedriver, chromium) {
    const browser = new Browser();
    browser.profile = mkdtempSync(join(tmpdir(), "report-browser-"));
    // Port 0: any free one, which it then says.
    browser.driver = spawn(chromedriver, ["--port=0"], { stdio: ["ignore", "pipe", "inherit"] });
    // Whoever waits for this script does so for a minute: nothing of it must be left then.
    setTimeout(() => {
      console.log("FAIL not done after 55 s");
      browser.driver.kill();
      process.exit(1);
    }, 55_000).unref();
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
        "goog:loggingPrefs": { browser: "ALL" },
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

  /** Size of the page's window. */
  async resize(width, height) {
    await this.request("POST", `${this.session}/goog/cdp/execute`, {
      cmd: "Emulation.setDeviceMetricsOverride",
      params: { width, height, deviceScaleFactor: 1, mobile: false },
    });
  }

  /** Value of the body of a function; promises are waited for. */
  run(script, ...args) {
    return this.request("POST", `${this.session}/execute/sync`, { script, args });
  }

  /** Waits until the body of a function gives something true. */
  async until(script, what, limit_s = 15) {
    const end = Date.now() + 1000 * limit_s;
    while (!(await this.run(script))) {
      if (Date.now() > end) throw new Error(`not within ${limit_s} s: ${what}`);
      await new Promise((resolve) => setTimeout(resolve, 50));
    }
  }

  /** PNG as a buffer. */
  async screenshot() {
    return Buffer.from(await this.request("GET", `${this.session}/screenshot`), "base64");
  }

  /** What the console says, since the last call. */
  log() {
    return this.request("POST", `${this.session}/se/log`, { type: "browser" });
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
