"use strict";
// Lengths in mm. The mold's frame has z up as it is poured, ridges down; the skin's has its ridges up.
// Colours of the pressure: matplotlib's viridis (CC0), which the colour-blind can read, in nine steps.
const COLOURS = ["#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962", "#addc30", "#fde725"];
const SKIN = "#eebfa6", EDGE = 0x333333, SHARP = 25, LEAVING = 600;  // degrees between faces at an edge that is drawn; ms
// Each key: its meaning, and the button that it presses or what it does.
const KEYS = {
  "?": ["show or hide these keys", "help"], "f": ["fit into the picture", "fit"], "m": ["mold", "mold"],
  "s": ["skin under load", "skin"], "t": ["turn over", "over"], "e": ["take apart, or put together", "apart"],
  "n": ["next step of the opening", "on"], "b": ["step back", "back"], "x": ["cut across x", "x"], "y": ["cut across y", "y"],
  "z": ["cut across z", "z"], "c": ["no cut", ""], "+": ["nearer", 1.25], "-": ["further away", 0.8],
};
const RULER = 140;  // pixels, the longest that the scale bar gets
const get = (id) => document.getElementById(id);
const numbers = (text, Kind) => new Kind(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer);

async function data() {
  const packed = Uint8Array.from(atob(get("data").textContent), (c) => c.charCodeAt(0));
  const text = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(text).json();
}

function stage() {
  const renderer = new THREE.WebGLRenderer({ antialias: true });
  renderer.setPixelRatio(window.devicePixelRatio);
  renderer.localClippingEnabled = true;
  get("stage").appendChild(renderer.domElement);
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(0xffffff);
  const camera = new THREE.OrthographicCamera(-1, 1, 1, -1, -1e4, 1e4);
  camera.up.set(0, 0, 1);
  const controls = new THREE.TrackballControls(camera, renderer.domElement);
  controls.rotateSpeed = 3; controls.staticMoving = true;
  controls.keys = ["", "", ""];  // else A, S and D change what a drag does
  // A lamp over the viewer's left shoulder; the sky and the floor fill what it leaves dark.
  const lamp = new THREE.DirectionalLight(0xffffff, 0.5), sky = new THREE.HemisphereLight(0xffffff, 0x9aa3ad, 0.58);
  sky.position.set(0, 0, 1);
  scene.add(lamp, sky);
  return { renderer, scene, camera, controls, lamp };
}

// A solid: its faces lit, its sharp edges, and what fills it where it is cut. Of faces behind the cut a ray meets
// one more from inside than from outside if it enters within the solid: that is counted in the stencil.
function solid(geometry, colour, cut, { clear = false, painted = false } = {}) {
  const group = new THREE.Group();
  const colours = painted ? { vertexColors: true } : { color: colour };
  const lit = { ...colours, flatShading: true, shininess: 0, clippingPlanes: cut, side: THREE.FrontSide };
  const face = new THREE.Mesh(geometry, new THREE.MeshPhongMaterial(lit));
  const lines = new THREE.LineSegments(new THREE.EdgesGeometry(geometry, SHARP),
    new THREE.LineBasicMaterial({ color: EDGE, clippingPlanes: cut }));
  const counted = [[THREE.BackSide, THREE.IncrementWrapStencilOp], [THREE.FrontSide, THREE.DecrementWrapStencilOp]];
  const counters = counted.map(([side, act]) => new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({
    side, clippingPlanes: cut, colorWrite: false, depthWrite: false, depthTest: false, stencilWrite: true,
    stencilFunc: THREE.AlwaysStencilFunc, stencilFail: act, stencilZFail: act, stencilZPass: act })));
  const cap = new THREE.Mesh(new THREE.PlaneGeometry(1, 1), new THREE.MeshBasicMaterial({
    color: new THREE.Color(colour).multiplyScalar(0.8), side: THREE.DoubleSide, stencilWrite: true, stencilRef: 0,
    stencilFunc: THREE.NotEqualStencilFunc, stencilFail: THREE.ReplaceStencilOp, stencilZFail: THREE.ReplaceStencilOp,
    stencilZPass: THREE.ReplaceStencilOp }));
  cap.onAfterRender = (renderer) => renderer.clearStencil();
  group.add(face, lines, ...counters);
  group.userData = { face, lines, counters, cap, clear };
  return group;
}

function part(told, cut) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(numbers(told.points, Float32Array), 3));
  geometry.setIndex(new THREE.BufferAttribute(numbers(told.faces, Uint32Array), 1));
  const made = solid(geometry, new THREE.Color(...told.colour), cut, { clear: told.clear });
  made.name = told.name;
  made.userData.wanted = true;
  return Object.assign(made.userData, told) && made;
}

// The longest 1, 2 or 5 times a power of ten that is no longer.
function roundLength(most) {
  const power = 10 ** Math.floor(Math.log10(most));
  return power * [5, 2, 1].find((k) => k * power <= most * (1 + 1e-9));
}

function colourAt(share) {
  const at = Math.min(Math.max(share, 0), 1) * (COLOURS.length - 1), i = Math.min(Math.floor(at), COLOURS.length - 2);
  return new THREE.Color(COLOURS[i]).lerp(new THREE.Color(COLOURS[i + 1]), at - i);
}

// The plate, clear, as large as the skin; its lower face lies at its own z = 0.
function glass(geometry) {
  geometry.computeBoundingBox();
  const wide = geometry.boundingBox.getSize(new THREE.Vector3()), thick = 0.03 * wide.x;
  const sheet = new THREE.BoxGeometry(1.1 * wide.x, 1.1 * wide.y, thick).translate(0, 0, thick / 2);
  return new THREE.Mesh(sheet, new THREE.MeshBasicMaterial({ color: 0x7799bb, transparent: true, opacity: 0.16, depthWrite: false }));
}

// The skin under its load: `set(share)` moves its corners from rest towards where the force brings them.
function loaded(told, cut) {
  const rest = numbers(told.rest, Float32Array), moved = numbers(told.moved, Float32Array);
  const pressure = numbers(told.pressure, Float32Array), largest = pressure.reduce((a, b) => Math.max(a, b), 0);
  // Faces share no corners: an end's colour is the silicone's, whatever presses on the ridges beside it.
  const corners = numbers(told.faces, Uint32Array), plain = new THREE.Color(SKIN), shades = new Float32Array(moved.length);
  const points = new Float32Array(3 * corners.length), paint = new Float32Array(points.length);
  const ends = corners.map((_, j) => { const k = j - j % 3, y = (i) => rest[3 * corners[k + i] + 1]; return y(0) === y(1) && y(1) === y(2); });
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(points, 3));
  geometry.setAttribute("color", new THREE.BufferAttribute(paint, 3));
  const made = solid(geometry, plain, cut, { painted: true });
  const { lines } = made.userData;
  let plate = null;
  const set = (share) => {
    pressure.forEach((p, i) => (p > 0 && share === 1 ? colourAt(p / largest) : plain).toArray(shades, 3 * i));
    corners.forEach((corner, j) => {
      for (let i = 0, from = 3 * corner; i < 3; i++, from++) points[3 * j + i] = rest[from] + share * (moved[from] - rest[from]);
      if (ends[j]) plain.toArray(paint, 3 * j); else paint.set(shades.subarray(3 * corner, 3 * corner + 3), 3 * j);
    });
    geometry.attributes.position.needsUpdate = geometry.attributes.color.needsUpdate = true;
    geometry.computeBoundingSphere();
    lines.geometry.dispose();
    lines.geometry = new THREE.EdgesGeometry(geometry, SHARP);
    if (plate) plate.position.z = told.plate[0] + share * (told.plate[1] - told.plate[0]);
  };
  set(1);
  plate = told.plate && glass(geometry);
  if (plate) { made.add(plate); set(1); }
  return { made, set, largest };
}

function start(told) {
  const { renderer, scene, camera, controls, lamp } = stage();
  const plane = new THREE.Plane(new THREE.Vector3(-1, 0, 0), 0), cut = [];
  const mold = new THREE.Group(), bench = new THREE.Group();
  const parts = told.parts.map((each) => part(each, cut));
  mold.add(...parts);
  scene.add(mold, bench);
  const load = told.load && loaded(told.load, cut);
  if (load) bench.add(load.made);
  bench.visible = false;
  const solids = load ? [...parts, load.made] : parts;
  scene.add(...solids.map((each) => each.userData.cap));
  let step = 0, over = false;
  let reach = 1;  // mm from the middle to the nearer edges of the picture, before any zoom
  let gone = 1, left = 0;  // how far the parts of the last step have gone, 0 to 1, and since when, ms

  const shown = () => (bench.visible ? bench : mold);
  const draw = () => {
    const [right, up, back] = [0, 1, 2].map((i) => new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, i));
    lamp.position.copy(back).addScaledVector(up, 0.6).addScaledVector(right, -0.2);
    renderer.render(scene, camera);
    ruler();
  };

  // The scale bar: lengths across the line of sight, as the camera has no perspective.
  function ruler() {
    const perMm = get("stage").clientHeight * camera.zoom / (camera.top - camera.bottom), bar = get("ruler");
    const length = roundLength(RULER / perMm);
    bar.classList.toggle("hidden", !shown().children.some((each) => each.visible));
    bar.dataset.mm = length;
    bar.firstElementChild.style.width = `${length * perMm}px`;
    bar.lastElementChild.textContent = `${Number(length.toPrecision(1))} mm`;
  }

  // Where each part stands: taken apart by the slider, and gone by the opening's steps so far.
  function place() {
    const share = Number(get("apart").value);
    for (const each of parts) {
      each.position.fromArray(each.userData.apart).multiplyScalar(share);
      each.rotation.set(0, 0, 0);
      each.visible = each.userData.wanted;
    }
    told.steps.slice(0, step).forEach(({ moves }, i) => {
      for (const move of moves) for (const [name, way] of Object.entries(move.parts)) {
        const each = parts.find((one) => one.name === name), last = i === step - 1;
        each.visible &&= last;  // what left before is out of the way
        leave(each, way, last ? gone : 1);
      }
    });
    get("step").textContent = step ? `step ${step} of ${told.steps.length}` : "closed";
    get("told").textContent = step ? told.steps[step - 1].words : "";
    get("back").disabled = !step;
    get("on").disabled = step === told.steps.length;
    section();
  }

  function leave(each, way, share) {
    if (way.shift) { each.position.addScaledVector(new THREE.Vector3(...way.shift), share); return; }
    const turn = new THREE.Matrix4().makeRotationX(share * way.angle), axis = new THREE.Vector3(0, 0, way.centre);
    each.position.add(axis.clone().sub(axis.clone().applyMatrix4(turn)));
    each.rotation.x += share * way.angle;
  }

  // The cut goes through what is shown, at a share of its size.
  function section() {
    const axis = document.querySelector("input[name=cut]:checked").value, box = visible();
    const i = "xyz".indexOf(axis), size = box.getSize(new THREE.Vector3());
    const recut = !!axis !== cut.length > 0;  // else what draws the parts stays as it is
    cut.length = 0;
    if (axis) {
      const side = (axis === "y" ? 1 : -1) * (get("flip").checked ? -1 : 1);
      const at = box.min.getComponent(i) + Number(get("place").value) * size.getComponent(i);
      plane.normal.set(0, 0, 0).setComponent(i, side);
      plane.constant = -side * at;
      cut.push(plane);
    }
    solids.forEach((each, order) => {
      const { face, lines, counters, cap, clear } = each.userData, through = clear && !axis;
      Object.assign(face.material, { transparent: through, opacity: through ? 0.45 : 1, depthWrite: !through });
      cap.visible = !!axis && each.visible && each.parent.visible;
      for (const one of counters) { one.visible = !!axis; one.renderOrder = order; }
      cap.renderOrder = order + 0.5;
      face.renderOrder = lines.renderOrder = solids.length + (through ? 1 : 0);
      box.getCenter(cap.position);
      if (axis) cap.position.setComponent(i, -plane.constant * plane.normal.getComponent(i));
      cap.scale.setScalar(2 * size.length());
      cap.lookAt(cap.position.clone().add(plane.normal));
      if (recut) for (const child of each.children) child.material.needsUpdate = true;
    });
    draw();
  }

  function visible() {
    const box = new THREE.Box3();
    scene.updateMatrixWorld();
    for (const each of shown().children) if (each.visible) box.expandByObject(each);
    return box.isEmpty() ? new THREE.Box3(new THREE.Vector3(-1, -1, -1), new THREE.Vector3(1, 1, 1)) : box;
  }

  function size() {
    const { clientWidth: wide, clientHeight: high } = get("stage");
    renderer.setSize(wide, high);
    const half = reach * Math.max(1, high / wide);
    camera.top = half; camera.bottom = -half;
    camera.left = -half * wide / high; camera.right = half * wide / high;
    camera.updateProjectionMatrix();
    controls.handleResize();
    draw();
  }

  function fit() {
    const ball = visible().getBoundingSphere(new THREE.Sphere());
    controls.target.copy(ball.center);
    camera.position.copy(ball.center).add(new THREE.Vector3(0.55, -1, 0.75).multiplyScalar(3 * ball.radius));
    camera.up.set(0, 0, 1);
    camera.zoom = 1;
    reach = 1.05 * ball.radius;
    controls.update();
    size();
  }

  // As near as before, or further off where parts leave the picture.
  function widen() {
    const ball = visible().getBoundingSphere(new THREE.Sphere());
    controls.target.copy(ball.center);
    camera.position.copy(camera.getWorldDirection(new THREE.Vector3())).multiplyScalar(-3 * ball.radius).add(ball.center);
    camera.zoom = Math.min(camera.zoom, reach / (1.05 * ball.radius));
    controls.update();
    size();
  }

  function choose(skin) {
    bench.visible = skin; mold.visible = !skin;
    get("mold").classList.toggle("on", !skin); get("skin").classList.toggle("on", skin);
    get("of-mold").classList.toggle("hidden", skin); get("of-skin").classList.toggle("hidden", !skin);
    get("over").disabled = skin;
    fit(); section();
  }

  function list() {
    const groups = new Map();
    for (const each of parts) groups.set(each.userData.group, [...(groups.get(each.userData.group) || []), each]);
    for (const [name, members] of groups) {
      const label = document.createElement("label"), box = document.createElement("input");
      const swatch = document.createElement("span");
      box.type = "checkbox"; box.checked = true; box.dataset.part = name;
      box.onchange = () => { for (const each of members) each.userData.wanted = box.checked; place(); };
      swatch.className = "swatch";
      swatch.style.background = `#${new THREE.Color(...members[0].userData.colour).getHexString()}`;
      label.append(box, swatch, members.length > 1 ? `${name} (${members.length})` : name);
      get("parts").append(label);
    }
    const all = (on) => () => get("parts").querySelectorAll("input").forEach((box) => { if (box.checked !== on) box.click(); });
    get("all").onclick = all(true); get("none").onclick = all(false);
  }

  // The name of what the pointer is on.
  function pointed(event) {
    const box = renderer.domElement.getBoundingClientRect(), ray = new THREE.Raycaster();
    const at = new THREE.Vector2((event.clientX - box.left) / box.width * 2 - 1, 1 - (event.clientY - box.top) / box.height * 2);
    ray.setFromCamera(at, camera);
    const seen = shown().children.filter((each) => each.visible).map((each) => each.userData.face);
    const hit = ray.intersectObjects(seen).find((each) => cut.every((one) => one.distanceToPoint(each.point) >= 0));
    const name = get("name"), x = event.clientX - box.left, y = event.clientY - box.top;
    name.textContent = hit ? hit.object.parent.name : "";
    name.classList.toggle("hidden", !hit);
    name.style.left = `${Math.max(0, Math.min(x + 12, box.width - name.offsetWidth))}px`;
    name.style.top = `${Math.max(0, y - 8 - name.offsetHeight)}px`;
  }

  function pressed(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const key = KEYS[event.key.toLowerCase()];
    if (!key || (get("keys").open && event.key !== "?")) return;
    const [, act] = key, apart = get("apart");
    if (typeof act === "number") { camera.zoom *= act; camera.updateProjectionMatrix(); draw(); }
    else if (act === "apart") { apart.value = Number(apart.value) < 0.5 ? 1 : 0; apart.oninput(); }
    else (get(act) || document.querySelector(`input[name=cut][value="${act}"]`)).click();
  }

  function help() {
    if (get("keys").open) get("keys").close(); else get("keys").showModal();
  }

  for (const [key, [words]] of Object.entries(KEYS)) {
    const row = get("key-list").insertRow(), name = document.createElement("kbd");
    name.textContent = key.toUpperCase();
    row.insertCell().append(name);
    row.insertCell().textContent = words;
  }
  get("help").onclick = help;
  window.addEventListener("keydown", pressed);
  if (load) load.made.name = "skin under load";
  list();
  get("apart").oninput = () => { place(); widen(); };
  get("on").onclick = () => { step += 1; gone = 1; place(); fit(); gone = 0; left = performance.now(); place(); };
  get("back").onclick = () => { step -= 1; gone = 1; place(); fit(); };
  get("over").onclick = () => { over = !over; mold.rotation.x = over ? Math.PI : 0; fit(); section(); };
  get("fit").onclick = fit;
  get("mold").onclick = () => choose(false);
  get("skin").onclick = () => choose(true);
  get("skin").disabled = !load;
  get("unloaded").classList.toggle("hidden", !!load);
  document.querySelectorAll("input[name=cut]").forEach((each) => { each.onchange = section; });
  get("place").oninput = section; get("flip").onchange = section;
  if (load) {
    get("load").oninput = () => { load.set(Number(get("load").value)); section(); };
    get("force").textContent = told.load.force;
    get("approach").textContent = `The plate comes ${told.load.approach} nearer.`;
    get("largest").textContent = load.largest.toPrecision(2);
    get("scale").style.background = `linear-gradient(90deg, ${COLOURS})`;
  }
  renderer.domElement.addEventListener("pointerdown", (event) => { if (event.pointerType !== "mouse") pointed(event); });
  renderer.domElement.addEventListener("pointerleave", (event) => {
    if (event.pointerType === "mouse") get("name").classList.add("hidden");  // a finger leaves as it is lifted
  });
  renderer.domElement.addEventListener("pointermove", (event) => { if (!event.buttons) pointed(event); });
  controls.addEventListener("change", draw);
  window.addEventListener("resize", size);
  place(); fit();
  const turn = () => {
    requestAnimationFrame(turn);
    controls.update();
    if (gone < 1) { gone = Math.min(1, (performance.now() - left) / LEAVING); place(); }
    document.body.dataset.still = gone < 1 ? "no" : "yes";
  };
  turn();
  document.body.dataset.ready = "yes";
}

data().then(start).catch((failure) => {
  const told = document.createElement("p");
  told.textContent = `This browser draws nothing in three dimensions (${failure.message}). Here is a picture instead.`;
  get("picture").classList.remove("hidden");
  get("stage").replaceChildren(told, get("picture"));
  throw failure;
});
