//! The weights of a gyro's angle increments in the errors of a navigator.
//!
//! With λ̇ = −Aᵀλ and λ(T) the unit vector of an error, the error is ∫ λ_g(t) ε_g(t) dt over the gyros g, so that one
//! solution backwards in time gives the response to the errors of all gyros at all times. A is constant within a sample,
//! as it is in its middle; then λ is multiplied by the matrix exponential of Aᵀ·sample, and the weight is the mean of λ
//! over the sample. Both are sums of `ORDER` powers in a fixed order.

use crate::navigation::equations::{ARCSEC, Leg, STATES, State};

/// Powers of A·sample in an exponential, which are exact to rounding for samples up to [`MAX_SAMPLE`].
const ORDER: usize = 12;

/// Longest sample, s: the Schuler oscillation turns by 0.15 rad.
pub const MAX_SAMPLE: f64 = 120.0;

/// A gyro, by the axis that it lies along.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Gyro {
    /// To the north.
    North,
    /// To the east.
    East,
    /// Down.
    Down,
}

/// An error of a navigator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Error {
    /// Heading, ″.
    Heading,
    /// Tilt about the axis to the north, ″.
    TiltNorth,
    /// Tilt about the axis to the east, ″.
    TiltEast,
    /// Velocity to the north, m/s.
    VelocityNorth,
    /// Velocity to the east, m/s.
    VelocityEast,
    /// Position to the north, m.
    PositionNorth,
    /// Position to the east, m.
    PositionEast,
}

/// The task of a navigator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Task {
    /// To keep the heading at rest, by the vertical gyro alone.
    Heading,
    /// To find the heading at rest in the given latitude, rad, from the rate of the Earth about the east gyro.
    Gyrocompass {
        /// Rate of the Earth, rad/s.
        earth_rate: f64,
        /// Latitude, rad.
        latitude: f64,
    },
    /// To keep attitude, velocity and position on a leg.
    Inertial(Leg),
}

/// The times of a task, in samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Times {
    /// Length of a sample, s.
    pub sample_s: f64,
    /// Samples of the alignment at rest before the start; 0 for a start without errors.
    pub alignment: usize,
    /// Samples from the start to the end.
    pub duration: usize,
    /// Whether the mean rates of the gyros in the alignment are taken as their biases, except for the one that finds the
    /// heading.
    pub calibrates: bool,
}

/// The weights of one gyro.
#[derive(Debug, Clone, PartialEq)]
pub struct Weights {
    /// The gyro.
    pub gyro: Gyro,
    /// Weights of its increments in each error of the task, in the unit of the error for an increment of 1 ″.
    pub of_errors: Vec<Vec<f64>>,
}

impl Task {
    /// Its errors.
    pub fn errors(&self) -> &'static [Error] {
        match self {
            Task::Heading | Task::Gyrocompass { .. } => &[Error::Heading],
            Task::Inertial(_) => &[
                Error::Heading,
                Error::TiltNorth,
                Error::TiltEast,
                Error::VelocityNorth,
                Error::VelocityEast,
                Error::PositionNorth,
                Error::PositionEast,
            ],
        }
    }

    /// The gyros that it uses.
    pub fn gyros(&self) -> &'static [Gyro] {
        match self {
            Task::Heading => &[Gyro::Down],
            Task::Gyrocompass { .. } => &[Gyro::East],
            Task::Inertial(_) => &[Gyro::North, Gyro::East, Gyro::Down],
        }
    }
}

impl Error {
    /// Its place in the state, and its size for a state of one, in radians for angles.
    fn place(self) -> (usize, f64) {
        match self {
            Error::Heading => (2, 1.0),
            Error::TiltNorth => (0, 1.0),
            Error::TiltEast => (1, 1.0),
            Error::VelocityNorth => (3, ARCSEC),
            Error::VelocityEast => (4, ARCSEC),
            Error::PositionNorth => (5, ARCSEC),
            Error::PositionEast => (6, ARCSEC),
        }
    }
}

/// The weights of the gyros of a task, for all its errors; a record has the samples of the alignment before those of the
/// task.
pub fn weights(task: &Task, times: &Times) -> Vec<Weights> {
    let Times { sample_s, alignment, duration, calibrates } = *times;
    let alone = |gyro, weights| vec![Weights { gyro, of_errors: vec![weights] }];
    match task {
        Task::Heading => {
            let mut weights = vec![0.0; alignment + duration];
            weights[alignment..].fill(1.0);
            if calibrates {
                calibrate(&mut weights, alignment);
            }
            alone(Gyro::Down, weights)
        }
        Task::Gyrocompass { earth_rate, latitude } => {
            let weight = compass(*earth_rate, *latitude, sample_s, alignment);
            alone(Gyro::East, vec![weight; alignment])
        }
        Task::Inertial(leg) => {
            let rows = task.errors().iter().map(|error| inertial(leg, *error, times));
            let rows: Vec<[Vec<f64>; 3]> = rows.collect();
            let of = |(place, gyro): (usize, &Gyro)| Weights {
                gyro: *gyro,
                of_errors: rows.iter().map(|row| row[place].clone()).collect(),
            };
            task.gyros().iter().enumerate().map(of).collect()
        }
    }
}

/// Takes the mean of the alignment's increments off those of the task.
fn calibrate(weights: &mut [f64], alignment: usize) {
    if alignment > 0 {
        let whole: f64 = weights[alignment..].iter().sum();
        weights[..alignment].iter_mut().for_each(|weight| *weight -= whole / alignment as f64);
    }
}

/// Weight of the increments of the east gyro in the heading that gyrocompassing finds, ″ per ″: a heading error is where
/// the rate of the Earth hides the mean error of the gyro.
fn compass(earth_rate: f64, latitude: f64, sample_s: f64, alignment: usize) -> f64 {
    -1.0 / (alignment as f64 * sample_s * earth_rate * libm::cos(latitude))
}

/// The weights of the three gyros in one error of a leg.
fn inertial(leg: &Leg, error: Error, times: &Times) -> [Vec<f64>; 3] {
    let Times { sample_s, alignment, duration, calibrates } = *times;
    let (place, size) = error.place();
    let mut weights = [(); 3].map(|()| vec![0.0; alignment + duration]);
    let mut adjoint: State = [0.0; STATES];
    adjoint[place] = size;
    let mut matrix = leg.matrix(0.0);
    for k in (0..duration).rev() {
        if !leg.is_steady() {
            matrix = leg.matrix((k as f64 + 0.5) * sample_s);
        }
        let [next, mean] = backwards(&matrix, sample_s, &adjoint);
        for (gyro, weights) in weights.iter_mut().enumerate() {
            weights[alignment + k] = mean[gyro];
        }
        adjoint = next;
    }
    if alignment > 0 {
        let of_heading = adjoint[2] * compass(leg.earth_rate, leg.latitude, sample_s, alignment);
        let [north, east, down] = &mut weights;
        if calibrates {
            calibrate(north, alignment);
            calibrate(down, alignment);
        }
        east[..alignment].fill(of_heading);
    }
    weights
}

/// The adjoint one sample earlier, and its mean over the sample.
fn backwards(matrix: &[State; STATES], sample_s: f64, adjoint: &State) -> [State; 2] {
    let (mut next, mut mean, mut power) = (*adjoint, *adjoint, *adjoint);
    for n in 1..=ORDER {
        // Aᵀ times the last power, for one more factor of the sample over n.
        let factor = sample_s / n as f64;
        let mut more = [0.0; STATES];
        for (row, from) in matrix.iter().zip(power) {
            for (to, a) in more.iter_mut().zip(row) {
                *to += a * from * factor;
            }
        }
        power = more;
        for i in 0..STATES {
            next[i] += power[i];
            mean[i] += power[i] / (n + 1) as f64;
        }
    }
    [next, mean]
}

#[cfg(test)]
mod tests {
    use core::f64::consts::PI;

    use super::*;
    use crate::navigation::equations::{EARTH_RATE, GRAVITY, RADIUS};

    fn at_rest(earth_rate: f64) -> Leg {
        Leg { earth_rate, latitude: 45.0 * PI / 180.0, velocity: [0.0; 2] }
    }

    fn times(duration: usize) -> Times {
        Times { sample_s: 10.0, alignment: 0, duration, calibrates: false }
    }

    #[test]
    fn on_an_earth_at_rest_the_channels_are_those_of_schuler() {
        let omega = libm::sqrt(GRAVITY / RADIUS);
        let found = weights(&Task::Inertial(at_rest(0.0)), &times(1440));
        let (north, east, down) = (&found[0].of_errors, &found[1].of_errors, &found[2].of_errors);
        for k in [0, 1, 700, 1438, 1439] {
            // Means of h(u) over u from `from` to `to`.
            let (from, to) = ((1439 - k) as f64 * 10.0, (1440 - k) as f64 * 10.0);
            let mean = |of: fn(f64) -> f64| (of(omega * to) - of(omega * from)) / (omega * 10.0);
            let tilt = mean(libm::sin);
            let velocity = mean(|x| -libm::cos(x)) * GRAVITY / omega * ARCSEC;
            let position = (1.0 - tilt) * RADIUS * ARCSEC;
            let expected = [
                (north[1][k], tilt),
                (north[4][k], velocity),
                (north[6][k], position),
                (east[2][k], tilt),
                (east[3][k], -velocity),
                (east[5][k], -position),
                (down[0][k], 1.0),
                (down[3][k], 0.0),
            ];
            for (place, (found, expected)) in expected.into_iter().enumerate() {
                let off = (found - expected).abs();
                assert!(off < 1e-9 * expected.abs().max(1e-6), "{place} at {k}: {found}, not {expected}");
            }
        }
    }

    #[test]
    fn gyrocompassing_hides_the_bias_of_the_east_gyro_until_the_earth_has_turned() {
        let task = Task::Inertial(at_rest(EARTH_RATE));
        let aligned = Times { alignment: 60, ..times(60) };
        let [free, aligned] = [times(60), aligned].map(|times| weights(&task, &times));
        let whole = |weights: &[Weights], error: usize| weights[1].of_errors[error].iter().sum::<f64>();
        // A constant error moves the position by a hundredth of what it does without gyrocompassing.
        assert!(whole(&aligned, 5).abs() < 0.01 * whole(&free, 5).abs());
        assert!(whole(&aligned, 0).abs() > 1e3 * whole(&free, 0).abs());
    }

    #[test]
    fn a_calibrated_gyro_has_no_bias() {
        for task in [Task::Heading, Task::Inertial(at_rest(EARTH_RATE))] {
            let found = weights(&task, &Times { alignment: 30, calibrates: true, ..times(90) });
            for Weights { gyro, of_errors } in found.iter().filter(|weights| weights.gyro != Gyro::East) {
                for (error, weights) in of_errors.iter().enumerate() {
                    let (sum, size) =
                        weights.iter().fold((0.0, 0.0), |(sum, size), w| (sum + w, size + libm::fabs(*w)));
                    assert!(libm::fabs(sum) <= 1e-12 * size, "{gyro:?}, error {error}: {sum} of {size}");
                }
            }
        }
    }

    #[test]
    fn half_the_sample_gives_the_same_responses_on_a_leg() {
        let leg = Leg { velocity: [150.0, 200.0], ..at_rest(EARTH_RATE) };
        let coarse = weights(&Task::Inertial(leg), &times(360));
        let fine = weights(&Task::Inertial(leg), &Times { sample_s: 5.0, ..times(720) });
        for (coarse, fine) in coarse.iter().zip(&fine) {
            for (coarse, fine) in coarse.of_errors.iter().zip(&fine.of_errors) {
                let largest = coarse.iter().fold(0.0, |most, w| libm::fmax(most, libm::fabs(*w)));
                for (k, coarse) in coarse.iter().enumerate() {
                    let mean = 0.5 * (fine[2 * k] + fine[2 * k + 1]);
                    assert!((coarse - mean).abs() < 1e-6 * largest, "sample {k}: {coarse}, not {mean}");
                }
            }
        }
    }
}
