"use strict";
// the model in WebGL: drag turns, wheel or two fingers zoom, shift and drag or two fingers move, a click tells of a stone
(() => {
  const model = JSON.parse(document.getElementById("model").textContent);
  const canvas = document.getElementById("canvas");
  const gl = canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
  const picked = document.getElementById("picked");
  if (!gl) { picked.textContent = "This browser has no WebGL 2: the model is not shown."; return; }
  const bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)).buffer;
  const MAPS = {
    stress: ["440154", "482878", "3e4989", "31688e", "26828e", "1f9e89", "35b779", "6ece58", "b5de2b", "fde725"],
    used: ["ffffcc", "ffeda0", "fed976", "feb24c", "fd8d3c", "fc4e2a", "e31a1c", "bd0026", "800026"],
    signed: ["2166ac", "4393c3", "92c5de", "d1e5f0", "f7f7f7", "fddbc7", "f4a582", "d6604d", "b2182b"],
  };
  const shader = (kind, text) => {
    const made = gl.createShader(kind);
    gl.shaderSource(made, `#version 300 es\nprecision highp float;\nprecision highp int;\n${text}`);
    gl.compileShader(made);
    if (!gl.getShaderParameter(made, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(made));
    return made;
  };
  const program = (vertex, fragment) => {
    const made = gl.createProgram();
    gl.attachShader(made, shader(gl.VERTEX_SHADER, vertex));
    gl.attachShader(made, shader(gl.FRAGMENT_SHADER, fragment));
    ["place", "move", "value", "block"].forEach((name, i) => gl.bindAttribLocation(made, i, name));
    gl.linkProgram(made);
    return made;
  };
  const VERTEX = `
    in vec3 place; in vec3 move; in float value; in uint block;
    uniform vec3 low, span, centre, half_; uniform float times; uniform mat3 turn; uniform vec2 shift; uniform float lift;
    out vec3 seen; out float v; flat out uint b;
    void main() {
      seen = turn * (low + place * span + times * move - centre);
      v = value; b = block;
      gl_Position = vec4((seen.xy + shift) / half_.xy, -seen.z / half_.z - lift, 1.0);
    }`;
  const faces = program(VERTEX, `
    in vec3 seen; in float v; flat in uint b; uniform float from, to; uniform int count; uniform vec3 map[10];
    uniform int chosen; uniform bool over, alone; out vec4 colour;
    void main() {
      if (alone && int(b) != chosen) discard;
      float light = 0.62 + 0.38 * abs(normalize(cross(dFdx(seen), dFdy(seen))).z);
      vec3 own = vec3(0.72, 0.73, 0.75);
      if (v <= 65534.5) {
        float at = clamp((v - from) / max(to - from, 1e-6), 0.0, 1.0) * float(count - 1);
        int i = min(int(at), count - 2);
        own = mix(map[i], map[i + 1], at - float(i));
        if (over && v > to) own = vec3(0.23, 0.03, 0.39);
      }
      if (int(b) == chosen) own = mix(own, vec3(0.15, 0.55, 1.0), 0.45);
      colour = vec4(own * light, 1.0);
    }`);
  const lines = program(VERTEX, `in vec3 seen; in float v; flat in uint b; out vec4 colour; void main() { colour = vec4(0.18, 0.2, 0.24, 1.0); }`);
  const numbers = program(VERTEX, `
    in vec3 seen; in float v; flat in uint b; out vec4 colour;
    void main() { uint n = b + 1u; colour = vec4(float(n & 255u), float((n >> 8) & 255u), float((n >> 16) & 255u), 255.0) / 255.0; }`);
  const buffer = (kind, data) => {
    const made = gl.createBuffer();
    gl.bindBuffer(kind, made);
    gl.bufferData(kind, data, gl.STATIC_DRAW);
    return made;
  };
  const mesh = (part, blocks) => {
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    buffer(gl.ARRAY_BUFFER, bytes(part.points));
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.UNSIGNED_SHORT, true, 0, 0);
    buffer(gl.ARRAY_BUFFER, bytes(part.moves));
    gl.enableVertexAttribArray(1);
    gl.vertexAttribPointer(1, 3, gl.SHORT, true, 0, 0);
    if (blocks) {
      buffer(gl.ARRAY_BUFFER, bytes(blocks));
      gl.enableVertexAttribArray(3);
      gl.vertexAttribIPointer(3, 1, gl.UNSIGNED_INT, 0, 0);
    }
    const cells = bytes(part.cells);
    buffer(gl.ELEMENT_ARRAY_BUFFER, cells);
    gl.bindVertexArray(null);
    return { array, count: cells.byteLength / 4 };
  };
  const skin = mesh(model.skin, model.block);
  const outline = mesh(model.outline, null);
  const field = document.getElementById("field");
  const slider = document.getElementById("factor");
  const edges = document.getElementById("edges");
  model.fields.forEach((one, i) => field.add(new Option(one.name, String(i))));
  const loaded = model.fields.map(() => null);
  const flat = model.dimension === 2;
  const radius = Math.hypot(...model.span.map((s, i) => (flat && i === 2 ? 0 : s))) / 2;
  const eye = { angle: 0, tilt: 0, zoom: 1, x: 0, y: 0 };
  let chosen = -1;
  const turned = () => {
    const [c, s, ct, st] = [Math.cos(eye.angle), Math.sin(eye.angle), Math.cos(eye.tilt), Math.sin(eye.tilt)];
    // columns: where the world's axes go; z is up in space, y in the plane
    return flat ? [c, s * st, s * ct, 0, ct, -st, -s, c * st, c * ct]
      : [c, -s * st, s * ct, s, c * st, -c * ct, 0, ct, st];
  };
  // half the extent of the box about the model as it is seen at first: the picture is filled, and turning does not change the scale
  const extent = () => {
    const t = turned();
    return [0, 1].map((row) => model.span.reduce((sum, s, i) => sum + Math.abs(t[3 * i + row]) * (flat && i === 2 ? 0 : s) / 2, 0));
  };
  const reset = () => {
    Object.assign(eye, flat ? { angle: 0, tilt: 0 } : { angle: 0.55, tilt: 0.42 }, { zoom: 1, x: 0, y: 0 });
    eye.fit = extent();
  };
  reset();
  const reach = () => {
    const wide = canvas.clientWidth / canvas.clientHeight;
    const tall = 1.12 * Math.max(eye.fit[1], eye.fit[0] / wide) / eye.zoom;
    return [tall * wide, tall];
  };
  const prefix = (value, unit) => {
    if (!unit) return Number(value.toPrecision(3)).toString();
    const [factor, letter] = [[1e9, "G"], [1e6, "M"], [1e3, "k"], [1, ""], [1e-3, "m"], [1e-6, "µ"], [1e-9, "n"]]
      .find(([f]) => Math.abs(value) >= f) || [1, ""];
    return `${Number((value / factor).toPrecision(3))} ${letter}${unit}`;
  };
  const look = () => {
    const one = model.fields[Number(field.value)];
    const used = one.name === "utilisation";
    let [from, to] = [one.from, one.to];
    if (used && one.high > 1) to = 1;
    const signed = from < 0 && to > 0;
    if (signed) { to = Math.max(-from, to); from = -to; }
    return { one, from, to, over: used && one.high > 1, map: MAPS[used ? "used" : signed ? "signed" : "stress"] };
  };
  const draw = (which, target) => {
    const ratio = target ? 1 : window.devicePixelRatio || 1;
    const [w, h] = [Math.round(canvas.clientWidth * ratio), Math.round(canvas.clientHeight * ratio)];
    if (!target && (canvas.width !== w || canvas.height !== h)) { canvas.width = w; canvas.height = h; }
    gl.viewport(0, 0, w, h);
    gl.enable(gl.DEPTH_TEST);
    const back = target ? 0 : 1;
    gl.clearColor(back, back, back, target ? 0 : 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const set = (prog, lift) => {
      const at = (name) => gl.getUniformLocation(prog, name);
      gl.useProgram(prog);
      gl.uniform3fv(at("low"), model.low);
      gl.uniform3fv(at("span"), model.span);
      gl.uniform3fv(at("centre"), model.low.map((l, i) => l + model.span[i] / 2 * (flat && i === 2 ? 0 : 1)));
      const [x, y] = reach();
      gl.uniform3fv(at("half_"), [x, y, 4 * radius]);
      gl.uniform1f(at("times"), times() * model.most);
      gl.uniformMatrix3fv(at("turn"), false, turned());
      gl.uniform2fv(at("shift"), [eye.x, eye.y]);
      gl.uniform1f(at("lift"), lift);
      return at;
    };
    const at = set(which, 0);
    const { one, from, to, over, map } = look();
    gl.bindVertexArray(skin.array);
    if (which === faces) {
      const number = Number(field.value);
      if (!loaded[number]) {
        loaded[number] = gl.createBuffer();
        gl.bindBuffer(gl.ARRAY_BUFFER, loaded[number]);
        gl.bufferData(gl.ARRAY_BUFFER, bytes(one.values), gl.STATIC_DRAW);
      }
      gl.bindBuffer(gl.ARRAY_BUFFER, loaded[number]);
      gl.enableVertexAttribArray(2);
      gl.vertexAttribPointer(2, 1, gl.UNSIGNED_SHORT, false, 0, 0);
      const scaled = (value) => (value - one.low) / ((one.high - one.low) || 1) * 65534;
      gl.uniform1f(at("from"), scaled(from));
      gl.uniform1f(at("to"), scaled(to));
      gl.uniform1i(at("count"), map.length);
      const parts = map.flatMap((hex) => [0, 2, 4].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255));
      gl.uniform3fv(at("map"), [...parts, ...Array(30 - parts.length).fill(0)]);
      gl.uniform1i(at("chosen"), chosen);
      gl.uniform1i(at("over"), over ? 1 : 0);
      gl.uniform1i(at("alone"), 0);
    }
    gl.drawElements(gl.TRIANGLES, skin.count, gl.UNSIGNED_INT, 0);
    if (which === faces && edges.checked) {
      set(lines, 0.001);
      gl.bindVertexArray(outline.array);
      gl.vertexAttribI4ui(3, 0, 0, 0, 0);
      gl.drawElements(gl.LINES, outline.count, gl.UNSIGNED_INT, 0);
    }
    if (which === faces && chosen >= 0) { // the chosen stone is seen through what is before it
      gl.clear(gl.DEPTH_BUFFER_BIT);
      gl.useProgram(faces);
      gl.uniform1i(at("alone"), 1);
      gl.bindVertexArray(skin.array);
      gl.drawElements(gl.TRIANGLES, skin.count, gl.UNSIGNED_INT, 0);
    }
    gl.bindVertexArray(null);
  };
  const times = () => model.factor * (Number(slider.value) / 33) ** 2;
  let waiting = false;
  const show = () => {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => {
      waiting = false;
      draw(faces, null);
      document.getElementById("times").textContent = Number(times().toPrecision(2)).toLocaleString("en");
      const { one, from, to, over, map } = look();
      document.getElementById("bar").style.background = `linear-gradient(to top, ${map.map((c) => `#${c}`).join(",")})`;
      const ends = document.getElementById("ends");
      ends.replaceChildren(...[`${to < one.high ? "≥ " : ""}${prefix(to, one.unit)}${over ? " (dark: more)" : ""}`, prefix((from + to) / 2, one.unit), `${from > one.low ? "≤ " : ""}${prefix(from, one.unit)}`]
        .map((text) => Object.assign(document.createElement("span"), { textContent: text })));
    });
  };
  const table = document.getElementById("stones");
  const rows = new Map(table ? [...table.tBodies[0].rows].map((row) => [row.cells[0].textContent, row]) : []);
  const heads = table ? [...table.tHead.rows[0].cells].map((head) => head.textContent) : [];
  const hint = `Drag ${flat ? "moves" : "turns"}, wheel or two fingers zoom${flat ? "" : ", shift and drag or two fingers move"}; click on a stone for its figures.`;
  const choose = (block, none) => {
    chosen = block;
    for (const row of rows.values()) row.classList.remove("chosen");
    const name = model.names[chosen];
    const row = rows.get(name);
    if (row) row.classList.add("chosen");
    const figures = row ? [...row.cells].slice(1).map((cell, i) => cell.textContent && `${heads[i + 1]}: ${cell.textContent}`) : [];
    picked.textContent = chosen < 0 ? none : `${name}\n${figures.filter(Boolean).join(" · ")}`;
    show();
  };
  if (table) table.classList.add("linked");
  for (const [name, row] of rows) {
    row.addEventListener("click", () => {
      choose(model.names.indexOf(name), hint);
      canvas.scrollIntoView({ block: "center" });
    });
  }
  const pick = (x, y) => {
    const [w, h] = [canvas.clientWidth, canvas.clientHeight];
    const target = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, target);
    const [colour, depth] = [gl.createRenderbuffer(), gl.createRenderbuffer()];
    gl.bindRenderbuffer(gl.RENDERBUFFER, colour);
    gl.renderbufferStorage(gl.RENDERBUFFER, gl.RGBA8, w, h);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.RENDERBUFFER, colour);
    gl.bindRenderbuffer(gl.RENDERBUFFER, depth);
    gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT24, w, h);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, depth);
    draw(numbers, target);
    const pixel = new Uint8Array(4);
    gl.readPixels(Math.floor(x), Math.floor(h - y - 1), 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.deleteFramebuffer(target);
    gl.deleteRenderbuffer(colour);
    gl.deleteRenderbuffer(depth);
    choose(pixel[0] + 256 * pixel[1] + 65536 * pixel[2] - 1, "No stone there.");
  };
  const move = (dx, dy) => {
    const [wide, tall] = reach();
    eye.x += 2 * wide * dx / canvas.clientWidth;
    eye.y -= 2 * tall * dy / canvas.clientHeight;
  };
  const turn = (dx, dy) => {
    eye.angle += 0.008 * dx;
    eye.tilt = Math.max(-1.57, Math.min(1.57, eye.tilt + 0.008 * dy));
  };
  const zoom = (factor) => { eye.zoom = Math.max(0.2, Math.min(200, eye.zoom * factor)); };
  const fingers = new Map(); // where pointers that are down are, by their number
  let far = 0; // way of all of them since the first came down
  const between = () => {
    const [a, b] = [...fingers.values()];
    return Math.hypot(a.x - b.x, a.y - b.y);
  };
  canvas.addEventListener("pointerdown", (event) => {
    if (!fingers.size) far = 0;
    fingers.set(event.pointerId, { x: event.offsetX, y: event.offsetY });
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    const last = fingers.get(event.pointerId);
    if (!last) return;
    const [dx, dy] = [event.offsetX - last.x, event.offsetY - last.y];
    const before = fingers.size === 2 ? between() : 0;
    fingers.set(event.pointerId, { x: event.offsetX, y: event.offsetY });
    far += Math.hypot(dx, dy);
    if (fingers.size === 2) {
      move(dx / 2, dy / 2);
      if (before) zoom(between() / before);
    } else if (event.shiftKey || flat) move(dx, dy);
    else turn(dx, dy);
    show();
  });
  const up = (event) => {
    const alone = fingers.size === 1 && fingers.delete(event.pointerId);
    fingers.delete(event.pointerId);
    if (alone && far < 4 && event.type === "pointerup") pick(event.offsetX, event.offsetY);
  };
  canvas.addEventListener("pointerup", up);
  canvas.addEventListener("pointercancel", up);
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoom(Math.exp(-0.0015 * event.deltaY));
    show();
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    const [dx, dy] = { ArrowLeft: [-12, 0], ArrowRight: [12, 0], ArrowUp: [0, -12], ArrowDown: [0, 12] }[event.key] || [0, 0];
    const factor = { "+": 1.2, "-": 1 / 1.2 }[event.key] || 1;
    if (!dx && !dy && factor === 1) return;
    event.preventDefault();
    (event.shiftKey || flat ? move : turn)(dx, dy);
    zoom(factor);
    show();
  });
  field.addEventListener("change", show);
  slider.addEventListener("input", show);
  edges.addEventListener("change", show);
  document.getElementById("reset").addEventListener("click", () => { reset(); choose(-1, hint); });
  window.addEventListener("resize", show);
  if (!model.factor) slider.disabled = true;
  choose(-1, hint);
})();
