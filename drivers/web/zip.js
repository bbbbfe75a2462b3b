// zip: an archive of files, stored as they are.
'use strict';

const ZIP_CRC = new Uint32Array(256).map((_, k) => {
    for (let bit = 0; bit < 8; bit++) k = k & 1 ? (k >>> 1) ^ 0xedb88320 : k >>> 1;
    return k;
});

function zipCheck(bytes) {
    let crc = ~0;
    for (const byte of bytes) crc = ZIP_CRC[(crc ^ byte) & 255] ^ (crc >>> 8);
    return ~crc >>> 0;
}

// Fields of a record, [bytes, value] each, little end first.
function zipRecord(...fields) {
    const record = new Uint8Array(fields.reduce((sum, [size]) => sum + size, 0));
    let at = 0;
    for (const [size, value] of fields)
        for (let k = 0; k < size; k++) record[at++] = Math.floor(value / 256 ** k) & 255;
    return record;
}

// A Blob of the Map from names to bytes.
function zip(files) {
    const UTF8 = 0x800, VERSION = 20, now = new Date();
    const clock = (now.getHours() << 11) | (now.getMinutes() << 5) | (now.getSeconds() >> 1);
    const day = ((now.getFullYear() - 1980) << 9) | ((now.getMonth() + 1) << 5) | now.getDate();
    const parts = [], central = [];
    let at = 0, listed = 0;
    for (const [name, bytes] of files) {
        const path = new TextEncoder().encode(name);
        const what = [[2, VERSION], [2, UTF8], [2, 0], [2, clock], [2, day], [4, zipCheck(bytes)], [4, bytes.length],
                      [4, bytes.length], [2, path.length], [2, 0]];
        const head = zipRecord([4, 0x04034b50], ...what);
        const entry = zipRecord([4, 0x02014b50], [2, VERSION], ...what, [2, 0], [2, 0], [2, 0], [4, 0], [4, at]);
        parts.push(head, path, bytes);
        central.push(entry, path);
        at += head.length + path.length + bytes.length;
        listed += entry.length + path.length;
    }
    const count = [2, files.size];
    const end = zipRecord([4, 0x06054b50], [2, 0], [2, 0], count, count, [4, listed], [4, at], [2, 0]);
    return new Blob([...parts, ...central, end], { type: 'application/zip' });
}
