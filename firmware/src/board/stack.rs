//! How much of the stack some work uses: the memory below the stack is painted, and checked afterwards.

/// How much is painted, bytes; the boards have more.
const PAINTED: usize = 64 * 1024;
const PAINT: u32 = 0xa5a5_a5a5;

/// Does some work; returns its result and how far below the caller its stack went, bytes.
#[inline(never)]
#[expect(
    unsafe_code,
    reason = "only the words below the stack pointer, which nobody owns, say how far a call has gone"
)]
pub fn used_by<T>(work: impl FnOnce() -> T) -> (T, usize) {
    let pointer = cortex_m::register::msp::read() as usize;
    // What the compiler keeps right below the pointer is not painted.
    let painted = (pointer - PAINTED..pointer - 64).step_by(4);
    for address in painted.clone() {
        // SAFETY: aligned, within the RAM, below the stack of the only thread; no interrupt is on.
        unsafe { core::ptr::with_exposed_provenance_mut::<u32>(address).write_volatile(PAINT) };
    }
    let done = work();
    for address in painted {
        // SAFETY: as above.
        if unsafe { core::ptr::with_exposed_provenance::<u32>(address).read_volatile() } != PAINT {
            return (done, pointer - address);
        }
    }
    (done, 0)
}
