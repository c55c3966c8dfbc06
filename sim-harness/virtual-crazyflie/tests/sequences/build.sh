#!/bin/sh
# Assembles the programs with the compiler that builds the firmware: no other tool is needed.
# The same sources give the same bytes; `sequences.rs` does not do this by itself, so that the
# tests run without the cross target.
set -eu
cd "$(dirname "$0")"
work=$(mktemp -d)
trap 'rm -r "$work"' EXIT
for source in *.s; do
    name=${source%.s}
    [ "$name" = common ] && continue
    cat > "$work/$name.rs" <<RUST
#![no_std]
#![no_main]
core::arch::global_asm!(include_str!("$PWD/common.s"), options(raw));
core::arch::global_asm!(include_str!("$PWD/$source"), options(raw));
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! { loop {} }
RUST
    rustc --edition 2024 --target thumbv7em-none-eabihf -C panic=abort -C opt-level=s \
        -C link-arg=-T"$PWD/image.ld" -C link-arg=--oformat=binary -C link-arg=--build-id=none \
        -o "$work/$name.bin" "$work/$name.rs"
    install -m 644 "$work/$name.bin" "$name.bin"
done
