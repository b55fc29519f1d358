//! Whether the processor has what this build was compiled for.

/// The build uses instructions that the processor lacks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the processor has no AVX2, which this program was built for; expected one that has it, or a build for any x86-64: \
     RUSTFLAGS=-Ctarget-cpu=x86-64 cargo build --release"
)]
pub struct Unsuited;

/// Looks before anything that takes such an instruction; after one of them it is too late for a message.
#[inline(never)]
pub fn check() -> Result<(), Unsuited> {
    #[cfg(all(target_arch = "x86_64", target_feature = "avx2"))]
    if !has_avx2() {
        return Err(Unsuited);
    }
    Ok(())
}

/// The standard library's own macro does not look where the build says that it is there; nor may anything wide be moved on the way, as what
/// the crate knows of a processor is: only two registers are looked at (Intel SDM, CPUID: leaf 0, EAX; leaf 7, EBX bit 5).
#[cfg(all(target_arch = "x86_64", target_feature = "avx2"))]
fn has_avx2() -> bool {
    const FEATURES: u32 = 7;
    raw_cpuid::cpuid!(0).eax >= FEATURES && raw_cpuid::cpuid!(FEATURES, 0).ebx & (1 << 5) != 0
}
