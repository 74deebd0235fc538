// The viewer: reads the payload, draws frames with WebGL 2, listens to mouse, touch and keys. It asks for nothing from outside.
"use strict";
const $ = (id) => document.getElementById(id);

function trouble(text) {
  $("loading").hidden = true;
  $("trouble").textContent = text;
  $("trouble").hidden = false;
  document.body.dataset.trouble = text;
}
addEventListener("error", (event) => trouble(event.message));
addEventListener("unhandledrejection", (event) => trouble(String(event.reason)));

// Base64 in slices, so that no second copy of the whole is needed.
function bytesOf(text) {
  const length = text.length, slice = 1 << 20, padding = text.endsWith("==") ? 2 : text.endsWith("=") ? 1 : 0;
  const bytes = new Uint8Array(length / 4 * 3 - padding);
  for (let start = 0, at = 0; start < length; start += slice) {
    const part = atob(text.slice(start, start + slice));
    for (let k = 0; k < part.length; k++) bytes[at++] = part.charCodeAt(k);
  }
  return bytes;
}

async function unpack() {
  // The page is shown before the work begins.
  await new Promise((resolve) => setTimeout(resolve, 30));
  const packed = bytesOf($("payload").textContent.trim());
  $("payload").textContent = "";
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const buffer = await new Response(stream).arrayBuffer();
  const length = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  return { buffer, head, shift: head.start };
}

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const plus = (a, b, s) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];

class Viewer {
  constructor({ buffer, head, shift }) {
    Object.assign(this, { buffer, head, shift });
    this.canvas = $("scene");
    const gl = this.canvas.getContext("webgl2", { antialias: true, alpha: false, powerPreference: "high-performance" });
    if (!gl) throw new Error("This browser has no WebGL 2: try another one, or switch hardware acceleration on.");
    this.gl = gl;
    this.frame = -1;
    this.field = head.chosen;
    this.playing = false;
    this.dirty = true;
    this.home();
    this.build();
    this.controls();
    this.listen();
    this.show(head.frames.length - 1);
    const loop = (now) => {
      this.tick(now);
      requestAnimationFrame(loop);
    };
    requestAnimationFrame(loop);
  }

  home() {
    const { eye } = this.head;
    this.camera = { target: eye.target.slice(), azimuth: eye.azimuth, elevation: eye.elevation, away: eye.away };
    this.dirty = true;
  }

  array(type, [offset, count]) {
    return new type(this.buffer, this.shift + offset, count);
  }

  build() {
    const { gl, head } = this;
    const compile = (kind, text) => {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      return shader;
    };
    const program = (vertex, fragment) => {
      const made = gl.createProgram();
      gl.attachShader(made, compile(gl.VERTEX_SHADER, vertex));
      gl.attachShader(made, compile(gl.FRAGMENT_SHADER, fragment));
      gl.linkProgram(made);
      if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made));
      const places = {};
      for (let k = 0; k < gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS); k++) {
        const { name } = gl.getActiveUniform(made, k);
        places[name] = gl.getUniformLocation(made, name);
      }
      return { made, places };
    };
    this.grain = program(GRAIN_VERTEX, GRAIN_FRAGMENT);
    this.chain = program(CHAIN_VERTEX, CHAIN_FRAGMENT);
    this.wall = program(WALL_VERTEX, WALL_FRAGMENT);
    this.screen = program(SCREEN_VERTEX, SCREEN_FRAGMENT);

    const buffer = (data) => {
      const made = gl.createBuffer();
      gl.bindBuffer(gl.ARRAY_BUFFER, made);
      if (data) gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
      return made;
    };
    this.corners = buffer(new Float32Array([-1, -1, 1, -1, -1, 1, 1, 1]));
    this.radii = buffer(this.array(Float32Array, head.radii));
    this.states = buffer();
    this.others = buffer();
    this.contacts = buffer();
    this.glass = buffer();
    this.stone = buffer();
    this.edges = buffer();
    const attribute = (place, from, size, type, normal, stride, offset, divisor) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, from);
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, size, type, normal, stride, offset);
      gl.vertexAttribDivisor(place, divisor);
    };
    const layout = (fill) => {
      const made = gl.createVertexArray();
      gl.bindVertexArray(made);
      fill();
      gl.bindVertexArray(null);
      return made;
    };
    this.layouts = {
      grain: layout(() => {
        attribute(0, this.corners, 2, gl.FLOAT, false, 0, 0, 0);
        attribute(1, this.states, 4, gl.UNSIGNED_SHORT, true, 8, 0, 1);
        attribute(2, this.radii, 1, gl.FLOAT, false, 0, 0, 1);
        attribute(3, this.others, 1, gl.UNSIGNED_SHORT, true, 2, 0, 1);
      }),
      chain: layout(() => {
        attribute(0, this.corners, 2, gl.FLOAT, false, 0, 0, 0);
        attribute(1, this.contacts, 3, gl.UNSIGNED_SHORT, true, 14, 0, 1);
        attribute(2, this.contacts, 3, gl.UNSIGNED_SHORT, true, 14, 6, 1);
        attribute(3, this.contacts, 1, gl.UNSIGNED_SHORT, true, 14, 12, 1);
      }),
      screen: layout(() => attribute(0, this.corners, 2, gl.FLOAT, false, 0, 0, 0)),
    };
    for (const name of ["glass", "stone", "edges"]) {
      this.layouts[name] = layout(() => attribute(0, this[name], 3, gl.FLOAT, false, 0, 0, 0));
    }
    this.image = gl.createTexture();
    this.depth = gl.createTexture();
    this.target = gl.createFramebuffer();
    this.scale = gl.createTexture();
  }

  // Textures of the size of the canvas.
  resize() {
    const { gl, canvas } = this;
    const ratio = this.fixedRatio || Math.min(window.devicePixelRatio || 1, 2);
    const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((side) => Math.max(1, Math.round(side * ratio)));
    if (canvas.width === width && canvas.height === height && this.sized) return;
    Object.assign(canvas, { width, height });
    this.sized = true;
    const texture = (made, inside, format, type) => {
      gl.bindTexture(gl.TEXTURE_2D, made);
      gl.texImage2D(gl.TEXTURE_2D, 0, inside, width, height, 0, format, type, null);
      for (const [key, value] of [[gl.TEXTURE_MIN_FILTER, gl.NEAREST], [gl.TEXTURE_MAG_FILTER, gl.NEAREST],
        [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE]]) gl.texParameteri(gl.TEXTURE_2D, key, value);
    };
    texture(this.image, gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE);
    texture(this.depth, gl.DEPTH_COMPONENT24, gl.DEPTH_COMPONENT, gl.UNSIGNED_INT);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.target);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, this.image, 0);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, this.depth, 0);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  // Takes a frame to the graphics memory.
  show(number) {
    const { gl, head } = this;
    this.frame = (number + head.frames.length) % head.frames.length;
    const frame = head.frames[this.frame];
    const load = (into, data) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, into);
      gl.bufferData(gl.ARRAY_BUFFER, data, gl.DYNAMIC_DRAW);
    };
    load(this.states, this.array(Uint16Array, frame.state));
    if (frame.radii) load(this.radii, this.array(Float32Array, frame.radii));
    this.colourBy();
    if (frame.contacts) load(this.contacts, this.array(Uint16Array, frame.contacts));
    const walls = head.walls[frame.walls];
    for (const name of ["glass", "stone", "edges"]) {
      if (walls) load(this[name], this.array(Float32Array, walls[name]));
    }
    $("time").value = this.frame;
    $("clock").textContent = `${frame.time.toFixed(3)} s  (${this.frame + 1} of ${head.frames.length})${frame.stage ? "  " + frame.stage : ""}`;
    this.dirty = true;
  }

  // The field that grains are coloured by: the first one travels with the places, others beside them or once for all frames.
  colourBy() {
    const { gl, head } = this, field = head.fields[this.field];
    const frame = head.frames[this.frame], once = frame.once ? frame.once[field.constant] : field.once;
    const data = field.once ? once : (field.number > 0 ? frame.others[field.number - 1] : null);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.others);
    gl.bufferData(gl.ARRAY_BUFFER, data ? this.array(Uint16Array, data) : frame.state[1] / 2, gl.DYNAMIC_DRAW);
  }

  legend() {
    const { gl, head } = this, field = head.fields[this.field], pixels = new Uint8Array(4 * 256);
    const stops = head.viridis;
    for (let k = 0; k < 256; k++) {
      const at = k / 255 * (stops.length - 1), below = Math.min(Math.floor(at), stops.length - 2);
      const colour = field.kinds ? head.palette[k % head.palette.length] : stops[below].map((low, c) => low + (stops[below + 1][c] - low) * (at - below));
      pixels.set([...colour, 255], 4 * k);
    }
    gl.bindTexture(gl.TEXTURE_2D, this.scale);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, 256, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    $("quantity").textContent = field.unit ? `${field.title} (${field.unit})` : field.title;
    $("bar").style.display = field.kinds ? "none" : "";
    $("kinds").replaceChildren(...(field.kinds || []).map((name, kind) => {
      const item = document.createElement("li"), dot = document.createElement("i");
      dot.style.background = `rgb(${head.palette[kind % head.palette.length]})`;
      item.append(name, dot);
      return item;
    }));
    const paint = $("scale").getContext("2d");
    for (let k = 0; k < 256; k++) {
      paint.fillStyle = `rgb(${pixels[4 * k]},${pixels[4 * k + 1]},${pixels[4 * k + 2]})`;
      paint.fillRect(0, 255 - k, 1, 1);
    }
    const [bottom, top] = field.range;
    $("ticks").replaceChildren(...field.ticks.map(({ at, text }) => {
      const tick = document.createElement("span");
      tick.style.bottom = `${100 * (at - bottom) / (top - bottom)}%`;
      tick.textContent = text;
      return tick;
    }));
    this.dirty = true;
  }

  // Focal length over half the height of the canvas: the opening spans the shorter side, so that a narrow window shows all.
  focal() {
    const { canvas, head } = this;
    return Math.min(1, canvas.clientWidth / Math.max(canvas.clientHeight, 1)) / Math.tan(0.5 * head.eye.opening);
  }

  axes() {
    const { up, front } = this.head.eye, { azimuth, elevation } = this.camera, beside = cross(front, up);
    const level = plus(plus([0, 0, 0], front, Math.cos(azimuth)), beside, -Math.sin(azimuth));
    const forward = plus(plus([0, 0, 0], level, Math.cos(elevation)), up, -Math.sin(elevation));
    const top = plus(plus([0, 0, 0], level, Math.sin(elevation)), up, Math.cos(elevation));
    return { forward, top, right: cross(forward, top) };
  }

  draw() {
    const { gl, canvas, camera, head } = this;
    this.resize();
    const { forward, top, right } = this.axes(), eye = plus(camera.target, forward, -camera.away);
    const view = [right[0], top[0], -forward[0], 0, right[1], top[1], -forward[1], 0, right[2], top[2], -forward[2], 0,
      -dot(right, eye), -dot(top, eye), dot(forward, eye), 1];
    const far = camera.away + 8 * head.eye.size, near = Math.max(camera.away - 2 * head.eye.size, 0.004 * far);
    const focal = this.focal();
    const projection = [focal * canvas.height / canvas.width, 0, 0, 0, 0, focal, 0, 0,
      0, 0, -(far + near) / (far - near), -1, 0, 0, -2 * far * near / (far - near), 0];
    let clip = [0, 0, 0, -1];
    if (this.cut) {
      const axis = "xyz".indexOf(this.cut.axis), at = head.low[axis] + this.cut.place * head.span[axis];
      const sign = (eye[axis] >= at ? 1 : -1) * (this.cut.flip ? -1 : 1);
      const inView = [right[axis] * sign, top[axis] * sign, -forward[axis] * sign];
      clip = [...inView, sign * (eye[axis] - at)];
    }
    const use = ({ made, places }) => {
      gl.useProgram(made);
      gl.uniformMatrix4fv(places.view, false, view);
      gl.uniformMatrix4fv(places.projection, false, projection);
      if (places.low) gl.uniform3fv(places.low, head.low);
      if (places.span) gl.uniform3fv(places.span, head.span);
      gl.uniform4fv(places.clip, clip);
      return places;
    };
    const frame = head.frames[this.frame];
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.target);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(1, 1, 1, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.depthMask(true);
    gl.disable(gl.BLEND);
    const size = Number($("size").value);
    if (size > 0) {
      const places = use(this.grain), field = head.fields[this.field];
      gl.activeTexture(gl.TEXTURE0);
      gl.bindTexture(gl.TEXTURE_2D, this.scale);
      gl.uniform1i(places.scale, 0);
      gl.uniform1f(places.size, size);
      gl.uniform1i(places.first, field.number === 0 ? 1 : 0);
      gl.uniform1f(places.kinds, field.kinds ? 1 : 0);
      gl.uniform2fv(places.shown, field.shown);
      gl.bindVertexArray(this.layouts.grain);
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, frame.state[1] / 4);
    }
    if ($("chains").checked && frame.contacts) {
      const places = use(this.chain);
      gl.uniform1f(places.thick, head.thick);
      gl.bindVertexArray(this.layouts.chain);
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, frame.contacts[1] / 7);
    }
    const walls = $("walls").checked ? head.walls[frame.walls] : null;
    const faces = (name, mode, paint, lit) => {
      const places = use(this.wall);
      gl.uniform4fv(places.paint, paint);
      gl.uniform1i(places.lit, lit ? 1 : 0);
      gl.bindVertexArray(this.layouts[name]);
      gl.drawArrays(mode, 0, walls[name][1] / 3);
    };
    if (walls) faces("stone", gl.TRIANGLES, [0.78, 0.77, 0.75, 1], true);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, canvas.width, canvas.height);
    const { made, places } = this.screen;
    gl.useProgram(made);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.image);
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, this.depth);
    gl.uniform1i(places.image, 0);
    gl.uniform1i(places.depth, 1);
    gl.uniform2f(places.pixel, 1 / canvas.width, 1 / canvas.height);
    gl.uniform2f(places.planes, near, far);
    gl.uniform3f(places.paper, 1, 1, 1);
    gl.bindVertexArray(this.layouts.screen);
    gl.depthFunc(gl.ALWAYS);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    gl.depthFunc(gl.LESS);
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, null);
    if (walls) {
      gl.enable(gl.BLEND);
      gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
      gl.depthMask(false);
      faces("glass", gl.TRIANGLES, [0.5, 0.57, 0.64, 0.12], true);
      faces("edges", gl.LINES, [0.2, 0.24, 0.29, 0.8], false);
      gl.depthMask(true);
    }
  }

  tick(now) {
    if (this.playing && now - (this.turned || 0) >= 1000 / this.head.rate) {
      this.turned = now;
      this.show(this.frame + 1);
    }
    const { canvas } = this;
    if (canvas.clientWidth !== this.width || canvas.clientHeight !== this.height) {
      [this.width, this.height, this.dirty] = [canvas.clientWidth, canvas.clientHeight, true];
    }
    if (!this.dirty) return;
    this.dirty = false;
    this.draw();
    document.body.dataset.drawn = String(Number(document.body.dataset.drawn || 0) + 1);
  }

  // Milliseconds per frame when each is loaded, drawn and waited for.
  measure(count) {
    const { gl } = this, pixel = new Uint8Array(4);
    const wait = () => gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    this.draw();
    wait();
    const start = performance.now();
    for (let k = 0; k < count; k++) {
      this.show(k);
      this.draw();
      wait();
    }
    const debug = gl.getExtension("WEBGL_debug_renderer_info");
    const renderer = debug ? gl.getParameter(debug.UNMASKED_RENDERER_WEBGL) : gl.getParameter(gl.RENDERER);
    return { milliseconds: (performance.now() - start) / count, renderer, error: gl.getError(), size: [this.canvas.width, this.canvas.height] };
  }
}
