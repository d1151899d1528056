//! The columns of a study of navigation, with a row for each point, and what its filters claim.

use crate::chart::Law;
use crate::kinds::navigation::Solution;
use crate::kinds::navigation::point::Point;
use crate::kinds::navigation::run::{Claim, Level, Sizes};
use sagnac_base::quantity::expression::NAUTICAL_MILE;
use sagnac_base::table::column::{Band, abouts};
use sagnac_base::table::{About, Cell, ColumnOf, Role, Unit, Usual};
use sagnac_theory::navigation::ARCSEC;

/// A quantity of which the size is estimated: an error in one direction, or in two.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Quantity {
    Heading,
    Tilt,
    Velocity,
    Position,
}

impl Quantity {
    /// Returns the quantities of a solution, in the order of [`Row::sizes`].
    pub(crate) fn of(solution: Solution) -> &'static [Quantity] {
        match solution {
            Solution::Inertial => {
                &[Quantity::Heading, Quantity::Tilt, Quantity::Velocity, Quantity::Position]
            }
            Solution::Heading | Solution::Gyrocompass => &[Quantity::Heading],
        }
    }

    /// Returns the places of its errors among those of the task.
    pub(crate) fn errors(self) -> &'static [usize] {
        match self {
            Quantity::Heading => &[0],
            Quantity::Tilt => &[1, 2],
            Quantity::Velocity => &[3, 4],
            Quantity::Position => &[5, 6],
        }
    }

    /// Size in tables of a unit of its errors: of ″, m/s or m.
    pub(crate) fn shown(self) -> f64 {
        match self {
            Quantity::Heading | Quantity::Velocity => 1.0,
            Quantity::Tilt => ARCSEC * 1e6,
            Quantity::Position => 1.0 / NAUTICAL_MILE,
        }
    }
}

/// The classes of navigators by the growth of their circular error, nmi/h, the best first.
const GRADES: [(Law, &str, f64); 3] = [
    (Law::StrategicGrade, "strategic", 0.02),
    (Law::NavigationGrade, "navigation", 1.0),
    (Law::TacticalGrade, "tactical", 10.0),
];

/// Their laws in charts of the position.
pub(crate) static LAWS: [Law; 3] = [Law::StrategicGrade, Law::NavigationGrade, Law::TacticalGrade];

/// The law of charts of the consistency of a filter.
pub(crate) static OF_FILTERS: [Law; 1] = [Law::ConsistentFilter];

/// A row before it becomes cells.
pub(crate) struct Row<'a> {
    pub(crate) point: &'a Point,
    pub(crate) trials: u64,
    /// The size of each quantity of the solution.
    pub(crate) sizes: Vec<Sizes>,
    /// What the filter claims, where there is one.
    pub(crate) claim: Option<Claim>,
    /// Largest relative difference in magnitude of the rms of a quantity in closed form from that of the inputs.
    pub(crate) representation: Option<f64>,
}

impl Row<'_> {
    fn size(&self, quantity: Quantity, of: impl Fn(&Sizes) -> Option<f64>) -> Option<f64> {
        of(self.sizes.get(quantity as usize)?).map(|value| value * quantity.shown())
    }

    fn z(&self, quantity: Quantity) -> Option<f64> {
        self.sizes.get(quantity as usize)?.z()
    }

    fn level(
        &self,
        quantity: Quantity,
        level: fn(&Sizes) -> Option<Level>,
        of: fn(&Level) -> Option<f64>,
    ) -> Option<f64> {
        self.size(quantity, |sizes| of(&level(sizes)?))
    }

    fn rms_band(&self, quantity: Quantity) -> Band {
        Some((
            self.size(quantity, |sizes| sizes.rms_band().map(|ends| ends.0))?,
            self.size(quantity, |sizes| sizes.rms_band().map(|ends| ends.1))?,
        ))
    }

    fn band(&self, quantity: Quantity, level: fn(&Sizes) -> Option<Level>) -> Band {
        self.level(quantity, level, |level| level.low).zip(self.level(quantity, level, |level| level.high))
    }

    fn hours(&self) -> f64 {
        self.point.inputs.duration_s / 3600.0
    }

    /// Growth of the circular error, nmi/h.
    fn growth(&self) -> Option<f64> {
        Some(self.level(Quantity::Position, |sizes| sizes.half, |level| Some(level.value))? / self.hours())
    }

    fn grade(&self) -> Cell {
        let Some(growth) = self.growth() else { return Cell::Blank };
        let grade = GRADES.iter().find(|(_, _, most)| growth <= *most);
        Cell::Text(grade.map_or("none", |(_, name, _)| name).to_owned())
    }

    /// A consistent filter has a NEES of 1; of a class, it is the limit at the end of the row's navigation, nmi.
    pub(crate) fn law(&self, law: Law) -> Cell {
        if law == Law::ConsistentFilter {
            return 1.0.into();
        }
        let grade = GRADES.iter().find(|(known, ..)| *known == law);
        grade.map(|(_, _, rate)| rate * self.hours()).into()
    }
}

/// The columns of the size of a quantity: its rms and two levels, each with its closed form.
macro_rules! sizes {
    ($columns:ident, $quantity:ident, $unit:expr, $name:literal, $half:literal, $label:literal, $in:literal) => {
        $columns.extend([
            Of::new(concat!($name, "_rms"), $unit, concat!($label, ", rms"), |row| {
                row.size(Quantity::$quantity, |sizes| sizes.rms).into()
            })
            .is(Role::Error, concat!("Root mean square of the ", $label, " over the trials, ", $in, "."))
            .within(|row| row.rms_band(Quantity::$quantity)),
            Of::new(
                concat!($name, "_rms_se"),
                $unit,
                concat!($label, ", standard error of the rms"),
                |row| row.size(Quantity::$quantity, |sizes| sizes.rms_se).into(),
            )
            .is_of(
                concat!($name, "_rms"),
                Role::StandardError,
                concat!("Standard error (1 σ) of `", $name, "_rms`, ", $in, "."),
            ),
            Of::new(
                concat!("theory_", $name, "_rms"),
                $unit,
                concat!($label, ", rms (closed form)"),
                |row| row.size(Quantity::$quantity, |sizes| Some(sizes.closed_rms)).into(),
            )
            .is_of(
                concat!($name, "_rms"),
                Role::Theory,
                concat!(
                    "`",
                    $name,
                    "_rms` in closed form, wᵀCw of the weights and the covariance of the increments, ",
                    $in,
                    "."
                ),
            ),
            Of::new(
                concat!($name, "_z"),
                Unit::NONE,
                concat!($label, ", deviation from the closed form, standard errors"),
                |row| row.z(Quantity::$quantity).into(),
            )
            .is_of(
                concat!($name, "_rms"),
                Role::Z,
                concat!(
                    "Deviation of `",
                    $name,
                    "_rms` from its closed form in standard errors; beyond ±5 something is wrong."
                ),
            ),
            Of::new(concat!($name, $half), $unit, concat!($label, ", 50 %"), |row| {
                row.level(Quantity::$quantity, |sizes| sizes.half, |level| Some(level.value)).into()
            })
            .is(Role::Error, concat!("The level, ", $in, ", that half of the trials stay below."))
            .within(|row| row.band(Quantity::$quantity, |sizes| sizes.half)),
            Of::new(concat!($name, $half, "_lo"), $unit, concat!($label, ", 50 % (lower)"), |row| {
                row.level(Quantity::$quantity, |sizes| sizes.half, |level| level.low).into()
            })
            .is_of(
                concat!($name, $half),
                Role::Lower,
                "Lower end of the 95 % interval of the level; blank where the trials cannot bound it.",
            ),
            Of::new(concat!($name, $half, "_hi"), $unit, concat!($label, ", 50 % (upper)"), |row| {
                row.level(Quantity::$quantity, |sizes| sizes.half, |level| level.high).into()
            })
            .is_of(
                concat!($name, $half),
                Role::Upper,
                "Upper end of the 95 % interval of the level; blank where the trials cannot bound it.",
            ),
            Of::new(
                concat!("theory_", $name, $half),
                $unit,
                concat!($label, ", 50 % (closed form)"),
                |row| row.size(Quantity::$quantity, |sizes| Some(sizes.closed_half)).into(),
            )
            .is_of(
                concat!($name, $half),
                Role::Theory,
                concat!(
                    "The level for normally distributed errors with the mean and covariance in closed form, ",
                    $in,
                    "."
                ),
            ),
            Of::new(concat!($name, "_p95"), $unit, concat!($label, ", 95 %"), |row| {
                row.level(Quantity::$quantity, |sizes| sizes.most, |level| Some(level.value)).into()
            })
            .is(Role::Error, concat!("The level, ", $in, ", that 95 % of the trials stay below."))
            .within(|row| row.band(Quantity::$quantity, |sizes| sizes.most)),
            Of::new(concat!($name, "_p95_lo"), $unit, concat!($label, ", 95 % (lower)"), |row| {
                row.level(Quantity::$quantity, |sizes| sizes.most, |level| level.low).into()
            })
            .is_of(
                concat!($name, "_p95"),
                Role::Lower,
                "Lower end of the 95 % interval of the level; blank where the trials cannot bound it.",
            ),
            Of::new(concat!($name, "_p95_hi"), $unit, concat!($label, ", 95 % (upper)"), |row| {
                row.level(Quantity::$quantity, |sizes| sizes.most, |level| level.high).into()
            })
            .is_of(
                concat!($name, "_p95"),
                Role::Upper,
                "Upper end of the 95 % interval of the level; blank where the trials cannot bound it.",
            ),
            Of::new(
                concat!("theory_", $name, "_p95"),
                $unit,
                concat!($label, ", 95 % (closed form)"),
                |row| row.size(Quantity::$quantity, |sizes| Some(sizes.closed_most)).into(),
            )
            .is_of(
                concat!($name, "_p95"),
                Role::Theory,
                concat!(
                    "The level for normally distributed errors with the mean and covariance in closed form, ",
                    $in,
                    "."
                ),
            ),
        ]);
    };
}

/// The columns of a solution, with a filter or without, except the swept keys, in the order of the file.
#[rustfmt::skip]
pub(crate) fn columns<'a>(solution: Solution, has_filter: bool) -> Vec<ColumnOf<Row<'a>>> {
    type Of<'a> = ColumnOf<Row<'a>>;
    let mut columns = vec![
        Of::new("trials", Unit::NONE, "trials", |row| row.trials.into())
            .is(Role::Trials, "Number of navigators behind the estimates of the row, each with records of its own."),
    ];
    sizes!(columns, Heading, Unit::ARCSEC, "heading", "_p50", "error of the heading", "″");
    if solution == Solution::Inertial {
        sizes!(columns, Tilt, Unit::MICRORAD, "tilt", "_p50", "tilt", "µrad, of both horizontal axes together");
        sizes!(columns, Velocity, Unit::M_PER_S, "velocity", "_p50", "error of the velocity", "m/s, of both horizontal directions together");
        sizes!(columns, Position, Unit::NMI, "position", "_cep", "error of the position", "nautical miles, over the ground");
        columns.extend([
            Of::new("cep_rate", Unit::NMI_PER_H, "growth of the circular error", |row| row.growth().into())
                .is(Role::Estimate, "`position_cep` divided by the time of navigation, nmi/h, by which navigators are classed."),
            Of::new("grade", Unit::NONE, "class of the navigator", Row::grade)
                .is(Role::Note, "The usual class for `cep_rate`: `strategic` up to 0.02 nmi/h, `navigation` up to 1 nmi/h, `tactical` up to 10 nmi/h, else `none`."),
        ]);
    }
    if has_filter {
        columns.extend(claims());
    }
    columns.push(
        Of::new("representation", Unit::NONE, "representation", |row| row.representation.into())
            .is_of("heading_rms", Role::Representation, "Relative difference of the rms in closed form, that of the integers that are sampled, from the closed form \
                of the inputs, which shares no computed number with them: the largest in magnitude over the quantities. What exceeds the proven bound of \
                rounding ends the run."),
    );
    let usual = if solution == Solution::Inertial { "position_p95" } else { "heading_p95" };
    let mark = |column: ColumnOf<Row<'a>>| if column.about.name == usual { column.usual(Usual::Estimate) } else { column };
    columns.into_iter().map(mark).collect()
}

/// All possible columns of such a study except the swept keys.
pub(crate) fn described() -> Vec<About> {
    let laws = LAWS.iter().chain(&OF_FILTERS).map(|law| law.about());
    abouts(&columns(Solution::Inertial, true)).into_iter().chain(laws).collect()
}

fn of(row: &Row, value: impl Fn(&Claim) -> Option<f64>) -> Cell {
    row.claim.as_ref().and_then(value).into()
}

/// The columns of a solution with a filter, after those of the heading.
#[rustfmt::skip]
fn claims<'a>() -> Vec<ColumnOf<Row<'a>>> {
    type Of<'a> = ColumnOf<Row<'a>>;
    vec![
        Of::new("claimed", Unit::ARCSEC, "error of the heading claimed by the filter, σ", |row| of(row, |claim| Some(claim.sigma)))
            .is(Role::Estimate, "Standard deviation of the heading that the filter claims, ″, of its own model."),
        Of::new("nees", Unit::NONE, "mean squared error over claimed variance (NEES)", |row| of(row, |claim| claim.nees))
            .is(Role::Estimate, "Normalized estimation error squared: mean squared error of the heading over the variance that the filter claims. 1 is \
                consistent, more is too sure, less too careful.")
            .within(|row| row.claim.as_ref().and_then(Claim::nees_band)),
        Of::new("nees_se", Unit::NONE, "NEES, standard error", |row| of(row, |claim| claim.nees_se))
            .is_of("nees", Role::StandardError, "Standard error (1 σ) of `nees`."),
        Of::new("nees_lo", Unit::NONE, "NEES (lower)", |row| of(row, |claim| claim.nees_band().map(|ends| ends.0)))
            .is_of("nees", Role::Lower, "Lower end of the 95 % interval of `nees`."),
        Of::new("nees_hi", Unit::NONE, "NEES (upper)", |row| of(row, |claim| claim.nees_band().map(|ends| ends.1)))
            .is_of("nees", Role::Upper, "Upper end of the 95 % interval of `nees`."),
        Of::new("theory_nees", Unit::NONE, "NEES (closed form)", |row| of(row, |claim| Some(claim.closed_nees)))
            .is_of("nees", Role::Theory, "`nees` in closed form, wᵀCw over the claimed variance."),
        Of::new("nees_z", Unit::NONE, "NEES, deviation from the closed form, standard errors", |row| of(row, |claim| claim.z))
            .is_of("nees", Role::Z, "Deviation of `nees` from its closed form in standard errors; beyond ±5 something is wrong."),
        Of::new("within95", Unit::NONE, "part of trials within the filter's 95 % region", |row| of(row, |claim| claim.within))
            .is(Role::Estimate, "Part of the trials whose error is within 1.96 σ of the filter's own claim; 0.95 if it is consistent.")
            .within(|row| row.claim.as_ref().and_then(|claim| claim.within_band)),
        Of::new("within95_lo", Unit::NONE, "part within the 95 % region (lower)", |row| of(row, |claim| claim.within_band.map(|ends| ends.0)))
            .is_of("within95", Role::Lower, "Lower end of the 95 % interval of `within95` (Wilson)."),
        Of::new("within95_hi", Unit::NONE, "part within the 95 % region (upper)", |row| of(row, |claim| claim.within_band.map(|ends| ends.1)))
            .is_of("within95", Role::Upper, "Upper end of the 95 % interval of `within95` (Wilson)."),
        Of::new("theory_within95", Unit::NONE, "part within the 95 % region (closed form)", |row| of(row, |claim| Some(claim.closed_within)))
            .is_of("within95", Role::Theory, "`within95` for normally distributed errors with the mean and variance in closed form."),
    ]
}
