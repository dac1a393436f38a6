//! One number a lane: arithmetic on several trials at once.
//!
//! Only addition, subtraction, multiplication, division, square root, comparison and selection are used, each exactly
//! rounded by IEEE 754 and none fused, so every instruction set gives the same bits, and a lane's bits never depend
//! on its neighbours.

use std::f64::consts::FRAC_2_PI;

use fearless_simd::{Select, Simd, SimdBase};

/// A number for each lane: as many as the instruction set takes at once.
pub(super) type Real<S> = <S as Simd>::f64s;
/// A truth value for each lane.
pub(super) type Mask<S> = <S as Simd>::mask64s;

/// Trials that are run side by side.
pub(super) fn lanes<S: Simd>() -> usize {
    Real::<S>::LEN
}

#[inline(always)]
pub(super) fn splat<S: Simd>(simd: S, value: f64) -> Real<S> {
    Real::<S>::splat(simd, value)
}

/// The smaller number; `b` where they are equal. The instruction sets' own minima differ for zeros of unlike sign.
#[inline(always)]
pub(super) fn min<S: Simd>(_: S, a: Real<S>, b: Real<S>) -> Real<S> {
    a.simd_lt(b).select(a, b)
}

/// The larger number; `b` where they are equal.
#[inline(always)]
pub(super) fn max<S: Simd>(_: S, a: Real<S>, b: Real<S>) -> Real<S> {
    a.simd_gt(b).select(a, b)
}

#[inline(always)]
pub(super) fn clamp<S: Simd>(simd: S, x: Real<S>, low: Real<S>, high: Real<S>) -> Real<S> {
    min(simd, max(simd, x, low), high)
}

#[inline(always)]
pub(super) fn reciprocal<S: Simd>(simd: S, x: Real<S>) -> Real<S> {
    splat(simd, 1.0) / x
}

/// The nearest integer, for magnitudes below 2^51.
#[inline(always)]
fn round<S: Simd>(_: S, x: Real<S>) -> Real<S> {
    // Adding 1.5 x 2^52 leaves no bits for the fraction.
    const SHIFT: f64 = 6_755_399_441_055_744.0;
    (x + SHIFT) - SHIFT
}

/// Sine and cosine of an angle in radians: reduction by multiples of pi/2 (Cody and Waite), then the polynomials of
/// the freely distributable `fdlibm` (Sun Microsystems, 1993) on [-pi/4, pi/4].
#[inline(always)]
pub(super) fn sin_cos<S: Simd>(simd: S, x: Real<S>) -> (Real<S>, Real<S>) {
    /// pi/2 in two parts, the first with 33 bits.
    const HALF_PI: [f64; 2] = [1.570_796_326_734_125_6, 6.077_100_506_506_192e-11];
    let turns = round(simd, x * FRAC_2_PI);
    let r = (x - turns * HALF_PI[0]) - turns * HALF_PI[1];
    let z = r * r;
    let sine = r + r
        * z
        * (((((z * 1.589_690_995_211_55e-10 - 2.505_076_025_340_686_3e-8) * z
            + 2.755_731_370_707_006_8e-6)
            * z
            - 1.984_126_982_985_795e-4)
            * z
            + 8.333_333_333_322_49e-3)
            * z
            - 1.666_666_666_666_663_2e-1);
    let cosine = z
        * z
        * (((((z * -1.135_964_755_778_819_5e-11 + 2.087_572_321_298_175e-9) * z
            - 2.755_731_435_139_066_3e-7)
            * z
            + 2.480_158_728_947_673e-5)
            * z
            - 1.388_888_888_887_411e-3)
            * z
            + 4.166_666_666_666_66e-2)
        - z * 0.5
        + 1.0;
    // The quadrant, 0 to 3: (k - 1.5) / 4 never lies half-way between integers.
    let quadrant = turns - round(simd, (turns - 1.5) * 0.25) * 4.0;
    let odd = quadrant.simd_eq(1.0) | quadrant.simd_eq(3.0);
    let (s, c) = (odd.select(cosine, sine), odd.select(sine, cosine));
    let s = quadrant.simd_ge(2.0).select(-s, s);
    let c = (quadrant.simd_eq(1.0) | quadrant.simd_eq(2.0)).select(-c, c);
    (s, c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::Level;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn sine_and_cosine_agree_with_libm(x in -100.0..100.0_f64) {
            let simd = fearless_simd::dispatch!(Level::baseline(), simd => {
                let (s, c) = sin_cos(simd, splat(simd, x));
                (s[0], c[1])
            });
            prop_assert!((simd.0 - libm::sin(x)).abs() < 1e-15 * (1.0 + x.abs()), "{} {}", simd.0, libm::sin(x));
            prop_assert!((simd.1 - libm::cos(x)).abs() < 1e-15 * (1.0 + x.abs()), "{} {}", simd.1, libm::cos(x));
        }
    }
}
