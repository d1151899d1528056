//! The shapes for which the kernel is compiled apart.

use std::sync::Arc;

use crate::launch::{Launch, Sampled, Trial};
use crate::moments::{self, Moments, Trials};
use crate::switched_run::SwitchedRun;
use crate::switched_run::shape::Shape;
use crate::word::Word;

/// The shape of the paper's gyro: one tone and no other spread.
const PLAIN: Shape = Shape {
    ends: true,
    times: 0,
    walk: false,
    noise: true,
    tones: 1,
    magnetic: false,
    initial: false,
    non_magnetic: false,
    mode: false,
    warm_up: false,
    relock: None,
    any_end: true,
};

/// The shape of the paper's gyro with a random walk.
const WALKING: Shape = Shape { walk: true, ..PLAIN };

impl From<Shape> for Arc<dyn Sampled> {
    // The table of methods compiles the kernel for every width. It is made here, so that this happens in this package.
    fn from(shape: Shape) -> Self {
        Arc::new(shape)
    }
}

impl Trial for Shape {
    // Only here: the shader has one shape.
    #[inline(always)]
    fn tally<W: Word>(self, launch: &Launch, trials: Trials) -> Vec<Moments> {
        let shape = self;
        // Each of the first comparisons makes the shape a constant of its branch.
        if W::LANES > 1 && shape == PLAIN {
            moments::tally::<W>(SwitchedRun::new(launch, PLAIN), trials)
        } else if W::LANES > 1 && shape == WALKING {
            moments::tally::<W>(SwitchedRun::new(launch, WALKING), trials)
        } else {
            moments::tally::<W>(SwitchedRun::new(launch, shape), trials)
        }
    }
}
