// The array as a picture: one context of the schedule, one cycle of the run, or the run's heat.

const CHIPS = 6;
const BANK = 26; // height of the row of banks

const percent = (share) => `${Math.round(100 * share)} %`;
const run = data.run;
const sampleAt = new Map(run ? run.samples.map((sample) => [sample[0], sample]) : []);
const stalled = new Set(run ? run.stalled : []);

function asWord(word) {
  const view = new DataView(new ArrayBuffer(4));
  view.setUint32(0, word);
  const float = view.getFloat32(0);
  return `${view.getInt32(0)}, as float32 ${Number(float.toPrecision(6))}`;
}

function linkShapes(link, index, how) {
  const { carries = null, label = "", tip, share = null } = how;
  const used = carries !== null || Boolean(share);
  const group = draw("g", { class: used ? "link used" : "link", "data-link": index,
    "data-node": carries });
  for (const points of link.runs) {
    const line = draw("polyline", { points: points.map((p) => p.join(",")).join(" "),
      "marker-end": used ? "url(#head-link)" : null });
    if (share) line.style.cssText = `stroke: ${heat(share)}; stroke-width: ${1 + 2.5 * share}`;
    group.append(line);
  }
  if (label) for (const [x, y] of link.labels)
    group.append(draw("text", { x, y, class: "wire", text: label }));
  return tipped(group, tip);
}

const heat = (share) => `color-mix(in srgb, var(--busy) ${Math.round(15 + 85 * share)}%, var(--pane))`;

function peShape(pe, index, parts) {
  const { pe_width: width, pe_height: height } = data.fabric;
  const { node = null, colour = null, name = "", corner = "", state: kind = "", tip } = parts;
  const [x, y] = pe.at;
  const group = draw("g", { class: `pe ${kind}${pe.memory ? " memory" : ""}`, "data-pe": index,
    "data-node": node, transform: `translate(${x} ${y})` });
  const box = draw("rect", { width, height, rx: 5 });
  if (colour) box.style.fill = colour;
  group.append(box);
  if (width > 40) group.append(draw("text", { x: 5, y: 11, class: "small", text: index }),
    draw("text", { x: width - 5, y: 11, class: "small", "text-anchor": "end", text: corner }));
  const fits = Math.floor((width - 6) / 6.1);
  group.append(draw("text", { x: width / 2, y: 0.47 * height, "text-anchor": "middle", class: "name",
    text: name.length > fits ? `${name.slice(0, fits - 1)}…` : name }));
  return tipped(group, `PE ${index}: ${tip}`);
}

// Words that a PE holds, as chips in its lower part.
function chips(index, words) {
  const { pe_width: width, pe_height: height } = data.fabric;
  const [x, y] = data.fabric.pes[index].at;
  if (width < 60 || words.length > CHIPS) {
    const text = width < 60 ? `+${words.length}` : `${words.length} words held`;
    const tip = words.map(([what, id]) => `${what} holds #${id}`).join(", ");
    return words.length ? [tipped(draw("text", { x: x + width - 4, y: y + height - 4,
      "text-anchor": "end", class: "small", text }), tip)] : [];
  }
  const wide = (width - 6) / 3;
  return words.map(([what, id], number) => {
    const left = x + 3 + (number % 3) * wide;
    const top = y + height - 14 - 12.5 * (words.length > 3 ? 1 - Math.floor(number / 3) : 0);
    const chip = draw("g", { class: "chip", "data-node": id, transform: `translate(${left} ${top})` },
      draw("rect", { width: wide - 1.5, height: 11.5, rx: 2.5 }),
      draw("text", { x: wide / 2 - 0.7, y: 8.6, "text-anchor": "middle", text: `${what}:${id}` }));
    return tipped(chip, `${what} holds the word of ${title(id)}`);
  });
}

const title = (id) => (nodeOf(id) ? nodeOf(id).title : `#${id}`);

function heldBy(slot) {
  const words = new Map();
  const add = (pe, what, id) => words.set(pe, [...(words.get(pe) || []), [what, id]]);
  for (const [pe, kind, index, id] of slot.held) add(pe, kind === "out" ? "o" : `r${index}`, id);
  for (const [pe, id] of slot.moved) add(pe, "mov", id);
  return words;
}

// One context; `live`: iteration of each PE's operation in this cycle, where a run is shown.
function contextShapes(slot, live, words) {
  const issues = new Map();
  for (const [pe, id, stage] of slot.issues) {
    if (!issues.has(pe) || nodeOf(id).name !== "live_out") issues.set(pe, [id, stage]);
  }
  const kept = new Map(slot.kept);
  const shapes = [];
  const carried = new Map(slot.links);
  data.fabric.links.forEach((link, index) => {
    const id = carried.get(index);
    const word = words && words.has(index) ? `: ${asWord(words.get(index))}` : "";
    const tip = `link from PE ${link.src} to PE ${link.dst}` +
      (id === undefined ? ", not driven" : ` carries the word of ${title(id)}${word}`);
    shapes.push(linkShapes(link, index, id === undefined ? { tip } : { carries: id, label: id, tip }));
  });
  data.fabric.pes.forEach((pe, index) => {
    const found = issues.get(index);
    if (!found) {
      const busy = kept.get(index);
      const tip = busy === undefined ? "idle" : `still busy with ${title(busy)}`;
      shapes.push(peShape(pe, index, { node: busy ?? null, tip, state: busy === undefined ? "" : "kept" }));
      return;
    }
    const [id, stage] = found;
    const node = nodeOf(id);
    const asleep = live && node.name !== "live_out" && !live.has(index);
    const corner = live && live.has(index) ? `i ${live.get(index)}` : `s${stage}`;
    shapes.push(peShape(pe, index, { node: id, colour: node.colour, name: node.name, corner,
      state: asleep ? "asleep" : "busy",
      tip: asleep ? `no live iteration for ${node.title}` : node.title }));
  });
  for (const [pe, held] of heldBy(slot)) shapes.push(...chips(pe, held));
  for (const [pe, id] of slot.issues)
    if (issues.get(pe)[0] !== id || nodeOf(id).name === "live_out") shapes.push(...liveOut(pe, id));
  return shapes;
}

function liveOut(pe, id) {
  const [x, y] = data.fabric.pes[pe].at;
  const mark = draw("circle", { class: "live-out", "data-node": id, cx: x + data.fabric.pe_width - 6,
    cy: y + 0.5 * data.fabric.pe_height, r: 4 });
  return [tipped(mark, `writes to its constant store: ${title(id)}`)];
}

function heatShapes() {
  const length = run.end - run.first;
  const links = data.fabric.links.map((link, index) => {
    const share = run.carried[index] / length;
    return linkShapes(link, index, { share,
      tip: `link from PE ${link.src} to PE ${link.dst}: a word in ${run.carried[index]} of ${length} cycles` });
  });
  const pes = data.fabric.pes.map((pe, index) => {
    const share = run.issues[index] / length;
    return peShape(pe, index, { colour: heat(share), name: percent(share), state: "heat",
      tip: `issues in ${run.issues[index]} of ${length} cycles` });
  });
  return [...links, ...pes];
}

function bankShapes(counts, whole) {
  const { width, height, banks } = data.fabric;
  const each = (width - 30) / banks;
  return counts.map((count, bank) => {
    const share = whole ? count / whole : Math.min(1, count / 2);
    const group = draw("g", { class: !whole && count > 1 ? "bank conflict" : "bank", "data-bank": bank });
    const box = draw("rect", { x: 15 + bank * each, y: height + 6, width: each - 3, height: BANK - 8, rx: 3 });
    if (count && (whole || count === 1)) box.style.fill = heat(share);
    group.append(box, draw("text", { x: 15 + (bank + 0.5) * each - 1.5, y: height + BANK - 9, "text-anchor": "middle",
      class: "small", text: banks > 16 ? "" : `bank ${bank}` }));
    return tipped(group, whole ? `bank ${bank}: ${count} accesses in ${whole} cycles`
      : `bank ${bank}: ${count} accesses in this cycle`);
  });
}

function showArray() {
  const { width, height } = data.fabric;
  const banked = state.mode !== "contexts";
  const svg = draw("svg", { class: "array", viewBox: `0 16 ${width} ${height - 16 + (banked ? BANK : 0)}`,
    role: "img", "aria-labelledby": "array-title array-note" });
  svg.style.maxWidth = `${1.9 * width}px`;
  svg.append(draw("defs", {}, arrow("head-link")));
  if (state.mode === "heat") svg.append(...heatShapes(), ...bankShapes(run.accesses, run.end - run.first));
  else if (state.mode === "cycles") svg.append(...cycleShapes());
  else if (region().slots.length) svg.append(...contextShapes(region().slots[state.slot], null, null));
  byId("array").replaceChildren(svg);
  byId("array-note").textContent = arrayNote();
}

function cycleShapes() {
  const sample = sampleAt.get(state.cycle);
  if (!sample) return data.fabric.pes.map((pe, index) => peShape(pe, index, { tip: "does nothing", state: "asleep" }));
  const [, , slot, issued, words, banks] = sample;
  const live = new Map(issued.map(([pe, , iteration]) => [pe, iteration]));
  const counts = new Array(data.fabric.banks).fill(0);
  for (const bank of banks) counts[bank] += 1;
  const slots = region().slots;
  const shapes = slots.length ? contextShapes(slots[slot], live, new Map(words)) : [];
  return [...shapes, ...bankShapes(counts, 0)];
}

function arrayNote() {
  if (state.mode === "heat")
    return `Cycles ${run.first} to ${run.end - 1}: how often each PE issues, each link carries a word and each bank is accessed; ${run.stalled.length} cycles stalled.`;
  if (state.mode === "contexts") {
    if (!region().slots.length) return "The region places nothing.";
    return `Steady state: what each PE issues (s: stage), the words on links and in registers by the id of their operation. ${region().usage}.`;
  }
  if (stalled.has(state.cycle)) return `Cycle ${state.cycle}: the tile stands still, as accesses meet in a bank.`;
  const sample = sampleAt.get(state.cycle);
  if (!sample) return `Cycle ${state.cycle}: between regions.`;
  return `Cycle ${state.cycle}: region ${region().name}, context ${sample[2]}, ${sample[3].length} operations issue (i: iteration).`;
}
