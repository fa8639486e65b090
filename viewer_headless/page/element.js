// SPDX-License-Identifier: BSD-3-Clause
// Creates elements of the page; text is never parsed as HTML.

export const byId = (id) => document.getElementById(id);

/** element("td", {class: "n"}, "12", other): returns a new element with attributes, handlers (on...) and children. */
export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (value === true) made.setAttribute(name, "");
    else if (value !== false && value !== undefined) made.setAttribute(name, value);
  }
  made.append(...children.filter((child) => child !== null && child !== undefined));
  return made;
}
