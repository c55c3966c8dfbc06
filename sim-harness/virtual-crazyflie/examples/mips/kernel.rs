//! About the computation of a flight controller in a millisecond: an attitude filter, three
//! controllers, the propagation of a covariance, and some bytes that are packed and checked.
//!
//! `kernel.bin` is made of it by
//!
//! ```text
//! rustc --edition 2024 --target thumbv7em-none-eabihf -C opt-level=s -C target-cpu=cortex-m4 \
//!     -C panic=abort --crate-type bin -C linker=rust-lld -C link-arg=-Ttext=0x08004000 \
//!     -C link-arg=-estart kernel.rs -o kernel.elf
//! llvm-objcopy -O binary -j .text kernel.elf kernel.bin
//! ```
//!
//! Its entry (`llvm-nm kernel.elf`) is 0x0800_4000. It never returns; after each round it adds one
//! to the word at 0x2000_0000.
#![no_std]
#![no_main]

use core::hint::black_box;
use core::ptr::write_volatile;

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    loop {}
}

struct Attitude {
    q: [f32; 4],
    bias: [f32; 3],
}

#[inline(never)]
fn turn(attitude: &mut Attitude, gyro: [f32; 3], acc: [f32; 3], dt: f32) {
    let [w, x, y, z] = attitude.q;
    let norm = acc[0] * acc[0] + acc[1] * acc[1] + acc[2] * acc[2];
    let mut rate = gyro;
    if norm > 0.01 {
        let inverse = inverse_root(norm);
        let a = acc.map(|a| a * inverse);
        let v = [x * z - w * y, w * x + y * z, w * w - 0.5 + z * z];
        let e = [a[1] * v[2] - a[2] * v[1], a[2] * v[0] - a[0] * v[2], a[0] * v[1] - a[1] * v[0]];
        for axis in 0..3 {
            attitude.bias[axis] += e[axis] * 0.002 * dt;
            rate[axis] += e[axis] * 0.8 + attitude.bias[axis];
        }
    }
    let [p, q, r] = rate.map(|rate| 0.5 * rate * dt);
    let next = [
        w - x * p - y * q - z * r,
        x + w * p + y * r - z * q,
        y + w * q - x * r + z * p,
        z + w * r + x * q - y * p,
    ];
    let inverse = inverse_root(next.iter().map(|q| q * q).sum());
    attitude.q = next.map(|q| q * inverse);
}

#[inline(never)]
fn inverse_root(x: f32) -> f32 {
    let mut y = f32::from_bits(0x5F37_59DF - (x.to_bits() >> 1));
    for _ in 0..3 {
        y *= 1.5 - 0.5 * x * y * y;
    }
    y
}

struct Controller {
    integral: f32,
    last: f32,
}

#[inline(never)]
fn control(state: &mut Controller, wanted: f32, measured: f32, dt: f32) -> f32 {
    let error = wanted - measured;
    state.integral = (state.integral + error * dt).clamp(-20.0, 20.0);
    let slope = (error - state.last) / dt;
    state.last = error;
    (250.0 * error + 500.0 * state.integral + 2.5 * slope).clamp(-32767.0, 32767.0)
}

#[inline(never)]
fn spread(p: &mut [[f32; 6]; 6], f: &[[f32; 6]; 6]) {
    let mut fp = [[0.0; 6]; 6];
    for row in 0..6 {
        for column in 0..6 {
            fp[row][column] = (0..6).map(|k| f[row][k] * p[k][column]).sum();
        }
    }
    for row in 0..6 {
        for column in row..6 {
            let sum: f32 = (0..6).map(|k| fp[row][k] * f[column][k]).sum();
            let sum = (sum + 1e-6).min(100.0);
            p[row][column] = sum;
            p[column][row] = sum;
        }
    }
}

#[inline(never)]
fn pack(bytes: &mut [u8; 30], values: &[f32], round: u32) -> u32 {
    let mut at = 0;
    for value in values {
        let half = (value * 100.0) as i16;
        bytes[at..at + 2].copy_from_slice(&half.to_le_bytes());
        at += 2;
    }
    let mut crc = round;
    for &byte in bytes.iter() {
        crc ^= u32::from(byte);
        for _ in 0..8 {
            crc = if crc & 1 != 0 { crc >> 1 ^ 0xEDB8_8320 } else { crc >> 1 };
        }
    }
    crc
}

// The floating-point unit is switched on before anything can use it.
core::arch::global_asm!(
    ".globl start",
    ".thumb_func",
    "start:",
    "movw r0, #0xED88",
    "movt r0, #0xE000",
    "mov.w r1, #0xF00000",
    "str r1, [r0]",
    "isb",
    "b {run}",
    run = sym run,
);

extern "C" fn run() -> ! {
    let mut attitude = Attitude { q: [1.0, 0.0, 0.0, 0.0], bias: [0.0; 3] };
    let mut controllers: [Controller; 3] =
        core::array::from_fn(|_| Controller { integral: 0.0, last: 0.0 });
    let mut p = [[0.0; 6]; 6];
    let mut f = [[0.0; 6]; 6];
    for n in 0..6 {
        p[n][n] = 0.1;
        f[n][n] = 0.999;
        f[n][(n + 3) % 6] = 0.001;
    }
    let mut bytes = [0; 30];
    let mut round = 0u32;
    loop {
        let phase = (round & 1023) as f32 * 0.01;
        let gyro = black_box([0.1 * phase, 0.2 - 0.01 * phase, 0.05]);
        turn(&mut attitude, gyro, black_box([0.1, 0.2, 9.7]), 0.001);
        let mut out = [0.0; 3];
        for (axis, out) in out.iter_mut().enumerate() {
            *out = control(&mut controllers[axis], 0.0, gyro[axis], 0.001);
        }
        spread(&mut p, &f);
        let crc = pack(&mut bytes, &[out[0], out[1], out[2], attitude.q[1], p[0][0]], round);
        round = round.wrapping_add(1);
        // SAFETY: nothing else is there.
        unsafe {
            write_volatile(0x2000_0004 as *mut u32, crc);
            write_volatile(0x2000_0000 as *mut u32, round);
        }
    }
}
