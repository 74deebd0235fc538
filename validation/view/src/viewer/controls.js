// What the viewer listens to: the panel, mouse, touch and keys.
Viewer.prototype.controls = function () {
  const { head } = this;
  $("name").textContent = head.scene;
  $("about").textContent = head.about;
  $("note").textContent = head.note;
  $("time").max = head.frames.length - 1;
  $("field").replaceChildren(...head.fields.map(({ title }, number) => new Option(title, number)));
  $("field").value = this.field;
  $("field").onchange = (event) => {
    this.field = Number(event.target.value);
    this.colourBy();
    this.legend();
  };
  const again = () => { this.dirty = true; };
  for (const name of ["size", "walls"]) $(name).oninput = again;
  $("chains").onchange = (event) => {
    // Chains lie inside the grains.
    if (event.target.checked && $("size").value > 0.5) $("size").value = 0.35;
    if (!event.target.checked && $("size").value < 0.5) $("size").value = 1;
    again();
  };
  if (!head.frames.some((frame) => frame.contacts)) $("chains-label").style.display = "none";
  if (!head.walls.length) $("walls").parentElement.style.display = "none";
  const cut = () => {
    const axis = $("axis").value;
    $("place").disabled = !axis;
    this.cut = axis ? { axis, place: Number($("place").value), flip: $("flip").checked } : null;
    again();
  };
  for (const name of ["axis", "place", "flip"]) $(name).oninput = cut;
  $("time").oninput = (event) => {
    this.play(false);
    this.show(Number(event.target.value));
  };
  $("play").onclick = () => this.play(!this.playing);
  $("options").open = innerWidth > 700 && innerHeight > 480;
  if (head.frames.length < 2) document.querySelector("footer").style.display = "none";
  this.legend();
};

Viewer.prototype.play = function (on) {
  this.playing = on;
  $("play").textContent = on ? "\u275A\u275A" : "\u25B6";
  if (on && this.frame === this.head.frames.length - 1) this.show(0);
};

Viewer.prototype.turn = function (x, y) {
  const { camera } = this;
  camera.azimuth += x;
  camera.elevation = Math.min(Math.max(camera.elevation + y, -1.57), 1.57);
  this.dirty = true;
};

// By pixels of the canvas: what is under the pointer goes with it.
Viewer.prototype.move = function (x, y) {
  const { camera, canvas } = this, { right, top } = this.axes();
  const unit = 2 * camera.away / (this.focal() * canvas.clientHeight);
  camera.target = plus(plus(camera.target, right, -x * unit), top, y * unit);
  this.dirty = true;
};

Viewer.prototype.approach = function (factor) {
  const { size } = this.head.eye;
  this.camera.away = Math.min(Math.max(this.camera.away * factor, 0.02 * size), 20 * size);
  this.dirty = true;
};

Viewer.prototype.listen = function () {
  const { canvas } = this, fingers = new Map();
  const gap = () => {
    const [a, b] = [...fingers.values()];
    return { x: 0.5 * (a.x + b.x), y: 0.5 * (a.y + b.y), apart: Math.max(Math.hypot(a.x - b.x, a.y - b.y), 1) };
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  });
  canvas.addEventListener("pointermove", (event) => {
    const old = fingers.get(event.pointerId);
    if (!old) return;
    const [x, y] = [event.clientX - old.x, event.clientY - old.y];
    if (fingers.size === 2) {
      const before = gap();
      fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      const after = gap();
      this.approach(before.apart / after.apart);
      this.move(after.x - before.x, after.y - before.y);
      return;
    }
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (event.shiftKey || event.buttons & 6) this.move(x, y);
    else this.turn(0.006 * x, 0.006 * y);
  });
  for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (event) => fingers.delete(event.pointerId));
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    this.approach(Math.exp(0.0012 * Math.max(-300, Math.min(300, event.deltaY))));
  }, { passive: false });
  canvas.addEventListener("webglcontextlost", (event) => {
    event.preventDefault();
    trouble("The graphics driver has stopped: load the page again.");
  });
  $("panel").addEventListener("submit", (event) => event.preventDefault());
  addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || event.target.tagName === "SELECT") return;
    const toggle = (name) => {
      $(name).checked = !$(name).checked;
      $(name).dispatchEvent(new Event($(name).onchange ? "change" : "input"));
    };
    const step = (by) => {
      this.play(false);
      this.show(this.frame + by);
    };
    const keys = {
      " ": () => this.play(!this.playing),
      ArrowRight: () => step(1), ArrowLeft: () => step(-1),
      Home: () => step(-this.frame), End: () => step(this.head.frames.length - 1 - this.frame),
      "+": () => this.approach(0.9), "-": () => this.approach(1.11),
      r: () => this.home(), w: () => toggle("walls"), c: () => toggle("chains"),
    };
    const act = keys[event.key] || keys[event.key.toLowerCase()];
    if (!act) return;
    // The slider of time would move by itself too.
    event.preventDefault();
    act();
  });
};

// What a test may ask for behind the address: #measure=30, #chains, #clip=y, #frame=0, #ratio=1.
function wishes(viewer) {
  for (const wish of location.hash.slice(1).split("&").filter(Boolean)) {
    const [name, value] = wish.split("=");
    if (name === "ratio") viewer.fixedRatio = Number(value);
    if (name === "frame") viewer.show(Number(value));
    if (name === "chains") $("chains").click();
    if (name === "clip") {
      $("axis").value = value;
      $("axis").dispatchEvent(new Event("input"));
    }
    if (name === "field") {
      $("field").value = value;
      $("field").dispatchEvent(new Event("change"));
    }
    if (name === "measure") document.body.dataset.measured = JSON.stringify(viewer.measure(Number(value)));
  }
}

unpack().then((data) => {
  window.viewer = new Viewer(data);
  $("loading").hidden = true;
  wishes(window.viewer);
  document.body.dataset.ready = "true";
}).catch((error) => trouble(error.message));
