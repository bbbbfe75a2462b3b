// worker: checks and runs scenes. Behind wasi.js in one script.
//
//   page -> worker  { act: 'check' | 'run' | 'pause' | 'go' | 'stop', dim, wasm, name, text, files }; wasm: a module
//   worker -> page  { is: 'checked' | 'began' | 'box' | 'instant' | 'fields' | 'line' | 'files' | 'end', ... }
'use strict';

const FIELDS = 1, ENDS = 2; // answers, see web.c
const RESULT = 3; // a pd_print_kind
const WHEN = { start: 0, step: 1, end: 2 };
const SLICE = 300; // [ms] a run hears the page at least so often, as far as steps allow
const BUILD_SHARE = 12; // a slice is longer than its building so many times
const SHOW_EVERY = 150; // [ms] between fields
const FOLDER = 'run';
const OWN = /\.part$|^(checkpoint|pictures)\.bin$|^pdcorr\.lock$/; // files that are not for the user

const files = new Files();
const engines = new Map(); // of the dimensions
let run = null;

class Engine {
    async begin(wasm) {
        const wasi = new Wasi(files, line => postMessage({ is: 'line', kind: 1, text: line }));
        const page = {
            print: (kind, text) => run.lines.push({ is: 'line', kind, text: this.text(text) }),
            box: (...lattice) => run.box(this, ...lattice),
            instant: (...figures) => run.instant(...figures),
            field: (...field) => run.field(this, ...field),
            shown: () => postMessage({ is: 'fields', time: run.fieldTime, list: run.fields }),
        };
        const instance = await WebAssembly.instantiate(wasm, { ...wasi.imports, page });
        this.out = instance.exports;
        wasi.begin(instance);
    }

    // A loop in place of indexOf: that of Firefox leaves the upper halves of vector registers in use, and on some
    // processors what the thread then computes takes ten times as long.
    text(at) {
        const all = new Uint8Array(this.out.memory.buffer, at);
        let end = 0;
        while (all[end]) end++;
        return new TextDecoder().decode(all.slice(0, end));
    }

    // Calls with texts in the memory of the program; the others are numbers.
    call(name, ...values) {
        const texts = [];
        const given = values.map(value => {
            if (typeof value !== 'string') return value;
            const bytes = new TextEncoder().encode(value), at = this.out.web_room(bytes.length + 1);
            const room = new Uint8Array(this.out.memory.buffer, at, bytes.length + 1);
            room.set(bytes);
            room[bytes.length] = 0;
            texts.push(at);
            return at;
        });
        const status = this.out[name](...given);
        texts.forEach(at => this.out.web_drop(at));
        return status;
    }

    numbers(at, count) {
        return new Uint32Array(this.out.memory.buffer, at, count).slice();
    }

    message() {
        return this.text(this.out.web_message());
    }
}

async function engine(dim, wasm) {
    if (!engines.has(dim)) {
        const made = new Engine();
        await made.begin(wasm);
        engines.set(dim, made);
    }
    return engines.get(dim);
}

class Run {
    constructor(task) {
        this.task = task;
        this.state = 'runs';
        this.slice = SLICE;
        this.shown = this.flushed = -Infinity;
        this.lines = [];
    }

    box(of, dim, cells, low, high, aroundAxis, axis, slice) {
        const numbers = at => [...new Float64Array(of.out.memory.buffer, at, dim)];
        this.lattice = {
            dim, cells: [...new Int32Array(of.out.memory.buffer, cells, dim)], low: numbers(low), high: numbers(high),
            aroundAxis: aroundAxis !== 0, axis, slice,
        };
        if (!this.told) postMessage({ is: 'box', ...this.lattice });
        this.told = true;
    }

    instant(when, time, dt, until, steps, loss, speed, concentration, imbalance) {
        const now = performance.now();
        if (now - this.flushed > SHOW_EVERY) this.flush();
        if (when === WHEN.start && this.goesOn) { // built again
            this.slice = Math.max(SLICE, BUILD_SHARE * (now - this.begun));
            this.stepped = now;
            return 0;
        }
        if (when === WHEN.start) this.stepped = now;
        const figures = { time, dt, until, steps, loss, speed, concentration, imbalance };
        if (when !== WHEN.end) postMessage({ is: 'instant', ...figures });
        const ends = when === WHEN.step && (this.state === 'stops' || now - this.stepped > this.slice);
        const last = when === WHEN.end && (time >= until || this.state === 'stops');
        const shows = when === WHEN.start || last || (when === WHEN.step && (ends || now - this.shown > SHOW_EVERY));
        if (shows) {
            this.shown = now;
            this.fields = [];
            this.fieldTime = time;
        }
        return (shows ? FIELDS : 0) | (ends ? ENDS : 0);
    }

    // The drawn plane of a field, in single precision; of vectors the length.
    field(of, name, label, data, components, map, place) {
        const { dim, cells, axis, slice } = this.lattice, all = cells.reduce((a, b) => a * b, 1);
        const from = new Float64Array(of.out.memory.buffer, data, components * all);
        const stride = [1, cells[0], cells[0] * (cells[1] || 1)];
        const [right, up] = [0, 1, 2].filter(d => d < dim && (dim < 3 || d !== axis));
        const nx = cells[right], ny = dim > 1 ? cells[up] : 1, values = new Float32Array(nx * ny);
        for (let j = 0; j < ny; j++)
            for (let i = 0; i < nx; i++) {
                const at = i * stride[right] + (dim > 1 ? j * stride[up] : 0) + (dim > 2 ? slice * stride[axis] : 0);
                let sum = 0;
                for (let c = 0; c < components; c++) sum += from[at + c * all] ** 2;
                values[j * nx + i] = components > 1 ? Math.sqrt(sum) : from[at];
            }
        this.fields.push({ name: of.text(name), label: of.text(label), map, place, nx, ny, values });
    }

    // Files that are new since the last time, to the page.
    flush() {
        this.flushed = performance.now();
        const changes = files.changes(FOLDER).filter(([name]) => !OWN.test(name));
        if (changes.length) postMessage({ is: 'files', changes });
    }

    async all() {
        const { dim, wasm, name, text } = this.task, works = await engine(dim, wasm);
        files.makeFolder(FOLDER);
        postMessage({ is: 'began', version: works.text(works.out.web_version()), maps: [
            works.numbers(works.out.web_colours(0), 256), works.numbers(works.out.web_colours(1), 256),
            works.numbers(works.out.web_labels(), 256)] });
        let status = 1;
        while (status === 1) {
            this.begun = performance.now();
            const stops = this.state === 'stops';
            status = works.call('web_run', name, text, FOLDER, this.goesOn ? 1 : 0, stops ? 0 : 1);
            const over = stops || status !== 1;
            // each slice says all of it: what is modelled is news in the first one, figures are in the last
            this.lines.filter(line => (line.kind === RESULT ? over : !this.goesOn)).forEach(line => postMessage(line));
            this.lines = [];
            this.goesOn = true;
            this.flush();
            if (status === 1 && stops) return postMessage({ is: 'end', how: 'stopped' });
            if (status === 1) await this.hear();
        }
        if (status < 0) return postMessage({ is: 'end', how: 'failed', message: works.message() });
        postMessage({ is: 'end', how: 'done' });
    }

    // Lets messages of the page in; returns when the run may go on.
    hear() {
        return new Promise(go => {
            this.go = go;
            setTimeout(() => this.state !== 'pauses' && go());
        });
    }
}

async function act(task) {
    if (task.files) for (const [name, bytes] of task.files) files.put(name, bytes);
    if (task.act === 'check') {
        const works = await engine(task.dim, task.wasm), status = works.call('web_check', task.name, task.text);
        postMessage({ is: 'checked', id: task.id, message: status < 0 ? works.message() : '' });
    } else if (task.act === 'run') {
        run = new Run(task);
        await run.all();
    } else if (task.act === 'pause') run.state = 'pauses';
    else {
        run.state = task.act === 'stop' ? 'stops' : 'runs';
        if (run.go) run.go();
    }
}

onmessage = event => act(event.data).catch(error => {
    postMessage({ is: 'end', how: 'failed', message: String(error.message || error) });
});
