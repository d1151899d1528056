//! The error equations of a strapdown navigator in local-level axes: north, east, down.
//!
//! The state is the attitude error (rotation of the computed axes relative to the true ones), rad, the error of the
//! horizontal velocity, m/s, and the horizontal error of the position, m. The Earth is a sphere that turns, the height is
//! known, as it is with a barometer, and accelerometers have no errors. Source: the φ-angle model of Titterton and Weston,
//! "Strapdown Inertial Navigation Technology", 2nd ed., chapter 12.

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
