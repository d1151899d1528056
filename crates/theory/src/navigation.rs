//! From the errors of gyros to the errors of a navigator: linear functionals of their records.
//!
//! For small errors the error of a navigator is e(T) = ∫ h(t) ε(t) dt for each gyro with the rate error ε. For a record of
//! angle increments this is Σ w_k Δθ_k, where w_k is the mean of h over sample k. [`Leg::matrix`] has the error equations of
//! a strapdown in local-level axes, [`weights()`] solves their adjoint for the w_k, and [`Noise::covariance`] gives wᵀCw for each
//! noise of a record. [`filter`] has the weights of a Kalman filter.
//!
//! # Error equations
//!
//! The axes are north, east, down.
//! The state is the attitude error (rotation of the computed axes relative to the true ones), rad, the error of the
//! horizontal velocity, m/s, and the horizontal error of the position, m. The Earth is a sphere that turns, the height is
//! known, as it is with a barometer, and accelerometers have no errors. Source: the φ-angle model of Titterton and Weston,
//! "Strapdown Inertial Navigation Technology", 2nd ed., chapter 12.
//!
//! # Weights
//!
//! With λ̇ = −Aᵀλ and λ(T) the unit vector of an error, the error is ∫ λ_g(t) ε_g(t) dt over the gyros g, so that one
//! solution backwards in time gives the response to the errors of all gyros at all times. A is constant within a sample,
//! as it is in its middle; then λ is multiplied by the matrix exponential of Aᵀ·sample, and the weight is the mean of λ
//! over the sample. Both are sums of `ORDER` powers in a fixed order.
//!
//! # Covariance
//!
//! wᵀCw is the covariance of two weighted sums of the increments of a noisy angle. Increment k, from 0 on, is the difference
//! of the angles k + 1 and k. Each covariance follows from that of the increments, without the matrix C: sums over samples
//! replace it.

pub mod filter;

use core::f64::consts::PI;

/// Rate of the Earth, rad/s: 15.041 °/h.
pub const EARTH_RATE: f64 = 7.292_115e-5;

/// Mean radius of the Earth, m.
pub const RADIUS: f64 = 6.371e6;

/// Standard acceleration of free fall, m/s².
pub const GRAVITY: f64 = 9.80665;

/// One arc second, rad.
pub const ARCSEC: f64 = PI / 648_000.0;

/// Places of the state: the attitude error about north, east and down, the velocity error to the north and east, and the
/// position error to the north and east.
pub const STATES: usize = 7;

/// An error state; see [`STATES`].
pub type State = [f64; STATES];

/// A straight leg over the Earth, with the same velocity from its start to its end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Leg {
    /// Rate of the Earth, rad/s; 0 for an Earth that does not turn.
    pub earth_rate: f64,
    /// Latitude at the start, rad.
    pub latitude: f64,
    /// Velocity to the north and east, m/s; 0 for a navigator at rest.
    pub velocity: [f64; 2],
}

impl Leg {
    /// Whether the equations are the same at all times.
    pub fn is_steady(&self) -> bool {
        self.velocity == [0.0; 2]
    }

    /// Latitude after some time, rad.
    pub fn latitude_at(&self, time_s: f64) -> f64 {
        self.latitude + self.velocity[0] / RADIUS * time_s
    }

    /// The matrix A of ẋ = A x + ε, by rows, at a time, s.
    pub fn matrix(&self, time_s: f64) -> [State; STATES] {
        let latitude = self.latitude_at(time_s);
        let mut matrix = [[0.0; STATES]; STATES];
        for column in 0..STATES {
            let mut state = [0.0; STATES];
            state[column] = 1.0;
            let rates = self.rates(latitude, state);
            for (row, rate) in matrix.iter_mut().zip(rates) {
                row[column] = rate;
            }
        }
        matrix
    }

    /// A x.
    fn rates(&self, latitude: f64, [pn, pe, pd, vn, ve, north, east]: State) -> State {
        let (sin, cos) = (libm::sin(latitude), libm::cos(latitude));
        let (tan, earth) = (sin / cos, self.earth_rate);
        let attitude = [pn, pe, pd];
        let error = [vn, ve, 0.0];
        let [velocity_north, velocity_east] = self.velocity;
        let velocity = [velocity_north, velocity_east, 0.0];
        // Error of the latitude.
        let drift = north / RADIUS;

        let of_earth = [earth * cos, 0.0, -earth * sin];
        let over_earth = [velocity_east / RADIUS, -velocity_north / RADIUS, -velocity_east * tan / RADIUS];
        let error_of_earth = [-earth * sin * drift, 0.0, -earth * cos * drift];
        let error_over_earth =
            [ve / RADIUS, -vn / RADIUS, -ve * tan / RADIUS - velocity_east / (cos * cos * RADIUS) * drift];

        let turning = sum(of_earth, over_earth);
        let error_of_turning = sum(error_of_earth, error_over_earth);
        let coriolis = sum(of_earth, turning);
        let error_of_coriolis = sum(error_of_earth, error_of_turning);
        // The velocity is the same all the time, so that the specific force holds it against gravity and Coriolis.
        let force = sum(cross(coriolis, velocity), [0.0, 0.0, -GRAVITY]);

        let turned = cross(attitude, turning);
        let pushed = cross(attitude, force);
        let moved = cross(velocity, error_of_coriolis);
        let deflected = cross(error, coriolis);
        let accelerated = |i: usize| pushed[i] + moved[i] + deflected[i];
        [
            turned[0] - error_of_turning[0],
            turned[1] - error_of_turning[1],
            turned[2] - error_of_turning[2],
            accelerated(0),
            accelerated(1),
            vn,
            ve + velocity_east * tan * drift - velocity_north * tan / RADIUS * east,
        ]
    }
}

fn sum(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

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

/// The noise of a record, with angles in any unit and times in samples; 0 and `None` stand for nothing.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Noise {
    /// Standard deviation of independent errors of all angles.
    pub errors: f64,
    /// Standard deviation of independent increments.
    pub white: f64,
    /// Standard deviations of rates that are held for 1, 2, 4, … samples on a grid with a random position.
    pub octaves: Vec<f64>,
    /// Standard deviation of the steps of a random walk of the rate, which starts with one step before the first sample.
    pub walk: f64,
    /// Stationary standard deviation of a Markov rate, and its decay per sample.
    pub markov: Option<[f64; 2]>,
    /// Amplitude of a sine of the angle, and its turns per sample; its phase is random.
    pub sine: Option<[f64; 2]>,
    /// Jumps of the angle after every so many samples, and their variance.
    pub jumps: Option<(usize, f64)>,
}

impl Noise {
    /// Covariance of the sums with the weights `a` and `b`.
    pub fn covariance(&self, a: &[f64], b: &[f64]) -> f64 {
        let mut sum = self.errors * self.errors * dot(&of_angles(a), &of_angles(b));
        sum += self.white * self.white * dot(a, b);
        let held = self.octaves.iter().enumerate().filter(|(_, sigma)| **sigma != 0.0);
        if held.clone().next().is_some() {
            let (a, b) = (sums_before(a), sums_before(b));
            for (octave, sigma) in held {
                sum += sigma * sigma * of_holds(&a, &b, octave);
            }
        }
        if self.walk != 0.0 {
            sum += self.walk * self.walk * dot(&from_here_on(a), &from_here_on(b));
        }
        if let Some([sigma, decay]) = self.markov {
            sum += sigma * sigma * of_markov(a, b, libm::exp(-decay));
        }
        if let Some([amplitude, turns]) = self.sine {
            sum += 0.5 * amplitude * amplitude * of_sine(a, b, turns);
        }
        if let Some((interval, variance)) = self.jumps {
            // The jump after a sample is in the increment that follows.
            let jumps = (interval..a.len()).step_by(interval).map(|at| a[at] * b[at]);
            sum += variance * jumps.sum::<f64>();
        }
        sum
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The weights of the angles of increments with these weights, one more.
pub fn of_angles(weights: &[f64]) -> Vec<f64> {
    let at = |k: usize| weights.get(k).copied().unwrap_or(0.0);
    let before = |k: usize| k.checked_sub(1).map_or(0.0, at);
    (0..=weights.len()).map(|k| before(k) - at(k)).collect()
}

/// Sums of the weights from each sample on: the response to a step of the rate there.
fn from_here_on(weights: &[f64]) -> Vec<f64> {
    let mut sums = weights.to_vec();
    for k in (1..sums.len()).rev() {
        sums[k - 1] += sums[k];
    }
    sums
}

/// Sums of the weights before each sample, and of all.
fn sums_before(weights: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0; weights.len() + 1];
    for (k, weight) in weights.iter().enumerate() {
        sums[k + 1] = sums[k] + weight;
    }
    sums
}

/// Σ_p S_a(p) S_b(p)/L over all places p of a window of L = 2^octave samples, with S the sum of the weights in it, from the
/// sums of the weights before each sample.
fn of_holds(a: &[f64], b: &[f64], octave: usize) -> f64 {
    let (samples, length) = (a.len() - 1, 1_usize << octave);
    // A window longer than the record overlaps it as one of its length does, and holds all of it more often.
    let overlap = length.min(samples);
    let mut sum = (length - overlap) as f64 * ((a[samples] - a[0]) * (b[samples] - b[0]));
    // Windows that begin before the record, lie in it, and end after it.
    for (a_to, b_to) in a[1..overlap].iter().zip(&b[1..overlap]) {
        sum += (a_to - a[0]) * (b_to - b[0]);
    }
    for ((a_from, a_to), (b_from, b_to)) in a.iter().zip(&a[overlap..]).zip(b.iter().zip(&b[overlap..])) {
        sum += (a_to - a_from) * (b_to - b_from);
    }
    for (a_from, b_from) in a[samples - overlap + 1..samples].iter().zip(&b[samples - overlap + 1..samples]) {
        sum += (a[samples] - a_from) * (b[samples] - b_from);
    }
    sum / length as f64
}

/// Σ a_k b_l r^|k − l|.
fn of_markov(a: &[f64], b: &[f64], r: f64) -> f64 {
    let (mut before_a, mut before_b, mut sum) = (0.0, 0.0, 0.0);
    for (a, b) in a.iter().zip(b) {
        sum += a * b + a * before_b + b * before_a;
        before_a = r * (before_a + a);
        before_b = r * (before_b + b);
    }
    sum
}

/// The real part of Ã·B̃*, transforms of the weights of the angles at the frequency of the sine.
fn of_sine(a: &[f64], b: &[f64], turns: f64) -> f64 {
    let turns = turns - libm::floor(turns);
    let transform = |weights: &[f64]| {
        let mut sums = [0.0; 2];
        for (k, weight) in of_angles(weights).iter().enumerate() {
            let phase = k as f64 * turns;
            let phase = 2.0 * PI * (phase - libm::floor(phase));
            sums[0] += weight * libm::cos(phase);
            sums[1] += weight * libm::sin(phase);
        }
        sums
    };
    let ([ar, ai], [br, bi]) = (transform(a), transform(b));
    ar * br + ai * bi
}

#[cfg(test)]
mod tests {
    use super::*;

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

    const SAMPLES: usize = 23;

    fn two() -> [Vec<f64>; 2] {
        let of = |from: f64| (0..SAMPLES).map(|k| libm::sin(from + 0.37 * k as f64) + 0.2).collect();
        [of(0.3), of(1.9)]
    }

    /// ΣΣ a_k C_kl b_l.
    fn by_definition(covariance: impl Fn(usize, usize) -> f64) -> f64 {
        let [a, b] = two();
        let row = |k: usize| b.iter().enumerate().map(|(l, b)| covariance(k, l) * b).sum::<f64>();
        a.iter().enumerate().map(|(k, a)| a * row(k)).sum()
    }

    fn check(noise: &Noise, covariance: impl Fn(usize, usize) -> f64) {
        let [a, b] = two();
        let (found, expected) = (noise.covariance(&a, &b), by_definition(covariance));
        assert!(
            (found - expected).abs() < 1e-12 * expected.abs().max(1.0),
            "{noise:?}: {found}, not {expected}"
        );
    }

    #[test]
    fn covariances_are_those_of_the_whole_matrix() {
        let nothing = Noise::default();
        check(&Noise { white: 3.0, ..nothing.clone() }, |k, l| if k == l { 9.0 } else { 0.0 });
        check(&Noise { errors: 2.0, ..nothing.clone() }, |k, l| match k.abs_diff(l) {
            0 => 8.0,
            1 => -4.0,
            _ => 0.0,
        });
        check(&Noise { walk: 0.5, ..nothing.clone() }, |k, l| 0.25 * (k.min(l) + 1) as f64);
        for octave in 0..8 {
            let mut octaves = vec![0.0; octave + 1];
            octaves[octave] = 1.5;
            let length = f64::from(1 << octave);
            check(&Noise { octaves, ..nothing.clone() }, |k, l| {
                2.25 * libm::fmax(0.0, 1.0 - k.abs_diff(l) as f64 / length)
            });
        }
        check(&Noise { markov: Some([2.0, 0.3]), ..nothing.clone() }, |k, l| {
            4.0 * libm::exp(-0.3 * k.abs_diff(l) as f64)
        });
        // Increments of A cos(φ + k δ) with a random φ.
        let turns = 0.13;
        let angle = |lag: f64| libm::cos(2.0 * PI * turns * lag);
        check(&Noise { sine: Some([2.0, turns]), ..nothing.clone() }, |k, l| {
            let lag = k as f64 - l as f64;
            2.0 * (2.0 * angle(lag) - angle(lag + 1.0) - angle(lag - 1.0))
        });
        check(&Noise { jumps: Some((5, 7.0)), ..nothing }, |k, l| {
            if k == l && k > 0 && k % 5 == 0 { 7.0 } else { 0.0 }
        });
    }
}
