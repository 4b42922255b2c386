/* Tables sort by their heads; the dots of figures say which trial they are. Nothing is loaded. */
"use strict";

/* Sorting: a click on a head sorts upwards, the next one downwards, the third restores the order. */

for (const table of document.querySelectorAll("table")) {
  const body = table.tBodies[0];
  if (!body || body.rows.length < 2) continue;
  const original = [...body.rows];
  const texts = original.map((row) => [...row.cells].map((cell) => cell.textContent.trim()));
  /* A name that holds for several rows stands in the first of them alone. */
  const blanks = [];
  for (let k = 1; k < texts.length; k++) {
    if (texts[k][0] === "") {
      texts[k][0] = texts[k - 1][0];
      blanks.push(k);
    }
  }
  const heads = [...table.tHead.rows[0].cells];
  heads.forEach((head, column) => {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    head.append(button);
    head.setAttribute("aria-sort", "none");
    button.addEventListener("click", () => {
      const next = { none: "ascending", ascending: "descending", descending: "none" };
      const order = next[head.getAttribute("aria-sort")];
      for (const other of heads) other.setAttribute("aria-sort", "none");
      head.setAttribute("aria-sort", order);
      const sorted = original.map((row, k) => k);
      if (order !== "none") sorted.sort(comparison(texts, column, order === "ascending" ? 1 : -1));
      body.append(...sorted.map((k) => original[k]));
      table.classList.toggle("sorted", order !== "none");
      for (const k of blanks) {
        original[k].cells[0].textContent = order === "none" ? "" : texts[k][0];
      }
    });
  });
}

function comparison(texts, column, sign) {
  return (a, b) => {
    const [left, right] = [texts[a][column], texts[b][column]];
    const missing = isMissing(left) - isMissing(right);
    if (missing) return missing; /* to the end, whatever the order */
    const [x, y] = [value(left), value(right)];
    if (x === null && y === null) return sign * left.localeCompare(right, "en") || a - b;
    if (x === null || y === null) return sign * ((x === null) - (y === null));
    return sign * ((x > y) - (x < y)) || a - b;
  };
}

function isMissing(text) {
  return text === "" || text === "\u2013" || text === "none";
}

/* The number that a text begins with, or null. */
function value(text) {
  const plain = text.replace("\u2212", "-").replace(/^\u2265 /, "");
  if (/^-?(\u221e|inf)/.test(plain)) return plain[0] === "-" ? -Infinity : Infinity;
  return /^[-+]?\d/.test(plain) ? parseFloat(plain) : null;
}

/* Dots: the nearest one to the pointer, or the one with the focus, is ringed in every figure. */

const charts = [...document.querySelectorAll(".chart")];
const REACH = 7; /* points from a dot within which it answers */
const SAME = 0.3; /* points within which dots lie on one another */
const LEAP = 10; /* dots that Page Up and Page Down pass */

for (const chart of charts) {
  const svg = chart.querySelector("svg");
  const marks = [...svg.querySelectorAll("circle")];
  const places = marks.map((mark) => [mark.cx.baseVal.value, mark.cy.baseVal.value]);
  const box = document.createElement("div");
  box.className = "answer";
  box.hidden = true;
  box.tabIndex = -1; /* so that a click into it, to copy the command, does not close it */
  chart.append(box);
  const name = svg.getAttribute("aria-label");
  svg.setAttribute("aria-label", `${name}: ${marks.length} dots; arrow keys go from one to the next`);
  let shown = -1;
  let pinned = false; /* stays, whatever the pointer does */
  let stop = 0; /* the only dot that Tab reaches */
  marks.forEach((mark, k) => mark.setAttribute("tabindex", k === 0 ? "0" : "-1"));

  function at(event) {
    const point = new DOMPoint(event.clientX, event.clientY);
    const { x, y } = point.matrixTransform(svg.getScreenCTM().inverse());
    let best = -1;
    let least = REACH;
    places.forEach(([cx, cy], k) => {
      const distance = Math.hypot(cx - x, cy - y);
      if (distance < least) [best, least] = [k, distance];
    });
    return best;
  }

  function alike(k) {
    const [x, y] = places[k];
    return marks
      .map((_, other) => other)
      .filter((o) => Math.abs(places[o][0] - x) < SAME && Math.abs(places[o][1] - y) < SAME);
  }

  function show(k) {
    shown = k;
    unring();
    const { text, command } = words(marks[k]);
    const number = marks[k].dataset.case;
    for (const same of document.querySelectorAll(`circle[data-case="${number}"]`)) {
      same.classList.add(same === marks[k] ? "chosen" : "same");
    }
    const stack = alike(k);
    box.replaceChildren(element("span", text));
    if (command) box.append(element("code", command));
    if (stack.length > 1) {
      const place = stack.indexOf(k) + 1;
      box.append(element("small", `${place} of ${stack.length} at this place; click for the next`));
    }
    box.hidden = false;
    const scale = svg.clientWidth / svg.viewBox.baseVal.width;
    const [x, y] = [places[k][0] * scale, places[k][1] * scale];
    const left = Math.min(Math.max(x - box.offsetWidth / 2, 0), chart.clientWidth - box.offsetWidth);
    const above = y - box.offsetHeight - 6;
    box.style.left = `${Math.max(left, 0)}px`;
    box.style.top = `${above < 0 ? y + 6 : above}px`;
  }

  function hide() {
    shown = -1;
    pinned = false;
    box.classList.remove("pinned");
    box.hidden = true;
    unring();
  }

  function pin() {
    pinned = true;
    box.classList.add("pinned");
  }

  function focus(k) {
    marks[stop].setAttribute("tabindex", "-1");
    stop = Math.min(Math.max(k, 0), marks.length - 1);
    marks[stop].setAttribute("tabindex", "0");
    marks[stop].focus();
  }

  svg.addEventListener("pointermove", (event) => {
    const k = at(event);
    svg.classList.toggle("near", k >= 0);
    if (pinned || k < 0 || (shown >= 0 && alike(k).includes(shown))) return;
    show(k);
  });
  svg.addEventListener("mousedown", (event) => event.preventDefault()); /* click gives the focus */
  svg.addEventListener("click", (event) => {
    const k = at(event);
    if (k < 0) return hide();
    const stack = alike(k);
    const next = pinned && stack.includes(shown) ? (stack.indexOf(shown) + 1) % stack.length : -1;
    focus(next >= 0 ? stack[next] : stack.includes(shown) ? shown : k);
    show(stop); /* the focus may have been there before */
    pin();
  });
  chart.addEventListener("pointerleave", () => pinned || hide());
  svg.addEventListener("focusin", (event) => {
    show(marks.indexOf(event.target));
    pin();
  });
  chart.addEventListener("focusout", (event) => {
    if (!chart.contains(event.relatedTarget)) hide();
  });
  chart.addEventListener("keydown", (event) => {
    const steps = {
      ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1, PageDown: LEAP, PageUp: -LEAP,
      Home: -marks.length, End: marks.length,
    };
    if (event.key === "Escape") return hide();
    if (!(event.key in steps) || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    focus(stop + steps[event.key]);
  });
}

function unring() {
  for (const mark of document.querySelectorAll("circle.chosen, circle.same")) {
    mark.classList.remove("chosen", "same");
  }
}

/* What a dot says: a line, then the command. Its title becomes its label: the browser's own tooltip would hide ours. */
function words(mark) {
  const title = mark.querySelector("title");
  if (title) {
    mark.setAttribute("aria-label", title.textContent);
    title.remove();
  }
  const [text, command] = mark.getAttribute("aria-label").split(/\n(.*)/s);
  return { text, command };
}

function element(name, text) {
  const found = document.createElement(name);
  found.textContent = text;
  return found;
}

/* A link to a table that is folded away opens it. */

for (const link of document.querySelectorAll('a[href^="#"]')) {
  link.addEventListener("click", () => {
    const fold = document.querySelector(link.getAttribute("href"))?.closest("details");
    if (fold) fold.open = true;
  });
}
