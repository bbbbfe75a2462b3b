// streams.mjs MODULE COUNT: the zlib of node unpacks so many streams of tests/wasm/streams.c; says which are wrong.
import { readFile } from 'node:fs/promises';
import { WASI } from 'node:wasi';
import { inflateSync } from 'node:zlib';

const [, , path, count] = process.argv;
const wasi = new WASI({ version: 'preview1' });
const module = await WebAssembly.compile(await readFile(path));
const instance = await WebAssembly.instantiate(module, wasi.getImportObject());
const of = instance.exports;
let wrong = 0;
wasi.initialize(instance);
for (let k = 0; k < Number(count); k++) {
    const size = of.make(k), bytes = (at, length) => Buffer.from(of.memory.buffer, at, length);
    let said = size < 0 ? 'not packed' : '';
    try {
        const back = inflateSync(bytes(of.packed_at(), of.packed_size()));
        if (!said && !back.equals(bytes(of.raw_at(), size))) said = 'other bytes';
    } catch (error) {
        said = error.message;
    }
    if (said) console.log(`stream ${k} of ${size} bytes: ${said}`);
    if (said) wrong++;
}
console.log(`${count} streams, ${wrong} wrong`);
process.exit(wrong > 0 ? 1 : 0);
