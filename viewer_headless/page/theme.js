// SPDX-License-Identifier: BSD-3-Clause
// Dark or light theme: that of the system, or the chosen one.
import { byId } from "./element.js";

function isDark() {
  const chosen = document.documentElement.dataset.theme;
  return chosen ? chosen === "dark" : window.matchMedia("(prefers-color-scheme: dark)").matches;
}

/** `changed()` is called after a change of colours. */
export function makeTheme(changed) {
  const button = byId("theme");
  const show = () => {
    button.textContent = isDark() ? "☀" : "☾";
    changed();
  };
  button.addEventListener("click", () => {
    document.documentElement.dataset.theme = isDark() ? "light" : "dark";
    show();
  });
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", show);
  button.textContent = isDark() ? "☀" : "☾";
}
