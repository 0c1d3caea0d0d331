// Turns the car and its rays: WebGL 2 and nothing else. Without it the page has its plans.
for (const box of document.querySelectorAll("[data-view]")) start(box);

function start(box) {
  const data = JSON.parse(document.getElementById(box.dataset.view).textContent);
  const canvas = box.querySelector("canvas");
  const gl = canvas.getContext("webgl2", { antialias: true, alpha: false, preserveDrawingBuffer: true });
  if (!gl) return;
  box.classList.add("drawn");
  const solid = program(gl,
    "#version 300 es\nin vec3 at; uniform mat4 look; uniform vec3 low, size; out vec3 where; void main() { where = low + size * at; gl_Position = look * vec4(where, 1.0); }",
    "#version 300 es\nprecision highp float; in vec3 where; uniform vec4 tone; uniform float lit; out vec4 colour; void main() { vec3 n = normalize(cross(dFdx(where), dFdy(where))); float light = 0.45 + 0.55 * abs(dot(n, normalize(vec3(0.3, 0.4, 0.85)))); colour = vec4(tone.rgb * mix(1.0, light, lit), tone.a); }");
  const points = buffer(gl, gl.ARRAY_BUFFER, new Uint16Array(bytes(data.points).buffer));
  const parts = data.parts.map((part) => {
    const list = new Uint32Array(bytes(part.triangles).buffer);
    return { tone: part.tone, count: list.length, buffer: buffer(gl, gl.ELEMENT_ARRAY_BUFFER, list) };
  });
  const rays = data.rays.map((part) => {
    const list = new Float32Array(bytes(part.ends).buffer);
    return { tone: part.tone, count: list.length / 3, buffer: buffer(gl, gl.ARRAY_BUFFER, list) };
  });
  let turn = 0.9, rise = 0.45, away = data.away, held = null;
  const draw = () => {
    const wide = canvas.clientWidth * devicePixelRatio, high = canvas.clientHeight * devicePixelRatio;
    canvas.width = wide; canvas.height = high;
    gl.viewport(0, 0, wide, high);
    gl.enable(gl.DEPTH_TEST); gl.clearColor(...panel(), 1); gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.useProgram(solid);
    const place = (name) => gl.getUniformLocation(solid, name);
    gl.uniformMatrix4fv(place("look"), false, camera(turn, rise, away, wide / high));
    gl.uniform3fv(place("low"), data.low); gl.uniform3fv(place("size"), data.size); gl.uniform1f(place("lit"), 1);
    const at = gl.getAttribLocation(solid, "at");
    gl.enableVertexAttribArray(at);
    gl.bindBuffer(gl.ARRAY_BUFFER, points); gl.vertexAttribPointer(at, 3, gl.UNSIGNED_SHORT, true, 0, 0);
    for (const part of parts) {
      gl.uniform4fv(place("tone"), part.tone); gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, part.buffer);
      gl.drawElements(gl.TRIANGLES, part.count, gl.UNSIGNED_INT, 0);
    }
    gl.enable(gl.BLEND); gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA); gl.depthMask(false);
    gl.uniform3fv(place("low"), [0, 0, 0]); gl.uniform3fv(place("size"), [1, 1, 1]); gl.uniform1f(place("lit"), 0);
    for (const part of rays) {
      gl.uniform4fv(place("tone"), part.tone); gl.bindBuffer(gl.ARRAY_BUFFER, part.buffer);
      gl.vertexAttribPointer(at, 3, gl.FLOAT, false, 0, 0); gl.drawArrays(gl.LINES, 0, part.count);
    }
    gl.depthMask(true); gl.disable(gl.BLEND);
  };
  canvas.onpointerdown = (event) => { held = [event.clientX, event.clientY]; canvas.setPointerCapture(event.pointerId); };
  canvas.onpointerup = () => { held = null; };
  canvas.onpointermove = (event) => {
    if (!held) return;
    turn -= 0.008 * (event.clientX - held[0]);
    rise = Math.min(1.5, Math.max(-0.1, rise + 0.006 * (event.clientY - held[1])));
    held = [event.clientX, event.clientY]; draw();
  };
  canvas.onwheel = (event) => { event.preventDefault(); away = Math.min(60, Math.max(3, away * Math.exp(0.001 * event.deltaY))); draw(); };
  new ResizeObserver(draw).observe(canvas);
  draw();
}

function bytes(text) { return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)); }

function buffer(gl, kind, data) {
  const made = gl.createBuffer();
  gl.bindBuffer(kind, made); gl.bufferData(kind, data, gl.STATIC_DRAW);
  return made;
}

function program(gl, vertex, fragment) {
  const made = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text); gl.compileShader(shader); gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  return made;
}

function camera(turn, rise, away, aspect) {
  const eye = [away * Math.cos(rise) * Math.cos(turn), away * Math.cos(rise) * Math.sin(turn), 0.8 + away * Math.sin(rise)];
  const f = unit([-eye[0], -eye[1], 0.8 - eye[2]]), s = unit([f[1], -f[0], 0]), u = [s[1] * f[2] - s[2] * f[1], s[2] * f[0] - s[0] * f[2], s[0] * f[1] - s[1] * f[0]];
  const dot = (a) => -(a[0] * eye[0] + a[1] * eye[1] + a[2] * eye[2]);
  const k = 2.2, near = 0.2, far = 200, a = -(far + near) / (far - near), b = (-2 * far * near) / (far - near);
  const d = -dot(f);
  return [k / aspect * s[0], k * u[0], -a * f[0], f[0], k / aspect * s[1], k * u[1], -a * f[1], f[1], k / aspect * s[2], k * u[2], -a * f[2], f[2], k / aspect * dot(s), k * dot(u), a * d + b, -d];
}

function panel() {
  const tone = getComputedStyle(document.documentElement).getPropertyValue("--panel").trim();
  return [1, 3, 5].map((place) => parseInt(tone.slice(place, place + 2), 16) / 255);
}

function unit(v) { const l = Math.hypot(...v); return v.map((x) => x / l); }
