//! The number of lanes in which the kernels run: one on any processor, more where it has the instructions.

use crate::word::{Scalar, Word};

/// Evaluates intrinsics that read and write their operands only; those that read or write memory say why they may.
#[cfg(target_arch = "x86_64")]
macro_rules! instructions {
    ($($body:tt)*) => {
        // SAFETY: words of this width are private to the package and made within `Width::run` only, where the processor has
        // the instructions.
        unsafe { $($body)* }
    };
}

/// Implements the operators of a SIMD word, lane by lane.
#[cfg(target_arch = "x86_64")]
macro_rules! simd_operators {
    ($word:ident, $register:ty, $add:ident, $sub:ident, $mul:ident, $xor:ident, $and:ident, $shl:ident, $shr:ident) => {
        simd_operators!(binary $word, Add, add, $add);
        simd_operators!(binary $word, Sub, sub, $sub);
        simd_operators!(binary $word, Mul, mul, $mul);
        simd_operators!(binary $word, BitXor, bitxor, $xor);
        simd_operators!(binary $word, BitAnd, bitand, $and);
        simd_operators!(shift $word, Shl, shl, $shl);
        simd_operators!(shift $word, Shr, shr, $shr);
    };
    (binary $word:ident, $trait:ident, $method:ident, $instruction:ident) => {
        impl core::ops::$trait for $word {
            type Output = $word;
            #[inline(always)]
            fn $method(self, other: $word) -> $word {
                instructions! { $word($instruction(self.0, other.0)) }
            }
        }
    };
    (shift $word:ident, $trait:ident, $method:ident, $instruction:ident) => {
        impl core::ops::$trait<u32> for $word {
            type Output = $word;
            #[inline(always)]
            fn $method(self, n: u32) -> $word {
                instructions! { $word($instruction(self.0, _mm_cvtsi32_si128(n as i32))) }
            }
        }
    };
}
#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
pub(crate) mod pair;
#[cfg(all(target_family = "wasm", feature = "simd128"))]
mod simd128;

/// The number of lanes in which the kernels run. All widths give the same bits; only widths that the processor has can
/// be constructed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Width(Lanes);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Lanes {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
    #[cfg(all(target_family = "wasm", feature = "simd128"))]
    Simd128,
}

/// Work that can be done in any width.
pub trait AnyWidth {
    /// The result of the work, the same in every width.
    type Output;
    /// Does the work in lanes of the width of `W`.
    fn run<W: Word>(self) -> Self::Output;
}

impl Width {
    /// One lane, on any processor; the reference for the others.
    pub const PORTABLE: Width = Width(Lanes::Portable);

    /// The widths that this processor has, narrowest first.
    pub fn available() -> Vec<Width> {
        #[cfg_attr(not(target_arch = "x86_64"), allow(unused_mut))]
        let mut widths = vec![Width::PORTABLE];
        #[cfg(target_arch = "x86_64")]
        {
            let avx2 = is_x86_feature_detected!("avx2")
                && is_x86_feature_detected!("bmi1")
                && is_x86_feature_detected!("bmi2")
                && is_x86_feature_detected!("lzcnt");
            let avx512 = is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512bw")
                && is_x86_feature_detected!("avx512cd")
                && is_x86_feature_detected!("avx512dq")
                && is_x86_feature_detected!("avx512vl");
            widths.extend(avx2.then_some(Width(Lanes::Avx2)));
            widths.extend((avx2 && avx512).then_some(Width(Lanes::Avx512)));
        }
        // WebAssembly has no detection: a module with these instructions is loaded only where they are.
        #[cfg(all(target_family = "wasm", feature = "simd128"))]
        widths.push(Width(Lanes::Simd128));
        widths
    }

    /// The widest width of this processor.
    pub fn widest() -> Width {
        Width::available().pop().unwrap_or(Width::PORTABLE)
    }

    /// Common name of the instruction set.
    pub fn name(self) -> &'static str {
        match self.0 {
            Lanes::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Lanes::Avx2 => "AVX2",
            #[cfg(target_arch = "x86_64")]
            Lanes::Avx512 => "AVX-512",
            #[cfg(all(target_family = "wasm", feature = "simd128"))]
            Lanes::Simd128 => "SIMD128",
        }
    }

    /// Number of lanes.
    pub fn lanes(self) -> usize {
        match self.0 {
            Lanes::Portable => Scalar::LANES,
            #[cfg(target_arch = "x86_64")]
            Lanes::Avx2 => avx2::Avx2::LANES,
            #[cfg(target_arch = "x86_64")]
            Lanes::Avx512 => avx512::Avx512::LANES,
            #[cfg(all(target_family = "wasm", feature = "simd128"))]
            Lanes::Simd128 => simd128::Simd128::LANES,
        }
    }

    /// Does `work` in lanes of this width.
    pub fn run<T: AnyWidth>(self, work: T) -> T::Output {
        match self.0 {
            Lanes::Portable => work.run::<Scalar>(),
            // SAFETY: only `available` constructs these, where the processor has the instructions that the functions
            // enable.
            #[cfg(target_arch = "x86_64")]
            Lanes::Avx2 => unsafe { in_avx2(work) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Lanes::Avx512 => unsafe { in_avx512(work) },
            #[cfg(all(target_family = "wasm", feature = "simd128"))]
            Lanes::Simd128 => in_simd128(work),
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt")]
fn in_avx2<T: AnyWidth>(work: T) -> T::Output {
    work.run::<avx2::Avx2>()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512cd,avx512dq,avx512vl,avx2,bmi1,bmi2,lzcnt")]
fn in_avx512<T: AnyWidth>(work: T) -> T::Output {
    work.run::<avx512::Avx512>()
}

#[cfg(all(target_family = "wasm", feature = "simd128"))]
#[target_feature(enable = "simd128")]
fn in_simd128<T: AnyWidth>(work: T) -> T::Output {
    work.run::<simd128::Simd128>()
}
