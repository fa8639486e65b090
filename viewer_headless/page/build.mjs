// SPDX-License-Identifier: BSD-3-Clause
// node build.mjs NODE_MODULES TEMPLATE: bundles this folder into one self-contained HTML file.
import { createRequire } from "node:module";
import { mkdirSync, readFileSync, renameSync, writeFileSync } from "node:fs";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";

const [modules, template] = process.argv.slice(2).map((path) => resolve(path));
const page = dirname(fileURLToPath(import.meta.url));
const { buildSync } = createRequire(join(modules, "x.js"))("esbuild");

function bundle(entry) {
  const result = buildSync({
    entryPoints: [join(page, entry)],
    bundle: true,
    minify: true,
    write: false,
    format: "esm",
    target: ["chrome109", "firefox115", "safari16.4"],
    charset: "utf8",
    legalComments: "inline",
    nodePaths: [modules],
    logLevel: "warning",
  });
  return result.outputFiles[0].text;
}

// Functions, because '$&' has a special meaning in a replacement string; and no script may end early.
const style = bundle("style.css").replaceAll("</style", "<\\/style");
const script = bundle("main.js").replaceAll("</script", "<\\/script");
const html = readFileSync(join(page, "index.html"), "utf8")
  .replace("/*STYLE*/", () => style)
  .replace("/*SCRIPT*/", () => script);
mkdirSync(dirname(template), { recursive: true });
writeFileSync(`${template}.part`, html);
renameSync(`${template}.part`, template);
