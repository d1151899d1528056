//! A lattice rule: points that fill a unit cube of any number of dimensions evenly, for means over several drawn values.

/// Number of points.
pub const POINTS: u32 = 1 << 17;

/// The generator of the rule of Korobov with the least error in 2 to 6 dimensions, out of 500 tried, for functions with
/// square-integrable second mixed derivatives.
const GENERATOR: u32 = 81_053;

/// The coordinates of a point, each strictly between 0 and 1.
///
/// In one dimension they are the midpoints of equal parts. The mean of a smooth function over the points has an error of
/// about 1/N² for the N points; that of a rough one scatters as if they were independent.
pub fn point(index: u32) -> impl Iterator<Item = f64> {
    let mut multiple = index;
    core::iter::repeat_with(move || {
        let place = multiple % POINTS;
        multiple = multiple.wrapping_mul(GENERATOR);
        (f64::from(place) + 0.5) / f64::from(POINTS)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_coordinate_takes_each_part_once() {
        for dimension in 0..24 {
            let mut taken = vec![false; POINTS as usize];
            for index in 0..POINTS {
                let x = point(index).nth(dimension).unwrap();
                taken[(x * f64::from(POINTS)) as usize] = true;
            }
            let missed = taken.iter().filter(|taken| !**taken).count();
            assert_eq!(missed, 0, "of dimension {dimension}");
        }
    }

    /// The mean of a product of functions of mean 1 is 1.
    #[test]
    fn the_mean_of_a_smooth_function_is_right_to_a_ten_millionth_up_to_four_dimensions() {
        for dimensions in 1..=4 {
            let of = |x: f64| 1.0 + 2.0 * (x * x - x + 1.0 / 6.0);
            let product = |index| point(index).take(dimensions).map(of).product::<f64>();
            let mean = (0..POINTS).map(product).sum::<f64>() / f64::from(POINTS);
            assert!((mean - 1.0).abs() < 1e-7, "{dimensions} dimensions: {mean}");
        }
    }
}
