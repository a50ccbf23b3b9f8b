// The dataflow graph of the chosen region, laid out in layers by dagre.

const NODE_HEIGHT = 24;
const MANY = 300; // nodes from which on layers are the longest paths: simplex takes seconds
let layout = null; // of the region on show: { width, height, places }

function layOut(one, inputs) {
  const graph = new dagre.graphlib.Graph({ multigraph: true });
  const nodes = one.nodes.filter((node) => inputs || !node.source);
  const ranker = nodes.length > MANY ? "longest-path" : "network-simplex";
  graph.setGraph({ nodesep: 12, ranksep: 28, edgesep: 8, marginx: 14, marginy: 14, ranker });
  graph.setDefaultEdgeLabel(() => ({}));
  for (const node of nodes) {
    const width = Math.max(40, 7.1 * node.label.length + 16);
    graph.setNode(String(node.id), { width, height: NODE_HEIGHT });
  }
  const there = (id) => graph.hasNode(String(id));
  one.edges.forEach((edge, index) => {
    if (!there(edge.src) || !there(edge.dst)) return;
    // A recurrence points back up; what else later iterations read says nothing of layers.
    if (edge.distance && edge.src !== edge.dst && !reaches(one, edge.dst, edge.src)) return;
    const ends = edge.distance ? [edge.dst, edge.src] : [edge.src, edge.dst];
    const label = { minlen: 1, weight: edge.kind === "data" && !edge.distance ? 2 : 1 };
    graph.setEdge(String(ends[0]), String(ends[1]), label, `e${index}`);
  });
  dagre.layout(graph);
  return graph;
}

// Whether a word gets from one node to another in the same iteration.
function reaches(one, from, to) {
  const seen = new Set([from]);
  const open = [from];
  while (open.length) {
    const here = open.pop();
    if (here === to) return true;
    for (const edge of one.edges)
      if (edge.src === here && !edge.distance && !seen.has(edge.dst)) {
        seen.add(edge.dst);
        open.push(edge.dst);
      }
  }
  return false;
}

// A line past the layers.
function past(from, to) {
  const [x, y, u, v] = [from.x, from.y + NODE_HEIGHT / 2, to.x, to.y - NODE_HEIGHT / 2];
  const out = u < x ? -36 : 36;
  return `M${x} ${y}C${x + out} ${y + 34} ${u - out} ${v - 34} ${u} ${v}`;
}

function curve(points) {
  const at = (p) => `${p.x.toFixed(1)} ${p.y.toFixed(1)}`;
  let path = `M${at(points[0])}`;
  for (let i = 1; i < points.length - 1; i += 1) {
    const end =
      i === points.length - 2
        ? points[i + 1]
        : { x: (points[i].x + points[i + 1].x) / 2, y: (points[i].y + points[i + 1].y) / 2 };
    path += `Q${at(points[i])} ${at(end)}`;
  }
  return points.length === 2 ? `${path}L${at(points[1])}` : path;
}

// From a node to itself, on its right side.
function loop({ x, y, width }) {
  const side = x + width / 2;
  return `M${side} ${y + 5}C${side + 20} ${y + 16} ${side + 20} ${y - 16} ${side} ${y - 5}`;
}

function arrow(id) {
  const head = draw("path", { d: "M0 0L7 3.5L0 7z", class: id });
  return draw(
    "marker",
    { id, viewBox: "0 0 7 7", refX: 6.5, refY: 3.5, markerWidth: 6, markerHeight: 6,
      orient: "auto-start-reverse", markerUnits: "userSpaceOnUse" },
    head
  );
}

function edgeShapes(one, graph) {
  const routed = new Map(graph.edges().map((key) => [Number(key.name.slice(1)), graph.edge(key).points]));
  const shapes = [];
  one.edges.forEach((edge, index) => {
    const [from, to] = [graph.node(String(edge.src)), graph.node(String(edge.dst))];
    if (!from || !to) return;
    const points = [...(routed.get(index) || [])];
    if (edge.distance) points.reverse();
    const self = edge.src === edge.dst;
    const path = self ? loop(from) : points.length ? curve(points) : past(from, to);
    const later = edge.distance ? `, ${edge.distance} iteration${edge.distance > 1 ? "s" : ""} later` : "";
    const line = draw("path", { d: path, class: `edge ${edge.distance ? "carried" : edge.kind}${self || points.length ? "" : " past"}`, "data-edge": index,
      "marker-end": `url(#${edge.distance ? "head-carried" : "head"})` });
    const what = edge.kind === "data" ? "word" : edge.kind;
    const assumed = edge.assumed ? " (not proved apart)" : "";
    shapes.push(tipped(line, `${what} of #${edge.src} to #${edge.dst}${later}${assumed}`));
    if (!edge.distance) return;
    const middle = self ? { x: from.x + from.width / 2 + 12, y: from.y + 4 }
      : points[Math.floor(points.length / 2)] || { x: (from.x + to.x) / 2, y: (from.y + to.y) / 2 };
    shapes.push(draw("text", { x: middle.x + 5, y: middle.y, class: "distance", text: edge.distance }));
  });
  return shapes;
}

function nodeShape(node, place, first) {
  const { x, y, width } = place;
  const group = draw("g", {
    class: node.source ? "node input" : "node",
    "data-node": node.id,
    tabindex: first ? 0 : -1,
    role: "button",
    "aria-label": node.title,
    transform: `translate(${x.toFixed(1)} ${y.toFixed(1)})`,
  });
  group.append(
    draw("rect", { x: -width / 2, y: -NODE_HEIGHT / 2, width, height: NODE_HEIGHT,
      rx: node.source ? NODE_HEIGHT / 2 : 5, fill: node.colour || null }),
    draw("text", { "text-anchor": "middle", dy: "0.35em", text: node.label })
  );
  return tipped(group, node.title);
}

function showGraph() {
  const one = region();
  const graph = layOut(one, state.inputs);
  const { width = 100, height = 60 } = graph.graph();
  layout = { width: Math.max(width, 100) || 100, height: Math.max(height, 60) || 60, places: new Map() };
  const svg = draw("svg", { role: "presentation", viewBox: `0 0 ${layout.width} ${layout.height}` });
  svg.append(draw("defs", {}, arrow("head"), arrow("head-carried")));
  svg.append(...edgeShapes(one, graph));
  let first = true;
  for (const node of one.nodes) {
    const place = graph.node(String(node.id));
    if (!place) continue;
    layout.places.set(node.id, place);
    svg.append(nodeShape(node, place, first));
    first = false;
  }
  byId("graph").replaceChildren(svg);
  scale();
  const legend = one.groups.map(([name, colour]) =>
    make("li", {}, make("i", { style: `background:${colour}` }), name));
  legend.push(make("li", {}, make("i", { class: "line carried" }), "to a later iteration"));
  byId("legend").replaceChildren(...legend);
}

function scale() {
  const pane = byId("graph");
  const svg = pane.querySelector("svg");
  if (!svg) return;
  const room = { width: pane.clientWidth - 4, height: pane.clientHeight - 4 };
  const whole = Math.min(room.width / layout.width, room.height / layout.height);
  const fitted = Math.min(1.15, Math.max(0.72, whole));
  const factor = fitted * 1.25 ** state.zoom;
  svg.setAttribute("width", layout.width * factor);
  svg.setAttribute("height", layout.height * factor);
}

// The next node for an arrow key: along an edge, or beside in the layer.
function graphStep(element, way) {
  const id = Number(element.dataset.node);
  const at = (other) => byId("graph").querySelector(`[data-node="${other}"]`);
  const here = layout.places.get(id);
  if (way === "Up" || way === "Down") {
    const [from, to] = way === "Down" ? ["src", "dst"] : ["dst", "src"];
    const edge = region().edges.find((one) => one[from] === id && !one.distance && at(one[to]));
    return edge ? at(edge[to]) : null;
  }
  const sign = way === "Right" ? 1 : -1;
  let best = null;
  for (const [other, place] of layout.places) {
    const ahead = sign * (place.x - here.x);
    if (Math.abs(place.y - here.y) < 2 && ahead > 0 && (!best || ahead < best.ahead))
      best = { ahead, other };
  }
  return best ? at(best.other) : null;
}

// A pointer that drags the ground moves the graph.
function draggable(pane) {
  let from = null;
  pane.addEventListener("pointerdown", (event) => {
    if (event.pointerType !== "mouse" || event.target.closest("[data-node]")) return;
    from = { x: event.clientX + pane.scrollLeft, y: event.clientY + pane.scrollTop };
  });
  window.addEventListener("pointermove", (event) => {
    if (!from) return;
    pane.scrollLeft = from.x - event.clientX;
    pane.scrollTop = from.y - event.clientY;
  });
  window.addEventListener("pointerup", () => { from = null; });
}
