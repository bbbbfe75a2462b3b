# wasi: skips a test where clang cannot compile and link for WebAssembly. Sourced behind script.sh.

for tool in clang wasm-ld; do command -v $tool > /dev/null || skip_all "$tool is not installed"; done
printf 'int main(void) { return 0; }\n' > "$dir/p.c"
clang --target=wasm32-wasi "$dir/p.c" -o "$dir/p.wasm" 2> /dev/null || skip_all "there is no wasi-libc"
