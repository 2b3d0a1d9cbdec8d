// Plays the data of replay_page.cpp: lengths in mm, times in s, forces in N. Everything is a function of the shown
// time, and show() draws it.
'use strict';
const $ = id => document.getElementById(id);

function fail(reason) {
  $('error').hidden = false;
  $('error').textContent = String(reason && reason.message || reason);
  document.body.dataset.error = $('error').textContent;
}
addEventListener('error', event => fail(event.error || event.message));
addEventListener('unhandledrejection', event => fail(event.reason));

async function load() {
  if (typeof DecompressionStream === 'undefined')
    throw new Error('This page needs a browser from 2023 or later (DecompressionStream).');
  const packed = Uint8Array.from(atob($('data').textContent), c => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('gzip'));
  const bytes = await new Response(stream).arrayBuffer();
  const size = new DataView(bytes).getUint32(0, true);
  const page = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, size)));
  const types = {f32: Float32Array, u32: Uint32Array, u16: Uint16Array, i8: Int8Array, u8: Uint8Array};
  const open = node => {  // replace references by arrays
    if (node === null || typeof node !== 'object') return node;
    if ('at' in node && 'type' in node) return new types[node.type](bytes, 4 + size + node.at, node.count);
    for (const key in node) node[key] = open(node[key]);
    return node;
  };
  return open(page);
}

// Return the last index whose time is at most t. Times must not decrease.
function before(times, t) {
  let low = 0, high = times.length;
  while (high - low > 1) {
    const middle = low + high >> 1;
    if (times[middle] <= t) low = middle; else high = middle;
  }
  return low;
}

const colourOf = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

// Return the colour of a side's renderer, lighter on a dark page. If both sides have one renderer, the second is grey.
function sideColour(side) {
  if (side.isRepeated) return colourOf('--muted');
  const dark = matchMedia('(prefers-color-scheme: dark)').matches;
  const channel = shift => side.data.colour >> shift & 255, lighter = c => dark ? c + 0.4 * (255 - c) : c;
  return `rgb(${[16, 8, 0].map(shift => Math.round(lighter(channel(shift)))).join(' ')})`;
}

function geometryOf(mesh) {
  const places = new Float32Array(mesh.places.length);
  for (let i = 0; i < places.length; ++i) places[i] = mesh.low[i % 3] + mesh.step[i % 3] * mesh.places[i];
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(places, 3));
  geometry.setAttribute('normal', new THREE.BufferAttribute(mesh.normals, 3, true));
  geometry.setAttribute('color', new THREE.BufferAttribute(mesh.colours, 3, true));
  geometry.setIndex(new THREE.BufferAttribute(mesh.corners, 1));
  return geometry;
}

const finish = options => new THREE.MeshPhongMaterial(Object.assign({shininess: 40, specular: 0x1c1c1c}, options));
const tooth = () => finish({vertexColors: THREE.VertexColors, side: THREE.DoubleSide});

// A capsule from a to b: a rod and two spheres.
function capsule(a, b, radius, material) {
  const group = new THREE.Group(), from = new THREE.Vector3(...a), to = new THREE.Vector3(...b);
  const length = from.distanceTo(to), r = Math.max(radius, 0.15);
  for (const end of length > 0 ? [from, to] : [from]) {
    const ball = new THREE.Mesh(new THREE.SphereGeometry(r, 40, 28), material);
    ball.position.copy(end);
    group.add(ball);
  }
  if (length > 0) {
    const rod = new THREE.Mesh(new THREE.CylinderGeometry(r, r, length, 40, 1, true), material);
    rod.position.copy(from).add(to).multiplyScalar(0.5);
    rod.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), to.clone().sub(from).normalize());
    group.add(rod);
  }
  return group;
}

// A half space as a disc below the start of the tool.
function plane(obstacle, side, reach) {
  const group = new THREE.Group(), normal = new THREE.Vector3(0, 0, 1);
  const turn = new THREE.Quaternion(...obstacle.turn);
  const middle = new THREE.Vector3(...side.start).sub(new THREE.Vector3(...obstacle.position));
  middle.applyQuaternion(turn.clone().conjugate());
  const disc = new THREE.Mesh(new THREE.CircleGeometry(reach, 96), finish({color: obstacle.colour,
    side: THREE.DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1}));
  disc.position.set(middle.x, middle.y, 0);
  group.add(disc);
  if (obstacle.name !== 'gum') {
    const lines = [], step = 10;
    for (let x = -reach + step / 2; x < reach; x += step) {
      const half = Math.sqrt(reach * reach - x * x);
      lines.push(new THREE.Vector3(x, -half, 0), new THREE.Vector3(x, half, 0));
      lines.push(new THREE.Vector3(-half, x, 0), new THREE.Vector3(half, x, 0));
    }
    const grid = new THREE.LineSegments(new THREE.BufferGeometry().setFromPoints(lines),
      new THREE.LineBasicMaterial({color: 0xbfa873}));
    grid.position.copy(disc.position);
    group.add(grid);
  }
  return group;
}

class Arrow {
  constructor(colour) {
    const material = finish({color: colour, depthTest: false, transparent: true, opacity: 0.92});  // over the tool
    this.shaft = new THREE.Mesh(new THREE.CylinderGeometry(0.35, 0.35, 1, 20), material);
    this.head = new THREE.Mesh(new THREE.ConeGeometry(0.95, 2.2, 24), material);
    this.object = new THREE.Group();
    this.object.add(this.shaft, this.head);
    this.head.renderOrder = this.shaft.renderOrder = 1;
  }
  place(point, direction, length) {
    this.object.visible = length > 0.3;
    const neck = Math.max(0.01, length - 2.2);
    this.shaft.scale.set(1, neck, 1);
    this.shaft.position.set(0, neck / 2, 0);
    this.head.position.set(0, neck + 1.1, 0);
    this.object.position.copy(point);
    this.object.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), direction);
  }
}

// One half of the stage. A side without poses has no half: it shows another controller's output for the first side's
// motion.
class Side {
  constructor(data, number, first) {
    Object.assign(this, {data, number, layers: data.poses ? undefined : first.layers,
      isRepeated: first !== undefined && first.data.colour === data.colour});
    if (data.poses) this.makeScene();
    this.makePanel();
  }
  makeScene() {
    const data = this.data;
    this.scene = new THREE.Scene();
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0xb9a99a, 0.62));
    for (const [x, y, z, strength] of [[-30, -50, 80, 0.5], [70, 20, 30, 0.22]]) {
      const light = new THREE.DirectionalLight(0xffffff, strength);
      light.position.set(x, y, z);
      this.scene.add(light);
    }
    this.bounds = new THREE.Box3();
    this.bricks = [];  // states of each brick of the solids, with their start times
    for (const obstacle of data.obstacles) this.addObstacle(obstacle);
    if (this.bounds.isEmpty()) this.bounds.setFromCenterAndSize(new THREE.Vector3(...data.start),
      new THREE.Vector3(40, 40, 20));
    const reach = Math.max(30, 1.3 * this.bounds.getSize(new THREE.Vector3()).length());
    for (const obstacle of data.obstacles)
      if (obstacle.plane) this.place(plane(obstacle, data, reach), obstacle);
    this.tool = new THREE.Group();
    data.tool.forEach((part, i) => {
      const isBur = i === data.bur, isNeedle = part.radius < 0.15;
      const to = isNeedle ? [part.a[0], part.a[1], part.a[2] + 25] : part.b;
      this.tool.add(capsule(part.a, to, isNeedle ? 0.4 : part.radius,
        finish({color: isBur ? 0xa9b2bc : 0x8f9aa6, shininess: 90, specular: 0x777777})));
    });
    this.scene.add(this.tool);
    this.arrow = new Arrow(0xd55e00);
    this.scene.add(this.arrow.object);
  }
  place(object, obstacle) {
    object.position.set(...obstacle.position);
    object.quaternion.set(...obstacle.turn);
    this.scene.add(object);
    return object;
  }
  addObstacle(obstacle) {
    const group = this.place(new THREE.Group(), obstacle), material = tooth();
    if (obstacle.mesh) group.add(new THREE.Mesh(geometryOf(obstacle.mesh), material));
    if (obstacle.box)
      group.add(new THREE.Mesh(new THREE.BoxGeometry(...obstacle.box.map(x => 2 * x)), finish({color: obstacle.colour})));
    if (obstacle.capsule) {
      const [radius, half] = obstacle.capsule;
      group.add(capsule([0, 0, -half], [0, 0, half], radius, finish({color: obstacle.colour})));
    }
    if (obstacle.solid) {
      if (obstacle.solid.rest) group.add(new THREE.Mesh(geometryOf(obstacle.solid.rest), material));
      const bricks = new Map();
      for (const piece of obstacle.solid.pieces) {
        if (!bricks.has(piece.brick)) bricks.set(piece.brick, {times: [], meshes: []});
        const mesh = piece.mesh ? new THREE.Mesh(geometryOf(piece.mesh), material) : null;
        if (mesh) { mesh.visible = false; group.add(mesh); }
        bricks.get(piece.brick).times.push(piece.time);
        bricks.get(piece.brick).meshes.push(mesh);
      }
      this.bricks.push(...bricks.values());
      this.layers = this.layers || obstacle.solid.layers;
    }
    group.updateMatrixWorld(true);
    group.traverse(part => {
      if (!part.geometry) return;
      part.geometry.computeBoundingBox();
      this.bounds.union(part.geometry.boundingBox.clone().applyMatrix4(part.matrixWorld));
    });
  }
  makePanel() {
    const panel = document.createElement('section');
    const heading = document.createElement('h2');
    heading.textContent = this.data.title;
    heading.style.color = sideColour(this);
    const list = document.createElement('dl');
    const row = (name, colour) => {
      const term = document.createElement('dt'), value = document.createElement('dd');
      if (colour !== undefined) {
        const swatch = document.createElement('span');
        swatch.className = 'swatch';
        swatch.style.background = '#' + colour.toString(16).padStart(6, '0');
        term.append(swatch);
      }
      term.append(name);
      list.append(term, value);
      return value;
    };
    this.values = {force: row('force'), depth: row('depth')};
    this.volumes = this.data.removed ? (this.layers || []).map(layer => row(layer.name, layer.colour)) : [];
    this.guard = document.createElement('p');
    this.guard.className = 'guard';
    panel.append(heading, list, this.guard);
    const half = document.createElement('div');
    half.append(panel);
    $('sides').append(half);
  }
  // Interpolate the pose between the last picture at or before t and the next one.
  move(t) {
    const m = this.data, i = before(m.times, t), j = Math.min(i + 1, m.times.length - 1);
    const span = m.times[j] - m.times[i], share = span > 0 ? Math.min(1, Math.max(0, (t - m.times[i]) / span)) : 0;
    const at = k => new THREE.Vector3().fromArray(m.poses, 7 * k);
    const turn = k => new THREE.Quaternion().fromArray(m.poses, 7 * k + 3);
    this.tool.position.copy(at(i).lerp(at(j), share));
    this.tool.quaternion.copy(turn(i).slerp(turn(j), share));
    for (const brick of this.bricks) {
      const now = brick.meshes[before(brick.times, t)];
      if (now === brick.shown) continue;
      if (brick.shown) brick.shown.visible = false;
      if (now) now.visible = true;
      brick.shown = now;
    }
    const c = m.contacts.subarray(6 * i, 6 * i + 6);
    this.arrow.object.visible = false;
    if (isFinite(c[0]) && m.forces[i] > 0 && t <= m.end)
      this.arrow.place(new THREE.Vector3(c[0], c[1], c[2]), new THREE.Vector3(c[3], c[4], c[5]).normalize(),
        1.2 * m.forces[i]);
  }
  // Show the values at t: those of the last picture at or before t. After the end of a shorter recording there are none.
  show(t) {
    if (this.scene) this.move(t);
    const k = before(this.data.times, t), ended = t > this.data.end;
    this.force = ended ? NaN : this.data.forces[k];
    const depth = this.data.depths[k];
    this.values.force.textContent = ended ? '\u2013' : this.force.toFixed(2) + ' N';
    this.values.depth.textContent = ended ? '\u2013'
      : depth < 0.1 ? (1e3 * depth).toFixed(1) + ' \u00b5m' : depth.toFixed(2) + ' mm';
    this.volumes.forEach((value, l) => { value.textContent = this.data.removed[8 * k + l].toFixed(2) + ' mm\u00b3'; });
    const reason = this.data.guards[k];
    this.guard.textContent = ended ? 'ended at ' + this.data.end.toFixed(2) + ' s' : reason === 0 ? '' : 'guard: ' + this.data.reasons[reason];
  }
}

// Return a step of 1, 2 or 5 times a power of ten that gives about `count` steps.
function stepOf(span, count) {
  const raw = span / count, power = Math.pow(10, Math.floor(Math.log10(raw)));
  return [1, 2, 5, 10].map(x => x * power).find(x => x >= raw);
}

class Chart {
  constructor(key, caption, sides, end, seek) {
    Object.assign(this, {key, sides, end});
    const figure = document.createElement('figure'), text = document.createElement('figcaption');
    this.canvas = document.createElement('canvas');
    text.textContent = caption;
    figure.append(text, this.canvas);
    $('charts').append(figure);
    const go = event => {
      if (event.type === 'pointerdown') this.canvas.setPointerCapture(event.pointerId);
      if (event.buttons === 0) return;
      const box = this.canvas.getBoundingClientRect();
      seek((event.clientX - box.left - this.left) / (box.width - this.left - this.right) * this.end);
    };
    this.canvas.addEventListener('pointerdown', go);
    this.canvas.addEventListener('pointermove', go);
    this.left = 46;
    this.right = 10;
    let low = 0, high = 1e-3;
    for (const side of sides) {
      for (const x of side.data[key].low) if (isFinite(x)) low = Math.min(low, x);
      for (const x of side.data[key].high) if (isFinite(x)) high = Math.max(high, x);
    }
    this.low = low < -0.02 * high ? low : 0;
    this.high = 1.06 * high;
  }
  draw(t) {
    const ratio = devicePixelRatio || 1, width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    if (width === 0 || height === 0) return;
    if (this.canvas.width !== Math.round(width * ratio) || this.canvas.height !== Math.round(height * ratio)) {
      this.canvas.width = Math.round(width * ratio);
      this.canvas.height = Math.round(height * ratio);
    }
    const c = this.canvas.getContext('2d'), bottom = height - 22, top = 6;
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.clearRect(0, 0, width, height);
    const x = s => this.left + s / this.end * (width - this.left - this.right);
    const y = v => bottom - (v - this.low) / (this.high - this.low) * (bottom - top);
    c.font = '12px Roboto, "Segoe UI", system-ui, sans-serif';
    c.lineWidth = 1;
    c.strokeStyle = colourOf('--line');
    c.fillStyle = colourOf('--muted');
    c.textAlign = 'right';
    c.textBaseline = 'middle';
    const step = stepOf(this.high - this.low, Math.max(2, height / 45));
    const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    for (let v = Math.ceil(this.low / step) * step; v <= this.high; v += step) {
      c.beginPath(); c.moveTo(this.left, y(v)); c.lineTo(width - this.right, y(v)); c.stroke();
      c.fillText(v.toFixed(digits), this.left - 6, y(v));
    }
    c.textAlign = 'center';
    c.textBaseline = 'top';
    const second = stepOf(this.end, Math.max(2, width / 80));
    for (let s = 0; s <= this.end; s += second)
      c.fillText(s.toFixed(second < 1 ? 1 : 0) + (s === 0 ? ' s' : ''), x(s), bottom + 5);
    for (const side of this.sides) {
      const {low, high} = side.data[this.key], bucket = side.data.bucket;
      c.fillStyle = c.strokeStyle = sideColour(side);
      c.lineWidth = 1.3;
      c.lineJoin = 'round';
      // Draw the range of all values in each column of pixels.
      const columns = Math.max(1, Math.round((width - this.left - this.right) * ratio));
      c.beginPath();
      for (let column = 0; column < columns; ++column) {
        const from = Math.floor(column / columns * this.end / bucket);
        const to = Math.max(from + 1, Math.floor((column + 1) / columns * this.end / bucket));
        let least = Infinity, most = -Infinity;
        for (let i = from; i < Math.min(to, low.length); ++i) {
          least = Math.min(least, low[i]);
          most = Math.max(most, high[i]);
        }
        if (!(least <= most)) continue;
        const px = this.left + (column + 0.5) / ratio;
        c.lineTo(px, y(most));
        if (most > least) c.lineTo(px, y(least));
      }
      c.stroke();
    }
    c.strokeStyle = colourOf('--ink');
    c.beginPath(); c.moveTo(x(t), top); c.lineTo(x(t), bottom); c.stroke();
  }
}

// A camera that orbits a point at a distance; z is up.
class Orbit {
  constructor(canvas, changed) {
    this.camera = new THREE.PerspectiveCamera(32, 1, 1, 3000);
    this.camera.up.set(0, 0, 1);
    this.focus = new THREE.Vector3();
    const fingers = new Map();
    canvas.addEventListener('pointerdown', event => {
      canvas.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, event);
    });
    for (const name of ['pointerup', 'pointercancel'])
      canvas.addEventListener(name, event => fingers.delete(event.pointerId));
    canvas.addEventListener('pointermove', event => {
      const last = fingers.get(event.pointerId);
      if (!last) return;
      const dx = event.clientX - last.clientX, dy = event.clientY - last.clientY;
      if (fingers.size === 2) {
        const other = [...fingers.values()].find(finger => finger.pointerId !== event.pointerId);
        const apart = finger => Math.hypot(finger.clientX - other.clientX, finger.clientY - other.clientY);
        this.zoom(apart(last) / Math.max(1, apart(event)));
        this.pan(dx / 2, dy / 2, canvas.clientHeight);
      } else if (event.shiftKey || event.buttons & 6) {
        this.pan(dx, dy, canvas.clientHeight);
      } else {
        this.azimuth -= 0.008 * dx;
        this.elevation = Math.min(1.55, Math.max(-1.55, this.elevation + 0.008 * dy));
      }
      fingers.set(event.pointerId, event);
      changed();
    });
    canvas.addEventListener('wheel', event => {
      event.preventDefault();
      this.zoom(Math.exp(0.0012 * event.deltaY));
      changed();
    }, {passive: false});
    canvas.addEventListener('contextmenu', event => event.preventDefault());
  }
  look(focus, distance, elevation) {
    this.focus.copy(focus);
    this.distance = distance;
    this.azimuth = -1.05;
    this.elevation = elevation;
  }
  zoom(factor) { this.distance = Math.min(1500, Math.max(5, this.distance * factor)); }
  pan(dx, dy, height) {
    const scale = 2 * this.distance * Math.tan(THREE.Math.degToRad(this.camera.fov / 2)) / height;
    const e = this.camera.matrixWorld.elements;
    for (const [axis, by] of [[0, -dx * scale], [4, dy * scale]])
      this.focus.add(new THREE.Vector3(e[axis], e[axis + 1], e[axis + 2]).multiplyScalar(by));
  }
  aim(aspect) {
    const flat = Math.cos(this.elevation), camera = this.camera;
    camera.aspect = aspect;
    camera.position.set(flat * Math.cos(this.azimuth), flat * Math.sin(this.azimuth), Math.sin(this.elevation));
    camera.position.multiplyScalar(this.distance / Math.min(1, aspect)).add(this.focus);
    camera.lookAt(this.focus);
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
    return camera;
  }
}

load().then(page => {
  const sides = [];
  page.sides.forEach((data, i) => sides.push(new Side(data, i, sides[0])));
  const first = sides[0].data, end = Math.max(...sides.map(side => side.data.end), first.period);
  const shown = sides.filter(side => side.scene);
  $('sides').classList.toggle('halves', shown.length > 1);
  $('title').textContent = (first.scene || 'wall') + ': ' + sides.map(side => side.data.title).join(' beside ');
  document.title = 'Enamel: ' + $('title').textContent;
  const rate = Math.round(1 / first.period);
  $('about').textContent = end.toFixed(1) + ' s at ' + rate + ' Hz' + (shown.length < sides.length
    ? '; the right renderer answers the motion of the left one' : '');

  const renderer = new THREE.WebGLRenderer({canvas: $('view'), antialias: true, preserveDrawingBuffer: true});
  renderer.setPixelRatio(devicePixelRatio || 1);
  renderer.autoClear = false;
  renderer.setScissorTest(true);
  let time = 0, speed = 1, playing = false, last = 0;
  const seek = t => {
    time = Math.min(end, Math.max(0, t));
    show();
  };
  const charts = [new Chart('force', 'Force on the tool, N', sides, end, seek),
                  new Chart('depth', 'Depth of the tool in the wall, mm', sides, end, seek)];

  function show() {
    const width = $('stage').clientWidth, height = $('stage').clientHeight;
    renderer.setSize(width, height, false);
    renderer.setClearColor(colourOf('--ground'));
    renderer.setScissor(0, 0, width, height);
    renderer.clear();
    for (const side of sides) side.show(time);
    shown.forEach((side, i) => {
      const from = Math.round(i * width / shown.length), wide = Math.round(width / shown.length);
      renderer.setViewport(from, 0, wide, height);
      renderer.setScissor(from, 0, wide, height);
      renderer.render(side.scene, orbit.aim(wide / height));
    });
    for (const chart of charts) chart.draw(time);
    $('slider').value = Math.round(1000 * time / end);
    $('clock').textContent = time.toFixed(2) + ' / ' + end.toFixed(1) + ' s';
    $('play').textContent = playing ? 'Pause' : 'Play';
    document.body.dataset.time = time.toFixed(4);
    document.body.dataset.forces = sides.map(side => side.force).join(' ');
  }
  const orbit = new Orbit($('view'), show);
  // Focus: the mean of the tool's contacts, or its start without contacts.
  const home = () => {
    const focus = new THREE.Vector3();
    let count = 0;
    for (let i = 0; i < first.contacts.length; i += 6)
      if (isFinite(first.contacts[i])) { focus.add(new THREE.Vector3().fromArray(first.contacts, i)); ++count; }
    if (count > 0) focus.divideScalar(count); else focus.set(...first.start);
    const size = sides[0].bounds.getSize(new THREE.Vector3()).length();
    orbit.look(focus, Math.min(160, Math.max(55, 1.9 * size)), first.bur >= 0 ? 0.95 : 0.55);  // into the hole
  };
  home();

  function tick(now) {
    if (!playing) return;
    // A picture's time may be before the click that started playing. A hidden page draws no pictures.
    time = Math.min(end, time + speed * Math.min(0.25, Math.max(0, now - last) / 1000));
    last = Math.max(last, now);
    if (time >= end) playing = false;
    show();
    if (playing) requestAnimationFrame(tick);
  }
  const toggle = on => {
    playing = on === undefined ? !playing : on;
    if (playing && time >= end) time = 0;
    last = performance.now();
    if (playing) requestAnimationFrame(tick);
    show();
  };
  for (const x of [0.01, 0.1, 0.25, 0.5, 1, 2, 4]) $('speed').add(new Option('\u00d7 ' + x, x, x === 1, x === 1));
  $('speed').onchange = () => { speed = Number($('speed').value); };
  $('play').onclick = () => toggle();
  $('home').onclick = () => { home(); show(); };
  $('slider').oninput = () => seek($('slider').value / 1000 * end);
  addEventListener('keydown', event => {
    if (event.target.tagName === 'SELECT' || event.ctrlKey || event.metaKey) return;
    const by = event.shiftKey ? 1 : first.times.length > 1 ? first.times[1] : 0.02;
    if (event.key === ' ') toggle();
    else if (event.key === 'ArrowRight') seek(time + by);
    else if (event.key === 'ArrowLeft') seek(time - by);
    else if (event.key === 'Home') seek(0);
    else if (event.key === 'End') seek(end);
    else if (event.key === 'h' || event.key === 'H') { home(); show(); }
    else return;
    event.preventDefault();
    if (document.activeElement) document.activeElement.blur();
  });
  new ResizeObserver(show).observe($('stage'));
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', show);
  const asked = /(?:^#|&)t=([0-9.]+)/.exec(location.hash);
  if (asked) seek(Number(asked[1]));
  else toggle(!matchMedia('(prefers-reduced-motion: reduce)').matches);
  document.body.dataset.ready = 'yes';
}).catch(fail);
