//! Contact impulses: projected Gauss-Seidel over the contacts, warm-started, with Coulomb's friction cone, and
//! accelerated as a nonsmooth nonlinear conjugate gradient method (Silcowitz, Niebe and Erleben, 2010).
//!
//! Each contact is a block of one normal and two tangential rows. In a sweep its normal impulse is set to what keeps
//! the surfaces apart, then its friction to what stops the sliding, shortened to the cone's radius where it is longer.
//! Alone, sweeps are slow where something light is squeezed between heavy things, as the object between hand and
//! table. So what a sweep changed is taken as a gradient, and between sweeps the impulses move on in conjugate
//! directions.

use fearless_simd::{Select, Simd, SimdBase, SimdMask};

use super::block::{Block, Bodies, Impulse, Velocities};
use super::contact::{CANDIDATES, Contact};
use super::lanes::{Mask, Real, max, splat};

/// A lane whose impulses change by less than this in a sweep is done, in N s: 1/600 of what carries the object for a
/// step.
const CONVERGED: f64 = 2e-5;

/// What a step's contacts need beside themselves.
pub(super) struct Settings {
    /// Length of a step, s.
    pub(super) step: f64,
    /// Sweeps over all contacts.
    pub(super) sweeps: u32,
    /// Friction coefficient.
    pub(super) friction: f64,
}

/// The contacts of a step, and the impulses of the last one.
pub(super) struct Solver<S: Simd> {
    /// As many as there are candidates; the first `used` are this step's.
    blocks: Vec<Block<S>>,
    used: usize,
    /// Impulses of the last step, by candidate: where the sweeps begin, and what touch sensors feel.
    last: [Impulse<S>; CANDIDATES],
}

impl<S: Simd> Solver<S> {
    pub(super) fn new(simd: S) -> Self {
        Self {
            blocks: (0..CANDIDATES).map(|_| Block::empty(simd)).collect(),
            used: 0,
            last: [Impulse::none(simd); CANDIDATES],
        }
    }

    /// Impulse of a candidate in the last step.
    pub(super) fn impulse(&self, candidate: usize) -> &Impulse<S> {
        &self.last[candidate]
    }

    /// Forgets the impulses of a lane.
    pub(super) fn forget(&mut self, lane: usize) {
        for Impulse { normal, friction } in &mut self.last {
            for number in [normal, &mut friction.x, &mut friction.y, &mut friction.z] {
                number[lane] = 0.0;
            }
        }
    }

    /// Builds the rows of a step's contacts.
    pub(super) fn prepare(
        &mut self,
        simd: S,
        bodies: &Bodies<'_, S>,
        contacts: &[Contact<S>],
        settings: &Settings,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                for (block, contact) in self.blocks.iter_mut().zip(contacts) {
                    let last = &self.last[contact.candidate];
                    block.prepare(simd, bodies, contact, last, settings.step);
                }
                self.used = contacts.len();
            },
        );
    }

    /// Finds the impulses, applies them to the velocities, and keeps them.
    pub(super) fn solve(&mut self, simd: S, settings: &Settings, velocities: &mut Velocities<S>) {
        simd.vectorize(
            #[inline(always)]
            || {
                let blocks = &mut self.blocks[..self.used];
                for block in &*blocks {
                    block.begin(velocities);
                }
                // The lanes that go on. One that is done keeps its impulses, whatever the others still need.
                let mut moving = splat(simd, 0.0).simd_eq(0.0);
                let mut gradient = splat(simd, 0.0);
                let mut conjugate = Velocities::zero(simd);
                for sweep in 1..=settings.sweeps {
                    let before = *velocities;
                    let changes = sweep_all(simd, blocks, settings.friction, moving, velocities);
                    moving &= changes.largest.simd_gt(CONVERGED * CONVERGED);
                    // The last sweep is not followed by a move, so that the impulses are within their cones.
                    if sweep == settings.sweeps || !moving.any_true() {
                        break;
                    }
                    // Fletcher and Reeves' factor; a lane whose changes grow begins anew.
                    let shrinks = moving & changes.sum.simd_le(gradient);
                    let factor = shrinks.select(changes.sum / gradient, splat(simd, 0.0));
                    gradient = changes.sum;
                    for block in &mut *blocks {
                        block.move_on(factor);
                    }
                    velocities.move_on(factor, &mut conjugate, &before);
                }
                let mut blocks = blocks.iter().peekable();
                for (candidate, last) in self.last.iter_mut().enumerate() {
                    *last = match blocks.next_if(|block| block.candidate == candidate) {
                        Some(block) => block.impulse(),
                        None => Impulse::none(simd),
                    };
                }
            },
        );
    }
}

/// How much a sweep changed the impulses, as squares, (N s)^2.
struct Changes<S: Simd> {
    /// The contact's that changed most.
    largest: Real<S>,
    /// All together.
    sum: Real<S>,
}

#[inline(always)]
fn sweep_all<S: Simd>(
    simd: S,
    blocks: &mut [Block<S>],
    friction: f64,
    moving: Mask<S>,
    velocities: &mut Velocities<S>,
) -> Changes<S> {
    let mut changes = Changes { largest: splat(simd, 0.0), sum: splat(simd, 0.0) };
    for block in blocks {
        let change = block.sweep(simd, friction, moving, velocities);
        changes.largest = max(simd, changes.largest, change);
        changes.sum += change;
    }
    changes
}
