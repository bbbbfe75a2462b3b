// page: what the user sees. The scene and its messages, the run in a worker, field, curve, files.
'use strict';

const $ = id => document.getElementById(id);
const CHECK_AFTER = 300; // [ms] without a key
const PAINT = { outside: 0, fluid: 1, solid: 2, wall: 3 }; // pd_kind of the cells
const PLACE = { fluid: 0, metal: 1, both: 2, all: 3 }; // of the values of a field: pd_field_place

// ---- what is embedded ----

const embedded = kind => [...document.querySelectorAll(`script.${kind}`)].map(
    s => ({ name: s.dataset.name, group: s.dataset.group, text: s.textContent.replace(/^\n/, '') }));
const scenes = embedded('scene');
const besides = embedded('beside').map(file => [file.name, new TextEncoder().encode(file.text)]); // that scenes read
const programs = new Map();

// The program of a dimension: gzip in base64. All workers share what has been compiled.
async function program(dim) {
    if (!programs.has(dim)) {
        const packed = Uint8Array.from(atob($('wasm' + dim).textContent), c => c.charCodeAt(0));
        const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('gzip'));
        programs.set(dim, WebAssembly.compile(await new Response(stream).arrayBuffer()));
    }
    return programs.get(dim);
}

// How many axes a scene has: the ranges of its box. 2 where it does not say.
function dimension(text) {
    const plain = text.replace(/#.*/g, ''), grid = /\[grid\]([^[]*)/.exec(plain);
    const box = grid && /\bbox\s*=(.*?)([A-Za-z_]\w*\s*=|$)/s.exec(grid[1]);
    const ranges = box ? box[1].split('..').length - 1 : 2;
    return ranges >= 1 && ranges <= 3 ? ranges : 2;
}

const workerUrl = URL.createObjectURL(new Blob([$('worker-text').textContent], { type: 'text/javascript' }));

function engine(hear) {
    const worker = new Worker(workerUrl);
    worker.onmessage = event => hear(event.data);
    worker.onerror = event => hear({ is: 'end', how: 'failed', message: event.message });
    return worker;
}

// ---- numbers ----

function digits(value, count = 4) {
    if (!Number.isFinite(value)) return '–';
    const size = Math.abs(value), plain = size === 0 || (size < 1e5 && size >= 1e-3);
    return plain ? String(+value.toPrecision(count)) : value.toExponential(count - 2);
}

function duration(seconds) {
    if (!(seconds >= 0) || seconds === Infinity) return '–';
    if (seconds < 60) return `${digits(seconds, 3)} s`;
    if (seconds < 3600) return `${digits(seconds / 60, 3)} min`;
    return seconds < 172800 ? `${digits(seconds / 3600, 4)} h` : `${digits(seconds / 86400, 4)} d`;
}

function bytesText(count) {
    if (count < 1e4) return `${count} B`;
    return count < 1e6 ? `${Math.round(count / 1e3)} kB` : `${(count / 1e6).toFixed(1)} MB`;
}

// "[mol/m3]" of "C [mol/m3]"
const unitOf = field => (/\[.*\]/.exec(field.label) || [''])[0];

// ---- the scene ----

const editor = $('editor');
let sceneName = '', checks = 0, checker = null, checkTimer = 0, wrongLine = 0;

function showLines() {
    const count = editor.value.split('\n').length, gutter = $('gutter');
    gutter.replaceChildren();
    for (let k = 1; k <= count; k++) {
        const line = k === wrongLine ? document.createElement('b') : document.createTextNode(String(k));
        if (k === wrongLine) line.textContent = String(k);
        gutter.append(line, '\n');
    }
    scrollLines();
}

function scrollLines() {
    const style = getComputedStyle(editor), height = parseFloat(style.lineHeight), top = parseFloat(style.paddingTop);
    const y = top + (wrongLine - 1) * height - editor.scrollTop;
    $('gutter').scrollTop = editor.scrollTop;
    $('mark').style.top = `${y}px`;
    $('mark').style.height = `${height}px`;
    $('bubble').style.top = `${y + height + 2}px`;
}

// A message of the library: "NAME:LINE: column N: what was found and expected".
function showMessage(message) {
    const at = /^[^:]*:(\d+): (?:column (\d+): )?(.*)$/s.exec(message);
    wrongLine = at ? +at[1] : 0;
    const place = at ? `Line ${at[1]}${at[2] ? `, column ${at[2]}` : ''}: ` : '';
    $('verdict').textContent = at ? place + at[3] : message || 'The scene can be read.';
    $('verdict').classList.toggle('bad', message !== '');
    $('verdict').dataset.column = at && at[2] ? at[2] : '1';
    $('mark').hidden = $('bubble').hidden = !at;
    $('bubble').textContent = at ? at[3] : '';
    editor.setAttribute('aria-invalid', String(message !== ''));
    showLines();
}

function goToMessage() {
    if (!wrongLine) return;
    const lines = editor.value.split('\n');
    const before = lines.slice(0, wrongLine - 1).reduce((sum, line) => sum + line.length + 1, 0);
    editor.focus();
    editor.setSelectionRange(before + (+$('verdict').dataset.column - 1), before + lines[wrongLine - 1].length);
    editor.scrollTop = Math.max(0, (wrongLine - 4) * parseFloat(getComputedStyle(editor).lineHeight));
}

async function check() {
    const id = ++checks, text = editor.value, dim = dimension(text);
    checker = checker || engine(said => said.id === checks && showMessage(said.message));
    checker.postMessage({ act: 'check', id, dim, wasm: await program(dim), name: sceneName, text, files: besides });
}

function choose(index) {
    sceneName = scenes[index].name;
    editor.value = scenes[index].text;
    editor.scrollTop = editor.scrollLeft = 0;
    showMessage('');
    check();
}

// ---- the run ----

let worker = null, state = 'ready', began = 0, waited = 0, pausedAt = 0, stopAsked = false;
let files = new Map(), urls = new Map(), history = [], frame = null, lattice = null, maps = null;

function setState(now, text) {
    state = now;
    $('state').textContent = text || now;
    const busy = now === 'running' || now === 'paused' || now === 'stopping';
    $('run').disabled = busy;
    $('pause').disabled = now !== 'running' && now !== 'paused';
    $('pause').textContent = now === 'paused' ? 'Go on' : 'Pause';
    $('stop').disabled = !busy;
    $('stop').textContent = now === 'stopping' ? 'Stop at once' : 'Stop';
    document.body.dataset.state = now;
}

async function start() {
    setState('running', 'builds the model');
    files = new Map();
    urls.forEach(url => URL.revokeObjectURL(url));
    urls.clear();
    history = [];
    frame = lattice = null;
    $('log').textContent = '';
    $('progress').value = 0;
    ['time', 'steps', 'dt', 'loss', 'imbalance', 'left'].forEach(id => ($(id).textContent = '–'));
    showFiles();
    drawPlot();
    const text = editor.value, dim = dimension(text), wasm = await program(dim);
    began = performance.now();
    waited = 0;
    if (worker) worker.terminate();
    worker = engine(hear);
    worker.postMessage({ act: 'run', dim, wasm, name: sceneName, text, files: besides });
}

function hear(said) {
    if (said.is === 'began') {
        maps = said.maps;
        $('version').textContent = `pdcorr ${said.version}`;
    } else if (said.is === 'box') lattice = said;
    else if (said.is === 'instant') showInstant(said);
    else if (said.is === 'fields') {
        frame = said;
        showFields();
    } else if (said.is === 'line') {
        $('log').textContent += said.text + '\n';
    } else if (said.is === 'files') {
        for (const [name, bytes] of said.changes) {
            files.set(name, bytes);
            URL.revokeObjectURL(urls.get(name));
            urls.delete(name);
        }
        showFiles();
    } else if (said.is === 'end') end(said);
}

function end(said) {
    const spent = duration((performance.now() - began - waited) / 1000);
    if (worker) worker.terminate();
    worker = null;
    if (said.how === 'failed') {
        showMessage(said.message);
        $('log').textContent += said.message + '\n';
    }
    if (said.how === 'done') $('progress').value = 1;
    setState(said.how, `${said.how === 'done' ? 'done' : said.how} after ${spent}`);
    $('left').textContent = '–';
}

function pause() {
    const goes = state === 'paused';
    if (goes) waited += performance.now() - pausedAt;
    else pausedAt = performance.now();
    worker.postMessage({ act: goes ? 'go' : 'pause' });
    setState(goes ? 'running' : 'paused');
}

// The run ends with the files of its last step; the second time it ends at once, with those that are there.
function stop() {
    if (state === 'stopping') return end({ how: 'stopped' });
    if (state === 'paused') waited += performance.now() - pausedAt;
    worker.postMessage({ act: 'stop' });
    setState('stopping', 'ends after this step');
}

function showInstant(at) {
    if (state === 'running') $('state').textContent = 'running';
    const last = history[history.length - 1];
    if (!last || at.time > last.time) history.push(at);
    const spent = (performance.now() - began - waited) / 1000, share = at.until > 0 ? at.time / at.until : 0;
    $('progress').value = share;
    $('time').textContent = `${duration(at.time)} of ${duration(at.until)}`;
    $('steps').textContent = String(at.steps);
    $('dt').textContent = at.steps ? duration(at.dt) : '–';
    $('loss').textContent = `${digits(100 * at.loss)} %`;
    $('imbalance').textContent = digits(at.imbalance, 3);
    $('left').textContent = share > 0 && share < 1 ? duration((spent * (1 - share)) / share) : '–';
    soon(drawPlot);
}

// ---- the field ----

const shown = () => frame && (frame.list.find(f => f.name === $('field').value) || frame.list[0]);

function showFields() {
    const choice = $('field'), names = frame.list.map(f => f.name), before = choice.value;
    if ([...choice.options].map(o => o.value).join() !== names.join()) {
        choice.disabled = false;
        choice.replaceChildren(...frame.list.map(f => new Option(f.label, f.name)));
        choice.value = [before, 'C', 'u', 'density'].find(name => names.includes(name)) || names[0];
        if (choice.value !== before) $('low').value = $('high').value = '';
    }
    soon(drawField);
}

// What a cell shows: the field, or what stands there (see the pictures of the programs).
function painted(field, kind, k) {
    if (field.place === PLACE.all || !kind) return PAINT.fluid;
    const at = kind.values[k];
    if (at === PAINT.wall || at === PAINT.outside) return PAINT.wall;
    if (at === PAINT.solid) return field.place === PLACE.fluid ? PAINT.solid : PAINT.fluid;
    return field.place === PLACE.metal ? PAINT.outside : PAINT.fluid;
}

function range(field, kind) {
    let low = Infinity, high = -Infinity;
    field.values.forEach((value, k) => {
        if (painted(field, kind, k) !== PAINT.fluid || !Number.isFinite(value)) return;
        low = Math.min(low, value);
        high = Math.max(high, value);
    });
    if (low > high) low = high = 0;
    if (Math.abs(low) < 1e-9 * high) low = 0;
    if (field.map === 1) high = Math.max(-low, high), low = -high;
    const given = id => ($(id).value.trim() === '' || !Number.isFinite(+$(id).value) ? null : +$(id).value);
    return [given('low') ?? low, given('high') ?? high];
}

function cssColour(name) {
    const hex = getComputedStyle(document.documentElement).getPropertyValue(name).trim();
    return [1, 3, 5].map(k => parseInt(hex.slice(k, k + 2), 16));
}

const waiting = new Set();

// Draws before the screen is painted next, once for all that have asked.
function soon(draw) {
    if (waiting.has(draw)) return;
    waiting.add(draw);
    requestAnimationFrame(() => {
        waiting.delete(draw);
        draw();
    });
}

// A canvas with as many pixels as the screen has there.
function context(canvas) {
    const ratio = window.devicePixelRatio || 1, box = canvas.getBoundingClientRect();
    canvas.width = Math.max(1, Math.round(box.width * ratio));
    canvas.height = Math.max(1, Math.round(box.height * ratio));
    const c = canvas.getContext('2d');
    c.scale(ratio, ratio);
    return [c, box.width, box.height];
}

// Axes that the picture shows, with low and high ends [m].
function sides() {
    const free = [0, 1, 2].filter(d => d < lattice.dim && (lattice.dim < 3 || d !== lattice.axis));
    const names = lattice.aroundAxis ? 'xr' : 'xyz';
    return free.map(d => ({ name: names[d], low: lattice.low[d], high: lattice.high[d] }));
}

function lengthText(metres) {
    const size = Math.abs(metres);
    return size === 0 ? '0' : size < 1e-6 ? `${digits(metres * 1e9)} nm` : size < 1e-3 ? `${digits(metres * 1e6)} µm`
        : size < 1 ? `${digits(metres * 1e3)} mm` : `${digits(metres)} m`;
}

// Around an axis both halves are drawn.
const isMirrored = () => lattice.aroundAxis && lattice.low[1] <= 0;

// [px] as high as the box is at the width that there is, within reason.
function pictureHeight() {
    if (lattice.dim === 1) return 260;
    const [x, y] = sides(), mirrored = isMirrored();
    const shape = ((mirrored ? 2 : 1) * y.high - (mirrored ? 0 : y.low)) / (x.high - x.low);
    return Math.round(Math.min(460, Math.max(90, shape * $('picture').clientWidth)));
}

let placed = null; // where the picture stands in its canvas

function drawField() {
    const field = shown();
    if (!field || !maps || !lattice) return;
    const kind = frame.list.find(f => f.name === 'kind'), [low, high] = range(field, kind), labels = field.map === 2;
    const table = maps[field.map], colour = value => {
        if (!Number.isFinite(value)) return 0xff00ff;
        if (labels) return table[((value % 256) + 256) % 256];
        const share = high > low ? (value - low) / (high - low) : 0.5;
        return table[Math.max(0, Math.min(255, Math.round(255 * share)))];
    };
    document.querySelector('.bar').style.visibility = labels || lattice.dim === 1 ? 'hidden' : 'visible';
    ['low', 'high'].forEach(id => ($(id).disabled = labels));
    if (!labels) {
        $('bar-low').textContent = digits(low, 3);
        $('bar-high').textContent = `${digits(high, 3)} ${unitOf(field)}`;
        const bar = $('bar').getContext('2d'), line = bar.createImageData(256, 1);
        table.forEach((c, k) => line.data.set([c >> 16, (c >> 8) & 255, c & 255, 255], 4 * k));
        bar.putImageData(line, 0, 0);
    }
    $('picture').style.height = `${pictureHeight()}px`;
    const [c, width, height] = context($('picture'));
    if (lattice.dim === 1) drawRow(c, width, height, field, kind, low, high);
    else drawCells(c, width, height, field, kind, colour);
    const name = field.label.replace(/[[\]]/g, ''), time = duration(frame.time);
    const span = labels ? '' : `, from ${digits(low)} to ${digits(high)}`;
    $('picture').setAttribute('aria-label', `${name} at ${time}${span}`);
    if (!$('readout').dataset.held) $('readout').textContent = placeText();
}

function drawCells(c, width, height, field, kind, colour) {
    const [x, y] = sides(), mirrored = isMirrored(), rows = mirrored ? 2 * field.ny : field.ny;
    const cells = document.createElement('canvas');
    cells.width = field.nx;
    cells.height = rows;
    const all = cells.getContext('2d'), image = all.createImageData(field.nx, rows);
    const still = [];
    still[PAINT.solid] = cssColour('--solid');
    still[PAINT.wall] = cssColour('--wall');
    still[PAINT.outside] = cssColour('--card');
    for (let row = 0; row < rows; row++) {
        const up = rows - 1 - row, j = !mirrored ? up : up < field.ny ? field.ny - 1 - up : up - field.ny;
        for (let i = 0; i < field.nx; i++) {
            const k = j * field.nx + i, at = 4 * (row * field.nx + i), paint = painted(field, kind, k);
            const rgb = paint === PAINT.fluid ? colour(field.values[k]) : 0;
            image.data.set(still[paint] || [rgb >> 16, (rgb >> 8) & 255, rgb & 255], at);
            image.data[at + 3] = 255;
        }
    }
    all.putImageData(image, 0, 0);
    const low = mirrored ? -y.high : y.low, scale = Math.min(width / (x.high - x.low), height / (y.high - low));
    const w = (x.high - x.low) * scale, h = (y.high - low) * scale;
    placed = { left: (width - w) / 2, top: (height - h) / 2, w, h, mirrored };
    Object.assign(placed, { low: [x.low, low], high: [x.high, y.high] });
    c.imageSmoothingEnabled = false;
    c.drawImage(cells, placed.left, placed.top, w, h);
}

function drawRow(c, width, height, field, kind, low, high) {
    const [x] = sides(), points = [];
    field.values.forEach((value, k) => {
        const at = x.low + ((k + 0.5) / field.nx) * (x.high - x.low);
        points.push([at, painted(field, kind, k) === PAINT.fluid ? value : NaN]);
    });
    placed = null;
    drawCurve(c, width, height, points, { x: [x.low, x.high], y: [low, high] }, lengthText, value => digits(value, 3));
}

function placeText() {
    const where = sides().map(s => `${s.name} ${lengthText(s.low)} to ${lengthText(s.high)}`).join(', ');
    return `${duration(frame.time)}; ${where}`;
}

// The value under the pointer.
function point(event) {
    if (!placed || !frame) return;
    const box = $('picture').getBoundingClientRect(), u = (event.clientX - box.left - placed.left) / placed.w;
    const v = 1 - (event.clientY - box.top - placed.top) / placed.h, f = shown();
    if (u < 0 || u >= 1 || v < 0 || v >= 1) return leave();
    const [x, y] = [u, v].map((share, d) => placed.low[d] + share * (placed.high[d] - placed.low[d]));
    const row = placed.mirrored ? Math.floor(Math.abs(2 * v - 1) * f.ny) : Math.floor(v * f.ny);
    const value = f.values[Math.min(row, f.ny - 1) * f.nx + Math.floor(u * f.nx)], [a, b] = sides();
    $('readout').dataset.held = 'yes';
    const where = `${a.name} = ${lengthText(x)}, ${b.name} = ${lengthText(y)}`;
    $('readout').textContent = `${where}: ${digits(value)} ${unitOf(f)}`;
}

function leave() {
    delete $('readout').dataset.held;
    if (frame && lattice) $('readout').textContent = placeText();
}

// ---- curves ----

// Rising round numbers between both ends.
function ticks(low, high, most) {
    const raw = (high - low) / most, ten = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].map(k => k * ten).find(k => k >= raw);
    const found = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(k * step);
    return found;
}

function drawCurve(c, width, height, points, ends, xText, yText) {
    const style = getComputedStyle(document.documentElement), colour = name => style.getPropertyValue(name).trim();
    const room = { left: 62, right: 16, top: 10, bottom: 26 };
    const w = width - room.left - room.right, h = height - room.top - room.bottom;
    let [low, high] = ends.y;
    if (!(high > low)) [low, high] = [low - 0.5 * Math.abs(low || 1), high + 0.5 * Math.abs(high || 1)];
    const [first, last] = ends.x, x = v => room.left + ((v - first) / (last - first || 1)) * w;
    const y = v => room.top + h - ((v - low) / (high - low)) * h;
    c.font = '12px system-ui, sans-serif';
    c.lineWidth = 1;
    c.fillStyle = colour('--soft');
    c.strokeStyle = colour('--line');
    c.textAlign = 'right';
    c.textBaseline = 'middle';
    for (const tick of ticks(low, high, 4)) {
        c.beginPath();
        c.moveTo(room.left, Math.round(y(tick)) + 0.5);
        c.lineTo(room.left + w, Math.round(y(tick)) + 0.5);
        c.stroke();
        c.fillText(yText(tick), room.left - 6, y(tick));
    }
    c.textBaseline = 'top';
    const at = ticks(first, last > first ? last : first + 1, Math.max(2, Math.floor(w / 110)));
    at.forEach(tick => {
        c.textAlign = x(tick) > room.left + w - 20 ? 'right' : 'center';
        c.fillText(xText(tick), x(tick), room.top + h + 8);
    });
    c.strokeStyle = colour('--accent');
    c.lineWidth = 2;
    c.lineJoin = 'round';
    c.beginPath();
    let draws = false;
    for (const [u, v] of points) {
        if (Number.isFinite(v)) draws ? c.lineTo(x(u), y(v)) : c.moveTo(x(u), y(v));
        draws = Number.isFinite(v);
    }
    c.stroke();
}

function drawPlot() {
    const [c, width, height] = context($('plot')), what = $('curve').value;
    if (history.length === 0 || !(history[0].until > 0)) return;
    const scale = what === 'loss' ? 100 : 1, shows = history.filter(at => what !== 'dt' || at.steps > 0);
    const points = shows.map(at => [at.time, scale * at[what]]);
    if (points.length === 0) return;
    const until = history[0].until, values = points.map(p => p[1]);
    const unit = until < 300 ? [1, 's'] : until < 7200 ? [60, 'min'] : until < 300000 ? [3600, 'h'] : [86400, 'd'];
    const ends = { x: [0, until / unit[0]], y: [Math.min(0, ...values), Math.max(...values)] };
    const inUnit = points.map(([t, v]) => [t / unit[0], v]);
    drawCurve(c, width, height, inUnit, ends, v => `${digits(v)} ${unit[1]}`, v => digits(v, 3));
    const last = history[history.length - 1], name = $('curve').selectedOptions[0].textContent;
    $('plot').setAttribute('aria-label', `${name}: ${digits(scale * last[what])} at ${duration(last.time)}`);
}

// ---- files ----

const kinds = { png: 'image/png', csv: 'text/csv', vti: 'application/xml', pvd: 'application/xml' };

function link(name) {
    if (!urls.has(name)) {
        const bytes = files.get(name), kind = kinds[name.split('.').pop()] || 'text/plain';
        urls.set(name, URL.createObjectURL(new Blob([bytes], { type: kind })));
    }
    return urls.get(name);
}

function showFiles() {
    const sum = [...files.values()].reduce((all, bytes) => all + bytes.length, 0), none = files.size === 0;
    const what = none ? 'A run writes VTI for ParaView, PNG and CSV.' : `${files.size} files, ${bytesText(sum)}`;
    $('files-note').textContent = what;
    $('zip').classList.toggle('off', none);
    $('zip').setAttribute('aria-disabled', String(none));
    if (none) $('zip').removeAttribute('href');
    else $('zip').href = '#';
    const names = [...files.keys()].sort((a, b) => a.localeCompare(b, 'en', { numeric: true }));
    $('files').replaceChildren(...names.map(name => {
        const [item, a, size] = ['li', 'a', 'span'].map(tag => document.createElement(tag));
        a.textContent = name;
        a.href = '#';
        a.dataset.name = name;
        a.download = name;
        size.textContent = bytesText(files.get(name).length);
        item.append(a, size);
        return item;
    }));
}

function download(href, name) {
    const a = document.createElement('a');
    a.href = href;
    a.download = name;
    a.click();
}

function downloadAll() {
    const url = URL.createObjectURL(zip(files));
    download(url, `${sceneName.replace(/\.scene$/, '')}.zip`);
    setTimeout(() => URL.revokeObjectURL(url), 60000);
}

// ---- all of it ----

function dark(is) {
    document.documentElement.classList.toggle('dark', is);
    soon(drawField);
    soon(drawPlot);
}

function begin() {
    const groups = new Map();
    scenes.forEach((scene, k) => {
        const group = groups.get(scene.group) || document.createElement('optgroup');
        group.label = scene.group;
        groups.set(scene.group, group);
        group.append(new Option(scene.name.replace(/\.scene$/, ''), k));
    });
    $('choice').append(...groups.values());
    $('choice').onchange = () => choose(+$('choice').value);
    editor.addEventListener('scroll', scrollLines);
    editor.addEventListener('input', () => {
        showLines();
        clearTimeout(checkTimer);
        checkTimer = setTimeout(check, CHECK_AFTER);
    });
    editor.addEventListener('keydown', event => {
        if (event.key === 'Enter' && (event.ctrlKey || event.metaKey) && !$('run').disabled) start();
    });
    $('verdict').onclick = goToMessage;
    $('run').onclick = start;
    $('pause').onclick = pause;
    $('stop').onclick = stop;
    $('field').onchange = () => {
        $('low').value = $('high').value = '';
        drawField();
    };
    $('low').oninput = $('high').oninput = drawField;
    $('curve').onchange = drawPlot;
    $('picture').onpointermove = point;
    $('picture').onpointerleave = leave;
    $('zip').onclick = event => {
        event.preventDefault();
        if (files.size) downloadAll();
    };
    $('files').onclick = event => {
        const name = event.target.dataset.name;
        if (name) event.target.href = link(name);
    };
    const prefers = matchMedia('(prefers-color-scheme: dark)');
    prefers.onchange = () => dark(prefers.matches);
    $('theme').onclick = () => dark(!document.documentElement.classList.contains('dark'));
    window.onresize = () => {
        soon(drawField);
        soon(drawPlot);
    };
    dark(prefers.matches);
    setState('ready');
    $('choice').value = String(Math.max(0, scenes.findIndex(scene => scene.name === 'mg_pin_2d.scene')));
    choose(+$('choice').value);
}

begin();
