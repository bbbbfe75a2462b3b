#!/bin/sh
# slow: weekly
# The header under WASI: a pin dissolves as it does natively, the program of scenes runs a template, and another zlib
# unpacks what the library has packed, with the vectors of browsers.
. tests/lib/script.sh
. tests/lib/wasi.sh
command -v node > /dev/null || skip_all "node is not installed"

cat > "$dir/run.mjs" << 'END'
import { WASI } from 'node:wasi';
import { readFile } from 'node:fs/promises';
const args = process.argv.slice(2);
const wasi = new WASI({ version: 'preview1', args, preopens: { '.': '.' }, returnOnExit: true });
const module = await WebAssembly.compile(await readFile(args[0]));
const instance = await WebAssembly.instantiate(module, wasi.getImportObject());
process.exit(wasi.start(instance));
END
flags='-std=c99 -O1 -ffp-contract=off -Wall -Wextra -Wpedantic -Wno-misleading-indentation -Werror -I.'
stack=-Wl,-z,stack-size=8388608

# shellcheck disable=SC2086
clang --target=wasm32-wasi $flags -DPDCORR_LINKED -DPDCORR_STATIC examples/04_pin.c -o "$dir/pin.wasm" -lm $stack \
    2> "$dir/log" && ${CC:-cc} $flags -DPDCORR_LINKED ${OMP:-} examples/04_pin.c "$build/pdcorr2d.o" -o "$dir/pin" -lm \
    2>> "$dir/log"
verdict "a pin compiles"
cd "$dir" || exit 1
./pin > native 2> log
timeout 120 node --no-warnings run.mjs pin.wasm > wasi 2> log
# the column of the ledger is rounding
cut -c 1-58 native > a
cut -c 1-58 wasi > b
[ -s a ] && cmp a b > log
verdict "a pin dissolves with the figures of the native program"
cd "$root" || exit 1

# shellcheck disable=SC2086
clang --target=wasm32-wasi $flags -DPD_DIM=2 drivers/scene.c -o "$dir/pd2d.wasm" -lm $stack 2> "$dir/log"
verdict "pd2d compiles"
scene=examples/scenes/templates/wire_2d.scene
"$programs/pd2d" $scene --out "$dir/native.out" --quiet > "$dir/native" 2> "$dir/log"
cp $scene "$dir"
(cd "$dir" && timeout 120 node --no-warnings run.mjs pd2d.wasm wire_2d.scene --out out --quiet > wasi 2> log)
verdict "pd2d runs a template"
figure() { tr ' ' '\n' < "$1" | sed -n 's/^volume_loss=//p'; }
figure "$dir/native" > "$dir/a"
figure "$dir/wasi" > "$dir/b"
paste "$dir/a" "$dir/b" | awk '{ d = $1 - $2; found++; wrong = wrong || d > 1e-12 || d < -1e-12 }
    END { exit !(found == 1 && !wrong) }'
verdict "pd2d: the loss of the native program"

for level in -O2 -Os -Oz; do
    # shellcheck disable=SC2086
    clang --target=wasm32-wasi -mexec-model=reactor -msimd128 $flags $level -Wno-unused-function -DPD_DIM=2 \
        tests/wasm/streams.c -o "$dir/streams.wasm" -lm $stack > "$dir/log" 2>&1 &&
        timeout 120 node --no-warnings tests/wasm/streams.mjs "$dir/streams.wasm" 300 > "$dir/log" 2>&1
    verdict "streams at $level"
done
score
