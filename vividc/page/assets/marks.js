// What is chosen, and the highlighting of one operation in all panes at once.

const data = JSON.parse(document.getElementById("data").textContent);
const byId = (id) => document.getElementById(id);
const SVG = byId("space").namespaceURI;

const state = {
  region: 0,
  slot: 0,
  cycle: data.run ? data.run.first : 0,
  mode: "contexts",
  inputs: true,
  zoom: 0, // 0: fit
  bound: null, // index of the bound that is highlighted
  highlights: true, // what binds, in each region that is chosen
};
const marks = { hover: null, pinned: null }; // each { nodes: [id], line }

const region = () => data.regions[state.region];
const nodesOf = new Map(
  data.regions.map((one) => [one, new Map(one.nodes.map((node) => [node.id, node]))])
);
const nodeOf = (id) => nodesOf.get(region()).get(id);

function fill(element, attributes, children) {
  for (const [key, value] of Object.entries(attributes)) {
    if (key === "text") element.textContent = value;
    else if (value === true) element.setAttribute(key, "");
    else if (value !== null && value !== false && value !== undefined)
      element.setAttribute(key, value);
  }
  element.append(...children.filter((child) => child !== null));
  return element;
}
const make = (name, attributes = {}, ...children) =>
  fill(document.createElement(name), attributes, children);
const draw = (name, attributes = {}, ...children) =>
  fill(document.createElementNS(SVG, name), attributes, children);

function tipped(element, text) {
  element.append(draw("title", { text }));
  return element;
}

const markOf = (id) => ({ nodes: [id], line: nodeOf(id) ? nodeOf(id).line : null });

function lineMark(line) {
  const nodes = region().nodes.filter((node) => node.line === line && !node.source);
  return { nodes: nodes.map((node) => node.id), line };
}

function paint() {
  const mark = marks.hover || marks.pinned;
  const chosen = new Set(mark ? mark.nodes : []);
  const bound = state.bound === null ? null : region().bounds[state.bound];
  const binding = new Set(bound ? bound.nodes : []);
  const edges = new Set(bound ? bound.edges : []);
  const lines = new Set([...binding].map((id) => nodeOf(id) && nodeOf(id).line));
  for (const element of document.querySelectorAll("[data-node]")) {
    const id = Number(element.dataset.node);
    element.classList.toggle("on", chosen.has(id));
    element.classList.toggle("binds", binding.has(id));
  }
  for (const element of document.querySelectorAll("[data-edge]")) {
    const edge = region().edges[Number(element.dataset.edge)];
    const near = mark && (chosen.has(edge.src) || chosen.has(edge.dst));
    element.classList.toggle("on", Boolean(near && chosen.size === 1));
    element.classList.toggle("binds", edges.has(Number(element.dataset.edge)));
  }
  for (const element of document.querySelectorAll("[data-line]")) {
    const line = Number(element.dataset.line);
    element.classList.toggle("on", Boolean(mark) && mark.line === line);
    element.classList.toggle("binds", lines.has(line));
  }
  byId("detail").textContent = describe(mark);
}

function describe(mark) {
  if (!mark) return "Point at an operation, or choose one with the keyboard, to see it in all panes; Enter or a click keeps it, Escape lets it go.";
  if (mark.nodes.length === 1) return nodeOf(mark.nodes[0]).title;
  const count = mark.nodes.length;
  return `line ${mark.line}: ${count || "no"} operations in region ${region().name}`;
}

function hover(mark) {
  marks.hover = mark;
  paint();
}

function pin(mark, from) {
  marks.pinned = mark;
  marks.hover = null;
  if (mark && mark.nodes.length === 1 && state.mode === "contexts") {
    const { time } = nodeOf(mark.nodes[0]);
    if (time !== null && from !== "array") setSlot(time % region().ii);
  }
  paint();
  if (mark) for (const pane of ["source", "graph", "table"]) if (pane !== from) reveal(byId(pane));
}

// Scroll a pane, and not the page, to the first thing in it that is highlighted.
function reveal(pane, what = ".on") {
  const target = pane.querySelector(what);
  if (!target) return;
  const inner = target.getBoundingClientRect();
  const outer = pane.getBoundingClientRect();
  if (inner.top < outer.top || inner.bottom > outer.bottom)
    pane.scrollTop += inner.top - outer.top - outer.height / 2;
  if (inner.left < outer.left || inner.right > outer.right)
    pane.scrollLeft += inner.left - outer.left - outer.width / 2;
}

// Pointer and keyboard for a pane whose elements stand for operations or lines.
function interactive(pane, step) {
  const find = (event) => event.target.closest("[data-node], [data-line]");
  const mark = (element) =>
    element.dataset.node !== undefined
      ? markOf(Number(element.dataset.node))
      : lineMark(Number(element.dataset.line));
  pane.addEventListener("pointerover", (event) => {
    const element = find(event);
    hover(element && event.pointerType !== "touch" ? mark(element) : null);
  });
  pane.addEventListener("pointerleave", () => hover(null));
  pane.addEventListener("focusin", (event) => {
    const element = find(event);
    if (element) hover(mark(element));
  });
  pane.addEventListener("focusout", () => hover(null));
  pane.addEventListener("click", (event) => {
    const element = find(event);
    pin(element ? mark(element) : null, pane.id);
    if (element && element.hasAttribute("tabindex")) rove(pane, element);
  });
  pane.addEventListener("keydown", (event) => {
    const element = find(event);
    if (!element) return;
    if (event.key === "Enter" || event.key === " ") {
      pin(mark(element), pane.id);
      event.preventDefault();
    } else if (step && event.key.startsWith("Arrow")) {
      const next = step(element, event.key.slice(5));
      if (next) rove(pane, next);
      event.preventDefault();
    }
  });
}

// One element of a pane is in the tab order: the one that had the focus last.
function rove(pane, element) {
  for (const other of pane.querySelectorAll('[tabindex="0"]')) other.setAttribute("tabindex", "-1");
  element.setAttribute("tabindex", "0");
  element.focus({ preventScroll: true });
  element.scrollIntoView({ block: "nearest", inline: "nearest" });
}

document.addEventListener("keydown", (event) => {
  if (event.key === "Escape") pin(null);
});
