//! Whether the processor has the instructions that this build was compiled for.

/// The build uses instructions that the processor lacks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the processor has no AVX2, which this program was built for; expected one that has it, or a build for any x86-64: \
     RUSTFLAGS=-Ctarget-cpu=x86-64 cargo build --release"
)]
pub struct Unsuited;

/// Checks before the first use of such an instruction; afterwards it is too late for a message.
#[inline(never)]
pub fn check() -> Result<(), Unsuited> {
    #[cfg(all(target_arch = "x86_64", target_feature = "avx2"))]
    if !has_avx2() {
        return Err(Unsuited);
    }
    Ok(())
}

/// The standard library's macro for this does not check instructions that the build assumes, and wide data must not be moved before the check:
/// so two registers are read (Intel SDM, CPUID: leaf 0, EAX; leaf 7, EBX bit 5).
#[cfg(all(target_arch = "x86_64", target_feature = "avx2"))]
fn has_avx2() -> bool {
    use std::arch::x86_64::{__cpuid, __cpuid_count};
    const FEATURES: u32 = 7;
    __cpuid(0).eax >= FEATURES && __cpuid_count(FEATURES, 0).ebx & (1 << 5) != 0
}
