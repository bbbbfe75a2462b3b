// wasi: files in memory, and as much of WASI (preview 1) as the C library of the programs asks for.
//
//   const files = new Files();
//   const wasi = new Wasi(files, line => console.log(line));
//   const instance = await WebAssembly.instantiate(module, wasi.imports);
//   wasi.begin(instance);
'use strict';

// Files by path, without "/" in front; folders are names alone.
class Files {
    constructor() {
        this.list = new Map(); // path: { bytes: Uint8Array with room, size, changed, number }
        this.folders = new Map([['', 1]]); // path: number
        this.count = 1;
    }

    make(path) {
        const file = { bytes: new Uint8Array(1024), size: 0, changed: true, number: ++this.count };
        this.list.set(path, file);
        return file;
    }

    put(path, bytes) {
        const file = this.make(path);
        file.bytes = bytes.slice();
        file.size = bytes.length;
    }

    get(path) {
        const file = this.list.get(path);
        return file && file.bytes.subarray(0, file.size);
    }

    write(file, at, bytes) {
        const end = at + bytes.length;
        if (end > file.bytes.length) {
            const more = new Uint8Array(Math.max(end, 2 * file.bytes.length));
            more.set(file.bytes.subarray(0, file.size));
            file.bytes = more;
        }
        file.bytes.set(bytes, at);
        file.size = Math.max(file.size, end);
        file.changed = true;
    }

    makeFolder(path) {
        this.folders.set(path, ++this.count);
    }

    // Paths and bytes of a folder that are new since the last call.
    changes(folder) {
        const found = [];
        for (const [path, file] of this.list) {
            if (!file.changed || !path.startsWith(folder + '/')) continue;
            file.changed = false;
            found.push([path.slice(folder.length + 1), this.get(path).slice()]);
        }
        return found;
    }
}

class WasiExit extends Error {}

const WASI_ERROR = {
    done: 0, badFile: 8, exists: 20, invalid: 28, isFolder: 31, missing: 44, noSystem: 52, noFolder: 54,
};
const WASI_TYPE = { device: 2, folder: 3, file: 4 };
const WASI_ROOT = 3; // descriptor of the folder that all paths begin at

class Wasi {
    constructor(files, say) {
        this.files = files;
        this.say = say;
        this.open = new Map();
        this.next = WASI_ROOT + 1;
        this.text = '';
        this.imports = { wasi_snapshot_preview1: this.functions() };
    }

    begin(instance) {
        this.memory = instance.exports.memory;
        if (instance.exports._initialize) instance.exports._initialize();
    }

    view() {
        return new DataView(this.memory.buffer);
    }

    bytes(at, count) {
        return new Uint8Array(this.memory.buffer, at, count);
    }

    // A path without ".", ".." and slashes at the ends.
    path(at, count) {
        const parts = [];
        for (const part of new TextDecoder().decode(this.bytes(at, count)).split('/')) {
            if (part === '..') parts.pop();
            else if (part && part !== '.') parts.push(part);
        }
        return parts.join('/');
    }

    // Calls with each piece of a list of buffers until it takes none.
    pieces(list, count, use) {
        let sum = 0;
        for (let k = 0; k < count; k++) {
            const [at, length] = [0, 4].map(offset => this.view().getUint32(list + 8 * k + offset, true));
            const used = use(at, length);
            sum += used;
            if (used < length) break;
        }
        return sum;
    }

    stat(at, number, type, size) {
        this.bytes(at, 64).fill(0);
        this.view().setBigUint64(at + 8, BigInt(number), true);
        this.view().setUint8(at + 16, type);
        this.view().setBigUint64(at + 24, 1n, true);
        this.view().setBigUint64(at + 32, BigInt(size), true);
        return WASI_ERROR.done;
    }

    // What has gone to the standard streams, line by line.
    speak(bytes) {
        this.text += new TextDecoder().decode(bytes);
        const lines = this.text.split('\n');
        this.text = lines.pop();
        lines.forEach(line => this.say(line));
    }

    functions() {
        const E = WASI_ERROR, files = this.files;
        const above = path => path.split('/').slice(0, -1).join('/');
        const file = (fd, use) => (this.open.has(fd) ? use(this.open.get(fd)) : E.badFile);
        const known = {
            environ_sizes_get: (count, size) => {
                this.view().setUint32(count, 0, true);
                this.view().setUint32(size, 0, true);
                return E.done;
            },
            environ_get: () => E.done,
            clock_time_get: (clock, precision, at) => {
                const now = clock === 0 ? Date.now() : performance.now();
                this.view().setBigUint64(at, BigInt(Math.round(now * 1e6)), true);
                return E.done;
            },
            proc_exit: status => {
                throw new WasiExit(`the program ended with status ${status}`);
            },
            fd_prestat_get: (fd, at) => {
                if (fd !== WASI_ROOT) return E.badFile;
                this.view().setUint32(at, 0, true);
                this.view().setUint32(at + 4, 1, true);
                return E.done;
            },
            fd_prestat_dir_name: (fd, at) => {
                this.bytes(at, 1)[0] = 0x2f; // "/"
                return E.done;
            },
            fd_fdstat_get: (fd, at) => {
                const f = this.open.get(fd), standard = fd < WASI_ROOT ? WASI_TYPE.device : WASI_TYPE.folder;
                if (fd > WASI_ROOT && !f) return E.badFile;
                this.bytes(at, 24).fill(0);
                this.view().setUint8(at, f ? WASI_TYPE.file : standard);
                this.view().setUint16(at + 2, f && f.append ? 1 : 0, true);
                this.view().setBigUint64(at + 8, 0x1fffffffn, true);
                this.view().setBigUint64(at + 16, 0x1fffffffn, true);
                return E.done;
            },
            fd_fdstat_set_flags: () => E.done,
            fd_filestat_get: (fd, at) => file(fd, f => this.stat(at, f.file.number, WASI_TYPE.file, f.file.size)),
            fd_close: fd => (this.open.delete(fd) ? E.done : E.badFile),
            fd_seek: (fd, offset, from, at) => file(fd, f => {
                const start = from === 0 ? 0 : from === 1 ? f.at : f.file.size, to = start + Number(offset);
                if (to < 0) return E.invalid;
                f.at = to;
                this.view().setBigUint64(at, BigInt(to), true);
                return E.done;
            }),
            fd_read: (fd, list, count, at) => file(fd, f => {
                const sum = this.pieces(list, count, (to, length) => {
                    const part = f.file.bytes.subarray(f.at, Math.min(f.at + length, f.file.size));
                    this.bytes(to, part.length).set(part);
                    f.at += part.length;
                    return part.length;
                });
                this.view().setUint32(at, sum, true);
                return E.done;
            }),
            fd_write: (fd, list, count, at) => {
                const f = this.open.get(fd);
                if (!f && fd !== 1 && fd !== 2) return E.badFile;
                const sum = this.pieces(list, count, (from, length) => {
                    const part = this.bytes(from, length);
                    if (!f) this.speak(part.slice());
                    else {
                        if (f.append) f.at = f.file.size;
                        files.write(f.file, f.at, part);
                        f.at += length;
                    }
                    return length;
                });
                this.view().setUint32(at, sum, true);
                return E.done;
            },
            path_open: (fd, lookup, from, length, flags, rights, inherited, modes, at) => {
                const path = this.path(from, length), create = flags & 1, fresh = flags & 8;
                if (files.folders.has(path)) return E.isFolder;
                if (!files.list.has(path) && !create) return E.missing;
                if (!files.folders.has(above(path))) return E.missing;
                if (files.list.has(path) && create && flags & 4) return E.exists;
                const opened = files.list.get(path) || files.make(path);
                if (fresh) {
                    opened.size = 0;
                    opened.changed = true;
                }
                this.open.set(this.next, { file: opened, at: 0, append: (modes & 1) === 1 });
                this.view().setUint32(at, this.next++, true);
                return E.done;
            },
            path_filestat_get: (fd, lookup, from, length, at) => {
                const path = this.path(from, length), found = files.list.get(path);
                if (found) return this.stat(at, found.number, WASI_TYPE.file, found.size);
                if (!files.folders.has(path)) return E.missing;
                return this.stat(at, files.folders.get(path), WASI_TYPE.folder, 0);
            },
            path_create_directory: (fd, from, length) => {
                const path = this.path(from, length);
                if (files.folders.has(path) || files.list.has(path)) return E.exists;
                if (!files.folders.has(above(path))) return E.missing;
                files.makeFolder(path);
                return E.done;
            },
            path_remove_directory: (fd, from, length) => {
                const path = this.path(from, length);
                return !files.folders.has(path) ? E.noFolder : files.folders.delete(path) ? E.done : E.missing;
            },
            path_unlink_file: (fd, from, length) => (files.list.delete(this.path(from, length)) ? E.done : E.missing),
            path_rename: (fd, from, length, to, other, size) => {
                const path = this.path(from, length), found = files.list.get(path);
                if (!found) return E.missing;
                files.list.delete(path);
                files.list.set(this.path(other, size), found);
                found.changed = true;
                return E.done;
            },
        };
        // What no program here has a use for is refused.
        return new Proxy(known, { get: (all, name) => all[name] || (() => E.noSystem), has: () => true });
    }
}
