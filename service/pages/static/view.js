// Draws a packed view of a run (studies/films/packed.py): points with colours, over time, or turned in space.
const VIRIDIS = ["440154", "472d7b", "3b528b", "2c728e", "21918c", "28ae80", "5ec962", "addc30", "fde725"];
const INFERNO = ["4a0c6b", "781c6d", "a52c60", "cf4446", "ed6925", "fb9b06", "f7d13d"]; // without its ends: on both pages
const GREYS = ["f2f2f2", "202020"];
const MAPS = { temperature: INFERNO, areal_density: GREYS };
const STEPS = 65535, LEVELS = 254, UNKNOWN = 0xff909090;
const NICE = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000];
const ARROWS = { ArrowLeft: [-20, 0], ArrowRight: [20, 0], ArrowUp: [0, -20], ArrowDown: [0, 20] }; // px
const TRIES = 20; // of a picture that waits for another one's

// The colours of the levels, as little-endian pixels; the last one is that of an unknown value.
function table(stops) {
  const channel = (stop, place) => parseInt(stops[stop].slice(place, place + 2), 16);
  const colours = new Uint32Array(LEVELS + 2);
  for (let level = 0; level <= LEVELS; level++) {
    const at = (level / LEVELS) * (stops.length - 1), low = Math.min(Math.floor(at), stops.length - 2);
    const mix = (place) => Math.round(channel(low, place) + (at - low) * (channel(low + 1, place) - channel(low, place)));
    colours[level] = (0xff000000 | (mix(4) << 16) | (mix(2) << 8) | mix(0)) >>> 0;
  }
  colours[LEVELS + 1] = UNKNOWN;
  return colours;
}

async function read(address) {
  for (let tries = 0; ; tries++) {
    const response = await fetch(address);
    if (response.ok) return response.arrayBuffer();
    if (response.status !== 503 || tries === TRIES) throw new Error((await response.json()).detail);
    await new Promise((done) => setTimeout(done, 3000));
  }
}

function unpack(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const view = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  if (!view.times.length) return view;
  const count = view.counts.reduce((sum, each) => sum + each, 0);
  const components = view.low.length;
  let place = 4 + length;
  view.position = view.low.map((low, k) => {
    const steps = new Uint16Array(buffer, place + 2 * count * k, count), width = (view.high[k] - low) / STEPS;
    return Float32Array.from(steps, (step) => low + step * width);
  });
  place += 2 * count * components;
  view.body = new Uint8Array(buffer, place, count);
  view.fields.forEach((field, number) => {
    field.levels = new Uint8Array(buffer, place + count * (number + 1), count);
    field.colours = table(MAPS[field.name] ?? VIRIDIS);
  });
  view.starts = [0];
  for (const each of view.counts) view.starts.push(view.starts.at(-1) + each);
  return view;
}

const digits = (value) => (value === 0 ? "0" : Math.abs(value) < 1e-3 ? value.toExponential(1) : String(+value.toPrecision(3)));

class Picture {
  constructor(figure, view) {
    this.view = view;
    this.canvas = figure.querySelector("canvas");
    this.find = (name) => figure.querySelector(`[name=${name}]`);
    this.key = figure.querySelector(".key");
    this.beyond = figure.querySelector(".beyond");
    this.said = figure.querySelector(".at");
    this.turns = view.low.length === 3;
    this.fill(figure);
    figure.querySelector(".controls").hidden = false;
    figure.querySelector(".controls").addEventListener("input", () => this.draw());
    this.find("play")?.addEventListener("click", () => this.play());
    this.moved = [0, 0]; // of a flat view, on the screen
    this.canvas.addEventListener("pointermove", (event) => event.buttons && this.move(event.movementX, event.movementY));
    this.canvas.addEventListener("keydown", (event) => {
      if (!ARROWS[event.key]) return;
      event.preventDefault();
      this.move(...ARROWS[event.key]);
    });
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  fill(figure) {
    const { view } = this, slider = this.find("frame");
    if (slider) {
      slider.max = view.times.length - 1;
      slider.value = slider.max;
    }
    this.find("field").append(...view.fields.map((field) => new Option(field.label, field.name)));
    const bodies = figure.querySelector(".bodies");
    view.bodies.forEach((name, number) => {
      const label = document.createElement("label"), box = document.createElement("input");
      Object.assign(box, { type: "checkbox", checked: true, value: number });
      label.append(box, ` ${name}`);
      bodies.append(label);
    });
    figure.querySelector("figcaption").append(` ${view.note}`);
  }

  play() {
    const slider = this.find("frame"), button = this.find("play");
    clearInterval(this.timer);
    this.timer = this.timer ? 0 : setInterval(() => {
      slider.value = (+slider.value + 1) % this.view.times.length;
      this.draw();
    }, 120);
    button.textContent = this.timer ? "Pause" : "Play";
  }

  move(across, down) {
    if (this.turns) {
      const turn = this.find("turn"), tilt = this.find("tilt");
      turn.value = ((+turn.value + across / 2 + 540) % 360) - 180;
      tilt.value = +tilt.value + down / 2;
    } else this.moved = [this.moved[0] + across, this.moved[1] + down];
    this.draw();
  }

  // Where the point of a number is on the screen, and how near: for the present size, window, turn and tilt.
  projection(width, height) {
    const { view } = this, [low, high] = view.window, zoom = 2 ** this.find("zoom").value;
    if (!this.turns) {
      const left = view.mirrored ? -high[0] : low[0], middle = [(left + high[0]) / 2, (low[1] + high[1]) / 2];
      const scale = zoom * Math.min(width / (high[0] - left), height / (high[1] - low[1])) * 0.94;
      const [x, y] = view.position, [across, down] = this.moved.map((each) => each * (devicePixelRatio || 1));
      return {
        scale,
        to: (i, side) => [(side * x[i] - middle[0]) * scale + across, (y[i] - middle[1]) * scale + down, 0],
      };
    }
    const middle = low.map((end, k) => (end + high[k]) / 2), half = Math.max(...low.map((end, k) => (high[k] - end) / 2));
    const scale = (zoom * Math.min(width, height) * 0.4) / half, [x, y, z] = view.position;
    const [turn, tilt] = ["turn", "tilt"].map((name) => (this.find(name).value * Math.PI) / 180);
    const [c, s, ct, st] = [Math.cos(turn), Math.sin(turn), Math.cos(tilt), Math.sin(tilt)];
    return {
      scale,
      to: (i) => {
        const a = x[i] - middle[0], b = y[i] - middle[1], down = z[i] - middle[2];
        const near = c * b - s * a;
        return [(c * a + s * b) * scale, (ct * down + st * near) * scale, ct * near - st * down];
      },
    };
  }

  draw() {
    const { view, canvas } = this, ratio = devicePixelRatio || 1;
    const width = (canvas.width = Math.round(canvas.clientWidth * ratio));
    const height = (canvas.height = Math.round(canvas.clientHeight * ratio));
    if (!width || !height) return;
    const frame = +(this.find("frame")?.value ?? 0);
    const field = view.fields.find((each) => each.name === this.find("field").value);
    const shown = [...canvas.parentNode.querySelectorAll(".bodies input")].map((box) => box.checked);
    const { scale, to } = this.projection(width, height);
    const context = canvas.getContext("2d"), image = context.createImageData(width, height);
    const pixels = new Uint32Array(image.data.buffer), depths = new Float32Array(width * height).fill(-Infinity);
    const sizes = view.width.map((each) => Math.max(1, each ? Math.ceil(each * scale) : Math.round(2 * ratio)));
    for (let i = view.starts[frame]; i < view.starts[frame + 1]; i++) {
      const body = view.body[i];
      if (!shown[body]) continue;
      for (const side of view.mirrored ? [1, -1] : [1]) {
        const [x, y, near] = to(i, side), size = sizes[body];
        const left = Math.round(width / 2 + x - size / 2), top = Math.round(height / 2 + y - size / 2);
        for (let row = Math.max(0, top); row < Math.min(height, top + size); row++)
          for (let column = Math.max(0, left); column < Math.min(width, left + size); column++) {
            const place = row * width + column;
            if (near < depths[place]) continue;
            depths[place] = near;
            pixels[place] = field.colours[field.levels[i]];
          }
      }
    }
    context.putImageData(image, 0, 0);
    this.ruler(context, scale, ratio, height);
    this.tell(field, frame);
  }

  ruler(context, scale, ratio, height) {
    const millimetres = NICE.findLast((each) => each * 1e-3 * scale < context.canvas.width / 3) ?? 1;
    context.fillStyle = getComputedStyle(this.canvas).color;
    context.font = `${13 * ratio}px system-ui, sans-serif`;
    context.fillRect(8 * ratio, height - 10 * ratio, millimetres * 1e-3 * scale, 2 * ratio);
    context.fillText(`${millimetres} mm`, 8 * ratio, height - 15 * ratio);
  }

  tell(field, frame) {
    const [low, bar, high] = this.key.children, time = `${digits(this.view.times[frame] * 1e6)} µs`;
    low.textContent = Math.abs(field.low) < 1e-3 * Math.abs(field.high) ? "≈ 0" : digits(field.low);
    high.textContent = `${digits(field.high)} ${field.unit}`;
    const context = bar.getContext("2d"), image = context.createImageData(bar.width, 1);
    new Uint32Array(image.data.buffer).set(field.colours.subarray(0, bar.width));
    context.putImageData(image, 0, 0);
    this.beyond.textContent = field.beyond;
    if (this.said) this.said.textContent = time;
    this.find("frame")?.setAttribute("aria-valuetext", time);
    this.canvas.setAttribute("aria-label", `${this.canvas.dataset.name} at ${time}, coloured by ${field.label}. ${this.beyond.textContent}`);
  }
}

// One after the other: each is made by a process of the service.
let last = Promise.resolve();

function load(figure) {
  const waiting = figure.querySelector("[role=status]");
  last = last.then(async () => {
    try {
      const view = unpack(await read(figure.dataset.src));
      waiting.textContent = view.times.length ? "" : view.note;
      if (view.times.length) new Picture(figure, view);
      figure.classList.toggle("drawn", view.times.length > 0);
    } catch (error) {
      waiting.textContent = `The picture could not be made: ${error.message}`;
    }
  });
}

const observer = new IntersectionObserver((seen) => {
  for (const { isIntersecting, target } of seen) {
    if (!isIntersecting) continue;
    observer.unobserve(target);
    target.dataset.seen = "yes";
    load(target);
  }
}, { rootMargin: "200px" });
const observeAll = () => document.querySelectorAll(".view").forEach((figure) => figure.dataset.seen || observer.observe(figure));
document.addEventListener("renewed", observeAll);
observeAll();
