"use strict";
// Draws the report from the JSON beside it. Text goes into the page as text only, never as HTML.
(() => {
  const root = document.documentElement;
  const byId = (id) => document.getElementById(id);
  const data = JSON.parse(byId("report-data").textContent);
  const run = data.run;

  // ---------------------------------------------------------------- values

  // Columns come as whole numbers of a small unit; what is missing is NaN.
  function column(values, unit) {
    const result = new Float64Array(values.length);
    for (let i = 0; i < values.length; ++i) result[i] = values[i] === null ? NaN : values[i] * unit;
    return result;
  }

  const raw = data.scans;
  const scans = {
    n: raw.index.length,
    index: Float64Array.from(raw.index),
    t: column(raw.t_ms, 1e-3),
    fate: raw.fate,
    score: column(raw.score_um, 1e-6),
    inliers: column(raw.inliers_permille, 0.1),
    points: column(raw.points, 1),
    moving: raw.moving ? column(raw.moving, 1) : null,
    bearing: column(raw.bearing_mrad, 1e-3),
    x: column(raw.x_mm, 1e-3),
    y: column(raw.y_mm, 1e-3),
    heading: column(raw.heading_mrad, 1e-3),
    odometryX: column(raw.odometry_x_mm, 1e-3),
    odometryY: column(raw.odometry_y_mm, 1e-3),
    error: raw.error_um ? column(raw.error_um, 1e-6) : null,
    odometryError: raw.odometry_error_um ? column(raw.odometry_error_um, 1e-6) : null,
    referenceX: raw.reference_x_mm ? column(raw.reference_x_mm, 1e-3) : null,
    referenceY: raw.reference_y_mm ? column(raw.reference_y_mm, 1e-3) : null,
    referenceZ: raw.reference_z_mm ? column(raw.reference_z_mm, 1e-3) : null,
    z: raw.z_mm ? column(raw.z_mm, 1e-3) : null,
    roll: raw.roll_mrad ? column(raw.roll_mrad, 0.18 / Math.PI) : null,
    pitch: raw.pitch_mrad ? column(raw.pitch_mrad, 0.18 / Math.PI) : null,
    stages: raw.stages_us.map((values) => column(values, 1e-3)),
  };
  const isKeyframe = (k) => (raw.flags.charCodeAt(k) & 1) !== 0;
  const lacksGround = (k) => (raw.flags.charCodeAt(k) & 4) !== 0;
  const searchedWide = (k) => (raw.flags.charCodeAt(k) & 2) !== 0;

  // Path driven up to every scan [m]; a scan without a pose stands where the one before did.
  scans.distance = new Float64Array(scans.n);
  for (let k = 0, last = -1, sum = 0; k < scans.n; ++k) {
    if (!Number.isNaN(scans.x[k])) {
      if (last >= 0) sum += Math.hypot(scans.x[k] - scans.x[last], scans.y[k] - scans.y[last]);
      last = k;
    }
    scans.distance[k] = sum;
  }
  // Stamps of skipped scans may go back; along an axis they may not.
  scans.axisTime = Float64Array.from(scans.t);
  for (let k = 1; k < scans.n; ++k) scans.axisTime[k] = Math.max(scans.axisTime[k], scans.axisTime[k - 1]);

  // What became of a scan: the letters of the column `fate`.
  const FATES = {
    a: { name: "accepted", note: "matched", colour: "--accepted", shape: "dot" },
    d: { name: "degenerate", note: "matched, but unknown along a direction", colour: "--degenerate", shape: "diamond" },
    s: { name: "spoilt", note: "matched, kept out of the maps", colour: "--spoilt", shape: "dot" },
    i: { name: "first", note: "nothing to match to yet", colour: "--few", shape: "square" },
    p: { name: "poor", note: "rejected", colour: "--poor", shape: "cross" },
    b: { name: "ambiguous", note: "rejected", colour: "--ambiguous", shape: "triangle" },
    f: { name: "too few points", note: "rejected", colour: "--few", shape: "cross" },
    r: { name: "rejected", note: "rejected", colour: "--poor", shape: "cross" },
    k: { name: "skipped", note: "has no pose", colour: "--few", shape: "tick" },
  };
  const fateCounts = {};
  for (const letter of scans.fate) fateCounts[letter] = (fateCounts[letter] || 0) + 1;
  const isRejected = (k) => "pbfr".includes(scans.fate[k]);

  const loops = data.loops.rows.map(
    ([scan, keyframe, submap, state, reason, score, inliers, second, x, y, toX, toY]) => ({
      scan, keyframe, submap, state, reason: data.texts[reason], score: score === null ? NaN : score * 1e-6,
      inliers: inliers === null ? NaN : inliers * 0.1, second: second ? second * 1e-6 : NaN,
      x: x * 1e-3, y: y * 1e-3, toX: toX * 1e-3, toY: toY * 1e-3,
    }));

  // ---------------------------------------------------------------- text

  const DASH = "\u2013";
  const isGiven = (value) => value !== null && value !== undefined && !Number.isNaN(value);
  const fixed = (value, digits) => (isGiven(value) ? value.toFixed(digits).replace(/^-/, "\u2212") : DASH);
  const metres = (value) => (isGiven(value) ? fixed(value, 3) + "\u00a0m" : DASH);
  const plural = (count, one, many) => count + " " + (count === 1 ? one : many || one + "s");

  function duration(seconds) {
    if (!(seconds >= 60)) return fixed(seconds, 1) + " s";
    const whole = Math.round(seconds);
    const hours = Math.floor(whole / 3600);
    const minutes = Math.floor((whole % 3600) / 60);
    const rest = String(whole % 60).padStart(2, "0");
    return hours > 0 ? hours + ":" + String(minutes).padStart(2, "0") + ":" + rest + " h" : minutes + ":" + rest + " min";
  }

  function milliseconds(value) {
    if (!isGiven(value)) return DASH;
    return value >= 1000 ? fixed(value / 1000, 2) + " s" : fixed(value, 2) + " ms";
  }

  function element(tag, attributes, ...children) {
    const result = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes || {})) {
      if (name === "text") result.textContent = value;
      else if (name === "class") result.className = value;
      else if (name.startsWith("on")) result.addEventListener(name.slice(2), value);
      else if (value !== null && value !== false) result.setAttribute(name, value === true ? "" : value);
    }
    result.append(...children);
    return result;
  }

  // ---------------------------------------------------------------- colours

  let theme = {};
  function readTheme() {
    const style = getComputedStyle(root);
    theme = { isDark: style.getPropertyValue("--dark").trim() === "1", font: getComputedStyle(document.body).fontFamily };
    for (const name of ["page", "card", "line", "grid", "text", "muted", "accent", "halo", "path", "odometry", "truth",
      "loop", "refused", "dropped", "accepted", "spoilt", "degenerate", "poor", "ambiguous", "few", "stage-0",
      "stage-1", "stage-2", "stage-3", "stage-4", "stage-5"]) {
      theme["--" + name] = style.getPropertyValue("--" + name).trim();
    }
  }
  const colourOf = (name) => theme[name];

  // From low to high, told apart in grey too; on a dark page the light end stands out less from white.
  const RAMP = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 200, 37]];
  function rampColour(share) {
    const at = Math.min(Math.max(share, 0), 1) * (RAMP.length - 1);
    const low = Math.min(Math.floor(at), RAMP.length - 2);
    const mix = RAMP[low].map((value, i) => Math.round(value + (RAMP[low + 1][i] - value) * (at - low)));
    return "rgb(" + mix.join(",") + ")";
  }

  // ---------------------------------------------------------------- drawing

  // Sizes a canvas to the box it has on the page; returns its context in units of CSS pixels.
  function prepare(canvas, width, height) {
    const ratio = Math.min(Math.max(window.devicePixelRatio || 1, root.classList.contains("printing") ? 2 : 1), 3);
    const pixelsX = Math.max(1, Math.round(width * ratio));
    const pixelsY = Math.max(1, Math.round(height * ratio));
    if (canvas.width !== pixelsX || canvas.height !== pixelsY) {
      canvas.width = pixelsX;
      canvas.height = pixelsY;
    }
    canvas.style.height = height + "px";
    const context = canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    return context;
  }

  function shape(context, kind, x, y, radius) {
    context.beginPath();
    if (kind === "dot") context.arc(x, y, radius, 0, 2 * Math.PI);
    else if (kind === "square") context.rect(x - radius, y - radius, 2 * radius, 2 * radius);
    else if (kind === "diamond") {
      const r = radius * 1.35;
      context.moveTo(x, y - r), context.lineTo(x + r, y), context.lineTo(x, y + r), context.lineTo(x - r, y);
      context.closePath();
    } else if (kind === "triangle") {
      const r = radius * 1.4;
      context.moveTo(x, y - r), context.lineTo(x + r, y + r * 0.8), context.lineTo(x - r, y + r * 0.8);
      context.closePath();
    } else {
      const r = radius * 1.1;
      if (kind === "ring") context.arc(x, y, radius, 0, 2 * Math.PI);
      else if (kind === "tick") context.moveTo(x, y - r), context.lineTo(x, y + r);
      else {
        context.moveTo(x - r, y - r), context.lineTo(x + r, y + r);
        context.moveTo(x - r, y + r), context.lineTo(x + r, y - r);
      }
      context.lineWidth = 1.6;
      context.stroke();
      return;
    }
    context.fill();
  }

  // A mark for the legends, drawn as on the canvases.
  function swatch(kind, colour, name) {
    const canvas = element("canvas", { class: "swatch", "aria-hidden": "true" });
    canvas.style.width = "18px";
    const paint = () => {
      const context = prepare(canvas, 18, 12);
      context.fillStyle = context.strokeStyle = colourOf(colour);
      if (kind === "line" || kind === "dashed") {
        context.lineWidth = 2;
        if (kind === "dashed") context.setLineDash([4, 3]);
        context.beginPath(), context.moveTo(0, 6), context.lineTo(18, 6), context.stroke();
      } else if (kind === "area") context.fillRect(3, 1, 12, 10);
      else if (kind === "map") {
        context.fillStyle = theme.isDark ? "#3a4048" : "#dddddd";
        context.fillRect(0, 0, 18, 12);
        context.fillStyle = theme.isDark ? "#ffffff" : "#000000";
        for (const [x, y] of [[4, 4], [9, 8], [14, 3]]) context.beginPath(), context.arc(x, y, 1.5, 0, 7), context.fill();
      } else shape(context, kind, 9, 6, 3.6);
    };
    swatches.push(paint);
    canvas.dataset.name = name || "";
    return canvas;
  }
  const swatches = [];

  // 1, 2 or 5 times a power of ten, the smallest that is not below `least`.
  function niceStep(least) {
    const power = Math.pow(10, Math.floor(Math.log10(least)));
    for (const factor of [1, 2, 5, 10]) if (factor * power >= least * 0.999999) return factor * power;
    return 10 * power;
  }

  function median(values) {
    const given = Array.from(values).filter(isGiven).sort((a, b) => a - b);
    return given.length ? given[Math.floor(given.length / 2)] : NaN;
  }

  function highest(values, first, last) {
    let result = 0;
    for (let k = first; k <= last; ++k) if (values[k] > result) result = values[k];
    return result;
  }

  // ---------------------------------------------------------------- the scan and the loop that are pointed at

  let pointedScan = -1;
  let pointedLoop = null;
  const overlays = [];  // Functions that draw what is pointed at.
  function drawOverlays() {
    for (const draw of overlays) draw();
  }
  function pointAt(k) {
    if (k === pointedScan) return;
    pointedScan = k;
    drawOverlays();
  }

  function scanLines(k) {
    const fate = FATES[scans.fate[k]];
    const lines = [["verdict", fate.name + (fate.note !== fate.name ? " (" + fate.note + ")" : "")]];
    lines.push(["stamp", fixed(run.first_stamp_s + scans.t[k], 3) + " s (" + duration(scans.t[k]) + " in)"]);
    if (isGiven(scans.score[k])) lines.push(["MHD score", fixed(scans.score[k], 4) + " m"]);
    if (isGiven(scans.inliers[k])) lines.push(["inliers", fixed(scans.inliers[k], 1) + " % of " + scans.points[k] + " points"]);
    else lines.push(["points", String(scans.points[k])]);
    if (isGiven(scans.x[k])) {
      lines.push(["position", fixed(scans.x[k], 2) + ", " + fixed(scans.y[k], 2) + " m, " +
        fixed(scans.heading[k] * 180 / Math.PI, 1) + "\u00b0"]);
      lines.push(["path", fixed(scans.distance[k], 1) + " m"]);
    }
    if (scans.z && isGiven(scans.z[k])) {
      lines.push(["height", fixed(scans.z[k], 2) + " m, roll " + fixed(scans.roll[k], 1) + "\u00b0, pitch " +
        fixed(scans.pitch[k], 1) + "\u00b0"]);
    }
    if (scans.error && isGiven(scans.error[k])) {
      lines.push(["error", metres(scans.error[k]) + ", odometry " + metres(scans.odometryError[k])]);
    }
    const total = scans.stages.reduce((sum, stage) => sum + stage[k], 0);
    if (isGiven(total) && scans.fate[k] !== "k") lines.push(["time", milliseconds(total)]);
    const notes = [];
    if (isKeyframe(k)) notes.push("keyframe");
    if (searchedWide(k)) notes.push("searched wide");
    if (lacksGround(k)) notes.push("no ground found");
    if (scans.moving && scans.moving[k] > 0) notes.push(plural(scans.moving[k], "moving point") + " left out");
    if (notes.length) lines.push(["", notes.join(", ")]);
    return lines;
  }

  const tip = byId("tip");
  function showTip(title, lines, clientX, clientY) {
    const table = element("table", {}, element("tbody", {}, ...lines.map(([name, value]) =>
      element("tr", {}, element("td", { text: name }), element("td", { text: value })))));
    tip.replaceChildren(element("strong", { text: title }), table);
    tip.hidden = false;
    const box = tip.getBoundingClientRect();
    const left = clientX + 16 + box.width > window.innerWidth ? clientX - 16 - box.width : clientX + 16;
    const top = clientY + 16 + box.height > window.innerHeight ? clientY - 16 - box.height : clientY + 16;
    tip.style.left = Math.max(4, left) + "px";
    tip.style.top = Math.max(4, top) + "px";
  }
  function hideTip() {
    tip.hidden = true;
  }
  const scanTitle = (k) => "Scan " + scans.index[k];
  // For those who do not see the tip.
  function tellScan(k) {
    byId("live").textContent = scanTitle(k) + ": " + scanLines(k).map((line) => line.join(" ")).join("; ");
  }

  // ---------------------------------------------------------------- map

  const map = {
    canvas: byId("map"),
    overlay: byId("map-overlay"),
    width: 0,
    height: 0,
    view: { x: 0, y: 0, scale: 10 },  // World point in the middle [m], pixels per metre.
    fitScale: 10,
    layers: {},
    image: byId("map-image"),
    tinted: null,
    draw() {},
  };

  function mapBounds() {
    const bounds = { left: Infinity, right: -Infinity, bottom: Infinity, top: -Infinity };
    const add = (x, y) => {
      if (Number.isNaN(x) || Number.isNaN(y)) return;
      bounds.left = Math.min(bounds.left, x), bounds.right = Math.max(bounds.right, x);
      bounds.bottom = Math.min(bounds.bottom, y), bounds.top = Math.max(bounds.top, y);
    };
    for (let k = 0; k < scans.n; ++k) add(scans.x[k], scans.y[k]);
    if (data.map) {
      add(data.map.left_m, data.map.top_m);
      add(data.map.left_m + data.map.width * data.map.metres_per_pixel,
        data.map.top_m - data.map.height * data.map.metres_per_pixel);
    }
    if (!(bounds.left <= bounds.right)) return { left: -1, right: 1, bottom: -1, top: 1 };
    return bounds;
  }

  function setUpMap() {
    const bounds = mapBounds();
    const boundsWidth = Math.max(bounds.right - bounds.left, 1);
    const boundsHeight = Math.max(bounds.top - bounds.bottom, 1);
    const toX = (x) => (x - map.view.x) * map.view.scale + map.width / 2;
    const toY = (y) => map.height / 2 - (y - map.view.y) * map.view.scale;

    function resize() {
      map.width = byId("map-stack").clientWidth;
      const wanted = map.width * boundsHeight / boundsWidth + 24;
      const most = root.classList.contains("printing") ? 620 : Math.max(320, Math.min(700, window.innerHeight * 0.78));
      const isFitted = map.view.scale === map.fitScale || map.height === 0;
      map.height = Math.round(Math.min(Math.max(wanted, 260), most));
      map.fitScale = Math.min((map.width - 16) / boundsWidth, (map.height - 16) / boundsHeight);
      if (isFitted) fit();
    }

    function fit() {
      map.view = { x: (bounds.left + bounds.right) / 2, y: (bounds.bottom + bounds.top) / 2, scale: map.fitScale };
    }

    function zoom(factor, x = map.width / 2, y = map.height / 2) {
      const scale = Math.min(Math.max(map.view.scale * factor, map.fitScale * 0.5), Math.max(2000, map.fitScale * 4));
      const worldX = map.view.x + (x - map.width / 2) / map.view.scale;
      const worldY = map.view.y - (y - map.height / 2) / map.view.scale;
      map.view = { x: worldX - (x - map.width / 2) / scale, y: worldY + (y - map.height / 2) / scale, scale };
      map.draw();
    }

    function pan(dx, dy) {
      map.view.x -= dx / map.view.scale;
      map.view.y += dy / map.view.scale;
      map.draw();
    }

    // The map in the colours of the page. Its grey is only ever blended, never read, which browsers may forbid.
    map.tint = () => {
      map.tinted = null;
      map.back = theme.isDark ? "#363a40" : "#dddddd";
      if (!map.image || !map.image.complete || map.image.naturalWidth === 0) return;
      const canvas = document.createElement("canvas");
      canvas.width = map.image.naturalWidth;
      canvas.height = map.image.naturalHeight;
      const context = canvas.getContext("2d");
      context.drawImage(map.image, 0, 0);
      const fill = (operation, colour) => {
        context.globalCompositeOperation = operation;
        context.fillStyle = colour;
        context.fillRect(0, 0, canvas.width, canvas.height);
      };
      const shade = data.map.unknown_shade;
      if (theme.isDark) {
        fill("difference", "#ffffff");
        fill("lighter", "rgb(20,24,30)");
        const dark = 255 - shade;
        map.back = "rgb(" + [20 + dark, 24 + dark, 30 + dark].join(",") + ")";
      } else {
        map.back = "rgb(" + [shade, shade, shade].join(",") + ")";
      }
      map.tinted = canvas;
    };

    function polyline(context, xs, ys, accept) {
      let drawn = 0;
      let isOpen = false;
      let lastX = 0;
      let lastY = 0;
      let pending = null;
      for (let k = 0; k < scans.n; ++k) {
        if (Number.isNaN(xs[k])) continue;
        if (accept && !accept(k)) {
          isOpen = false;
          continue;
        }
        const x = toX(xs[k]);
        const y = toY(ys[k]);
        ++drawn;
        if (!isOpen) context.moveTo(x, y);
        else if (Math.abs(x - lastX) + Math.abs(y - lastY) < 0.7) {
          pending = [x, y];
          continue;
        } else context.lineTo(x, y);
        isOpen = true;
        pending = null;
        lastX = x, lastY = y;
      }
      if (pending) context.lineTo(pending[0], pending[1]);
      return drawn;
    }

    function drawLine(context, xs, ys, colour, width, dash, accept) {
      context.save();
      context.lineJoin = context.lineCap = "round";
      context.beginPath();
      const drawn = polyline(context, xs, ys, accept);
      context.strokeStyle = colourOf("--halo");
      context.lineWidth = width + 2.5;
      context.stroke();
      context.strokeStyle = colour;
      context.lineWidth = width;
      context.setLineDash(dash);
      context.stroke();
      context.restore();
      return drawn;
    }

    // The path in many colours: one stroke for each of them.
    function drawColoured(context, colouring) {
      context.save();
      context.lineCap = "round";
      context.strokeStyle = colourOf("--halo");
      context.lineWidth = 5.5;
      context.beginPath();
      const drawn = polyline(context, scans.x, scans.y);
      context.stroke();
      context.lineWidth = 3;
      const strokes = new Map();
      let last = -1;
      for (let k = 0; k < scans.n; ++k) {
        if (Number.isNaN(scans.x[k])) continue;
        if (last >= 0) {
          const colour = colouring.colour(k);
          if (!strokes.has(colour)) strokes.set(colour, []);
          strokes.get(colour).push([last, k]);
        }
        last = k;
      }
      for (const [colour, segments] of strokes) {
        context.strokeStyle = colour;
        context.beginPath();
        for (const [from, to] of segments) {
          context.moveTo(toX(scans.x[from]), toY(scans.y[from]));
          context.lineTo(toX(scans.x[to]), toY(scans.y[to]));
        }
        context.stroke();
      }
      context.restore();
      return drawn;
    }

    function drawLoops(context, state, colour, dash) {
      context.save();
      context.strokeStyle = context.fillStyle = colour;
      context.lineWidth = 1.1;
      context.globalAlpha = 0.85;
      let drawn = 0;
      for (const loop of loops) {
        if (loop.state !== state) continue;
        const x = toX(loop.x);
        const y = toY(loop.y);
        context.setLineDash(dash);
        context.beginPath(), context.moveTo(x, y), context.lineTo(toX(loop.toX), toY(loop.toY)), context.stroke();
        context.setLineDash([]);
        shape(context, state === "accepted" ? "dot" : "ring", x, y, state === "accepted" ? 2.8 : 4);
        ++drawn;
      }
      context.restore();
      return drawn;
    }

    function drawEnds(context) {
      const posed = [];
      for (let k = 0; k < scans.n; ++k) if (!Number.isNaN(scans.x[k])) posed.push(k);
      if (!posed.length) return;
      const mark = (k, text, isFilled) => {
        const x = toX(scans.x[k]);
        const y = toY(scans.y[k]);
        context.beginPath(), context.arc(x, y, 5.5, 0, 7);
        context.fillStyle = isFilled ? colourOf("--text") : colourOf("--card");
        context.fill();
        context.lineWidth = 2, context.strokeStyle = isFilled ? colourOf("--card") : colourOf("--text"), context.stroke();
        context.font = "600 12px " + theme.font;
        context.lineWidth = 3, context.strokeStyle = colourOf("--card"), context.lineJoin = "round";
        // On different sides, as a path that closes has both at one place.
        context.textAlign = isFilled ? "left" : "right";
        const beside = x + (isFilled ? 10 : -10);
        context.strokeText(text, beside, y + 4), context.fillStyle = colourOf("--text"), context.fillText(text, beside, y + 4);
        context.textAlign = "left";
      };
      mark(posed[0], "start", false);
      mark(posed[posed.length - 1], "end", true);
    }

    function drawScale(context) {
      const length = niceStep(70 / map.view.scale);
      const pixels = length * map.view.scale;
      const text = length >= 1000 ? length / 1000 + " km" : length >= 1 ? length + " m" : Math.round(length * 100) + " cm";
      const x = 14;
      const y = map.height - 16;
      context.font = "600 12px " + theme.font;
      const width = Math.max(pixels, context.measureText(text).width) + 16;
      context.fillStyle = colourOf("--halo");
      context.fillRect(x - 8, y - 24, width, 34);
      context.strokeStyle = context.fillStyle = colourOf("--text");
      context.lineWidth = 2;
      context.beginPath();
      context.moveTo(x, y - 5), context.lineTo(x, y + 3), context.lineTo(x + pixels, y + 3), context.lineTo(x + pixels, y - 5);
      context.stroke();
      context.fillText(text, x + 4, y - 7);
      map.canvas.dataset.scaleBar = text;
    }

    map.draw = () => {
      const context = prepare(map.canvas, map.width, map.height);
      const { layers } = map;
      context.fillStyle = map.back;
      context.fillRect(0, 0, map.width, map.height);
      const drawn = {};
      if (layers.map && map.tinted) {
        const { metres_per_pixel: size, left_m: left, top_m: top } = data.map;
        const pixels = size * map.view.scale;
        context.imageSmoothingEnabled = pixels < 1.5;
        context.imageSmoothingQuality = "high";
        context.drawImage(map.tinted, toX(left), toY(top), map.tinted.width * pixels, map.tinted.height * pixels);
        drawn.map = "yes";
      }
      if (layers.truth) drawn.truth = drawLine(context, scans.referenceX, scans.referenceY, colourOf("--truth"), 2, []);
      if (layers.odometry) {
        drawn.odometry = drawLine(context, scans.odometryX, scans.odometryY, colourOf("--odometry"), 1.6, [5, 4]);
      }
      if (layers.path) {
        const colouring = colourings.get(byId("colour-by").value);
        if (colouring.colour) drawn.path = drawColoured(context, colouring);
        else drawn.path = drawLine(context, scans.x, scans.y, colourOf("--path"), 2.2, []);
      }
      if (layers.accepted) drawn.accepted = drawLoops(context, "accepted", colourOf("--loop"), []);
      if (layers.dropped) drawn.dropped = drawLoops(context, "dropped", colourOf("--dropped"), [3, 3]);
      if (layers.refused) drawn.refused = drawLoops(context, "refused", colourOf("--refused"), [3, 3]);
      if (layers.degenerate) drawn.degenerate = drawDegenerate(context);
      if (layers.rejected) {
        drawn.rejected = 0;
        for (let k = 0; k < scans.n; ++k) {
          if (!isRejected(k) || Number.isNaN(scans.x[k])) continue;
          const fate = FATES[scans.fate[k]];
          context.fillStyle = context.strokeStyle = colourOf(fate.colour);
          shape(context, fate.shape, toX(scans.x[k]), toY(scans.y[k]), 4);
          ++drawn.rejected;
        }
      }
      drawEnds(context);
      drawScale(context);
      for (const name of Object.keys(map.canvas.dataset)) if (name.startsWith("drawn")) delete map.canvas.dataset[name];
      for (const [name, count] of Object.entries(drawn)) {
        map.canvas.dataset["drawn" + name[0].toUpperCase() + name.slice(1)] = String(count);
      }
      drawOverlay();
    };

    // Short strokes along the direction that the match left open.
    function drawDegenerate(context) {
      let drawn = 0;
      context.save();
      context.strokeStyle = context.fillStyle = colourOf("--degenerate");
      context.lineWidth = 2;
      for (let k = 0; k < scans.n; ++k) {
        if (scans.fate[k] !== "d" || Number.isNaN(scans.x[k])) continue;
        const x = toX(scans.x[k]);
        const y = toY(scans.y[k]);
        if (isGiven(scans.bearing[k])) {
          const angle = scans.heading[k] + scans.bearing[k];
          const dx = 8 * Math.cos(angle);
          const dy = -8 * Math.sin(angle);
          context.beginPath(), context.moveTo(x - dx, y - dy), context.lineTo(x + dx, y + dy), context.stroke();
        } else shape(context, "diamond", x, y, 3);
        ++drawn;
      }
      context.restore();
      return drawn;
    }

    function drawOverlay() {
      const context = prepare(map.overlay, map.width, map.height);
      if (pointedLoop) {
        const submap = data.submaps.find((entry) => entry[0] === pointedLoop.submap);
        if (submap) {
          context.save();
          context.lineJoin = context.lineCap = "round";
          context.globalAlpha = 0.45;
          context.strokeStyle = colourOf("--loop");
          context.lineWidth = 9;
          context.beginPath();
          polyline(context, scans.x, scans.y, (k) => scans.index[k] >= submap[1] && scans.index[k] <= submap[2]);
          context.stroke();
          context.restore();
        }
        context.strokeStyle = colourOf("--text");
        context.lineWidth = 2.5;
        const x = toX(pointedLoop.x);
        const y = toY(pointedLoop.y);
        context.beginPath(), context.moveTo(x, y), context.lineTo(toX(pointedLoop.toX), toY(pointedLoop.toY)), context.stroke();
        context.beginPath(), context.arc(x, y, 9, 0, 7), context.stroke();
      }
      if (pointedScan < 0 || Number.isNaN(scans.x[pointedScan])) return;
      const x = toX(scans.x[pointedScan]);
      const y = toY(scans.y[pointedScan]);
      const heading = scans.heading[pointedScan];
      const ring = (colour, width) => {
        context.strokeStyle = colour, context.lineWidth = width;
        context.beginPath(), context.arc(x, y, 7, 0, 7);
        context.moveTo(x + 7 * Math.cos(heading), y - 7 * Math.sin(heading));
        context.lineTo(x + 18 * Math.cos(heading), y - 18 * Math.sin(heading));
        context.stroke();
      };
      ring(colourOf("--card"), 5);
      ring(colourOf("--text"), 2.2);
      if (scans.referenceX && map.layers.truth && isGiven(scans.referenceX[pointedScan])) {
        context.fillStyle = colourOf("--truth");
        shape(context, "dot", toX(scans.referenceX[pointedScan]), toY(scans.referenceY[pointedScan]), 3.5);
      }
    }
    overlays.push(drawOverlay);

    function nearestScan(x, y, reach) {
      let best = -1;
      let least = reach * reach;
      for (let k = 0; k < scans.n; ++k) {
        const dx = toX(scans.x[k]) - x;
        const dy = toY(scans.y[k]) - y;
        const distance = dx * dx + dy * dy;
        if (distance < least) least = distance, best = k;
      }
      return best;
    }
    function nearestLoop(x, y, reach) {
      let best = null;
      let least = reach * reach;
      for (const loop of loops) {
        if (!map.layers[loop.state]) continue;
        for (const share of [0, 0.25, 0.5, 0.75]) {
          const dx = toX(loop.x + share * (loop.toX - loop.x)) - x;
          const dy = toY(loop.y + share * (loop.toY - loop.y)) - y;
          if (share > 0 && Math.hypot(toX(loop.toX) - toX(loop.x), toY(loop.toY) - toY(loop.y)) < 12) continue;
          if (dx * dx + dy * dy < least) least = dx * dx + dy * dy, best = loop;
        }
      }
      return best;
    }

    function hover(event) {
      const box = map.canvas.getBoundingClientRect();
      const x = event.clientX - box.left;
      const y = event.clientY - box.top;
      const loop = nearestLoop(x, y, 6);
      const k = nearestScan(x, y, event.pointerType === "touch" ? 30 : 18);
      const before = pointedLoop;
      pointedLoop = loop;
      if (before !== loop) drawOverlay();
      pointAt(k);
      const lines = k >= 0 ? scanLines(k) : [];
      if (loop) lines.push(...loopLines(loop));
      if (lines.length) showTip(k >= 0 ? scanTitle(k) : "Loop", lines, event.clientX, event.clientY);
      else hideTip();
    }

    const pointers = new Map();
    let moved = 0;
    map.canvas.addEventListener("pointerdown", (event) => {
      map.canvas.setPointerCapture(event.pointerId);
      pointers.set(event.pointerId, event);
      moved = 0;
      map.canvas.classList.add("dragging");
    });
    map.canvas.addEventListener("pointermove", (event) => {
      const before = pointers.get(event.pointerId);
      if (!before) {
        hover(event);
        return;
      }
      const box = map.canvas.getBoundingClientRect();
      if (pointers.size === 1) {
        const dx = event.clientX - before.clientX;
        const dy = event.clientY - before.clientY;
        moved += Math.abs(dx) + Math.abs(dy);
        pan(dx, dy);
        hideTip();
      } else if (pointers.size === 2) {
        const other = [...pointers.values()].find((pointer) => pointer.pointerId !== event.pointerId);
        const span = (a, b) => Math.max(10, Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY));
        moved += 10;
        pan((event.clientX - before.clientX) / 2, (event.clientY - before.clientY) / 2);
        zoom(span(event, other) / span(before, other), (event.clientX + other.clientX) / 2 - box.left,
          (event.clientY + other.clientY) / 2 - box.top);
      }
      pointers.set(event.pointerId, event);
    });
    const release = (event) => {
      if (!pointers.delete(event.pointerId)) return;
      if (pointers.size === 0) map.canvas.classList.remove("dragging");
      if (event.type === "pointerup" && moved < 6) hover(event);
    };
    map.canvas.addEventListener("pointerup", release);
    map.canvas.addEventListener("pointercancel", release);
    map.canvas.addEventListener("pointerleave", () => {
      hideTip();
      pointedLoop = null;
      pointAt(-1);
      drawOverlay();
    });
    map.canvas.addEventListener("wheel", (event) => {
      // All of the map is seen: the page scrolls on.
      if (event.deltaY > 0 && map.view.scale <= map.fitScale * 0.51) return;
      event.preventDefault();
      const box = map.canvas.getBoundingClientRect();
      const lines = event.deltaMode === 1 ? event.deltaY * 20 : event.deltaY;
      zoom(Math.exp(-Math.min(Math.max(lines, -200), 200) * 0.0025), event.clientX - box.left, event.clientY - box.top);
    }, { passive: false });
    map.canvas.addEventListener("keydown", (event) => {
      const actions = {
        "+": () => zoom(1.4), "=": () => zoom(1.4), "-": () => zoom(1 / 1.4), "0": () => (fit(), map.draw()),
        ArrowLeft: () => pan(60, 0), ArrowRight: () => pan(-60, 0), ArrowUp: () => pan(0, 60), ArrowDown: () => pan(0, -60),
      };
      if (!actions[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      actions[event.key]();
    });
    byId("zoom-in").addEventListener("click", () => zoom(1.5));
    byId("zoom-out").addEventListener("click", () => zoom(1 / 1.5));
    byId("zoom-fit").addEventListener("click", () => (fit(), map.draw()));

    // Shows a place, near enough to see single scans.
    map.show = (x, y) => {
      map.view = { x, y, scale: Math.max(map.view.scale, Math.min(map.width, map.height) / 15) };
      map.draw();
      const reduced = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
      byId("map-section").scrollIntoView({ behavior: reduced ? "auto" : "smooth", block: "nearest" });
    };
    map.resize = resize;

    setUpLayers();
    const rejected = (fateCounts.p || 0) + (fateCounts.b || 0) + (fateCounts.f || 0) + (fateCounts.r || 0);
    map.canvas.setAttribute("aria-label", "Map with the path of " + plural(run.scans.read, "scan") + ", " +
      fixed(run.path_m, 1) + " m long, " + plural(rejected, "rejected scan") + ", " +
      plural(loops.filter((loop) => loop.state === "accepted").length, "accepted loop"));
    byId("map-section").hidden = false;
  }

  function loopLines(loop) {
    const lines = [["loop", "keyframe " + loop.keyframe + " (scan " + loop.scan + ") to submap " + loop.submap]];
    lines.push(["", loop.state + (loop.reason ? ": " + loop.reason : "")]);
    lines.push(["loop's MHD", fixed(loop.score, 4) + " m, " + fixed(loop.inliers, 1) + " % inliers"]);
    return lines;
  }

  function setUpLayers() {
    const count = (state) => loops.filter((loop) => loop.state === state).length;
    const rejected = [...scans.fate].filter((letter) => "pbfr".includes(letter)).length;
    const all = [
      ["map", "Map", "map", "--text", data.map && map.image, "", true],
      ["path", run.odometry_only ? "Trajectory" : "Optimised path", "line", "--path", true, "", true],
      ["odometry", "Odometry (causal)", "dashed", "--odometry", scans.odometryX.some(isGiven), "", true],
      ["truth", "Ground truth", "line", "--truth", scans.referenceX, "", true],
      ["accepted", "Loops accepted", "dot", "--loop", count("accepted"), count("accepted"), true],
      ["refused", "Loops refused", "ring", "--refused", count("refused"), count("refused"), true],
      ["dropped", "Loops dropped again", "ring", "--dropped", count("dropped"), count("dropped"), true],
      ["degenerate", "Degenerate scans", "diamond", "--degenerate", fateCounts.d, fateCounts.d, true],
      ["rejected", "Rejected scans", "cross", "--poor", rejected, rejected, true],
    ];
    for (const [name, text, kind, colour, isThere, number, isOn] of all) {
      if (!isThere) continue;
      map.layers[name] = isOn;
      const box = element("input", { type: "checkbox", id: "layer-" + name });
      box.checked = isOn;
      box.addEventListener("change", () => {
        map.layers[name] = box.checked;
        map.draw();
      });
      byId("layers").append(element("label", { for: "layer-" + name }, box, swatch(kind, colour, name),
        element("span", { text }), element("span", { class: "count", text: String(number) })));
    }
    const select = byId("colour-by");
    for (const [name, colouring] of colourings) select.append(element("option", { value: name, text: colouring.text }));
    select.addEventListener("change", () => {
      drawColourKey();
      map.draw();
    });
  }

  // Ways to colour the path.
  const colourings = new Map([["plain", { text: "nothing" }]]);
  colourings.set("fate", { text: "verdict", colour: (k) => colourOf(FATES[scans.fate[k]].colour) });
  function addRamp(name, text, values, digits, unit) {
    const sorted = Array.from(values).filter(isGiven).sort((a, b) => a - b);
    if (!sorted.length) return;
    // A few extremes must not make all others look alike.
    const low = sorted[Math.floor(0.01 * (sorted.length - 1))];
    const high = sorted[Math.ceil(0.99 * (sorted.length - 1))];
    const span = high > low ? high - low : 1;
    colourings.set(name, {
      text, low: fixed(low, digits) + unit, high: fixed(high, digits) + unit,
      colour: (k) => (isGiven(values[k]) ? rampColour(Math.round(31 * (values[k] - low) / span) / 31) : colourOf("--few")),
    });
  }
  addRamp("score", "MHD score", scans.score, 3, " m");
  if (scans.error) addRamp("error", "error", scans.error, 3, " m");
  addRamp("time", "time", scans.t, 0, " s");
  if (scans.z) addRamp("z", "height", scans.z, 2, " m");

  function fateKeys() {
    return Object.keys(FATES).filter((letter) => fateCounts[letter]).map((letter) =>
      element("li", { title: FATES[letter].note }, swatch(FATES[letter].shape, FATES[letter].colour),
        FATES[letter].name + " " + fateCounts[letter]));
  }
  function drawColourKey() {
    const colouring = colourings.get(byId("colour-by").value);
    const key = byId("colour-key");
    key.replaceChildren();
    if (colouring.low) {
      const ramp = element("div", { class: "ramp" });
      ramp.style.background = "linear-gradient(to right," + [0, 0.25, 0.5, 0.75, 1].map(rampColour).join(",") + ")";
      key.append(ramp, element("div", { class: "ends" }, element("span", { text: colouring.low }),
        element("span", { text: colouring.high })));
    } else if (colouring.colour) {
      key.append(element("ul", { class: "keys" }, ...fateKeys()));
      for (const paint of swatches) paint();
    }
  }

  // ---------------------------------------------------------------- charts

  const X_MODES = {
    index: { text: "scan index", label: "scan", values: scans.index, unit: "" },
    time: { text: "time", label: "time [s]", values: scans.axisTime, unit: " s" },
    distance: { text: "distance", label: "path [m]", values: scans.distance, unit: " m" },
  };
  const axis = { mode: "index", low: 0, high: 1 };
  const charts = [];
  const MARGIN = { left: 52, right: 12, top: 8, bottom: 30 };

  const axisValues = () => X_MODES[axis.mode].values;
  function showAll() {
    const values = axisValues();
    axis.low = values[0];
    axis.high = values[values.length - 1] > values[0] ? values[values.length - 1] : values[0] + 1;
  }
  // The first scan whose place on the axis is not below `value`.
  function lowerBound(value) {
    const values = axisValues();
    let low = 0;
    let high = values.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (values[middle] < value) low = middle + 1;
      else high = middle;
    }
    return low;
  }
  function nearestOnAxis(value) {
    const values = axisValues();
    const next = Math.min(lowerBound(value), values.length - 1);
    return next > 0 && value - values[next - 1] < values[next] - value ? next - 1 : next;
  }
  function setAxis(low, high) {
    const values = axisValues();
    const first = values[0];
    const last = values[values.length - 1] > first ? values[values.length - 1] : first + 1;
    const span = Math.min(Math.max(high - low, (last - first) / Math.max(scans.n, 8) * 4), last - first);
    axis.low = Math.min(Math.max(low, first), last - span);
    axis.high = axis.low + span;
    for (const chart of charts) chart.draw();
  }
  function zoomAxis(factor) {
    const middle = pointedScan >= 0 ? axisValues()[pointedScan] : (axis.low + axis.high) / 2;
    setAxis(middle + (axis.low - middle) / factor, middle + (axis.high - middle) / factor);
  }

  // A line with, for every column of pixels, its lowest and highest value: as it looks with all points, only quicker.
  function chartLine(context, values, first, last, toX, toY) {
    let drawn = 0;
    let at = NaN;
    let low = 0;
    let high = 0;
    let final = 0;
    let isOpen = false;
    const flush = () => {
      if (Number.isNaN(at)) return;
      if (low !== high) context.lineTo(at, low), context.lineTo(at, high), context.lineTo(at, final);
      at = NaN;
    };
    context.beginPath();
    for (let k = first; k <= last; ++k) {
      if (Number.isNaN(values[k])) continue;
      const x = Math.round(toX(k) * 2) / 2;
      const y = toY(values[k]);
      ++drawn;
      if (x === at) {
        low = Math.min(low, y), high = Math.max(high, y), final = y;
        continue;
      }
      flush();
      if (isOpen) context.lineTo(x, y);
      else context.moveTo(x, y);
      isOpen = true;
      at = x, low = high = final = y;
    }
    flush();
    if (drawn === 1) context.lineTo(at + 1, final);
    context.stroke();
    return drawn;
  }

  // A chart below those there are. `spec.draw(context, area)` draws and returns the number of points; `spec.range(first,
  // last)` gives the lowest and the highest value of these scans.
  function addChart(spec) {
    const canvas = element("canvas", { id: "chart-" + spec.name, tabindex: "0", role: "img", "aria-label": spec.summary });
    const overlay = element("canvas", { class: "overlay", "aria-hidden": "true" });
    const stack = element("div", { class: "stack" }, canvas, overlay);
    byId("charts").append(element("div", { class: "chart" },
      element("h3", {}, spec.title, element("span", { class: "unit", text: spec.unit }),
        element("ul", { class: "keys" }, ...spec.keys)),
      stack));
    const chart = { width: 0, selection: null };
    const place = () => ({
      left: MARGIN.left, right: chart.width - MARGIN.right, top: MARGIN.top, bottom: spec.height - MARGIN.bottom,
    });
    const toAxis = (x) => {
      const { left, right } = place();
      return axis.low + (x - left) / (right - left) * (axis.high - axis.low);
    };

    chart.draw = () => {
      chart.width = stack.clientWidth;
      const context = prepare(canvas, chart.width, spec.height);
      const { left, right, top, bottom } = place();
      const values = axisValues();
      // One more on either side, so that lines go on to the edge.
      const first = Math.max(lowerBound(axis.low) - 1, 0);
      const last = Math.min(lowerBound(axis.high) + 1, scans.n - 1);
      let [low, high] = spec.range(first, last);
      if (!(high > low)) high = low + 1;
      const step = niceStep((high - low) / Math.max(2, Math.floor((bottom - top) / 34)));
      low = Math.floor(low / step + 1e-6) * step;
      high = Math.ceil(high / step - 1e-6) * step;
      const toX = (k) => left + (values[k] - axis.low) / (axis.high - axis.low) * (right - left);
      const toY = (value) => bottom - (value - low) / (high - low) * (bottom - top);

      context.font = "11.5px " + theme.font;
      context.lineWidth = 1;
      context.textBaseline = "middle";
      context.textAlign = "right";
      const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-6));
      for (let i = 0; low + i * step <= high + step / 2; ++i) {
        const y = Math.round(toY(low + i * step)) + 0.5;
        context.strokeStyle = colourOf("--grid");
        context.beginPath(), context.moveTo(left, y), context.lineTo(right, y), context.stroke();
        context.fillStyle = colourOf("--muted");
        context.fillText(fixed(low + i * step, digits), left - 7, y);
      }
      context.textBaseline = "top";
      context.textAlign = "center";
      const xStep = niceStep((axis.high - axis.low) / Math.max(2, (right - left) / 90));
      const isWhole = axis.mode === "index";
      const xDigits = isWhole ? 0 : Math.max(0, -Math.floor(Math.log10(xStep) + 1e-6));
      for (let i = Math.ceil(axis.low / xStep); i * xStep <= axis.high; ++i) {
        if (isWhole && xStep < 1 && (i * xStep) % 1 !== 0) continue;
        const x = Math.round(left + (i * xStep - axis.low) / (axis.high - axis.low) * (right - left)) + 0.5;
        context.strokeStyle = colourOf("--grid");
        context.beginPath(), context.moveTo(x, top), context.lineTo(x, bottom + 4), context.stroke();
        context.fillStyle = colourOf("--muted");
        context.fillText(fixed(i * xStep, xDigits), x, bottom + 7);
      }
      context.textAlign = "right";
      context.fillText(X_MODES[axis.mode].label, right, bottom + 19);

      context.save();
      context.beginPath(), context.rect(left - 4, top - 4, right - left + 8, bottom - top + 8), context.clip();
      const drawn = spec.draw(context, { left, right, top, bottom, first, last, toX, toY });
      context.restore();
      canvas.dataset.drawnPoints = String(drawn);
      chart.drawOverlay();
    };

    chart.drawOverlay = () => {
      const context = prepare(overlay, chart.width, spec.height);
      const { left, right, top, bottom } = place();
      if (chart.selection) {
        const [from, to] = chart.selection;
        context.fillStyle = colourOf("--accent");
        context.globalAlpha = 0.18;
        context.fillRect(Math.min(from, to), top, Math.abs(to - from), bottom - top);
        context.globalAlpha = 1;
      }
      if (pointedScan < 0) return;
      const x = left + (axisValues()[pointedScan] - axis.low) / (axis.high - axis.low) * (right - left);
      if (x < left - 1 || x > right + 1) return;
      context.strokeStyle = colourOf("--text");
      context.lineWidth = 1;
      context.beginPath(), context.moveTo(Math.round(x) + 0.5, top), context.lineTo(Math.round(x) + 0.5, bottom), context.stroke();
    };
    overlays.push(chart.drawOverlay);

    const xOf = (event) => event.clientX - canvas.getBoundingClientRect().left;
    const hover = (event) => {
      const { left, right } = place();
      const x = xOf(event);
      if (x < left - 8 || x > right + 8) {
        hideTip();
        pointAt(-1);
        return;
      }
      const k = nearestOnAxis(toAxis(x));
      pointAt(k);
      showTip(scanTitle(k), scanLines(k), event.clientX, event.clientY);
    };
    canvas.addEventListener("pointerdown", (event) => {
      if (event.pointerType === "touch") {
        hover(event);
        return;
      }
      if (event.button !== 0) return;
      canvas.setPointerCapture(event.pointerId);
      const { left, right } = place();
      const x = Math.min(Math.max(xOf(event), left), right);
      chart.selection = [x, x];
    });
    canvas.addEventListener("pointermove", (event) => {
      hover(event);
      if (!chart.selection) return;
      const { left, right } = place();
      chart.selection[1] = Math.min(Math.max(xOf(event), left), right);
      chart.drawOverlay();
    });
    canvas.addEventListener("pointerup", () => {
      const selection = chart.selection;
      chart.selection = null;
      if (selection && Math.abs(selection[1] - selection[0]) > 6) {
        setAxis(toAxis(Math.min(...selection)), toAxis(Math.max(...selection)));
      } else chart.drawOverlay();
    });
    canvas.addEventListener("pointercancel", () => {
      chart.selection = null;
      chart.drawOverlay();
    });
    canvas.addEventListener("pointerleave", () => {
      hideTip();
      pointAt(-1);
    });
    canvas.addEventListener("dblclick", () => {
      showAll();
      for (const each of charts) each.draw();
    });
    canvas.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const move = (steps) => {
        const from = pointedScan >= 0 ? pointedScan : lowerBound(axis.low) - Math.sign(steps);
        const k = Math.min(Math.max(from + steps, 0), scans.n - 1);
        pointAt(k);
        tellScan(k);
        const value = axisValues()[k];
        if (value < axis.low || value > axis.high) {
          const half = (axis.high - axis.low) / 2;
          setAxis(value - half, value + half);
        }
      };
      const pace = event.shiftKey ? 10 : 1;
      const actions = {
        ArrowLeft: () => move(-pace), ArrowRight: () => move(pace), "+": () => zoomAxis(1.5), "=": () => zoomAxis(1.5),
        "-": () => zoomAxis(1 / 1.5), "0": () => (showAll(), charts.forEach((each) => each.draw())),
        Escape: () => pointAt(-1),
      };
      if (!actions[event.key]) return;
      event.preventDefault();
      actions[event.key]();
    });
    charts.push(chart);
  }

  function addScoreChart() {
    if (!scans.score.some(isGiven) && !isGiven(highest(scans.score, 0, scans.n - 1))) return;
    // Gates of the same height are one line.
    const gates = new Map();
    for (const gate of data.gates.slice().sort((a, b) => a.score_m - b.score_m)) {
      if (!gates.has(gate.score_m)) gates.set(gate.score_m, []);
      gates.get(gate.score_m).push(gate.label);
    }
    const gateKeys = [...gates].map(([score, labels]) =>
      element("li", {}, swatch("dashed", "--muted"), "above " + score + " m: " + labels.join(", ")));
    const top = Math.max(0, ...gates.keys());
    addChart({
      name: "score", title: "MHD score and verdict", unit: "m", height: 210,
      keys: [...fateKeys(), ...gateKeys],
      summary: "Score of " + plural(scans.n, "scan") + ", median " + fixed(median(scans.score), 4) + " m, highest " +
        fixed(highest(scans.score, 0, scans.n - 1), 4) + " m",
      range: (first, last) => [0, Math.max(top * 1.1, highest(scans.score, first, last))],
      draw: (context, { left, right, top: above, bottom, first, last, toX, toY }) => {
        context.save();
        context.setLineDash([6, 4]);
        context.strokeStyle = colourOf("--muted");
        for (const score of gates.keys()) {
          const y = Math.round(toY(score)) + 0.5;
          context.beginPath(), context.moveTo(left, y), context.lineTo(right, y), context.stroke();
        }
        context.restore();
        const radius = last - first > 3 * (right - left) ? 1.3 : last - first > (right - left) / 3 ? 1.9 : 2.8;
        // Where thousands of marks fall on the same pixel, one will do.
        const taken = new Set();
        let drawn = 0;
        const mark = (k) => {
          const fate = FATES[scans.fate[k]];
          const x = toX(k);
          const y = isGiven(scans.score[k]) ? toY(scans.score[k]) : bottom - 4;
          ++drawn;
          const key = (Math.round(x) * 4096 + Math.round(y)) * 16 + Object.keys(FATES).indexOf(scans.fate[k]);
          if (taken.has(key)) return;
          taken.add(key);
          context.fillStyle = context.strokeStyle = colourOf(fate.colour);
          const isPlain = scans.fate[k] === "a" || scans.fate[k] === "s";
          shape(context, fate.shape, x, Math.max(y, above), isPlain ? radius : Math.max(radius, 2.2) + 0.8);
        };
        // What is out of the ordinary comes last and on top.
        for (let k = first; k <= last; ++k) if (scans.fate[k] === "a") mark(k);
        for (let k = first; k <= last; ++k) if (scans.fate[k] !== "a") mark(k);
        return drawn;
      },
    });
  }

  function lineChart(name, title, unit, height, lines, fromZero) {
    const ranged = (pick, first, last, start) => {
      let result = start;
      for (const line of lines) {
        for (let k = first; k <= last; ++k) if (isGiven(line.values[k])) result = pick(result, line.values[k]);
      }
      return result;
    };
    addChart({
      name, title, unit, height,
      keys: lines.map((line) => element("li", {}, swatch(line.dash ? "dashed" : "line", line.colour), line.text)),
      summary: title + ": " + lines.map((line) => line.text + ", median " + fixed(median(line.values), 3) + " " + unit).join("; "),
      range: (first, last) => (fromZero ? [0, ranged(Math.max, first, last, 0)]
        : [ranged(Math.min, first, last, Infinity), ranged(Math.max, first, last, -Infinity)]),
      draw: (context, { first, last, toX, toY }) => {
        let drawn = 0;
        for (const line of lines) {
          context.strokeStyle = colourOf(line.colour);
          context.lineWidth = 1.5;
          context.lineJoin = "round";
          context.setLineDash(line.dash || []);
          drawn += chartLine(context, line.values, first, last, toX, toY);
        }
        context.setLineDash([]);
        return drawn;
      },
    });
  }

  function addTimeChart() {
    const colours = data.times.stages.map((stage, i) => "--stage-" + (i % 6));
    const total = new Float64Array(scans.n);
    for (const stage of scans.stages) for (let k = 0; k < scans.n; ++k) total[k] += stage[k] || 0;
    addChart({
      name: "times", title: "Time per scan", unit: "ms", height: 170,
      keys: data.times.stages.map((stage, i) => element("li", { title: stage.name }, swatch("area", colours[i]), stage.key)),
      summary: "Time per scan by stage, median " + fixed(data.times.total.median_ms, 2) + " ms, 95th percentile " +
        fixed(data.times.total.p95_ms, 2) + " ms, highest " + fixed(data.times.total.max_ms, 2) + " ms",
      range: (first, last) => [0, highest(total, first, last)],
      draw: (context, { left, right, first, last, toX, toY }) => {
        // A column of pixels shows the slowest of its scans.
        const slowest = new Map();
        for (let k = first; k <= last; ++k) {
          const x = Math.round(toX(k));
          if (!slowest.has(x) || total[k] > total[slowest.get(x)]) slowest.set(x, k);
        }
        const width = Math.max(1, Math.min(14, (right - left) / Math.max(1, last - first) * 0.8));
        scans.stages.forEach((stage, i) => {
          context.fillStyle = colourOf(colours[i]);
          for (const [x, k] of slowest) {
            let below = 0;
            for (let j = 0; j < i; ++j) below += scans.stages[j][k] || 0;
            const y = toY(below + (stage[k] || 0));
            context.fillRect(x - width / 2, y, width, toY(below) - y);
          }
        });
        return last - first + 1;
      },
    });
  }

  function setUpCharts() {
    if (scans.n === 0) return;
    addScoreChart();
    if (scans.error) {
      lineChart("error", "Position error against the ground truth", "m", 170, [
        { text: "odometry", values: scans.odometryError, colour: "--odometry", dash: [5, 4] },
        { text: run.odometry_only ? "trajectory" : "optimised path", values: scans.error, colour: "--path" },
      ], true);
    }
    if (scans.z) {
      lineChart("attitude", "Roll and pitch", "\u00b0", 150, [
        { text: "roll", values: scans.roll, colour: "--path" },
        { text: "pitch", values: scans.pitch, colour: "--odometry" },
      ], false);
      const heights = [{ text: "z", values: scans.z, colour: "--path" }];
      if (scans.referenceZ) heights.unshift({ text: "ground truth", values: scans.referenceZ, colour: "--truth" });
      lineChart("height", "Height", "m", 130, heights, false);
    }
    const counts = [{ text: "to match", values: scans.points, colour: "--path" }];
    if (scans.moving) counts.push({ text: "moving, left out", values: scans.moving, colour: "--odometry", dash: [5, 4] });
    lineChart("points", "Planar points", "per scan", 120, counts, true);
    addTimeChart();
    const mode = byId("x-mode");
    for (const [name, { text }] of Object.entries(X_MODES)) mode.append(element("option", { value: name, text }));
    mode.addEventListener("change", () => {
      axis.mode = mode.value;
      showAll();
      for (const chart of charts) chart.draw();
    });
    byId("x-in").addEventListener("click", () => zoomAxis(2));
    byId("x-out").addEventListener("click", () => zoomAxis(0.5));
    byId("x-all").addEventListener("click", () => {
      showAll();
      for (const chart of charts) chart.draw();
    });
    showAll();
    byId("scans-section").hidden = false;
  }

  // ---------------------------------------------------------------- tables

  // Columns: { text, value(row) to sort by, show(row) as text or node, number, wrap }. Long tables come in parts.
  function table(host, caption, columns, rows, options = {}) {
    const PART = 200;
    let sorted = rows.slice();
    let shown = PART;
    const heads = columns.map((entry, i) => {
      const head = element("th", { scope: "col", class: entry.number ? "number" : null });
      if (!entry.value || options.plain) head.textContent = entry.text;
      else head.append(element("button", { type: "button", text: entry.text, onclick: () => sortBy(i) }));
      return head;
    });
    const body = element("tbody");
    const more = element("button", { type: "button", class: "more-rows", onclick: () => {
      shown = Infinity;
      fill();
    } });
    function sortBy(i) {
      const isUp = heads[i].getAttribute("aria-sort") !== "ascending";
      for (const head of heads) head.removeAttribute("aria-sort");
      heads[i].setAttribute("aria-sort", isUp ? "ascending" : "descending");
      const value = columns[i].value;
      sorted.sort((a, b) => {
        const [u, v] = [value(a), value(b)];
        // What is missing comes last either way.
        if (!isGiven(u) || !isGiven(v)) return (isGiven(u) ? 0 : 1) - (isGiven(v) ? 0 : 1);
        return (u < v ? -1 : u > v ? 1 : 0) * (isUp ? 1 : -1);
      });
      fill();
    }
    function fill() {
      body.replaceChildren(...sorted.slice(0, shown).map((row) => element("tr", { class: row.isTotal ? "total" : null },
        ...columns.map((entry) => {
          const content = entry.show(row);
          return element("td", { class: entry.number ? "number" : entry.wrap ? "wrap" : null }, content instanceof Node ? content : String(content));
        }))));
      more.textContent = "Show all " + sorted.length;
      more.hidden = shown >= sorted.length;
      host.dataset.rows = String(sorted.length);
    }
    host.replaceChildren(element("table", {}, caption ? element("caption", { text: caption }) : "",
      element("thead", {}, element("tr", {}, ...heads)), body), more);
    fill();
    return { setRows: (newRows) => {
      sorted = newRows.slice();
      const at = heads.findIndex((head) => head.hasAttribute("aria-sort"));
      if (at < 0) {
        fill();
        return;
      }
      const direction = heads[at].getAttribute("aria-sort");
      heads[at].setAttribute("aria-sort", direction === "ascending" ? "descending" : "ascending");
      sortBy(at);
    } };
  }

  // The shown scan that is nearest to the one of this index.
  function shownScan(index) {
    let low = 0;
    let high = scans.n - 1;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (scans.index[middle] < index) low = middle + 1;
      else high = middle;
    }
    return low;
  }
  function scanLink(index) {
    return element("a", { href: "#map-section", class: "go", text: String(index), title: "Show on the map", onclick: (event) => {
      event.preventDefault();
      const k = shownScan(index);
      pointedLoop = null;
      pointedScan = k;
      if (isGiven(scans.x[k])) map.show(scans.x[k], scans.y[k]);
      drawOverlays();
    } });
  }
  function marked(colour, text) {
    const dot = element("span", { class: "dot", "aria-hidden": "true" });
    dot.style.background = "var(" + colour + ")";
    return element("span", {}, dot, text);
  }
  const cutNote = (list) => (list.total > list.rows.length ? " The table has the first " + list.rows.length + "." : "");

  function setUpFigures() {
    const counts = run.scans;
    const lastStamp = scans.n ? scans.axisTime[scans.n - 1] : 0;
    const share = (count) => (counts.read ? fixed(100 * count / counts.read, 1) + "\u00a0%" : DASH);
    const accepted = loops.filter((loop) => loop.state === "accepted").length;
    const figures = [
      ["Scans", String(counts.read), "", plural(counts.keyframes, "keyframe") + ", " + plural(run.submaps, "submap")],
      ["Not matched", String(counts.rejected + counts.skipped), "",
        counts.rejected + " rejected (" + share(counts.rejected) + "), " + counts.skipped + " skipped"],
      ["Path", fixed(run.path_m, 1), "m", "in " + duration(lastStamp)],
    ];
    if (data.errors) {
      figures.push(["ATE RMSE", fixed(data.errors.ate_rmse_m, 3), "m", "odometry " + metres(data.errors.odometry_ate_rmse_m)]);
      figures.push(["End error", fixed(data.errors.end_error_m, 3), "m", "over " + fixed(data.errors.path_m, 1) + " m"]);
    }
    if (data.loops.total) {
      figures.push(["Loops accepted", String(accepted), "", "of " + data.loops.total + " tried" +
        (data.errors && data.errors.false_loops !== undefined ? ", " + data.errors.false_loops + " of them false" : "")]);
    }
    figures.push(["Time per scan", fixed(data.times.total.median_ms, 1), "ms", "p95 " + fixed(data.times.total.p95_ms, 1) +
      " ms, max " + fixed(data.times.total.max_ms, 1) + " ms"]);
    figures.push(["Whole run", fixed(data.times.run_ms / 1000, 1), "s",
      run.threads + (run.threads === 1 ? " thread" : " threads") + (lastStamp > 0 && data.times.run_ms > 0
        ? ", " + fixed(lastStamp / (data.times.run_ms / 1000), 1) + "\u00a0\u00d7\u00a0real time" : "")]);
    figures.push(["Peak memory", fixed(run.peak_memory_mib, 0), "MiB", ""]);
    byId("figures").append(...figures.map(([name, value, unit, more]) => element("div", {}, element("dt", { text: name }),
      element("dd", {}, element("div", { class: "value" }, value, unit ? " " : "", element("small", { text: unit })),
        element("div", { class: "more", text: more })))));

    byId("subtitle").textContent = run.input;
    const badges = [];
    badges.push(element("span", { class: "badge", text: run.program }));
    badges.push(element("span", { class: run.state === "ok" ? "badge" : "badge warn", text: run.verdict }));
    if (run.interrupted) badges.push(element("span", { class: "badge warn", text: "interrupted: only a part of the input" }));
    if (run.odometry_only) badges.push(element("span", { class: "badge", text: "odometry only" }));
    byId("badges").append(...badges);
    if (run.notices.length) {
      byId("notices").querySelector("ul").append(...run.notices.map((text) => element("li", { text })));
      byId("notices").hidden = false;
    }
  }

  function setUpErrors() {
    if (!data.errors) return;
    const errors = data.errors;
    byId("errors-text").textContent = "Aligned by " + { none: "nothing", origin: "the first pose", se2: "SE(2), without scale",
      se3: "SE(3), without scale" }[errors.alignment] + "; path of the ground truth " + fixed(errors.path_m, 1) + " m" +
      (errors.unmatched_poses ? "; " + plural(errors.unmatched_poses, "pose") + " without a partner in it" : "") + ".";
    const value = (figure, which) => (isGiven(figure[which]) ? fixed(figure[which], 4) + " " + figure.unit : DASH);
    table(byId("errors-table"), "", [
      { text: "Figure", show: (row) => row.name, wrap: true },
      { text: run.odometry_only ? "Trajectory" : "Optimised path", show: (row) => value(row, "trajectory"), number: true },
      { text: "Odometry", show: (row) => value(row, "odometry"), number: true },
    ], errors.figures.filter((figure) => isGiven(figure.trajectory) || isGiven(figure.odometry)), { plain: true });
    byId("errors-section").hidden = false;
  }

  function setUpLoops() {
    if (!loops.length) return;
    const groups = new Map();
    for (const loop of loops) {
      const name = loop.state + (loop.reason ? ": " + loop.reason : "");
      groups.set(name, (groups.get(name) || 0) + 1);
    }
    byId("loops-text").textContent = [...groups].map(([name, count]) => count + " " + name).join(", ") + "." + cutNote(data.loops);
    const colours = { accepted: "--loop", refused: "--refused", dropped: "--dropped" };
    const rows = table(byId("loops-table"), "", [
      { text: "Scan", value: (row) => row.scan, number: true, show: (row) => element("a", {
        href: "#map-section", class: "go", text: String(row.scan), title: "Show on the map", onclick: (event) => {
          event.preventDefault();
          pointedLoop = row;
          pointedScan = -1;
          map.show((row.x + row.toX) / 2, (row.y + row.toY) / 2);
          drawOverlays();
        } }) },
      { text: "Keyframe", value: (row) => row.keyframe, show: (row) => row.keyframe, number: true },
      { text: "Submap", value: (row) => row.submap, show: (row) => row.submap, number: true },
      { text: "Outcome", value: (row) => row.state + row.reason, show: (row) => marked(colours[row.state], row.state) },
      { text: "Reason", value: (row) => row.reason || null, show: (row) => row.reason || DASH },
      { text: "MHD [m]", value: (row) => row.score, show: (row) => fixed(row.score, 4), number: true },
      { text: "Inliers [%]", value: (row) => row.inliers, show: (row) => fixed(row.inliers, 1), number: true },
      { text: "Second best [m]", value: (row) => row.second, show: (row) => fixed(row.second, 4), number: true },
    ], loops);
    const filter = byId("loop-filter");
    filter.append(element("option", { value: "", text: "all" }));
    for (const state of ["accepted", "refused", "dropped"]) {
      if (loops.some((loop) => loop.state === state)) filter.append(element("option", { value: state, text: state }));
    }
    filter.addEventListener("change", () => rows.setRows(loops.filter((loop) => !filter.value || loop.state === filter.value)));
    byId("loops-section").hidden = false;
  }

  function setUpTimes() {
    const times = data.times;
    if (!run.scans.read) return;
    const total = Object.assign({ isTotal: true }, times.total);
    table(byId("stages-table"), "Each scan [ms]", [
      { text: "Stage", show: (row) => row.key },
      { text: "", show: (row) => row.name, wrap: true },
      { text: "Median", show: (row) => fixed(row.median_ms, 2), number: true },
      { text: "p95", show: (row) => fixed(row.p95_ms, 2), number: true },
      { text: "Max", show: (row) => fixed(row.max_ms, 2), number: true },
    ], [...times.stages, total], { plain: true });
    table(byId("run-times-table"), "The run", [
      { text: "Stage", show: (row) => row[0] },
      { text: "Time", show: (row) => milliseconds(row[1]), number: true },
    ], [["search for loops", times.loop_search_ms], ["optimisation of the graph", times.optimization_ms],
      ["matching to the corrected map", times.map_refinement_ms], ["heights and tilts", times.terrain_ms],
      ["second reading, for the maps", times.second_pass_ms], Object.assign(["whole run, with reading", times.run_ms], { isTotal: true })],
    { plain: true });
    byId("times-section").hidden = false;
  }

  function setUpUnused() {
    if (!data.unused.total) return;
    const rows = data.unused.rows.map(([index, t, fate, reason, points, score, inliers]) => ({
      index, t: t * 1e-3, status: fate === "k" ? "skipped" : "rejected", fate, reason: data.texts[reason], points,
      score: score === null ? NaN : score * 1e-6, inliers: inliers === null ? NaN : inliers * 0.1,
    }));
    byId("unused-text").textContent = "Rejected scans have the pose that the motion model predicts, skipped ones have none." +
      cutNote(data.unused);
    table(byId("unused-table"), "", [
      { text: "Scan", value: (row) => row.index, show: (row) => scanLink(row.index), number: true },
      { text: "Stamp [s]", value: (row) => row.t, show: (row) => fixed(run.first_stamp_s + row.t, 3), number: true },
      { text: "Status", value: (row) => row.status, show: (row) => marked(FATES[row.fate].colour, row.status) },
      { text: "Reason", value: (row) => row.reason, show: (row) => row.reason, wrap: true },
      { text: "Points", value: (row) => row.points, show: (row) => row.points, number: true },
      { text: "MHD [m]", value: (row) => row.score, show: (row) => fixed(row.score, 4), number: true },
      { text: "Inliers [%]", value: (row) => row.inliers, show: (row) => fixed(row.inliers, 1), number: true },
    ], rows);
    byId("unused-section").hidden = false;
  }

  function setUpStretches() {
    if (!data.stretches.total) return;
    const rows = data.stretches.rows.map(([first, last, t, length, bearing]) => ({
      first, last, t: t * 1e-3, count: last - first + 1, length: length * 1e-3,
      bearing: bearing === null ? NaN : bearing * 0.18 / Math.PI,
    }));
    const longest = rows.reduce((best, row) => (row.length > best.length ? row : best));
    byId("stretches-text").textContent = plural(run.scans.degenerate, "scan") + " in " +
      plural(data.stretches.total, "stretch", "stretches") + ", the longest of " + fixed(longest.length, 1) +
      " m: along one direction the map did not determine the pose, which is the prediction's there." + cutNote(data.stretches);
    table(byId("stretches-table"), "", [
      { text: "First scan", value: (row) => row.first, show: (row) => scanLink(row.first), number: true },
      { text: "Last scan", value: (row) => row.last, show: (row) => scanLink(row.last), number: true },
      { text: "Scans", value: (row) => row.count, show: (row) => row.count, number: true },
      { text: "Length [m]", value: (row) => row.length, show: (row) => fixed(row.length, 2), number: true },
      { text: "From [s]", value: (row) => row.t, show: (row) => fixed(run.first_stamp_s + row.t, 3), number: true },
      { text: "Unknown along, off the heading", value: (row) => row.bearing, number: true,
        show: (row) => (isGiven(row.bearing) ? fixed(row.bearing, 0) + "\u00b0" : "heading or several") },
    ], rows);
    byId("stretches-section").hidden = false;
  }

  function setUpRun() {
    const counts = run.scans;
    const rows = [
      ["Program", run.program],
      ["Input", run.input],
      ["Scans read", String(counts.read)],
      ["Matched", counts.matched + ", of these " + counts.spoilt + " too spoilt for the maps, " + counts.degenerate + " degenerate"],
      ["Rejected, skipped", counts.rejected + ", " + counts.skipped],
      ["Searched wide", String(counts.searched_wide)],
      ["Keyframes, submaps", counts.keyframes + ", " + run.submaps],
      ["Stamps", fixed(run.first_stamp_s, 3) + " s and " + (scans.n ? fixed(scans.axisTime[scans.n - 1], 3) : "0") + " s more"],
      ["Threads", String(run.threads)],
      ["Peak memory", fixed(run.peak_memory_mib, 1) + " MiB"],
    ];
    if (scans.n < counts.read) rows.push(["Shown here", "every " + scans.index[1] + "th scan; summary.json counts all"]);
    table(byId("run-table"), "", [{ text: "What", show: (row) => row[0] }, { text: "Value", show: (row) => row[1], wrap: true }],
      rows, { plain: true });
    if (!data.config) return;
    byId("config-text").textContent = data.config;
    byId("config").hidden = false;
    byId("copy-config").addEventListener("click", async () => {
      let isCopied = false;
      try {
        await navigator.clipboard.writeText(data.config);
        isCopied = true;
      } catch {
        // A page from a file may be denied the clipboard, but not its own selection.
        getSelection().selectAllChildren(byId("config-text"));
        isCopied = document.execCommand("copy");
      }
      byId("copy-state").textContent = isCopied ? "copied" : "selected: copy it with the keyboard";
    });
  }

  // ---------------------------------------------------------------- all together

  function drawAll() {
    readTheme();
    map.tint();
    map.resize();
    for (const paint of swatches) paint();
    map.draw();
    for (const chart of charts) chart.draw();
    drawColourKey();
  }

  function start() {
    readTheme();
    setUpFigures();
    setUpMap();
    setUpCharts();
    setUpErrors();
    setUpLoops();
    setUpTimes();
    setUpUnused();
    setUpStretches();
    setUpRun();
    drawAll();
    let width = window.innerWidth;
    window.addEventListener("resize", () => {
      // On phones the height changes with every scroll.
      if (window.innerWidth === width) return;
      width = window.innerWidth;
      drawAll();
    });
    window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      // Paper is light: browsers change the scheme amid printing, when nothing may be drawn any more.
      if (!root.classList.contains("printing")) drawAll();
    });
    let wasOpen = false;
    const print = (isPrinting) => {
      root.classList.toggle("printing", isPrinting);
      if (isPrinting) wasOpen = byId("config").open;
      byId("config").open = isPrinting || wasOpen;
      drawAll();
    };
    window.addEventListener("beforeprint", () => print(true));
    window.addEventListener("afterprint", () => print(false));
    root.dataset.report = "drawn";
  }

  if (document.readyState === "complete") start();
  else window.addEventListener("load", start);
})();
